"""Makes the certificate of a plan: for every stretch of motion, proofs that moving bodies do not collide.

It uses only the plan as it will be written, as the verifier does. A component of the geometric state with several
possible values is treated as if it had all of them at once.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.errors import CutOff
from kabo.geometry.collision.part_trees import Cover
from kabo.geometry.collision.separation_proofs import Course, Unproven
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.phases import phase
from kabo.plan import (
    BodyParts,
    Certificate,
    Clearance,
    Node,
    Plan,
    topological_order,
)
from kabo.planner.certify.best_margins import Refinement
from kabo.planner.certify.certified_bodies import CertifiedBodies
from kabo.planner.certify.certified_pairs import PairChoice, Thing, kept_distances
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.least_so_far import LeastSoFar
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import MotionStretch, joined, stretches
from kabo.planner.certify.overlapping_pairs import every_pair_of_pieces, from_time_on
from kabo.planner.certify.proven_stretches import ProvenStretch
from kabo.planner.certify.stretch_things import StretchThings
from kabo.scene import KinematicTree

_LOG = logging.getLogger("kabo.planner")
DECIMALS = 6  # of a clearance in metres; rounded down
CUTS = (1, 2, 4, 8, 16)  # parts into which each piece of overlapping motions is cut, until a proof is found
NEAR_FACTOR = 1.25  # of the greatest distance that a pair keeps: so far apart, a pair needs no axis
MAX_WAYPOINTS = 20_000  # way points of a path that visits every pair of pieces; longer ones are not tried


class MovingStretch(NamedTuple):
    """A stretch of motion that was certified, with the course and the names of its moving bodies."""

    stretch: MotionStretch
    course: Course
    things: Sequence[Thing]


class Claim(NamedTuple):
    """What is to be proven of a stretch: pairs of things along a course, in one of several ways."""

    node: str
    stretch: MotionStretch
    things: Sequence[Thing]
    ways: Callable[[], Iterator[tuple[Course, Array, int]]]  # course, margins that are wanted, and cut
    before: tuple[int, ...] = ()  # segments of the node before


UNFINISHED = "the work was cut off before its proofs were found"


@dataclass(frozen=True)
class UnprovenPair:
    """A pair of bodies that could not be proven apart: the node, its segments, and the place on the path."""

    node: str
    segments: tuple[int, ...]
    between: tuple[str, str]
    piece: float
    gap: float

    def __str__(self) -> str:
        first, second = self.between
        where = f"segment {', '.join(map(str, self.segments))}, piece {self.piece:.3f}"
        return f"{self.node}: {first} and {second} are not proven apart ({where}, gap {self.gap:.3g} m)"


def certified(
    plan: Plan, surroundings: SceneSurroundings, look: Callable[[], None] = never
) -> tuple[Plan, dict[str, Any]]:
    """The plan with its certificate; and statistics: the time this took, and the pairs that are not proven apart.

    If a proof is missing, or the work is cut off, the plan gets a list of the missing proofs instead of a
    certificate, and is then verified without one. `look` is called periodically and raises CutOff to end the work.
    """
    began = perf_counter()
    try:
        made: Certificate | list[Any] = certify(plan, surroundings, look=look)
    except ValueError as error:
        made = [str(error)]
    except CutOff:
        made = [UNFINISHED]
    gaps = [str(gap) for gap in made] if isinstance(made, list) else []
    figures = {"certificate_s": perf_counter() - began, "certificate_gaps": gaps}
    if isinstance(made, list):
        return replace(plan, certificate_gaps=tuple(gaps) or ("no proofs were found",)), figures
    return replace(plan, certificate=made), figures


def certify(
    plan: Plan,
    surroundings: SceneSurroundings,
    near: float | None = None,
    look: Callable[[], None] = never,
    parts: Mapping[str, BodyParts] | None = None,
) -> Certificate | list[UnprovenPair]:
    """The certificate of a plan, or the pairs of bodies that are not proven apart.

    Args:
        plan: the plan as it will be written.
        surroundings: the scene, with the convex parts for which the plan was made.
        near: the distance [m] above which a pair needs no separating axis; if None epsilon, or a quarter more than what
            bodies keep from each other, if that is more.
        look: called periodically; an exception that it raises ends the work.
        parts: `bodies` of another certificate, to be used as they are: a verifier may know already what they enclose.

    Raises:
        ValueError: the plan has a cycle, no start state, or moves something that may be in several places.
    """
    covers: dict[str, Cover] = {}
    sharp = not parts
    while True:
        enough = max(surroundings.budget.epsilon, NEAR_FACTOR * surroundings.greatest_kept)
        certifying = _Certifying(plan, surroundings, near or enough, look, covers, parts)
        made = certifying.made(sharp)
        if certifying.bodies.divided:
            covers = certifying.bodies.covers  # all proofs are to be about the same parts
        elif isinstance(made, Certificate) or not certifying.bodies.refined:
            return made
        else:
            sharp = False  # refined parts are never worse; but no proof may be lost by them


class _Certifying:
    def __init__(
        self,
        plan: Plan,
        surroundings: SceneSurroundings,
        near: float,
        look: Callable[[], None],
        covers: Mapping[str, Cover],
        parts: Mapping[str, BodyParts] | None = None,
    ) -> None:
        self.look = look
        order = topological_order(plan)
        if order is None:
            raise ValueError("the plan has a cycle")
        self.plan, self.order, self.near = plan, order, near
        self.surroundings, self.scene = surroundings, surroundings.scene
        self.values = ComponentValues(plan, self.scene, order)
        self.things = StretchThings(surroundings, self.values)
        self.bodies = CertifiedBodies(self.things.enclosures(), covers, surroundings.budget, near, parts)
        self.gaps: list[UnprovenPair] = []
        self.choice = PairChoice(surroundings.never_collide)
        self.least = LeastSoFar(self.scene.movable, near)
        self._trees: dict[tuple[str, ...], tuple[list[int], KinematicTree]] = {}
        early = {name for name, node in plan.nodes.items() if node.overlap}
        shared = early | {name for name, node in plan.nodes.items() if early & set(node.successors)}
        # Of motions that share time with another one.
        self._moved: dict[str, list[MovingStretch]] = {name: [] for name in shared}

    def made(self, sharp: bool) -> Certificate | list[UnprovenPair]:
        """The certificate, or what is not proven; `sharp` if parts may be refined."""
        claims: list[Claim] = []
        self.refinement = Refinement(self.bodies, self.things.cuttable() if sharp else {})
        with phase("certifying", 2 * len(self.order), "nodes", log=_LOG) as step:
            for name in self.order:
                node = self.plan.nodes[name]
                self.least.enter(name)
                claims += [*self._node(name, node), *self._early(name, node)] if node.motion else []
                self.least.leave(name, node.successors)
                step()
            self.refinement.finish()
            found = [self._proven(claim) for claim in claims]
        if self.gaps:
            return self.gaps
        proven = [each for each in found if each is not None]
        proofs = tuple(each.proof() for each in proven)
        segments = [each for name in self.order for each in self._clearances(name, proven)]
        return Certificate(
            self.surroundings.budget.epsilon, tuple(segments), self.near, self.bodies.given(), proofs
        )

    def _clearances(self, name: str, proven: Sequence[ProvenStretch]) -> Iterator[Clearance]:
        """The clearance of each of a node's segments."""
        node = self.plan.nodes[name]
        least: dict[int, tuple[float, tuple[str, str] | None]] = {}
        for each in proven:
            if each.node == name:
                for i in each.stretch.segments:
                    least[i] = min(least.get(i, (np.inf, None)), each.least, key=lambda entry: entry[0])
        for i in sorted(least):
            margin, between = least[i]
            clearance = float(np.floor(margin * 10**DECIMALS)) / 10**DECIMALS if margin < self.near else None
            permitted = node.motion[i].allowed_contacts
            yield Clearance(name, i, clearance, None if clearance is None else between, permitted)

    # ------------------------------------------------------------------------------------------------- a node
    def _node(self, name: str, node: Node) -> Iterator[Claim]:
        moving = list(dict.fromkeys(segment.robot for segment in node.motion))
        situation = MotionSituation.at(name, self.values, self.scene, moving)
        for stretch in stretches(node.motion, dict(self.scene.robots), situation.q):
            self.look()
            yield self._stretch(name, node, stretch, situation)
            for i in stretch.ending:
                situation.end(node.motion[i])

    def _early(self, name: str, node: Node) -> Iterator[Claim]:
        """Claims that a motion that begins early never meets the rest of the previous one, however late either is."""
        if not node.overlap:
            return
        before = next(other for other in self.order if name in self.plan.nodes[other].successors)
        motion = self.plan.nodes[before].motion
        begin = max(segment.times[-1] for segment in motion) - node.overlap
        for first in self._moved[before]:
            rest = from_time_on(first.stretch, motion, self.scene.robots, begin)
            if rest is not None:
                waypoints, deviations = rest
                tail = first._replace(course=replace(first.course, waypoints=waypoints, deviations=deviations))
                yield from (self._apart_at_any_times(name, tail, second) for second in self._moved[name])

    # ---------------------------------------------------------------------------------------------- a stretch
    def _stretch(self, name: str, node: Node, stretch: MotionStretch, situation: MotionSituation) -> Claim:
        first_joint, tree = self._joined(tuple(stretch.waypoints))
        moving, standing = self.things.of(name, situation, dict(zip(stretch.waypoints, first_joint, strict=True)))
        things = [*moving, *standing]
        permitted = frozenset(frozenset(p) for i in stretch.segments for p in node.motion[i].allowed_contacts)
        waypoints = np.ascontiguousarray(np.hstack(list(stretch.waypoints.values())))
        bodies, none = [thing.body for thing in things], np.empty((0, 3), np.int64)
        whole = Course(tree, waypoints, bodies, none, deviations=stretch.together)
        if name in self._moved:
            alone = replace(whole, bodies=bodies[: len(moving)])
            self._moved[name].append(MovingStretch(stretch, alone, moving))
        passing = self._passing(node, stretch, things) & permitted
        ways: list[tuple[Course, Array]] = []
        for left_out in (permitted - passing, permitted) if passing else (permitted,):
            pairs = self.choice.pairs(things, len(moving), left_out, tree)
            course = replace(whole, pairs=pairs, kept=kept_distances(things, pairs, permitted, situation.roots))
            if not ways:
                wanted = self._wanted(course, things, passing if left_out != permitted else frozenset())
                ways += [] if wanted is None else [(course, wanted)]
            else:
                rows = pairs[:, :2] @ np.array([len(things), 1])
                first = ways[0][0].pairs[:, :2] @ np.array([len(things), 1])
                ways.append((course, np.ascontiguousarray(ways[0][1][np.isin(first, rows)])))
        return Claim(name, stretch, things, lambda: ((*way, 0) for way in ways))

    def _wanted(
        self, course: Course, things: Sequence[Thing], passing: Set[frozenset[str]] = frozenset()
    ) -> Array | None:
        """The margin that is worth having of each pair (P,) [m]; refines the parts of those that decide it.

        None if a pair that is `passing` touches.
        """
        scopes = np.array([self.least.scope(thing.name) for thing in things], np.int64)
        measured = self.bodies.near_pairs(course, scopes, self.least.caps)
        while (pair := measured.next()) is not None:
            names = frozenset(things[i].name for i in course.pairs[pair, :2].tolist())
            if names in passing and measured.distance(pair) <= 0.0:
                return None
            measured.settle(pair, min(self.near, self.refinement.distance(course, pair, measured)))
        self.least.note(measured.caps)
        return measured.wanted()

    def _proven(self, claim: Claim) -> ProvenStretch | None:
        """The proofs of a claim; None if there are none, which is noted as a gap."""
        self.look()
        for course, wanted, cut in claim.ways():  # noqa: B007  the last one is told
            found = self.bodies.prove(course, wanted)
            if not isinstance(found, Unproven):
                return ProvenStretch(
                    claim.node, claim.stretch, course, claim.things, course.pairs, found, claim.before, cut
                )
        assert isinstance(found, Unproven)
        a, b = (claim.things[i].name for i in course.pairs[found.pair, :2].tolist())
        self.gaps.append(UnprovenPair(claim.node, claim.stretch.segments, (a, b), found.start, found.gap))
        return None

    def _joined(self, robots: tuple[str, ...]) -> tuple[list[int], KinematicTree]:
        """The first joint of each of several robots in the tree of all of them, and this tree: made once."""
        if robots not in self._trees:
            self._trees[robots] = joined([self.scene.robots[robot].tree for robot in robots])
        return self._trees[robots]

    def _apart_at_any_times(self, name: str, first: MovingStretch, second: MovingStretch) -> Claim:
        things, count = [*first.things, *second.things], len(first.things)
        rows = self.choice.across(first.things, second.things)
        kept = kept_distances(things, rows + np.array([0, count, 0]), frozenset(), {})

        def course(cut: int) -> Course:
            return replace(every_pair_of_pieces(first.course, second.course, rows, cut), kept=kept)

        wanted = self._wanted(course(CUTS[0]), things)
        assert wanted is not None, "nothing is passing"

        def ways() -> Iterator[tuple[Course, Array, int]]:
            for cut in CUTS:
                made = course(cut)
                yield made, wanted, cut
                if len(made.waypoints) > MAX_WAYPOINTS:
                    return

        return Claim(name, second.stretch, things, ways, first.stretch.segments)

    def _passing(self, node: Node, stretch: MotionStretch, things: Sequence[Thing]) -> frozenset[frozenset[str]]:
        """Pairs of fingers and bodies not held by them, while no hand moves: these are proven apart even if permitted."""
        passing: set[frozenset[str]] = set()
        for name in stretch.waypoints:
            robot = self.scene.robots[name]
            own = [node.motion[i] for i in stretch.segments if node.motion[i].robot == name]
            if robot.gripper is not None and all(segment.joints == robot.planned_joints for segment in own):
                others = [thing.name for thing in things if "." not in thing.name and thing.robot != name]
                passing |= {frozenset((link, other)) for link in robot.gripper.touch_links for other in others}
        return frozenset(passing)
