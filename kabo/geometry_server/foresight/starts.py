"""What is wrong with a scene at its start: objects that overlap, stand inside others, are too near, or hang in the air.

Objects that a robot holds, as in the state of a run, hang in its hand, and may touch it.
What a robot may grasp is examined, and of other movable objects whether they overlap something; what is fixed may
overlap by intention, as walls do. The original meshes decide, through python-fcl; the convex parts of two things
are asked only where these are less than epsilon apart.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kabo import geometry  # its names load when they are used: python-fcl only here
from kabo.arrays import Array
from kabo.errors import InputError
from kabo.geometry import Solid
from kabo.geometry_server.foresight.clutches import clutch
from kabo.geometry_server.foresight.measures import millimetres
from kabo.geometry_server.foresight.things import Thing, placed, things_at_start
from kabo.geometry_server.predicates import ScenePredicates
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.support_relations import supports, why_unsupported
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.scene.transforms import inverse

KEY = "start faults"  # of what surroundings note
TOUCHING = 1e-4  # [m]: as far as constraints of placements hold, and as deep as what stands may lie in its support
MAX_STEPS = 60  # of an object that is let down until it touches


@dataclass(frozen=True)
class StartFault:
    """Something wrong at the start: the things, a clause for users, and the remedy.

    `metres`: how deep they overlap, how near they are, or how far the object hangs above what is below it; None if
    nothing is below it. `proven`: exact geometry says so; if not, epsilon decides.
    """

    kind: Literal["overlap", "inside", "near", "floating", "unsupported", "loose", "clutched"]
    things: tuple[str, ...]
    said: str
    hint: str
    metres: float | None = None
    proven: bool = True


def start_faults(surroundings: SceneSurroundings, *, parts: bool = True) -> tuple[StartFault, ...]:
    """Everything that is wrong at the start with what is movable, in the order of the scene; computed once.

    Without `parts` no convex part is made, and things that are only near are not told.
    """
    found: tuple[StartFault, ...] = surroundings.noted(
        (KEY, parts), lambda: tuple(_Start(surroundings, parts).faults())
    )
    return found


def start_faults_so_far(surroundings: SceneSurroundings) -> tuple[StartFault, ...]:
    """What `start_faults` without `parts` has found, if it was asked before; for those who have no time left."""
    found: tuple[StartFault, ...] | None = surroundings.recalled((KEY, False))
    return found or ()


def overlapping(surroundings: SceneSurroundings, situation: Situation, name: str) -> StartFault | None:
    """The first proven overlap of an object with a body, where both are still as at the start; None if there is none.

    Whoever grasps the object there has it in collision before it moves. Pairs that a mate joins are left out.
    """
    scene = surroundings.scene

    def unmoved(thing: str) -> bool:
        moved = thing in situation.objects and situation.objects[thing] != (scene.start.objects[thing],)
        return thing in scene.bodies and not moved

    for fault in start_faults(surroundings, parts=False):
        overlaps = fault.kind in ("overlap", "inside") and name in fault.things
        if overlaps and all(map(unmoved, fault.things)) and not any(scene.mates_between(*fault.things)):
            return fault
    return None


class _Start:
    """The things of a scene at its start."""

    def __init__(self, surroundings: SceneSurroundings, parts: bool) -> None:
        self.surroundings, self.scene, self.parts = surroundings, surroundings.scene, parts
        state = self.scene.start
        self.things = things_at_start(self.scene)
        situation = Situation.of(state)
        roots = {name: situation.held(name).parent.partition(".") for name in state.objects}
        self.holders = {name: robot for name, (robot, dot, _) in roots.items() if dot}
        movable = [body for body in self.scene.bodies.values() if body.movable]
        self.graspable = {body.name for body in movable if body.grasps}
        self.others = {body.name for body in movable if not body.grasps}

    def faults(self) -> Iterator[StartFault]:
        """The faults of every object that can be grasped, then overlaps of other movable ones; a pair is told once."""
        done: set[frozenset[str]] = set()
        for own in self.things:
            if own.name not in self.graspable:
                continue
            carried = supports(self.surroundings, Situation.of(self.scene.start), own.name)
            pairs = [
                fault for other in self.things if (fault := self._pair(own, other, carried, done)) is not None
            ]
            hanging: list[StartFault] = []
            if (
                not carried
                and own.name not in self.holders
                and not any(fault.kind in ("overlap", "inside") for fault in pairs)
            ):
                hanging = list(self._unsupported(own))
            if own.name in self.holders:
                hanging = [*self._loose(own), *self._clutched(own)]
            above = {fault.things for fault in hanging}
            yield from (fault for fault in pairs if fault.things not in above)
            yield from hanging
        yield from self._overlaps_of_others(done)

    def _overlaps_of_others(self, done: set[frozenset[str]]) -> Iterator[StartFault]:
        """The overlaps of movable objects that nobody can grasp: they may be pushed, or hang, so nothing else is told."""
        for own in self.things:
            if own.name not in self.others:
                continue
            carried = supports(self.surroundings, Situation.of(self.scene.start), own.name)
            for other in self.things:
                fault = self._pair(own, other, carried, done)
                if fault is not None and fault.kind in ("overlap", "inside"):
                    yield fault

    def _loose(self, own: Thing) -> Iterator[StartFault]:
        """A fault if a hand is said to hold an object that it does not touch, to epsilon."""
        robot = self.holders[own.name]
        gripper, epsilon = self.scene.robots[robot].gripper, self.surroundings.budget.epsilon
        links = () if gripper is None else gripper.touch_links
        touching = [thing for thing in self.things if thing.name in links]
        apart = min((geometry.exact_distance(own.group(), link.group()) for link in touching), default=0.0)
        if apart > epsilon:
            said = f"{own.name} is held by {robot} at the start, but {millimetres(apart)} away from its fingers"
            hint = "close the hand around it, or say where it is"
            yield StartFault("loose", (own.name,), said, hint, apart)

    def _clutched(self, own: Thing) -> Iterator[StartFault]:
        """A fault if a hand holds an object such that it cannot let go of it: its open fingers would overlap it."""
        robot = self.holders[own.name]
        found = clutch(self.scene, robot, own.name, self.things)
        if found is None:
            return
        depth = max(float(_depths(own, found.opened).max()), float(_depths(found.opened, own).max()))
        if depth > TOUCHING:
            said = (
                f"{own.name} sits in the hand of {robot} such that it cannot be let go of: when the hand is open, "
                f"{found.finger} and {own.name} overlap by up to {millimetres(depth)}, proven"
            )
            hint = f"turn or shift {own.name} in the hand, or take it out and say where it is"
            yield StartFault("clutched", (own.name, found.finger), said, hint, depth)

    # --------------------------------------------------------------------------------------------------- pairs
    def _pair(
        self, own: Thing, other: Thing, carried: tuple[str, ...], done: set[frozenset[str]]
    ) -> StartFault | None:
        pair, epsilon = frozenset((own.name, other.name)), self.surroundings.budget.epsilon
        if (
            own is other
            or pair in done
            or other.name in carried
            or self._touches_hand(own.name, other.name)
            or self.surroundings.never_collide(own.name, other.name)
        ):
            return None
        if np.any(own.low > other.high + epsilon) or np.any(other.low > own.high + epsilon):
            return None
        done.add(pair)
        if geometry.exact_collides(own.group(), other.group()):
            return self._overlap(own, other)
        if not self.parts:
            return None
        apart = geometry.exact_distance(own.group(), other.group())
        if TOUCHING < apart < epsilon and self._is_taken_to_touch(own.name, other.name):
            said = (
                f"{own.name} is {millimetres(apart)} from {other.name} at the start: "
                f"closer than epsilon = {millimetres(epsilon)} tells apart"
            )
            hint = "place them farther apart, or give a smaller epsilon"
            return StartFault("near", (own.name, other.name), said, hint, apart, proven=False)
        return None

    def _touches_hand(self, name: str, link: str) -> bool:
        """Whether an object is held by a robot, and the link is one of those with which this robot grasps."""
        holder = self.holders.get(name)
        gripper = None if holder is None else self.scene.robots[holder].gripper
        return gripper is not None and link in gripper.touch_links

    def _overlap(self, own: Thing, other: Thing) -> StartFault | None:
        """Two things that share points, more than at a contact: how deep, and whether one stands inside the other."""
        ours, theirs = _depths(own, other), _depths(other, own)
        depth = max(float(ours.max()), float(theirs.max()))
        if depth <= TOUCHING and self._hangs_on(own, other):
            return None
        first, second = (own, other) if not (theirs > -TOUCHING).all() else (other, own)
        things = first.name, second.name
        hint = "a pose is in the frame that its `frame` names, by default the world: move one of them"
        if other.name in self.scene.bodies:
            hint += _raised(own, other)
        if ((ours if first is own else theirs) > -TOUCHING).all():
            said = f"{first.name} begins inside {second.name}, up to {millimetres(depth)} deep, proven"
            return StartFault("inside", things, said, hint, depth)
        said = f"{first.name} and {second.name} overlap at the start, by up to {millimetres(depth)}, proven"
        return StartFault("overlap", things, said, hint, depth)

    @staticmethod
    def _hangs_on(own: Thing, other: Thing) -> bool:
        """Whether two things only touch: lifted by twice the tolerance, or let down by it, they do not overlap."""
        lengths = (-2.0 * TOUCHING, 2.0 * TOUCHING)
        return not all(geometry.exact_collides(own.group(length), other.group()) for length in lengths)

    def _is_taken_to_touch(self, first: str, second: str) -> bool:
        """Whether the convex parts of two things are not proven apart; True if there are no parts."""
        predicates = ScenePredicates(self.surroundings, self.scene.start)
        try:
            return predicates.collide(first, second)
        except InputError:
            return True

    # ------------------------------------------------------------------------------------------------- supports
    def _unsupported(self, own: Thing) -> Iterator[StartFault]:
        """A fault if nothing carries an object: the gap below it, or why what it touches is no support."""
        gaps = [
            (gap, other.name) for other in self.things if other is not own if (gap := _gap(own, other)) is not None
        ]
        gap, below = min(gaps, default=(None, None))
        if gap is not None and gap <= TOUCHING:
            why = why_unsupported(self.surroundings, Situation.of(self.scene.start), own.name)
            if why is not None and self.scene.bodies[own.name].placements:
                hint = "a robot that lifts it is permitted to leave only what a placement family says it stands on"
                yield StartFault("unsupported", (own.name,), why, hint, proven=False)
            return
        if gap is None or below is None:
            said, hint = f"{own.name} hangs in the air at the start: nothing is below it", "give it a support"
            yield StartFault("floating", (own.name,), said, hint)
        else:
            said = f"{own.name} hangs in the air at the start: {millimetres(gap)} above {below}"
            yield StartFault("floating", (own.name, below), said, f"lower it by {millimetres(gap)}", gap)


def _raised(own: Thing, other: Thing) -> str:
    """How much higher an object is free of what is under its middle, as the end of a remedy; empty if little is there."""
    middle, height = 0.5 * (own.low + own.high), float(other.high[2] - own.low[2])
    carries = bool(np.all(other.low[:2] <= middle[:2]) and np.all(middle[:2] <= other.high[:2]))
    return f"; {own.name} is above {other.name} if it is {millimetres(height)} higher" if carries else ""


def _depths(inner: Thing, outer: Thing) -> Array:
    """How deep points of the inner body lie in the outer solid [m]; negative outside.

    The points are the corners and middles of the mesh's triangles, and what lies half-way to their mean, if inside.
    """
    corners = inner.mesh.vertices
    within = 0.5 * (corners + corners.mean(axis=0))
    own = Solid(corners, inner.mesh.faces)
    points = np.concatenate([corners, corners[inner.mesh.faces].mean(axis=1), within[own.insides(within)]])
    local = placed(placed(points, inner.pose), inverse(outer.pose))
    solid = Solid(outer.mesh.vertices, outer.mesh.faces)
    distances = solid.surface_distances(local)
    return np.asarray(np.where(solid.insides(local), distances, -distances))


def _gap(own: Thing, other: Thing) -> float | None:
    """How far an object can be let down until it touches another thing [m]; None if it never does.

    Whatever is at a distance d is not touched by moving less than d, so steps of the distance never pass it.
    """
    beside = np.any(own.low[:2] > other.high[:2]) or np.any(other.low[:2] > own.high[:2])
    if beside or other.low[2] > own.high[2]:
        return None
    lowered, most = 0.0, float(own.high[2] - other.low[2])
    for _ in range(MAX_STEPS):
        apart = geometry.exact_distance(own.group(lowered), other.group())
        if apart <= 0.5 * TOUCHING:
            return lowered + apart
        lowered += apart
        if lowered > most:
            return None
    return lowered
