"""Proofs that two links of a robot overlap at every configuration, where few joints lie between them.

At the middle of a cell of joint values, a point of one link lies inside the other link's solid, by some depth. No
configuration of the cell moves the point farther than the sum of turns times levers. If that is less than the depth, the
links overlap in the whole cell; else the cell is halved.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.errors import InputError
from kabo.geometry_server.robot_models.link_pairs import LinkPair
from kabo.meshes import Mesh, require_closed
from kabo.scene import REVOLUTE, Robot, link_poses
from kabo.scene.transforms import inverse

MAX_VALUES = 2  # joint values between two links; more make too many cells
MAX_CELLS = 400  # of one pair, and of either link's points
MAX_POINTS = 300  # of a link
LEAST_DEPTH = 2e-4  # [m]: a smaller overlap is not followed
NUMERIC = 1e-6  # [m] of depths and motions


@dataclass(frozen=True)
class _Lever:
    """A joint between two links: the joint value that moves it, and how far a point moves for a unit of this value."""

    value: int
    inner: bool  # whether it is on the side of the link whose points are followed
    ratio: float
    length: float  # from the joint to its link's frame, at most [m]; of a prismatic joint 0
    revolute: bool


def always_overlap(robot: Robot, pair: LinkPair) -> float | None:
    """The least depth [m] by which two links are proven to overlap at every configuration; None if it is not proven."""
    for first, second in (pair, pair[::-1]):
        proof = _Proof.of(robot, first, second)
        if proof is not None and (depth := proof.least_depth()) is not None:
            return depth
    return None


@dataclass(frozen=True)
class _Proof:
    robot: Robot
    point_link: str
    solid_link: str
    points: Array  # (P, 3) of the one link
    mesh: Mesh  # of the other
    levers: tuple[_Lever, ...]
    values: tuple[int, ...]  # the joint values between the links

    @classmethod
    def of(cls, robot: Robot, first: str, second: str) -> "_Proof | None":
        levers = _levers(robot, first, second)
        values = tuple(sorted({lever.value for lever in levers}))
        inner, outer = robot.links[first].mesh, robot.links[second].mesh
        if inner is None or outer is None or not 0 < len(values) <= MAX_VALUES or not _closed(outer):
            return None
        step = max(1, -(-len(inner.vertices) // MAX_POINTS))
        return cls(robot, first, second, inner.vertices[::step], outer, levers, values)

    def least_depth(self) -> float | None:
        """The least depth over all cells [m]; None if a cell is not proven."""
        from kabo.geometry import Solid

        solid, tree = Solid(self.mesh.vertices, self.mesh.faces), self.robot.tree
        cells = [(tree.lower[list(self.values)], tree.upper[list(self.values)])]
        least, asked = np.inf, 0
        while cells:
            low, high = cells.pop()
            asked += 1
            depth, moved = self._at(solid, 0.5 * (low + high), 0.5 * (high - low))
            if asked > MAX_CELLS or depth < LEAST_DEPTH:
                return None
            if moved + NUMERIC < depth:
                least = min(least, depth - moved)
                continue
            widest = int(np.argmax(high - low))
            middle = 0.5 * (low[widest] + high[widest])
            left, right = high.copy(), low.copy()
            left[widest] = right[widest] = middle
            cells += [(low, left), (right, high)]
        return least

    def _at(self, solid: "object", middle: Array, half: Array) -> tuple[float, float]:
        """The depth of the deepest point at the middle of a cell, and how far the cell moves that point [m]."""
        q = np.clip(np.zeros(self.robot.tree.size), self.robot.tree.lower, self.robot.tree.upper)
        q[list(self.values)] = middle
        poses = link_poses(self.robot, q.tolist())
        relative = inverse(poses[self.solid_link]) @ poses[self.point_link]
        local = self.points @ relative[:3, :3].T + relative[:3, 3]
        inside = solid.insides(local)  # type: ignore[attr-defined]
        if not inside.any():
            return 0.0, np.inf
        depths = np.where(inside, solid.surface_distances(local), 0.0)  # type: ignore[attr-defined]
        deepest = int(np.argmax(depths))
        depth = float(depths[deepest])
        turns = dict(zip(self.values, half.tolist(), strict=True))
        own, other = (float(np.linalg.norm(each[deepest])) for each in (self.points, local))
        return depth, sum(_motion(lever, turns, own, other + depth) for lever in self.levers)


def _motion(lever: _Lever, turns: Mapping[int, float], own: float, other: float) -> float:
    """How far a joint moves a point at most [m], `own` and `other` metres from the origins of the two links."""
    turn = abs(lever.ratio) * turns[lever.value]
    return turn * (lever.length + (own if lever.inner else other)) if lever.revolute else turn


def _closed(mesh: Mesh) -> bool:
    try:
        require_closed(mesh)
    except InputError:
        return False
    return True


def _levers(robot: Robot, first: str, second: str) -> tuple[_Lever, ...]:
    """The moving joints between two links, with the first link's as inner ones."""
    ways = [_way(robot, robot.links[name].joint) for name in (first, second)]
    shared = set(ways[0]) & set(ways[1])
    found = []
    for name, way, inner in ((first, ways[0], True), (second, ways[1], False)):
        length = float(np.linalg.norm(robot.links[name].joint_T_link[:3, 3]))
        for joint in way:
            if joint in shared:
                break
            tree = robot.tree
            revolute = bool(tree.kind[joint] == REVOLUTE)
            if tree.ratio[joint] != 0.0:
                found.append(_Lever(int(tree.source[joint]), inner, float(tree.ratio[joint]), length, revolute))
            length += float(np.linalg.norm(tree.placement[joint, 9:])) + _travel(robot, joint)
    return tuple(found)


def _travel(robot: Robot, joint: int) -> float:
    """How far a sliding joint is from its zero at most [m]; 0 for one that turns."""
    tree = robot.tree
    if tree.kind[joint] == REVOLUTE:
        return 0.0
    source = int(tree.source[joint])
    most = max(abs(float(tree.lower[source])), abs(float(tree.upper[source]))) if tree.ratio[joint] else 0.0
    return abs(float(tree.ratio[joint])) * most + abs(float(tree.shift[joint]))


def _way(robot: Robot, joint: int) -> Sequence[int]:
    """The joints from a link's up to the world."""
    found = []
    while joint > 0:
        found.append(joint)
        joint = int(robot.tree.parent[joint])
    return found
