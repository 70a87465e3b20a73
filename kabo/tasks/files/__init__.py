"""Task files: from YAML to tasks and back, the names of stages, and reports of planning runs [T 3.7].

The package `language` parses the files; this package checks names and types against the stages that exist.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
