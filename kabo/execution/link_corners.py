"""How far points of links, and of bodies that hands hold, are from where they should be: a quick bound, and a close one.

The difference of two poses is affine in the point, and its length convex: the corners of a box around a body bound it.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.scene import REVOLUTE, Robot, Scene, link_poses
from kabo.scene.transforms import inverse

Held = Mapping[str, tuple[str, Array]]  # of each body in a hand the link, and its pose (4, 4) in the link's frame


class Corners:
    """Boxes around all links and movable bodies of a scene, each in the body's own frame."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._links = {
            name: {link.name: link.mesh.box_corners for link in robot.links.values() if link.mesh is not None}
            for name, robot in scene.robots.items()
        }
        self._bodies = {name: scene.bodies[name].mesh.box_corners for name in scene.movable}
        self._turns = {name: self._turning(robot) for name, robot in scene.robots.items()}

    def _turning(self, robot: Robot) -> Array:
        """How far points of each link are from its origin, times how much each joint turns it (L, n) [m/rad]."""
        tree, rows = robot.tree, []
        for link, corners in self._links[robot.name].items():
            row, joint = np.zeros(len(robot.joint_names)), robot.links[link].joint
            while joint > 0:
                if tree.kind[joint] == REVOLUTE:
                    row[int(tree.source[joint])] += abs(float(tree.ratio[joint]))
                joint = int(tree.parent[joint])
            rows.append(row * float(np.linalg.norm(corners, axis=1).max()))
        return np.array(rows).reshape(-1, len(robot.joint_names))

    def bound(
        self, robot: str, actual: Sequence[float], planned: Sequence[float], origins: float, held: Held
    ) -> float:
        """How far any point may be off [m], if no link's origin is farther off than `origins` [m]."""
        off = np.abs(np.subtract(actual, planned))
        reach = max((self._reach(body, place) for body, (_, place) in held.items()), default=0.0)
        turned = float((self._turns[robot] @ off).max(initial=0.0))
        return origins + max(turned, reach * float(off.sum()))

    def _reach(self, body: str, place: Array) -> float:
        return float(np.linalg.norm(self._bodies[body] @ place[:3, :3].T + place[:3, 3], axis=1).max())

    def poses(
        self, robot: str, actual: Sequence[float], planned: Sequence[float], held: Held
    ) -> dict[str, tuple[Array, Array]]:
        """Of each link (`robot.link`), and of each body that the robot holds, the true pose (4, 4), and the planned one."""
        own = self.scene.robots[robot]
        true, wanted = link_poses(own, actual), link_poses(own, planned)
        found = {f"{robot}.{link}": (true[link], wanted[link]) for link in self._links[robot]}
        return found | {body: (true[link] @ at, wanted[link] @ at) for body, (link, at) in held.items()}

    def off(self, name: str, true: Array, wanted: Array) -> float:
        """How far points of a link or of a body are from where they would be in another pose (4, 4), at most [m]."""
        robot, _, link = name.partition(".")
        corners = self._links[robot][link] if link else self._bodies[name]
        off = corners @ (true[:3, :3] - wanted[:3, :3]).T + (true[:3, 3] - wanted[:3, 3])
        return float(np.linalg.norm(off, axis=1).max())

    def lost(
        self, poses: Mapping[str, tuple[Array, Array]], carrier: Mapping[str, str], pair: tuple[str, str]
    ) -> float:
        """How much nearer two things may be to each other than planned, because robots are off their paths [m].

        Args:
            poses: of things that robots move, true and planned. carrier: the robot of each. pair: the two things.
        """
        first, second = pair
        if first in poses and second in poses and carrier[first] == carrier[second]:
            (a, b), (c, d) = poses[first], poses[second]
            return self.off(second, inverse(a) @ c, inverse(b) @ d)
        return sum(self.off(name, *poses[name]) for name in pair if name in poses)
