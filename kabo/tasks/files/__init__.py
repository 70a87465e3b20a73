"""Task files: from YAML to tasks and back, the names of stages, and reports of what planning found [T 3.7].

Files are read by the language room; here their names and types are checked against the stages there are.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
