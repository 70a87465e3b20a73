"""The exporting room: plans as files for other executors and readers, one module for each format.

`export` writes a file's text, `check_export` compares a file with its plan. Formats without branches hold one branch, or
the motion of one node. `PlanLeaves` are leaves of py_trees on the protocols of `kabo.execution`.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
