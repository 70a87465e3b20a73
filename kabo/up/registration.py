"""Makes the engine `kabo` known to unified-planning, which has no entry points: an engine is added or configured.

Without a line of code, a file `up.ini` beside the program (or `~/.uprc`) does the same:

    [engine kabo]
    module_name: kabo.up.engine
    class_name: KaboEngine
"""

from typing import Any

from unified_planning.environment import get_environment

NAME = "kabo"


def register(environment: Any = None) -> None:
    """Adds the engine `kabo` to an environment of unified-planning, the global one if none is given, unless it is there.

    It becomes the last of the preference list: without a name an engine is chosen as before, if there was one.
    """
    factory = (environment or get_environment()).factory
    if NAME not in factory.engines:
        factory.add_engine(NAME, "kabo.up.engine", "KaboEngine")
