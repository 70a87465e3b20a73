"""Makes the certificate of a plan: for every stretch of motion, proofs that moving bodies do not collide.

It uses only the plan as it will be written, as the verifier does. A component of the geometric state with several
possible values is treated as if it had all of them at once.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.errors import CutOff
from kabo.geometry import Enclosure
from kabo.geometry.collision.part_trees import Cover
from kabo.geometry.collision.separation_proofs import Course, PlacedBody, Unproven
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.phases import phase
from kabo.plan import (
    Certificate,
    Clearance,
    Node,
    PairProof,
    Plan,
    StretchProof,
    topological_order,
)
from kabo.planner.certify.best_margins import ProvenStretch, widen
from kabo.planner.certify.certified_bodies import CertifiedBodies
from kabo.planner.certify.certified_pairs import PairChoice, Thing
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import MotionStretch, joined, stretches
from kabo.planner.certify.overlapping_pairs import every_pair_of_pieces, from_time_on
from kabo.scene import Robot, link_poses
from kabo.scene.transforms import flat

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
    plan: Plan, surroundings: SceneSurroundings, near: float | None = None, look: Callable[[], None] = never
) -> Certificate | list[UnprovenPair]:
    """The certificate of a plan, or the pairs of bodies that are not proven apart.

    Args:
        plan: the plan as it will be written.
        surroundings: the scene, with the convex parts for which the plan was made.
        near: the distance [m] above which a pair needs no separating axis; if None epsilon, or a quarter more than what
            bodies keep from each other, if that is more.
        look: called periodically; an exception that it raises ends the work.

    Raises:
        ValueError: the plan has a cycle, no start state, or moves something that may be in several places.
    """
    covers: dict[str, Cover] = {}
    while True:
        enough = max(surroundings.budget.epsilon, NEAR_FACTOR * surroundings.greatest_kept)
        certifying = _Certifying(plan, surroundings, near or enough, look, covers)
        made = certifying.made()
        if not certifying.bodies.divided:
            return made
        covers = certifying.bodies.covers  # all proofs are to be about the same parts


class _Certifying:
    def __init__(
        self,
        plan: Plan,
        surroundings: SceneSurroundings,
        near: float,
        look: Callable[[], None],
        covers: Mapping[str, Cover],
    ) -> None:
        self.look = look
        order = topological_order(plan)
        if order is None:
            raise ValueError("the plan has a cycle")
        self.plan, self.order, self.near = plan, order, near
        self.surroundings, self.scene = surroundings, surroundings.scene
        self.values = ComponentValues(plan, self.scene, order)
        self.bodies = CertifiedBodies(self._enclosures(), covers, surroundings.budget, near)
        self.gaps: list[UnprovenPair] = []
        self.choice = PairChoice(surroundings.never_collide)
        self._links = {name: self._links_of(robot) for name, robot in self.scene.robots.items()}
        self._fixed = [
            Thing(name, 0, self._mesh(name), None, 0, flat(pose), surroundings.kept(name))
            for name, pose in self.scene.fixed_poses.items()
        ]
        self._standing: dict[tuple[str, tuple[float, ...]], list[Array]] = {}
        early = {name for name, node in plan.nodes.items() if node.overlap}
        shared = early | {name for name, node in plan.nodes.items() if early & set(node.successors)}
        # Of motions that share time with another one.
        self._moved: dict[str, list[MovingStretch]] = {name: [] for name in shared}

    def made(self) -> Certificate | list[UnprovenPair]:
        proven: list[ProvenStretch] = []
        with phase("certifying", len(self.order), "nodes", log=_LOG) as step:
            for name in self.order:
                node = self.plan.nodes[name]
                proven += [*self._node(name, node), *self._early(name, node)] if node.motion else []
                step()
        if self.gaps:
            return self.gaps
        if not self.bodies.divided:  # else all is proven once more, with the divided parts
            widen(proven, frozenset(self.scene.movable), self.near, self.bodies.prove_best, self.look)
        proofs = tuple(_proof(each) for each in proven)
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
                pair = int(each.margins.argmin()) if len(each.margins) else -1
                margin = float(each.margins[pair]) if pair >= 0 else np.inf
                own = margin, each.names(pair) if margin < np.inf else None
                for i in each.stretch.segments:
                    least[i] = min(least.get(i, (np.inf, None)), own, key=lambda entry: entry[0])
        for i in sorted(least):
            margin, between = least[i]
            clearance = float(np.floor(margin * 10**DECIMALS)) / 10**DECIMALS if margin < self.near else None
            permitted = node.motion[i].allowed_contacts
            yield Clearance(name, i, clearance, None if clearance is None else between, permitted)

    # ------------------------------------------------------------------------------------------------ the scene
    def _enclosures(self) -> dict[str, Enclosure]:
        """The enclosure of every mesh, by its hash."""
        names = [
            f"{robot.name}.{link.name}"
            for robot in self.scene.robots.values()
            for link in robot.links.values()
            if link.mesh is not None
        ]
        made: dict[str, Enclosure] = {}
        for name in [*names, *self.scene.bodies]:
            digest = self._mesh(name)
            if digest not in made:
                made[digest] = self.surroundings.enclosure(name)
        return made

    def _mesh(self, name: str) -> str:
        mesh = self.surroundings.mesh(name)
        assert mesh is not None
        return mesh.digest

    def _links_of(self, robot: Robot) -> list[Thing]:
        found = []
        for link in robot.links.values():
            if link.mesh is not None:
                hand = robot.hand(link.joint)
                name, pose = f"{robot.name}.{link.name}", flat(link.joint_T_link)
                kept = self.surroundings.kept(name)
                found.append(Thing(name, 0, link.mesh.digest, robot.name, link.joint, pose, kept, hand))
        return found

    def _links_at(self, robot: str, q: tuple[float, ...], place: int) -> list[Thing]:
        if (robot, q) not in self._standing:
            poses = link_poses(self.scene.robots[robot], q)
            self._standing[robot, q] = [flat(poses[link.name.partition(".")[2]]) for link in self._links[robot]]
        poses_at = self._standing[robot, q]
        return [
            link._replace(place=place, robot=None, joint=0, pose=pose)
            for link, pose in zip(self._links[robot], poses_at, strict=True)
        ]

    # ------------------------------------------------------------------------------------------------- a node
    def _node(self, name: str, node: Node) -> Iterator[ProvenStretch]:
        moving = list(dict.fromkeys(segment.robot for segment in node.motion))
        situation = MotionSituation.at(name, self.values, self.scene, moving)
        for stretch in stretches(node.motion, dict(self.scene.robots), situation.q):
            self.look()
            found = self._stretch(name, node, stretch, situation)
            if found is not None:
                yield found
            for i in stretch.ending:
                situation.end(node.motion[i])

    def _early(self, name: str, node: Node) -> Iterator[ProvenStretch]:
        """Proofs that a motion that begins early never meets the rest of the previous one, however late either is."""
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
                found = [self._apart_at_any_times(name, tail, second) for second in self._moved[name]]
                yield from (each for each in found if each is not None)

    # ---------------------------------------------------------------------------------------------- a stretch
    def _stretch(
        self, name: str, node: Node, stretch: MotionStretch, situation: MotionSituation
    ) -> ProvenStretch | None:
        robots = [self.scene.robots[robot] for robot in stretch.waypoints]
        first_joint, tree = joined([robot.tree for robot in robots])
        moving, standing = self._things(name, situation, dict(zip(stretch.waypoints, first_joint, strict=True)))
        things = [*moving, *standing]
        permitted = frozenset(frozenset(p) for i in stretch.segments for p in node.motion[i].allowed_contacts)
        waypoints = np.hstack([stretch.waypoints[robot.name] for robot in robots])
        bodies = [PlacedBody(thing.mesh, thing.joint, thing.pose) for thing in things]
        if name in self._moved:
            alone = Course(
                tree,
                np.ascontiguousarray(waypoints),
                bodies[: len(moving)],
                np.empty((0, 3), np.int64),
                deviations=stretch.together,
            )
            self._moved[name].append(MovingStretch(stretch, alone, moving))
        passing = self._passing(node, stretch, things) & permitted
        for left_out in (permitted - passing, permitted) if passing else (permitted,):
            numbers, pairs = self.choice.pairs(things, len(moving), left_out, tree)
            grasped = _grasped(things, permitted)
            kept = np.array([_kept(things[i], things[k], grasped) for i, k in numbers])
            course = Course(
                tree, np.ascontiguousarray(waypoints), bodies, pairs, deviations=stretch.together, kept=kept
            )
            found = self.bodies.prove(course)
            if not isinstance(found, Unproven):
                break
        if isinstance(found, Unproven):
            a, b = (things[i].name for i in numbers[found.pair])
            self.gaps.append(UnprovenPair(name, stretch.segments, (a, b), found.start, found.gap))
            return None
        return ProvenStretch(name, stretch, course, things, numbers, found)

    def _apart_at_any_times(self, name: str, first: MovingStretch, second: MovingStretch) -> ProvenStretch | None:
        things, count = [*first.things, *second.things], len(first.things)
        pairs, rows = self.choice.across(first.things, second.things)
        kept = np.array([first.things[i].kept + second.things[k].kept for i, k in pairs])
        for cut in CUTS:
            self.look()
            course = replace(every_pair_of_pieces(first.course, second.course, rows, cut), kept=kept)
            found = self.bodies.prove(course)
            if not isinstance(found, Unproven) or len(course.waypoints) > MAX_WAYPOINTS:
                break
        if isinstance(found, Unproven):
            i, k = pairs[found.pair]
            names = first.things[i].name, second.things[k].name
            self.gaps.append(UnprovenPair(name, second.stretch.segments, names, found.start, found.gap))
            return None
        numbers = [(i, count + k) for i, k in pairs]
        before = first.stretch.segments
        return ProvenStretch(name, second.stretch, course, things, numbers, found, before, cut)

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

    def _things(
        self, name: str, situation: MotionSituation, first: Mapping[str, int]
    ) -> tuple[list[Thing], list[Thing]]:
        """The moving bodies, on joints of the joined tree, and the standing ones."""
        moving: list[Thing] = []
        standing = list(self._fixed)
        for robot in self.scene.robots:
            if robot in first:
                shift = first[robot]
                moving.extend(
                    link._replace(joint=link.joint + shift if link.joint else 0) for link in self._links[robot]
                )
            elif robot in situation.q:
                standing.extend(self._links_at(robot, tuple(situation.q[robot].tolist()), 0))
            else:
                for place, q in enumerate(self.values.configurations(name, robot)):
                    standing.extend(self._links_at(robot, q, place))
        for body in self.scene.movable:
            mesh = self.scene.bodies[body].mesh.digest
            where = situation.mounted(body) if body in situation.hung else None
            kept = self.surroundings.kept(body, None if where is None else where.robot)
            if where is not None and where.robot in first:
                joint = where.joint + first[where.robot] if where.joint else 0
                hand = self.scene.robots[where.robot].hand(where.joint)
                moving.append(Thing(body, 0, mesh, where.robot, joint, flat(where.joint_T), kept, hand))
            else:
                poses = situation.places[body] if body in situation.places else [situation.pose(body)]
                standing.extend(Thing(body, p, mesh, None, 0, flat(pose), kept) for p, pose in enumerate(poses))
        return moving, standing


def _proof(proven: ProvenStretch) -> StretchProof:
    """The proofs of a stretch as the plan has them."""
    pairs = []
    for (i, k), witness in zip(proven.numbers, proven.witnesses, strict=True):
        if witness is not None:
            first, second = proven.things[i], proven.things[k]
            pairs.append(PairProof(first.name, second.name, second.place, witness.walk, witness.axes))
    return StretchProof(proven.node, proven.stretch.segments, tuple(pairs), proven.before, proven.cut)


def _grasped(things: Sequence[Thing], permitted: frozenset[frozenset[str]]) -> set[tuple[str, str | None, int]]:
    """Bodies that a hand may touch, each with the robot and the hand."""
    hands = {thing.name: (thing.robot, thing.hand) for thing in things if thing.robot is not None and thing.hand}
    return {
        (other, *hands[link])
        for pair in permitted
        if len(pair) == 2
        for link, other in (tuple(pair), tuple(pair)[::-1])
        if link in hands and "." in link
    }


def _kept(first: Thing, second: Thing, grasped: set[tuple[str, str | None, int]]) -> float:
    """What two bodies keep from each other [m].

    It is nothing if only a gripper moves one relative to the other, or if one is of a hand that may touch the other.
    """
    same = first.robot is not None and (first.robot, first.hand) == (second.robot, second.hand) and first.hand > 0
    taken = (second.name, first.robot, first.hand) in grasped or (first.name, second.robot, second.hand) in grasped
    return 0.0 if same or taken else first.kept + second.kept
