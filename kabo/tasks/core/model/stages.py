"""Stages: the phases of a task, each a pure function of scenes, properties and a seed [T 3.2].

A generator writes the states on both sides; a propagator computes the state on one side from that on the other; a
connector joins two states; a monitoring generator is triggered by each solution of another stage.
"""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from kabo.tasks.core.model.errors import TaskError
from kabo.tasks.core.model.flow import PROPAGATE, Flow, Flows
from kabo.tasks.core.model.properties import Properties, Property
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.solutions import Solution

Told = float | tuple[float, str] | tuple[float, str, Any]  # cost, comment, a record for programs
CostTerm = Callable[[Solution], Told]
Values = Mapping[str, Any]


@dataclass(frozen=True)
class Misfit:
    """A value that does not fit the others of its stage: the keys that lead to it, what is wrong, and the remedy."""

    keys: tuple[str, ...]
    message: str
    hint: str | None = None


class Stage:
    """A phase of a task: a name, properties, and optionally a cost term that replaces the stage's own costs."""

    PROPERTIES: ClassVar[Mapping[str, Property]] = {}
    OPEN: ClassVar[bool] = False  # whether any property may be set without declaring it
    TRANSPARENT: ClassVar[bool] = False  # whether parts of its solutions are found without its name
    WRITES: ClassVar[Collection[str]] = ()  # the interface properties that it may write

    def __init__(self, name: str, /, *, cost: CostTerm | None = None, **properties: Any) -> None:
        declared: dict[str, Property] = {}
        for base in reversed(type(self).__mro__):
            declared |= getattr(base, "PROPERTIES", {})
        self.name = name
        self.cost = cost
        self.parent: Stage | None = None
        self.properties = Properties(self, declared, open_ended=self.OPEN)
        for key, value in properties.items():
            self.properties.set(key, value)

    @property
    def children(self) -> tuple["Stage", ...]:
        """The stages inside, in order of time; only containers have any."""
        return ()

    @property
    def path(self) -> str:
        """The names of the stages from the task's child down to this stage, joined by `/`.

        The task's path is its name.
        """
        names, stage = [self.name], self.parent
        while stage is not None and stage.parent is not None:
            names.append(stage.name)
            stage = stage.parent
        return "/".join(reversed(names))

    @property
    def flows(self) -> Flows:
        """The flows that this stage permits; of several, the neighbouring stages determine one."""
        raise NotImplementedError

    @classmethod
    def writes(cls, values: Values) -> Collection[str]:
        """The interface properties that a stage with these values may write."""
        return cls.WRITES

    @classmethod
    def misfits(cls, values: Values) -> Iterable[Misfit]:
        """Faults of values that were set on a stage, in each other's light; references in them are unresolved."""
        return ()

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name!r})"


class Generator(Stage):
    """A stage that writes the states on both sides; `generate` is given the task's first scene."""

    @property
    def flows(self) -> Flows:
        """The only flow of a generator, GENERATE."""
        return frozenset((Flow.GENERATE,))

    def generate(self, scene: Any, properties: Values, seed: int) -> Answers:
        """The scenes that the generator proposes, as results."""
        raise NotImplementedError


class Monitor(Generator):
    """A generator triggered by each solution of another stage; `generate` is given the scene at the end of that solution.

    `monitors` is the path of the other stage, relative to the container of this one (`..` goes up one container); of a
    stage in a wrapper, the wrapper is the container. A path that begins with `/` begins at the task.
    """

    def __init__(self, name: str, /, monitors: str | Stage, **properties: Any) -> None:
        super().__init__(name, **properties)
        self.monitors = monitors

    @property
    def monitored(self) -> Stage:
        """The stage whose solutions trigger this generator.

        Raises:
            TaskError: there is no stage at that path, or there are several.
        """
        if isinstance(self.monitors, Stage):
            return self.monitors
        here: Stage | None = self.parent
        while self.monitors.startswith("/") and here is not None and here.parent is not None:
            here = here.parent
        for step in self.monitors.split("/"):
            if here is None:
                break
            if step == "..":
                here = here.parent
            elif step not in ("", "."):
                found = [child for child in here.children if child.name == step]
                if len(found) > 1:
                    why = f"there are {len(found)} stages of that name; rename one, or give the stage itself"
                    raise TaskError(f"stage {self.path!r} monitors {self.monitors!r}, but {why}")
                here = found[0] if found else None
        if here is None or here is self:
            raise TaskError(f"stage {self.path!r} monitors {self.monitors!r}, but there is no such stage")
        return here


class Propagator(Stage):
    """A stage that computes the next state from a given one; with both `forward` and `backward` the task chooses one."""

    def __init__(self, name: str, /, *, only: Flow | None = None, **properties: Any) -> None:
        super().__init__(name, **properties)
        self.only = only

    @property
    def flows(self) -> Flows:
        """The directions that the class defines and that `only` does not exclude."""
        kind = type(self)
        able = {Flow.FORWARD: kind.forward is not Propagator.forward}
        able[Flow.BACKWARD] = kind.backward is not Propagator.backward
        return frozenset(flow for flow in PROPAGATE if able[flow] and self.only in (None, flow))

    def forward(self, scene: Any, properties: Values, seed: int) -> Answers:
        """The scenes after the stage, given the scene before it."""
        raise NotImplementedError

    def backward(self, scene: Any, properties: Values, seed: int) -> Answers:
        """The scenes before the stage, given the scene after it."""
        raise NotImplementedError


class Connector(Stage):
    """A stage that joins a state on its left with a state on its right."""

    @property
    def flows(self) -> Flows:
        """The only flow of a connector, CONNECT."""
        return frozenset((Flow.CONNECT,))

    def mismatch(self, start: Any, end: Any, properties: Values) -> str | None:
        """The reason why two scenes can never be joined, by any path; None if they may be."""
        return None

    def connect(self, start: Any, end: Any, properties: Values, seed: int) -> Answers:
        """The connections from the scene `start` to the scene `end`, as results."""
        raise NotImplementedError
