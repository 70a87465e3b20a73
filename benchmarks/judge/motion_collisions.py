"""Whether anything meets anything, on the original meshes, by coal: at every sample of every stretch.

Not every pair is asked at every sample: two bodies that are d apart, and of which no point moves farther than m until
a later sample, are there at least d - m apart. The points of a body move no farther than the corners of its box.
"""

from dataclasses import dataclass, field
from typing import Any

import coal
import numpy as np
from motion_limits import RATE
from motion_scene import Array, Scene
from motion_states import Motion, State, Stretch

NEAR = 0.025  # [m] distances above this are not told apart
FINE, SHARE = 1e-4, 0.03  # [m], and of the least distance: by so much it may be less between two looks


@dataclass
class Track:
    """A body over the samples of a stretch: poses (T, 4, 4), or (1, 4, 4) if it stands, and how far it has come (T,)."""

    name: str
    geometry: Any
    poses: Array
    joint: Any  # what carries it: robot and moving joint; None if it stands
    way: Array
    low: Array  # (T, 3) its box in the world
    high: Array


@dataclass
class Least:
    """The least distance of a segment [m], of which bodies, and all collisions."""

    distance: float = np.inf
    between: tuple[str, str] | None = None
    collisions: list[tuple[str, str, float]] = field(default_factory=list)
    asked: int = 0
    samples: int = 0


def samples(begin: float, end: float) -> Array:
    """The times of samples at a fixed rate, and both ends."""
    regular = np.arange(np.ceil(begin * RATE), np.floor(end * RATE) + 1) / RATE
    return np.unique(np.concatenate([[begin, end], regular[(regular > begin) & (regular < end)]]))


def permitted(stretch: Stretch) -> set[frozenset[str]]:
    """The contacts that the segments under way have permitted."""
    return {frozenset(pair) for each in stretch.under_way for pair in each.said["allowed_contacts"]}


class Collisions:
    """Looks for collisions in one scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.request, self.result = coal.DistanceRequest(), coal.DistanceResult()
        self.touch, self.touched = coal.CollisionRequest(), coal.CollisionResult()
        self.neighbours: dict[tuple[str, str, str], bool] = {}

    def least(self, motion: Motion, stretch: Stretch, others: list[State]) -> Least:
        """The least distance over a stretch, and what collides, whatever the state of all that does not move."""
        at = samples(stretch.begin, stretch.end)
        moving = self._moving(motion, stretch, at)
        standing = self._standing(motion, stretch, {track.name for track in moving}, others)
        couples = [(a, b) for i, a in enumerate(moving) for b in (*moving[i + 1 :], *standing)]
        return self._least(couples, permitted(stretch), at)

    def meeting(self, before: Motion, motion: Motion, overlap: float) -> list[Least]:
        """The same of a motion that begins `overlap` seconds before the one before it ends: of one against the other."""
        found, early = [], before.end - overlap
        for first in before.stretches():
            for second in motion.stretches():
                begin, end = max(first.begin - early, second.begin), min(first.end - early, second.end, overlap)
                if end > begin:
                    at = samples(begin, end)
                    tracks = self._moving(before, first, at + early), self._moving(motion, second, at)
                    couples = [(a, b) for a in tracks[0] for b in tracks[1]]
                    found.append(self._least(couples, permitted(first) | permitted(second), at))
        return found

    def _least(self, couples: list[tuple[Track, Track]], allowed: set[frozenset[str]], at: Array) -> Least:
        found, pairs = Least(samples=len(at)), []
        for first, second in couples:
            if (
                first.joint == second.joint
                or first.name == second.name
                or self._never(first.name, second.name, allowed)
            ):
                continue
            apart = np.maximum(first.low - second.high, second.low - first.high)
            boxes = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
            if boxes.min() < NEAR:
                pairs.append((float(boxes.min()), len(pairs), first, second, boxes))
        for _, _, first, second, boxes in sorted(pairs, key=lambda pair: pair[:2]):
            self._pair(first, second, boxes, at, found)
        return found

    def _pair(self, first: Track, second: Track, boxes: Array, at: Array, found: Least) -> None:
        """Looks at a pair wherever it may be nearer than anything before; `boxes` are lower bounds (T,)."""
        way = first.way + second.way if len(second.way) > 1 else first.way
        k = 0
        while k < len(at):
            own = min(NEAR, found.distance)
            if boxes[k] > own:
                later = np.flatnonzero(boxes[k:] <= own)
                if not len(later):
                    return
                k += int(later[0])
            distance = self.distance(first, second, k)
            found.asked += 1
            if distance <= 0.0:
                found.collisions.append((first.name, second.name, float(at[k])))
                found.distance, found.between = min(found.distance, distance), (first.name, second.name)
                return
            if distance < found.distance:
                found.distance, found.between = distance, (first.name, second.name)
            own = min(NEAR, found.distance)
            fine = max(FINE, SHARE * own)
            slack = max(distance - own, fine if distance > 2 * fine else 0.0)
            k = max(k + 1, int(np.searchsorted(way, way[k] + slack, side="right")))

    def distance(self, first: Track, second: Track, k: int) -> float:
        """The distance of two bodies at a sample [m]; 0 or less if they meet."""
        placed = [coal.Transform3s(t[:3, :3], t[:3, 3]) for t in (_at(first, k), _at(second, k))]
        self.result.clear()
        distance = coal.distance(first.geometry, placed[0], second.geometry, placed[1], self.request, self.result)
        if distance <= 1e-7:
            self.touched.clear()
            if coal.collide(first.geometry, placed[0], second.geometry, placed[1], self.touch, self.touched):
                return min(distance, 0.0)
            return max(distance, 1e-9)
        return float(distance)

    def _never(self, first: str, second: str, allowed: set[frozenset[str]]) -> bool:
        return (
            frozenset((first, second)) in allowed
            or self.scene.may_touch(first, second)
            or self._near(first, second)
        )

    def _near(self, first: str, second: str) -> bool:
        """Whether two links of a robot belong to one moving joint, or to a joint and its parent."""
        (robot, dot, a), (other, _, b) = first.partition("."), second.partition(".")
        if not dot or robot != other or robot not in self.scene.robots:
            return False
        key = robot, a, b
        if key not in self.neighbours:
            owner = self.scene.robots[robot]
            joints = [
                owner.settled(owner.model.frames[owner.frames[link]].parentJoint, self.moved[robot])
                for link in (a, b)
            ]
            above = [owner.settled(owner.model.parents[j], self.moved[robot]) if j else -1 for j in joints]
            self.neighbours[key] = joints[0] == joints[1] or above[0] == joints[1] or above[1] == joints[0]
        return self.neighbours[key]

    def start(self, state: State) -> None:
        """Notes which joints of each robot move at all: those that states speak of."""
        self.moved = {name: self.scene.robots[name].moving(values) for name, values in state.robots.items()}

    def _moving(self, motion: Motion, stretch: Stretch, at: Array) -> list[Track]:
        found = []
        for name in dict.fromkeys(each.robot for each in stretch.under_way):
            robot = self.scene.robots[name]
            joints = robot.moving(j for each in stretch.under_way if each.robot == name for j in each.joints)
            carried = {
                link: robot.settled(robot.model.frames[i].parentJoint, joints) for link, i in robot.frames.items()
            }
            held = {thing: self._carrier(thing, stretch) for thing in stretch.parents}
            held = {thing: link for thing, (owner, link) in held.items() if owner == name and carried.get(link)}
            wanted = [link for link in robot.frames if carried[link] and link in robot.shapes]
            poses = motion.links(name, [*dict.fromkeys([*wanted, *held.values()])], at)
            for link in wanted:
                found += self._tracks(name, link, poses[link], (name, carried[link]))
            for thing, link in held.items():
                there = poses[link] @ self._within(thing, stretch)
                found.append(_track(thing, self.scene.bodies[thing], there, (name, carried[link])))
        return found

    def _tracks(self, robot: str, link: str, poses: Array, joint: Any) -> list[Track]:
        owner = self.scene.robots[robot]
        frame = owner.model.frames[owner.frames[link]].placement.inverse().homogeneous
        return [
            _track(f"{robot}.{link}", geometry, poses @ (frame @ at), joint)
            for _, at, geometry in owner.shapes[link]
        ]

    def _carrier(self, thing: str, stretch: Stretch) -> tuple[str, str]:
        parent = stretch.parents[thing][0]
        while parent in stretch.parents:
            parent = stretch.parents[parent][0]
        robot, _, link = parent.partition(".")
        return robot, link

    def _within(self, thing: str, stretch: Stretch) -> Array:
        parent, own = stretch.parents[thing]
        return self._within(parent, stretch) @ own if parent in stretch.parents else own

    def _standing(self, motion: Motion, stretch: Stretch, moving: set[str], others: list[State]) -> list[Track]:
        """All that stands, at every place where a state has it."""
        places: dict[tuple[Any, ...], Track] = {}
        for state in others:
            here = Motion.__new__(Motion)
            here.scene, here.state, here.curves = self.scene, self._mixed(motion, stretch, state), motion.curves
            at = np.array([stretch.begin])
            for name, geometry in self.scene.bodies.items():
                if name not in moving:
                    parents = {
                        **state.objects,
                        **{k: v for k, v in stretch.parents.items() if v is not motion.state.objects.get(k)},
                    }
                    self._add(places, name, geometry, here.world(name, at, parents))
            for name, robot in self.scene.robots.items():
                links = [link for link in robot.shapes if f"{name}.{link}" not in moving]
                for link, poses in here.links(name, links, at).items():
                    for track in self._tracks(name, link, poses, None):
                        self._add(places, track.name, track.geometry, track.poses)
        return list(places.values())

    @staticmethod
    def _mixed(motion: Motion, stretch: Stretch, state: State) -> State:
        """The state of what does not move, and the robots of the motion as they begin it."""
        movers = {each.robot for each in motion.curves}
        robots = {name: motion.state.robots[name] if name in movers else own for name, own in state.robots.items()}
        return State(robots, state.objects)

    @staticmethod
    def _add(places: dict[tuple[Any, ...], Track], name: str, geometry: Any, poses: Array) -> None:
        key = (name, id(geometry), *poses[0, :3].round(9).ravel())
        if key not in places:
            places[key] = _track(name, geometry, poses, None)


def _at(track: Track, k: int) -> Array:
    return track.poses[k if len(track.poses) > 1 else 0]


def _track(name: str, geometry: Any, poses: Array, joint: Any) -> Track:
    geometry.computeLocalAABB()
    low, high = np.array(geometry.aabb_local.min_), np.array(geometry.aabb_local.max_)
    corners = np.array([[*np.where([i & 1, i & 2, i & 4], high, low)] for i in range(8)])
    points = np.einsum("tij,cj->tci", poses[:, :3, :3], corners) + poses[:, None, :3, 3]
    steps = np.linalg.norm(np.diff(points, axis=0), axis=2).max(axis=1)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    return Track(name, geometry, poses, joint, way, points.min(axis=1), points.max(axis=1))
