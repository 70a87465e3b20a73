"""Refinement of a plan that was found: its linear stretches are joined and their motion made better, never worse.

A stretch is a chain of nodes with one way in and one way out. What is known, done and proven stays: each stretch begins
and ends where it did, unless only the goal follows, and all that is changed is proven free anew, for every value that is
possible there.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from time import perf_counter
from typing import TYPE_CHECKING

from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation
from kabo.planner.assembly import handles_of
from kabo.planner.evaluation import Variant
from kabo.tasks.robots.freedom import NONE, Freedoms, freedoms
from kabo.tasks.robots.joining import Act, Effort, joined, segment_length
from kabo.tasks.robots.legs import legs_of, proven
from kabo.tasks.robots.timing import duration, timed

if TYPE_CHECKING:
    from kabo.tasks.procedures import GeometricProcedures

BETTER = 1e-6  # rad, s: less is no difference


@dataclass(eq=False)
class Stop:
    """One node of the plan to be: variants of the search that are equal, and every situation that they begin in."""

    variants: list[Variant]
    situation: Situation

    @property
    def first(self) -> Variant:
        """Any of its variants: they differ in nothing that matters."""
        return self.variants[0]

    @property
    def answer(self) -> Success | None:
        """What it moves, if it moves."""
        return self.first.answer if isinstance(self.first.answer, Success) else None


@dataclass(frozen=True)
class Figures:
    """Length [rad or m, L2] and duration [s] of the longest branch, before and after."""

    length_found: float
    length: float
    duration_found: float
    duration: float
    seconds: float

    def written(self) -> dict[str, float]:
        """As statistics keep them."""
        return {
            "path_length_found": self.length_found,
            "path_length": self.length,
            "duration_found": self.duration_found,
            "duration": self.duration,
            "refine_s": self.seconds,
        }


def refine(
    variants: tuple[Variant, ...], server: "GeometricProcedures", stop: Callable[[], bool] = lambda: False
) -> Figures:
    """Gives the variants of a plan better motion, in place, and says how much better.

    Args:
        variants: of an evaluation in which every call succeeded; the first is the root.
        server: that answered them.
        stop: asked between stretches whether to leave the rest as it is.
    """
    began = perf_counter()
    stops = stops_of(variants, server)
    before = longest(variants, segment_length_of), longest(variants, duration_of)
    for stretch in stretches_of(variants, stops):
        if stop():
            break
        _refine(stretch, server)
    for each in dict.fromkeys(stops.values()):
        if not stop():
            _retime(each, server)
    after = longest(variants, segment_length_of), longest(variants, duration_of)
    return Figures(before[0], after[0], before[1], after[1], perf_counter() - began)


# ------------------------------------------------------------------------------------------------------ stretches
def stops_of(variants: tuple[Variant, ...], server: "GeometricProcedures") -> dict[Variant, Stop]:
    """Each variant's node of the plan."""
    made: dict[str, Stop] = {}
    found: dict[Variant, Stop] = {}
    for variant, handle in handles_of(variants, server).items():
        if handle in made:
            made[handle].variants.append(variant)
            made[handle].situation = made[handle].situation.union(variant.situation)
        else:
            made[handle] = Stop([variant], variant.situation)
        found[variant] = made[handle]
    return found


def stretches_of(variants: tuple[Variant, ...], stops: Mapping[Variant, Stop]) -> Iterator[list[Stop]]:
    """Every stretch, in an order in which each comes before what follows it; each node with an action is in one."""
    ways_in: dict[int, set[int]] = {}
    for variant in variants:
        for after in variant.following.values():
            ways_in.setdefault(id(stops[after]), set()).add(id(stops[variant]))
    taken: set[int] = set()
    for variant in variants:
        here = stops[variant]
        stretch: list[Stop] = []
        while id(here) not in taken and here.first.node.action is not None:
            taken.add(id(here))
            stretch.append(here)
            following = [stops[after] for after in here.first.following.values()]
            if len(here.first.following) != 1 or len(ways_in[id(following[0])]) != 1:
                break
            (here,) = following
        if stretch:
            yield stretch


def only_the_goal_follows(stretch: Sequence[Stop]) -> bool:
    """Whether nothing is done after a stretch."""
    return all(after.node.action is None and not after.following for after in stretch[-1].first.following.values())


def freedoms_of(stop: Stop, server: "GeometricProcedures") -> Freedoms:
    """What may be changed of a node's motion."""
    action = stop.first.node.action
    if action is None or action.call is None:
        return NONE
    bodies = (server.scene.bodies.get(str(value)) for value in server.bind(action.call).arguments.values())
    return freedoms(server.stages(action.call), [body for body in bodies if body is not None])


# ------------------------------------------------------------------------------------------------------ refinement
def _refine(stretch: Sequence[Stop], server: "GeometricProcedures") -> None:
    """The stretch with shorter motion."""
    acts = [
        Act((), {}, NONE)
        if (answer := stop.answer) is None
        else Act(answer.motion, answer.changes, freedoms_of(stop, server))
        for stop in stretch
    ]
    context, start = server.server.context(), stretch[0].situation
    made = joined(context, start, acts, Effort(), pinned=not only_the_goal_follows(stretch))
    situation = start
    for stop, act in zip(stretch, made, strict=True):
        _keep(stop, situation, act)
        situation = situation.replace(act.changes)


def _keep(stop: Stop, situation: Situation, act: Act) -> None:
    """Writes back what was found; each variant keeps what else is open there."""
    changed = {n: situation.values(n) for n in (*situation.robots, *situation.objects)}
    for variant in stop.variants:
        news = {n: v[0] for n, v in changed.items() if len(v) == 1 and variant.situation.values(n) != v}
        variant.situation = variant.situation.replace(news)
        if isinstance(variant.answer, Success):
            variant.answer = replace(variant.answer, motion=act.motion, changes=act.changes)
    stop.situation = situation


def _retime(stop: Stop, server: "GeometricProcedures") -> None:
    """New times for the motion of a node, if they are proven with it."""
    answer = stop.answer
    if answer is None or not answer.motion:
        return
    context = server.server.context()
    if legs_of(context, stop.situation, answer.motion) is None:
        return
    made = tuple(timed(context, stop.situation, answer.motion, round_corners=find_spec("toppra") is not None))
    if proven(context, stop.situation, made):
        for variant in stop.variants:
            if isinstance(variant.answer, Success):
                variant.answer = replace(variant.answer, motion=made)


# --------------------------------------------------------------------------------------------------------- figures
def segment_length_of(variant: Variant) -> float:
    """The length of what a variant moves [rad or m, L2]."""
    return sum(map(segment_length, variant.answer.motion)) if isinstance(variant.answer, Success) else 0.0


def duration_of(variant: Variant) -> float:
    """How long a variant moves [s]."""
    return duration(variant.answer.motion) if isinstance(variant.answer, Success) else 0.0


def longest(variants: tuple[Variant, ...], own: Callable[[Variant], float]) -> float:
    """The greatest sum along a branch."""
    total: dict[Variant, float] = {}
    for variant in reversed(variants):
        after = (total[each] for each in variant.following.values())
        total[variant] = own(variant) + max(after, default=0.0)
    return total[variants[0]]
