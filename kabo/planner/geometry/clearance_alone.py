"""Refused calls that the distance to be kept alone decides: for which pair, and how much distance there is.

What bodies keep from each other is asked for by `--clearance`, and by `uncertain` of scenes. A refused call is repeated
as for epsilon, and attempts that something blocked are asked again with nothing kept.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from kabo.geometry_server import GeometryServer, Measure, Refusal, millimetres
from kabo.geometry_server.foresight.measures import CLEARANCE
from kabo.language.formulas import GroundCall
from kabo.planner.geometry.epsilon_alone import Passing, Repeated, with_measures
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.records import Where
from kabo.tasks.robots.motion.kept_distances import told_distance


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

    def _told(self, passing: Sequence[Passing], looked: int) -> Measure:
        found = [(each.apart - each.wanted, each.apart, each) for each in passing if each.apart is not None]
        if not found:
            wanted = max((each.wanted for each in passing), default=0.0)
            said = f"{len(passing)} of {looked} attempts would pass if no {millimetres(wanted)} were to be kept"
            return Measure(CLEARANCE, said, wanted, 0.0)
        _, apart, nearest = max(found, key=lambda each: each[0])
        said = told_distance(nearest.refusal.pairs[0][0], apart, nearest.wanted, self.epsilon)
        return Measure(CLEARANCE, said, nearest.wanted, apart)
