"""The predicates of [K Def. 1] for things of a scene by name: bodies, links and motions in a geometric state.

`kabo.geometry` decides on the convex parts and poses of the named things; with `exact`, on the original meshes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo import geometry  # its names load when they are used: python-fcl only for `--geometry exact`
from kabo.arrays import Array
from kabo.geometry import Bounds, Enclosure, FixedGroup, InnerSolid, Motion, MovingGroup, SweptVolume, includes
from kabo.geometry_server.sight.views import Unseen, View
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.support_relations import lies_inside
from kabo.geometry_server.surroundings import SceneSurroundings, widened
from kabo.scene import GeometricState, inner_mesh, one_mesh, world_T
from kabo.scene.transforms import flat, transform

SOLE_HEIGHT = 1e-3  # [m] above a body's lowest point: vertices up to there touch the support
FAN_CORNERS = 20  # corners of a polygon in one convex part, beside the corner that all parts share
# [m] below a body's sole at which its support is tested: contact is never exact.
SOLE_DEPTHS = (2e-4, 1e-3, 2e-3)
MAX_EXACT_TRIANGLES = 2000  # a container of no more is used itself, without an inner bounding mesh


@dataclass(frozen=True)
class ScenePredicates:
    """Predicates on the things of a scene in one state.

    A thing is the name of a body, or `robot.link`. Allowed collisions of the scene are ignored.
    """

    surroundings: SceneSurroundings
    state: GeometricState

    def thing(self, name: str) -> FixedGroup:
        """A body or link at its pose in the state.

        Raises:
            ValueError: the thing has no geometry.
            KeyError: no thing has this name.
        """
        mesh = self.surroundings.mesh(name)
        arrays = None if mesh is None else (mesh.vertices, mesh.faces)
        elements = self.surroundings.elements(name)
        return FixedGroup(flat(self.pose(name)), self.surroundings.enclosure(name), arrays, elements)

    def pose(self, name: str) -> Array:
        """The pose (4, 4) of a thing in the world."""
        robot, dot, link = name.partition(".")
        if dot:
            return self.surroundings.links(robot, self.state.robots[robot])[link]
        return world_T(self.surroundings.scene, self.state, name)

    def motion(self, robot: str, waypoints: Sequence[Sequence[float]]) -> Motion:
        """The motion of a robot and what it holds along waypoints (W, n), straight in joint space."""
        chosen, groups = self.surroundings.scene.robots[robot], []
        for link in chosen.links.values():
            if link.mesh is not None:
                arrays = link.mesh.vertices, link.mesh.faces
                enclosure = self.surroundings.enclosure(f"{robot}.{link.name}")
                groups.append(MovingGroup(link.joint, flat(link.joint_T_link), enclosure, arrays, link.elements))
        situation = Situation.of(self.state)
        for name in situation.carried(robot):
            held, body = situation.held(name), self.surroundings.scene.bodies[name]
            arrays = body.mesh.vertices, body.mesh.faces
            link = chosen.links[held.parent.partition(".")[2]]
            pose = link.joint_T_link @ transform(held.position, held.quaternion)
            enclosure = self.surroundings.enclosure(name)
            groups.append(MovingGroup(link.joint, flat(pose), enclosure, arrays, body.elements))
        return Motion(chosen.tree, tuple(groups), np.array(waypoints, dtype=np.float64))

    def collide(self, first: str, second: str) -> bool:
        """Whether two things may collide [K Def. 1.1]."""
        if self.surroundings.exact:
            return geometry.exact_collides(self.thing(first), self.thing(second))
        return geometry.collides(self.thing(first), self.thing(second), self.surroundings.budget)

    def sweeps(self, motion: Motion, other: Motion | str) -> bool:
        """Whether a motion's swept volume may meet a thing, or another motion's swept volume [K Def. 1.2, 1.3]."""
        against = self.thing(other) if isinstance(other, str) else other
        mine, theirs = (
            max((body.kept for body in each.bodies), default=0.0) if isinstance(each, Motion) else each.kept
            for each in (motion, against)
        )
        budget = widened(self.surroundings.budget, mine + theirs)
        if self.surroundings.exact:
            return geometry.exact_sweep_collides(motion, against, 2.0 * budget.epsilon)
        return geometry.sweep_collides(motion, against, budget)

    def included(self, container: str, body: str) -> bool:
        """Whether a body is proven to lie inside a region, or inside the solid of another thing [K Def. 1.4]."""
        regions = self.surroundings.scene.regions
        if container in regions:
            return lies_inside(self.surroundings, body, self.pose(body), regions[container])
        if self.surroundings.exact:
            return geometry.exact_includes(self.thing(container), self.thing(body))
        return includes(self._container(container), self.thing(body), self.surroundings.budget)

    def stands_on(self, support: str, body: str, pose: Array) -> bool:
        """Whether the whole sole of a body at a pose (4, 4) is proven to lie on a support.

        The sole is the hull of the vertices within a millimetre of the lowest one: moved down by one of
        `SOLE_DEPTHS` it must be proven to lie inside the support.
        """
        mesh = self.surroundings.mesh(body)
        if mesh is None:
            raise ValueError(f"{body} has no geometry")
        points = mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
        touching = points[points[:, 2] <= points[:, 2].min() + SOLE_HEIGHT]
        container = self.surroundings.remembered(
            ("container", support, self.pose(support).tobytes()), lambda: self._container(support)
        )
        return any(
            includes(
                container, FixedGroup(flat(np.eye(4)), _flat(touching - (0.0, 0.0, d))), self.surroundings.budget
            )
            for d in SOLE_DEPTHS
        )

    def _container(self, name: str) -> InnerSolid:
        mesh, pose = self.surroundings.mesh(name), flat(self.pose(name))
        if mesh is None:
            raise ValueError(f"{name} has no geometry")
        within = self.surroundings.budget.geometry
        inner = [inner_mesh(each, within) for each in self.surroundings.elements(name)]
        deviation = max(gap for _, gap in inner)
        if deviation > 0.0:  # a round container: what lies in a mesh inside of it lies in it
            mesh = one_mesh([each for each, _ in inner]) or mesh
            return InnerSolid(pose, mesh.vertices, mesh.faces, deviation)
        if len(mesh.faces) <= MAX_EXACT_TRIANGLES:
            return InnerSolid(pose, mesh.vertices, mesh.faces, 0.0)
        return InnerSolid.within(pose, mesh.vertices, mesh.faces, self.surroundings.budget.geometry)

    def unseen(self, sensor: str, body: str) -> Unseen | None:
        """Why a camera (`robot.sensor`) does not see a body; None if it is proven to see all of it.

        Raises:
            KeyError: no robot, sensor or body has this name.
        """
        robot, _, name = sensor.partition(".")
        chosen = self.surroundings.scene.robots[robot]
        view = View(self.surroundings, Situation.of(self.state), chosen, chosen.sensors[name], body)
        return view.unseen(np.array(self.state.robots[robot]))

    def visible(self, sensor: str, body: str) -> bool:
        """Whether a camera (`robot.sensor`) is proven to see all of a body: nothing is in the way, and it is in range.

        False where anything reaches into a sight line, or any point is out of range or field of view; True where all
        of these are missed by epsilon.

        Raises:
            KeyError: no robot, sensor or body has this name.
        """
        return self.unseen(sensor, body) is None

    def distance(self, first: str, second: str) -> Bounds:
        """Proven bounds of the signed distance of two things [m]: negative where they overlap."""
        return geometry.signed_distance(self.thing(first), self.thing(second), self.surroundings.budget.geometry)

    def swept_volume(self, motion: Motion, tolerance: float | None = None) -> SweptVolume:
        """Polyhedra that contain a motion's swept volume, within `tolerance` [m]; None: the sweep's share of epsilon."""
        return geometry.swept_volume(motion, self.surroundings.budget.sweep if tolerance is None else tolerance)


def _flat(points: Array) -> Enclosure:
    """Convex parts whose union is the hull of points (V, 3) projected to the height of the lowest."""
    low, across = points[:, 2].min(), points[:, :2]
    try:
        corners = across[ConvexHull(across).vertices]
    except QhullError:  # a point, or all on one line
        corners = across
    ring = np.column_stack([corners, np.full(len(corners), low)])
    fans = [
        np.vstack([ring[:1], ring[k : k + FAN_CORNERS + 1]]) for k in range(0, max(1, len(ring) - 1), FAN_CORNERS)
    ]
    return Enclosure(tuple(np.ascontiguousarray(fan) for fan in fans), 0.0)
