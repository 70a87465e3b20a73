"""The data model of tasks: stages, containers, properties, states and solutions [T 3.2, 3.3]."""
