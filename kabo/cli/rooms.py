"""What the commands call of the rooms below; each name loads its room when it is first used, so `--help` loads none.

The names stand in the stub beside this file, a line each.
"""

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)
