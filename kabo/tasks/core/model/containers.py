"""Containers: stages that hold stages, one after the other or side by side, and wrappers around one [T 3.3, 3.4]."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from kabo.tasks.core.model.errors import TaskError
from kabo.tasks.core.model.flow import PROPAGATE, Flow, Flows
from kabo.tasks.core.model.properties import Property
from kabo.tasks.core.model.results import Answers, Result
from kabo.tasks.core.model.stages import Stage, Values

if TYPE_CHECKING:
    from kabo.tasks.core.model.solutions import Solution


class Container(Stage):
    """A stage made of stages; it takes any property, for its children to inherit."""

    OPEN = True

    def __init__(self, name: str, /, *children: Stage, **properties: Any) -> None:
        super().__init__(name, **properties)
        self._children: list[Stage] = []
        for child in children:
            self.add(child)

    @property
    def children(self) -> tuple[Stage, ...]:
        """The stages inside, in order."""
        return tuple(self._children)

    def add(self, child: Stage, index: int | None = None) -> Stage:
        """Puts a stage in, at the end or before `index` (negative ones count from the end); returns it.

        Raises:
            TaskError: the stage is in a container already, or would contain itself.
        """
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
        """Takes a stage out; returns it."""
        self._children.remove(child)
        child.parent = None
        return child

    def clear(self) -> None:
        """Takes all stages out."""
        for child in self.children:
            self.remove(child)

    def find(self, path: str) -> Stage | None:
        """The stage of a path below this one (`c/d`); of equal names the first; None if there is none."""
        here: Stage | None = self
        for name in path.split("/"):
            here = next((c for c in here.children if c.name == name), None) if here is not None else None
        return here

    def walk(self) -> Iterator[Stage]:
        """This container and every stage below it, in order of time, containers before what they hold."""
        waiting: list[Stage] = [self]
        while waiting:
            stage = waiting.pop()
            yield stage
            waiting.extend(reversed(stage.children))


class Serial(Container):
    """One after the other: a solution is a path of solutions of its children, its cost their sum."""

    @property
    def flows(self) -> Flows:
        """What the children leave possible; empty if they do not fit together."""
        sections = self.sections()
        if sections is None:
            return frozenset()
        first, last = (any(is_generator(c) for c in sections[i]) for i in (0, -1))
        if first and last:
            return frozenset((Flow.GENERATE,))
        if len(sections) == 1:
            common = PROPAGATE.intersection(*(c.flows for c in sections[0])) if sections[0] else PROPAGATE
            return frozenset(common)
        if last:
            return frozenset((Flow.FORWARD,))
        return frozenset((Flow.BACKWARD if first else Flow.CONNECT,))

    def sections(self) -> list[list[Stage]] | None:
        """The children between connectors; None if two generators, or two connectors, meet."""
        found: list[list[Stage]] = [[]]
        for child in self.children:
            if is_connector(child):
                found.append([])
            else:
                found[-1].append(child)
        counts = [sum(is_generator(c) for c in section) for section in found]
        if any(count > 1 for count in counts) or any(count == 0 for count in counts[1:-1]):
            return None
        return found


class Parallel(Container):
    """Side by side: all children share both interfaces."""

    @property
    def flows(self) -> Flows:
        """What all children can."""
        if not self.children:
            return frozenset()
        return frozenset.intersection(*(child.flows for child in self.children))


class Alternatives(Parallel):
    """Each child's solutions are solutions."""


class Fallbacks(Parallel):
    """A child is asked only where the one before it gave nothing: for each state, for each pair, or at all."""


class Merger(Parallel):
    """All children move at once, from one state: `merge` puts one solution of each together."""

    @property
    def flows(self) -> Flows:
        """Propagating only: merged motions begin, or end, in one state."""
        return super().flows & PROPAGATE

    def merge(self, scene: Any, solutions: Sequence["Solution"], properties: Values, seed: int) -> Answers:
        """The results of moving as in all the solutions, which begin (or, backward, end) in the scene."""
        raise NotImplementedError


class Wrapper(Container):
    """Around one child: each of its successes becomes what `transform` makes of it."""

    def __init__(self, name: str, child: Stage | None = None, /, **properties: Any) -> None:
        super().__init__(name, **properties)
        if child is not None:
            self.add(child)

    @property
    def flows(self) -> Flows:
        """Those of the child."""
        return self.children[0].flows if len(self.children) == 1 else frozenset()

    def transform(self, solution: "Solution", properties: Values, seed: int) -> Answers:
        """What becomes of a success of the child; as it is, unless a class says otherwise."""
        return [Result(cost=solution.cost, comment=solution.comment)]


class Limit(Wrapper):
    """Lets the first `max_solutions` of its child through and then asks it no more [T 3.6]."""

    PROPERTIES = {
        "max_solutions": Property(
            int,
            1,
            "how many solutions of its child; 0: it is not asked",
            lambda n: None if n >= 0 else "is at least 0",
        )
    }

    def __init__(
        self, name: str, child: Stage | None = None, /, *, max_solutions: int = 1, **properties: Any
    ) -> None:
        super().__init__(name, child, **properties)
        self.properties.set("max_solutions", max_solutions)


def is_generator(stage: Stage) -> bool:
    """Whether a stage writes states on both sides."""
    return Flow.GENERATE in stage.flows


def is_connector(stage: Stage) -> bool:
    """Whether a stage joins states from both sides."""
    return Flow.CONNECT in stage.flows
