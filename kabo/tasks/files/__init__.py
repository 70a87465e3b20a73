"""Task files: from YAML to tasks and back, the names of stages, and reports of planning runs [T 3.7].

The language room reads the files; here names and types are checked against the stages that exist.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
