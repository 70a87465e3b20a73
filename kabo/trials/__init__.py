"""Trials of parameters: runs explorations with functions, with planned tasks, or by asking and being told."""
