"""YAML with places, and one grammar for formulas: documents of domains, scenes, problems, tasks and explorations."""
