"""Replaces task solutions along a stretch so that the plan gets cheaper, using dynamic programming.

A task can have other solutions: another grasp, another place, another branch of inverse kinematics. Along a
stretch, the cheapest sequence of solutions to each state is kept for the few best states. If the stretch then ends
in another state, later nodes keep their motion where it is still proven and the objects that it moves are
unchanged; the other nodes are planned again. The change is accepted only if the whole plan gets cheaper.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from kabo.errors import CutOff
from kabo.geometry_server.answers import Success
from kabo.geometry_server.situation import Situation
from kabo.planner.refine.legs import proven
from kabo.planner.refine.refining_stops import Stop
from kabo.scene import Component
from kabo.tasks.procedures import GeometricProcedures

MAX_SOLUTIONS = 8  # solutions of each task along a stretch
BEAM_WIDTH = 4  # states that are kept after each node
MAX_ENDS = 4  # ends of a stretch with which the whole plan is tried
MAX_SOLUTIONS_BEHIND = 4  # solutions of each task behind a stretch with a new end
LEAST_GAIN = 1e-3  # by which the plan has to get cheaper

Cost = Callable[[Success | None], float]  # of the motion in an answer, at least 0; 0 without an answer


@dataclass(frozen=True)
class PlanDraft:
    """A version of the plan: for each stop, the answer to its call and the situation in which it begins."""

    answers: Mapping[Stop, Success | None]
    situations: Mapping[Stop, Situation]


@dataclass(frozen=True)
class _Way:
    """The answers along a stretch so far, their cost, and the situation after them."""

    cost: float
    situation: Situation
    answers: tuple[Success | None, ...]


@dataclass
class AlternativeChoice:
    """Searches for task solutions that make the plan cheaper; `order` lists its stops in topological order.

    The cost of a plan is the sum of `cost` over its stops: each counts once, on however many branches it is.
    """

    server: GeometricProcedures
    order: Sequence[Stop]
    draft: PlanDraft
    samples: int
    cost: Cost
    _began: int = field(init=False)
    _costs: dict[int, tuple[Success, float]] = field(init=False, default_factory=dict)  # by identity

    def __post_init__(self) -> None:
        self._began = self.server.statistics.samples

    @property
    def spent(self) -> bool:
        """Whether the budget of samples is used up or the run has to stop."""
        return self.server.statistics.samples - self._began > self.samples or self.server.stop()

    def total(self, draft: PlanDraft) -> float:
        """The cost of all motion of a plan."""
        return sum(map(self._cost, draft.answers.values()))

    def _cost(self, answer: Success | None) -> float:
        """The cost of an answer, computed once: the server keeps answers, which are asked for on many ways."""
        if answer is None:
            return self.cost(None)
        if id(answer) not in self._costs:
            self._costs[id(answer)] = answer, self.cost(answer)
        return self._costs[id(answer)][1]

    def improve(self, stretch: Sequence[Stop]) -> None:
        """Replaces solutions along a stretch if that makes the whole plan cheaper."""
        if self.spent:
            return
        best = self.draft
        with suppress(CutOff):  # what is better until then is taken
            for way in self._ways(stretch)[:MAX_ENDS]:
                forced = dict(zip(stretch, way.answers, strict=True))
                if all(forced[stop] is self.draft.answers[stop] for stop in stretch):
                    continue
                found = self._settled(forced, self.total(best) - LEAST_GAIN)
                if found is not None:
                    best = found
                if self.spent:
                    break
        self.draft = best

    # ---------------------------------------------------------------------------------------------- one stretch
    def _ways(self, stretch: Sequence[Stop]) -> list[_Way]:
        """The cheapest ways along a stretch to the few best ends, the cheapest first."""
        ways = [_Way(0.0, self.draft.situations[stretch[0]], ())]
        for stop in stretch:
            reached: dict[object, _Way] = {}
            for way in ways:
                for answer in self._solutions(stop, way.situation, MAX_SOLUTIONS):
                    after = way.situation if answer is None else way.situation.replace(answer.changes)
                    on = _Way(way.cost + self._cost(answer), after, (*way.answers, answer))
                    known = reached.get(after.key)
                    if known is None or on.cost < known.cost:
                        reached[after.key] = on
            ways = sorted(reached.values(), key=lambda way: way.cost)[:BEAM_WIDTH]
        return ways

    def _solutions(self, stop: Stop, situation: Situation, count: int) -> Iterator[Success | None]:
        """The first solutions of a node's task in a situation; its present one comes first where it is still possible."""
        now, call = self.draft.answers[stop], stop.call
        if call is None or now is None:
            yield None
            return
        if situation.key == self.draft.situations[stop].key:
            yield now
        for attempt in range(count):
            if self.spent:
                return
            answer = self.server.call(call, situation, attempt)
            if not isinstance(answer, Success):
                return
            if answer != now:
                yield answer

    # -------------------------------------------------------------------------------------------- the whole plan
    def _settled(self, forced: Mapping[Stop, Success | None], most: float) -> PlanDraft | None:
        """The plan with some answers given and all others made to fit; None if impossible, or if it costs more than `most`.

        Nodes with the same call that all ended alike still do: so branches can meet behind them.
        """
        arriving: dict[Stop, Situation] = {self.order[0]: self.draft.situations[self.order[0]]}
        answers: dict[Stop, Success | None] = {}
        ends: dict[object, Mapping[str, Component]] = {}
        for stop, answer in forced.items():
            if answer is not None:
                ends.setdefault(self._end(stop), answer.changes)
        cost = 0.0
        left = sum(map(self._cost, forced.values()))  # what is still to come at least
        for stop in self.order:
            situation = arriving[stop]
            if stop in forced:
                answers[stop] = forced[stop]
                left -= self._cost(forced[stop])
            else:
                fitting = self._fitting(stop, situation, ends.get(self._end(stop)))
                if fitting is None:
                    return None
                (answers[stop],) = fitting
            answer = answers[stop]
            if answer is not None:
                ends.setdefault(self._end(stop), answer.changes)
            cost += self._cost(answer)
            if cost + left > most:
                return None
            after = situation if answer is None else situation.replace(answer.changes)
            for follower in stop.following:
                known = arriving.get(follower)
                arriving[follower] = after if known is None else known.union(after)
        return PlanDraft(answers, arriving)

    def _end(self, stop: Stop) -> object:
        """A key that is the same for the nodes with a call that end alike at present."""
        now = self.draft.answers[stop]
        return None if now is None else (stop.call, frozenset(now.changes.items()))

    def _fitting(
        self, stop: Stop, situation: Situation, end: Mapping[str, Component] | None
    ) -> tuple[Success | None] | None:
        """The answer of a node in a situation: the present one if it is still proven, else the cheapest new solution.

        If `end` is given, the node makes these changes if it can; it has to where branches meet behind it.
        """
        now, call, before = self.draft.answers[stop], stop.call, self.draft.situations[stop]
        if now is None or call is None:
            return (now,)
        stays = end is None or now.changes == end
        if stays and situation.key == before.key:
            return (now,)
        single = self.server.single(call, situation)
        if any(len(situation.values(name)) != 1 for name in single):
            return None
        stays &= all(situation.values(name) == before.values(name) for name in single)
        if stays and proven(self.server.server.context(), situation, now.motion):
            return (now,)
        count = MAX_SOLUTIONS_BEHIND if end is None else MAX_SOLUTIONS
        found: list[Success] = []
        for each in self._solutions(stop, situation, count):
            if each is not None and each.changes == end:
                return (each,)
            found += [each] if each is not None else []
        if not found or end is not None and any(after.ways_in > 1 for after in stop.following):
            return None
        return (min(found[:MAX_SOLUTIONS_BEHIND], key=self._cost),)
