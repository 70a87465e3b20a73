"""A geometry server by script: procedures succeed or fail as a test says, and every call is written down."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace

from kabo.geometry_server import Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.scene import Attachment, GeometricState

Script = Callable[[GroundCall, Situation, int], Success | Refusal]


def at(x: float, parent: str = "world") -> Attachment:
    """An object at x along the first axis."""
    return Attachment(parent, (x, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def moved(**changes: tuple[float, ...] | Attachment) -> Success:
    """Success without a motion that changes these components."""
    return Success((), changes)


@dataclass
class ScriptedServer:
    """Moves its first two arguments, reads the second; `script` answers."""

    script: Script
    robots: Mapping[str, tuple[float, ...]]
    objects: Mapping[str, Attachment]
    asked: list[tuple[str, int]] = field(default_factory=list)
    met: list[GeometricState] = field(default_factory=list)

    @property
    def scene(self) -> SimpleNamespace:
        """What the planner reads of a scene."""
        start = GeometricState(self.robots, self.objects)
        return SimpleNamespace(robots=self.robots, movable=tuple(self.objects), start=start)

    def bind(self, call: GroundCall) -> SimpleNamespace:
        """Which components a call moves and reads."""
        names = tuple(str(name) for name in call.arguments)
        return SimpleNamespace(moves=names[:2], reads=names[1:2])

    def single(self, call: GroundCall, situation: Situation) -> tuple[str, ...]:
        """The components that need one value."""
        return tuple(sorted(self.bind(call).moves))

    def call(self, call: GroundCall, situation: Situation, attempt: int = 0, effort: int = 0) -> Success | Refusal:
        """The scripted answer."""
        self.asked.append((str(call), attempt))
        return self.script(call, situation, attempt)

    def identify(self, state: GeometricState) -> int:
        """The number of a state, in the order in which they were met."""
        if state not in self.met:
            self.met.append(state)
        return self.met.index(state)

    def state(self, identifier: int) -> GeometricState:
        """The state of a number."""
        return self.met[identifier]
