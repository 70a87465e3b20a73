"""Refused calls that the distance to be kept alone decides: for which pair, and how much distance there is.

What bodies keep from each other is asked for by `--clearance`, and by `uncertain` of scenes. A refused call is repeated
as for epsilon, and attempts that something blocked are asked again with nothing kept.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from kabo.geometry_server import GeometryServer, Measure, Refusal, millimetres
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.epsilon_alone import Repeated, with_measures
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import Where


def with_clearance(
    failures: Sequence[tuple[GroundCall, Refusal]], asked: GeometricProcedures, stop: Callable[[], bool]
) -> list[tuple[GroundCall, Refusal]]:
    """The refused calls; where what is kept alone decides, the refusal has a measure that says for whom."""
    if not asked.server.surroundings.keeps:
        return list(failures)
    return with_measures(failures, asked, lambda call, where: clearance_measure(asked, call, where, stop))


def clearance_measure(
    asked: GeometricProcedures, call: GroundCall, where: Where, stop: Callable[[], bool]
) -> Measure | None:
    """What the kept distance alone refuses of a call: the pair that has the most of it, with the distance that there is.

    None if nothing is kept, if most attempts fail without it, too, or if there is no time to find out.
    """
    return _Unkept(asked, stop).measure(call, where) if asked.server.surroundings.keeps else None


class _Unkept(Repeated):
    """A call that is repeated with nothing kept."""

    def _relaxed(self, given: GeometryServer) -> GeometryServer:
        scene = replace(given.scene, uncertain={})
        return GeometryServer(scene, self.epsilon, given.seed, given.surroundings.exact, self.stop)

    def _told(self, passing: Sequence[Refusal], blocked: int) -> Measure:
        found = [(gap, self._wanted(each, gap[1])) for each in passing if (gap := self._gap(each)) is not None]
        if not found:
            wanted = max((self._wanted(each, each.pairs[0][0]) for each in passing if each.pairs), default=0.0)
            said = f"{len(passing)} of {blocked} attempts would pass if no {millimetres(wanted)} were to be kept"
            return Measure("clearance", said, wanted, 0.0)
        (apart, (first, second)), wanted = max(found, key=lambda each: each[0][0] - each[1])
        are = f"{first} and {second} are {millimetres(apart)} apart"
        return Measure("clearance", f"{are}, but {millimetres(wanted)} are to be kept", wanted, apart)

    def _wanted(self, refusal: Refusal, pair: tuple[str, str]) -> float:
        """The distance that a pair is to keep where an attempt was refused [m]."""
        surroundings, situation = self.asked.server.surroundings, getattr(refusal.question, "scene", None)
        carriers = {}
        if situation is not None:
            robots = situation.situation.robots
            carriers = {name: robot for robot in robots for name in situation.situation.carried(robot)}
        return sum(surroundings.kept(name, carriers.get(name)) for name in pair)
