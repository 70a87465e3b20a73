"""Containers: stages that hold other stages in series or in parallel, and wrappers around one stage [T 3.3, 3.4]."""

from collections.abc import Collection, Iterator, Sequence
from typing import Any

from kabo.tasks.core.model.errors import TaskError
from kabo.tasks.core.model.flow import PROPAGATE, Flow, Flows
from kabo.tasks.core.model.properties import Property
from kabo.tasks.core.model.results import Answers, Result
from kabo.tasks.core.model.solutions import Solution
from kabo.tasks.core.model.stages import Stage, Values


class Container(Stage):
    """A stage made of stages. Any property may be set on it, so that its children can inherit the value."""

    OPEN = True

    def __init__(self, name: str, /, *children: Stage, **properties: Any) -> None:
        super().__init__(name, **properties)
        self._children: list[Stage] = []
        for child in children:
            self.add(child)

    @property
    def children(self) -> tuple[Stage, ...]:
        """The stages inside, in order of time."""
        return tuple(self._children)

    def add(self, child: Stage, index: int | None = None) -> Stage:
        """Inserts a stage at the end, or before `index` (negative numbers count from the end), and returns it.

        Raises:
            TaskError: it is no stage, is in a container already, or would contain itself.
        """
        if not isinstance(child, Stage):
            raise TaskError(f"{self.name!r} holds stages, and {child!r} is none: make one, as NoOp('name')")
        if child.parent is not None:
            raise TaskError(f"stage {child.name!r} is in {child.parent.name!r} already; a stage has one parent")
        holder: Stage | None = self
        while holder is not None:
            if holder is child:
                raise TaskError(f"container {child.name!r} cannot contain itself")
            holder = holder.parent
        child.parent = self
        self._children.insert(len(self._children) if index is None else index, child)
        return child

    def remove(self, child: Stage) -> Stage:
        """Removes a stage from the container and returns it."""
        self._children.remove(child)
        child.parent = None
        return child

    def clear(self) -> None:
        """Removes all stages from the container."""
        for child in self.children:
            self.remove(child)

    def find(self, path: str) -> Stage | None:
        """The stage at a path below this container (`c/d`), or None.

        If several stages have the same path, the first is returned.
        """
        here: Stage | None = self
        for name in path.split("/"):
            here = next((c for c in here.children if c.name == name), None) if here is not None else None
        return here

    def walk(self) -> Iterator[Stage]:
        """This container and every stage below it, in order of time, containers before the stages that they hold."""
        waiting: list[Stage] = [self]
        while waiting:
            stage = waiting.pop()
            yield stage
            waiting.extend(reversed(stage.children))


class Serial(Container):
    """Stages in sequence: a solution is a path of solutions of its children, and its cost is their sum."""

    @property
    def flows(self) -> Flows:
        """The flows that the sequence of children permits; empty if the children do not fit together."""
        sections = self._sections()
        if sections is None:
            return frozenset()
        first, last = (any(Flow.GENERATE in flows for _, flows in sections[i]) for i in (0, -1))
        if first and last:
            return frozenset((Flow.GENERATE,))
        if len(sections) == 1:
            return PROPAGATE.intersection(*(flows for _, flows in sections[0]))
        if last:
            return frozenset((Flow.FORWARD,))
        return frozenset((Flow.BACKWARD if first else Flow.CONNECT,))

    def sections(self) -> list[list[Stage]] | None:
        """The children split at connectors; None if a section has two generators, or an inner section has none."""
        sections = self._sections()
        return None if sections is None else [[child for child, _ in section] for section in sections]

    def _sections(self) -> list[list[tuple[Stage, Flows]]] | None:
        """As `sections`, with the flows of each child, which is asked once: containers ask all that they hold."""
        found: list[list[tuple[Stage, Flows]]] = [[]]
        for child in self.children:
            flows = child.flows
            if Flow.CONNECT in flows:
                found.append([])
            else:
                found[-1].append((child, flows))
        counts = [sum(Flow.GENERATE in flows for _, flows in section) for section in found]
        if any(count > 1 for count in counts) or any(count == 0 for count in counts[1:-1]):
            return None
        return found


class Parallel(Container):
    """Stages side by side: all children have the same start interface and the same end interface."""

    TRANSPARENT = True

    @property
    def flows(self) -> Flows:
        """The flows that all children permit."""
        if not self.children:
            return frozenset()
        return frozenset.intersection(*(child.flows for child in self.children))


class Alternatives(Parallel):
    """A container in which every solution of a child is a solution."""


class Fallbacks(Parallel):
    """A container that tries a child only where the ones before it failed: per state, per pair of states, or as a whole."""


class Merger(Parallel):
    """A container whose children move at the same time from one state: `merge` combines one solution of each child."""

    @property
    def flows(self) -> Flows:
        """Those of the flows forward and backward that all children permit."""
        return super().flows & PROPAGATE

    def merge(self, scene: Any, solutions: Sequence[Solution], properties: Values, seed: int) -> Answers:
        """The results of executing one solution of each child at the same time.

        All solutions start in `scene`, or end in it if the merger runs backward.
        """
        raise NotImplementedError


class Wrapper(Container):
    """A container of one child: `transform` turns each solution of the child into solutions of the wrapper."""

    TRANSPARENT = True

    def __init__(self, name: str, child: Stage | None = None, /, **properties: Any) -> None:
        super().__init__(name, **properties)
        if child is not None:
            self.add(child)

    @property
    def flows(self) -> Flows:
        """The flows that the child permits; empty unless there is exactly one child."""
        return self.children[0].flows if len(self.children) == 1 else frozenset()

    def transform(self, solution: Solution, properties: Values, seed: int) -> Answers:
        """The results into which a solution of the child is transformed.

        By default there is one result, with the same cost and comment.
        """
        return [Result(cost=solution.cost, comment=solution.comment)]


class Limit(Wrapper):
    """A wrapper that passes on the first `max_solutions` solutions of its child and then stops running it [T 3.6]."""

    PROPERTIES = {
        "max_solutions": Property(
            int,
            1,
            "how many solutions of its child; 0: it is not asked",
            lambda n: None if n >= 0 else f"is at least 0, not {n}",
        )
    }

    def __init__(
        self, name: str, child: Stage | None = None, /, *, max_solutions: int = 1, **properties: Any
    ) -> None:
        super().__init__(name, child, **properties)
        self.properties.set("max_solutions", max_solutions)


def is_generator(stage: Stage) -> bool:
    """Whether a stage may write the states on both of its sides."""
    return Flow.GENERATE in stage.flows


def is_connector(stage: Stage) -> bool:
    """Whether a stage may join a state on its left with a state on its right."""
    return Flow.CONNECT in stage.flows


def fails_given(stage: Stage, refuted: Collection[Stage]) -> bool:
    """Whether a stage has no solution if the `refuted` ones have none: of `Alternatives` and `Fallbacks`, all must fail."""
    if stage in refuted:
        return True
    inside = [fails_given(child, refuted) for child in stage.children]
    return any(inside) if not isinstance(stage, (Alternatives, Fallbacks)) else bool(inside) and all(inside)


def in_vain(stage: Stage, refuted: Collection[Stage]) -> Iterator[Stage]:
    """The stages below a stage, and itself, that can be part of no solution if the `refuted` ones have none."""
    if fails_given(stage, refuted):
        waiting = [stage]
        while waiting:
            here = waiting.pop()
            yield here
            waiting.extend(here.children)
    else:
        for child in stage.children:
            yield from in_vain(child, refuted)
