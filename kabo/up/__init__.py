"""The room of unified-planning (extra `up`): its problems solved by kabo, its plans from kabo's and back, its export.

`import kabo.up` makes the engine `kabo` known to unified-planning, if that is installed: from then on
`OneshotPlanner(name="kabo")` finds it. Nothing else of kabo imports this room, since unified-planning takes 2 s to load.
"""

from importlib.util import find_spec

from kabo.lazy import lazy_names

__getattr__, __dir__ = lazy_names(__name__, __file__)

if find_spec("unified_planning") is not None:
    from kabo.up.registration import register as _register

    _register()
