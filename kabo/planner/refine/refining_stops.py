"""Stops (nodes of the plan before it is written, with equal variants merged), and linear stretches of stops."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.assembly import handles_of
from kabo.planner.geometry.evaluation import Variant
from kabo.planner.refine.timing import duration
from kabo.tasks.procedures import GeometricProcedures


@dataclass(eq=False)
class Stop:
    """A node of the future plan: its equal variants, and the union of the situations in which they begin."""

    variants: list[Variant]
    situation: Situation
    following: "tuple[Stop, ...]" = ()
    ways_in: int = 0

    @property
    def first(self) -> Variant:
        """The first variant, which represents all variants: refinement reads nothing in which they differ."""
        return self.variants[0]

    @property
    def answer(self) -> Success | None:
        """The successful answer to the stop's call; None if the stop has no call."""
        return self.first.answer if isinstance(self.first.answer, Success) else None

    @property
    def call(self) -> GroundCall | None:
        """The procedure call of the stop's action; None if it has none."""
        action = self.first.node.action
        return None if action is None else action.call

    @property
    def is_goal(self) -> bool:
        """Whether the stop is the goal node, which has neither action nor successors."""
        return self.first.node.action is None and not self.following

    def keep(self, situation: Situation, answer: Success | None) -> None:
        """Sets the situation of the stop and its variants; and also their answer, unless `answer` is None."""
        self.situation = situation
        for variant in self.variants:
            variant.situation = situation
            if answer is not None:
                variant.answer = answer

    def let_begin_early(self, overlap: float) -> None:
        """Sets the time [s] by which the stop's motion begins before the previous one has ended."""
        for variant in self.variants:
            variant.overlap = overlap


def stops_of(variants: tuple[Variant, ...], server: GeometricProcedures) -> list[Stop]:
    """The stops of a plan in topological order, the root first."""
    handles = handles_of(variants, server)
    made: dict[str, Stop] = {}
    for variant in variants:
        known = made.get(handles[variant])
        if known is None:
            made[handles[variant]] = Stop([variant], variant.situation)
        else:
            known.variants.append(variant)
            known.situation = known.situation.union(variant.situation)
    for stop in made.values():
        stop.following = tuple(made[handles[after]] for after in stop.first.following.values())
    for stop in made.values():
        for follower in stop.following:
            follower.ways_in += 1
    return _in_order(list(made.values()))


def _in_order(stops: Sequence[Stop]) -> list[Stop]:
    """The stops in topological order, duplicates merged."""
    waiting, open_ = {stop: stop.ways_in for stop in stops}, [stops[0]]
    for stop in open_:  # the list grows while it is walked
        for follower in stop.following:
            waiting[follower] -= 1
            if waiting[follower] == 0:
                open_.append(follower)
    return open_


def stretches_of(stops: Sequence[Stop]) -> Iterator[list[Stop]]:
    """The maximal linear chains of stops, in order: inside a chain, each stop leads only to the next."""
    taken: set[Stop] = set()
    for first in stops:
        stretch: list[Stop] = []
        here = first
        while here not in taken and here.first.node.action is not None:
            taken.add(here)
            stretch.append(here)
            if len(here.following) != 1 or here.following[0].ways_in != 1:
                break
            here = here.following[0]
        if stretch:
            yield stretch


def seconds_of(stop: Stop) -> float:
    """The time from the end of the previous stop's motion to the end of this one [s]."""
    return 0.0 if stop.answer is None else duration(stop.answer.motion) - stop.first.overlap
