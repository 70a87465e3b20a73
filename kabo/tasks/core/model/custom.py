"""Decorators that turn a function of (scene, properties, seed) into a stage class.

@forward(step=1.0)
def advance(scene, properties, seed):
    yield Result(scene + properties["step"])

task.add(advance("two steps", step=2.0))
"""

from collections.abc import Callable
from typing import Any

from kabo.tasks.core.model.containers import Wrapper
from kabo.tasks.core.model.properties import MISSING, Property
from kabo.tasks.core.model.stages import Connector, Generator, Monitor, Propagator, Stage

Function = Callable[..., Any]


def _declared(given: Any) -> Property:
    """A property declared by its default value, by its type (then a value is required), or by a `Property`."""
    if isinstance(given, Property):
        return given
    if isinstance(given, type):
        return Property(given, MISSING)
    if given is None:
        return Property(Any, None)
    return Property((list, tuple) if isinstance(given, (list, tuple)) else type(given), given)


def _maker(base: type[Stage], *methods: str) -> Callable[..., Callable[[Function], type[Stage]]]:
    def declare(**declared: Any) -> Callable[[Function], type[Stage]]:
        def make(function: Function) -> type[Stage]:
            def method(self: Stage, *arguments: Any) -> Any:
                return function(*arguments)

            content: dict[str, Any] = dict.fromkeys(methods, method)
            content["PROPERTIES"] = {name: _declared(value) for name, value in declared.items()}
            content |= {"__doc__": function.__doc__, "__module__": function.__module__}
            return type(function.__name__, (base,), content)

        return make

    return declare


generator = _maker(Generator, "generate")  # a decorator: makes a Generator of a function (scene, properties, seed)
monitor = _maker(Monitor, "generate")  # a decorator: makes a Monitor of a function (scene, properties, seed)
forward = _maker(
    Propagator, "forward"
)  # a decorator: a Propagator that runs forward, of (scene, properties, seed)
backward = _maker(Propagator, "backward")  # a decorator: a Propagator that runs backward
propagator = _maker(Propagator, "forward", "backward")  # a decorator: one function both ways
connector = _maker(Connector, "connect")  # a decorator: makes a Connector of (start, end, properties, seed)
wrapper = _maker(Wrapper, "transform")  # a decorator: makes a Wrapper of a function (solution, properties, seed)
