"""Completion in shells: scripts made of the parsers, which start no Python when somebody presses TAB."""
