"""Explains why there is no plan and what would help: examines failed calls, and tries changes of the scene."""
