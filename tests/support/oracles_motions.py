"""A judge of motions that is slow and obvious: many moments of a motion, the exact meshes, python-fcl, nothing proven.

It takes nothing from the verifier. What moves is told by what hangs together: a hand moves what it holds, and all
that is joined to that. Contacts that the plan permits are not looked at: whether they may be is not its business.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import fcl
import numpy as np

from kabo.plan import Node, Plan, Segment, StateChange
from kabo.scene import Attachment, GeometricState, Mesh, Scene, link_poses, world_T

STEP = 0.015  # [m] about how far an outer link moves between two moments
LEVER = 1.0  # [m] of a turning joint

Pair = tuple[str, str]


@dataclass
class Moment:
    """A moment of a motion: where everything is, which contacts are permitted, who moves."""

    time: float
    poses: dict[str, np.ndarray]
    permitted: frozenset[frozenset[str]]
    moving: frozenset[str]
    segment: int


@dataclass
class Hit:
    """Two things that overlap, and when."""

    node: str
    time: float
    pair: Pair


@dataclass
class Replay:
    """One motion in one state, moment by moment."""

    scene: Scene
    state: GeometricState
    segments: Sequence[Segment]
    permits: Sequence[tuple[Pair, ...]]
    held: dict[str, tuple[str, np.ndarray]] = field(default_factory=dict)
    joined: set[frozenset[str]] = field(default_factory=set)

    def __post_init__(self) -> None:
        scene = self.scene
        self.q = {name: np.array(q, dtype=float) for name, q in self.state.robots.items()}
        self.poses = {name: world_T(scene, self.state, name) for name in scene.bodies}
        self.links = {name: link_poses(robot, self.q[name]) for name, robot in scene.robots.items()}
        for name, where in self.state.objects.items():
            if where.parent in self.state.objects:
                self.joined.add(frozenset((name, where.parent)))
            elif where.parent != "world" and "." in where.parent:
                self.hold(name, where.parent)

    def hold(self, name: str, link: str) -> None:
        robot, _, own = link.partition(".")
        self.held[name] = link, np.linalg.inv(self.links[robot][own]) @ self.poses[name]

    def together(self, name: str) -> set[str]:
        """All that is joined to an object."""
        found, open_ = {name}, [name]
        while open_:
            one = open_.pop()
            for pair in self.joined:
                more = pair - found if one in pair else ()
                found |= set(more)
                open_ += list(more)
        return found

    def moments(self) -> Iterator[Moment]:
        """The moments in order of time."""
        ends = sorted({t for s in self.segments for t in (s.times[0], s.times[-1])})
        for start, end in zip(ends, ends[1:], strict=False):
            running = [i for i, s in enumerate(self.segments) if s.times[0] <= start and s.times[-1] >= end]
            if not running:
                continue
            for time in self._times(start, end, running):
                self._move(time, running)
                yield self._moment(time, running)
            for i in running:
                if self.segments[i].times[-1] == end:
                    self._events(self.segments[i])

    def _times(self, start: float, end: float, running: Sequence[int]) -> list[float]:
        knots = sorted({start, end, *(t for i in running for t in self.segments[i].times if start < t < end)})
        times = [start]
        for a, b in zip(knots, knots[1:], strict=False):
            moved = 0.0
            for i in running:
                segment = self.segments[i]
                rows = np.array([_at(segment, t) for t in (a, b)])
                moved += float(np.abs(rows[1] - rows[0]).sum()) * LEVER
            count = max(1, int(np.ceil(moved / STEP)))
            times += [a + (b - a) * k / count for k in range(1, count + 1)]
        return times

    def _move(self, time: float, running: Sequence[int]) -> None:
        for i in running:
            segment = self.segments[i]
            robot = self.scene.robots[segment.robot]
            columns = [robot.joint_names.index(joint) for joint in segment.joints]
            self.q[segment.robot][columns] = _at(segment, time)
            self.links[segment.robot] = link_poses(robot, self.q[segment.robot])
        for name, (link, link_T) in self.held.items():
            robot_name, _, own = link.partition(".")
            delta = self.links[robot_name][own] @ link_T @ np.linalg.inv(self.poses[name])
            if np.abs(delta - np.eye(4)).max() > 1e-12:
                for each in self.together(name):
                    self.poses[each] = delta @ self.poses[each]

    def _events(self, segment: Segment) -> None:
        for name in segment.detach:
            if name in self.held and self.held[name][0].partition(".")[0] == segment.robot:
                del self.held[name]
        for name, to in segment.attach:
            for each in self.together(name):
                self.held.pop(each, None)
            if "." in to:
                self.hold(name, to)
            else:
                self.joined.add(frozenset((name, to)))

    def _moment(self, time: float, running: Sequence[int]) -> Moment:
        robots = {self.segments[i].robot for i in running}
        poses = dict(self.poses)
        for name, links in self.links.items():
            poses |= {f"{name}.{link}": pose for link, pose in links.items()}
        moving = {thing for thing in poses if thing.partition(".")[0] in robots and "." in thing}
        for name, (link, _) in self.held.items():
            if link.partition(".")[0] in robots:
                moving |= self.together(name)
        permitted = frozenset(frozenset(pair) for i in running for pair in self.permits[i])
        return Moment(time, poses, permitted, frozenset(moving), running[0])


def _at(segment: Segment, time: float) -> np.ndarray:
    rows = np.asarray(segment.waypoints)
    return np.array([np.interp(time, segment.times, rows[:, k]) for k in range(rows.shape[1])])


class Judge:
    """Dense sampling of motions in a scene."""

    _models: dict[str, fcl.BVHModel] = {}  # by the digest of the mesh

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        meshes: dict[str, Mesh] = {name: body.mesh for name, body in scene.bodies.items()}
        for name, robot in scene.robots.items():
            meshes |= {f"{name}.{link.name}": link.mesh for link in robot.links.values() if link.mesh is not None}
        self.names = list(meshes)
        self.objects, self.centres, self.radii = {}, [], []
        for name, mesh in meshes.items():
            self.objects[name] = fcl.CollisionObject(self._model(mesh))
            lower, upper = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            self.centres.append((lower + upper) / 2)
            self.radii.append(np.linalg.norm(mesh.vertices - self.centres[-1], axis=1).max())
        pairs = [
            (i, j)
            for i, a in enumerate(self.names)
            for j, b in enumerate(self.names[:i])
            if not scene.never_collide(a, b)
        ]
        self.pairs = np.array(pairs, dtype=int).reshape(-1, 2)

    def _model(self, mesh: Mesh) -> fcl.BVHModel:
        if mesh.digest not in self._models:
            vertices, faces = np.ascontiguousarray(mesh.vertices), np.asarray(mesh.faces, dtype=np.int64)
            model = fcl.BVHModel()
            model.beginModel(len(vertices), len(faces))
            model.addSubModel(vertices, faces)
            model.endModel()
            self._models[mesh.digest] = model
        return self._models[mesh.digest]

    def hits(self, node: str, replay: Replay) -> Iterator[Hit]:
        """Overlaps that nobody permits, of things that move against each other; each pair once."""
        told: set[Pair] = set()
        first: Moment | None = None
        for moment in replay.moments():
            if first is None or moment.segment != first.segment:
                first = moment
            for pair in self._near(moment):
                if frozenset(pair) in moment.permitted or pair in told or not self._overlap(pair, moment):
                    continue
                if np.abs(_between(pair, moment) - _between(pair, first)).max() < 1e-9:
                    continue  # they do not move against each other, or only begin to
                told.add(pair)
                yield Hit(node, moment.time, pair)

    def least(self, pair: Pair, replay: Replay) -> float:
        """The least distance of two things over all moments [m]; 0 where they overlap."""
        moments, least = list(replay.moments()), np.inf
        if any(self._overlap(pair, moment) for moment in moments):
            return 0.0  # distances take much longer
        for moment in moments:
            first, second = self._placed(pair, moment)
            least = min(least, fcl.distance(first, second, fcl.DistanceRequest(), fcl.DistanceResult()))
        return float(least)

    def _near(self, moment: Moment) -> list[Pair]:
        poses = np.array([moment.poses[name] for name in self.names])
        centres = np.einsum("nij,nj->ni", poses[:, :3, :3], np.array(self.centres)) + poses[:, :3, 3]
        moving, radii = np.array([name in moment.moving for name in self.names]), np.array(self.radii)
        i, j = self.pairs[:, 0], self.pairs[:, 1]
        near = np.linalg.norm(centres[i] - centres[j], axis=1) <= radii[i] + radii[j]
        return [(self.names[a], self.names[b]) for a, b in self.pairs[near & (moving[i] | moving[j])]]

    def _placed(self, pair: Pair, moment: Moment):
        for name in pair:
            pose = moment.poses[name]
            self.objects[name].setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
        return self.objects[pair[0]], self.objects[pair[1]]

    def _overlap(self, pair: Pair, moment: Moment) -> bool:
        first, second = self._placed(pair, moment)
        return fcl.collide(first, second, fcl.CollisionRequest(), fcl.CollisionResult()) > 0


def _between(pair: Pair, moment: Moment) -> np.ndarray:
    """The pose of the second thing in the frame of the first."""
    result: np.ndarray = np.linalg.inv(moment.poses[pair[0]]) @ moment.poses[pair[1]]
    return result


def states_of(plan: Plan, scene: Scene, most: int = 8) -> dict[str, list[GeometricState]]:
    """The geometric states in which each node can begin, at most so many."""
    assert plan.start is not None
    found: dict[str, list[GeometricState]] = {name: [] for name in plan.nodes}
    open_ = [(plan.root, _changed(scene.start, plan.start, scene))]
    while open_:
        name, state = open_.pop()
        if name not in found or state in found[name] or len(found[name]) >= most:
            continue
        found[name].append(state)
        node = plan.nodes[name]
        after = state if node.after is None else _changed(state, node.after, scene)
        open_ += [(successor, after) for successor in node.successors]
    return found


def _changed(state: GeometricState, change: StateChange, scene: Scene) -> GeometricState:
    robots = {
        name: tuple(
            joints.get(j, v) for j, v in zip(scene.robots[name].joint_names, state.robots[name], strict=True)
        )
        for name, joints in change.robots.items()
    }
    objects = {n: Attachment(p.parent, p.position, p.quaternion) for n, p in change.objects.items()}
    return state.replace({**robots, **objects})


def replay_of(scene: Scene, state: GeometricState, node: Node, reference: Node | None = None) -> Replay:
    """The replay of a node; contacts are permitted as `reference` says of the same way, or else place."""
    known = {(s.robot, s.waypoints): s.allowed_contacts for s in ([] if reference is None else reference.motion)}
    same = [] if reference is None or len(reference.motion) != len(node.motion) else list(reference.motion)
    permits = []
    for i, segment in enumerate(node.motion):
        otherwise = same[i].allowed_contacts if same else segment.allowed_contacts
        permits.append(known.get((segment.robot, segment.waypoints), otherwise))
    return Replay(scene, state, node.motion, permits)


def collisions(
    scene: Scene, plan: Plan, nodes: Sequence[str], reference: Mapping[str, Node] | None = None
) -> Iterator[Hit]:
    """Overlaps in the motions of some nodes of a plan, in every state in which they can begin."""
    judge, states = Judge(scene), states_of(plan, scene)
    for name in nodes:
        for state in states[name]:
            known = None if reference is None else reference.get(name)
            yield from judge.hits(name, replay_of(scene, state, plan.nodes[name], known))
