"""The bodies of a stretch: those that move, on the joints that carry them, and those that stand.

What stretches have in common is made once: the links of a robot that moves, of one that stands in a configuration, and
bodies at a place.
"""

from collections.abc import Mapping

from kabo.arrays import Array
from kabo.geometry import Enclosure
from kabo.geometry.collision.separation_proofs import PlacedBody
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.planner.certify.certified_pairs import Thing
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.scene import Mesh, Robot, link_poses
from kabo.scene.transforms import flat


class StretchThings:
    """Makes the bodies of stretches."""

    def __init__(self, surroundings: SceneSurroundings, values: ComponentValues) -> None:
        self._surroundings, self._scene, self._values = surroundings, surroundings.scene, values
        self._fixed = [
            Thing(name, 0, PlacedBody(self._mesh(name), 0, flat(pose)), None, surroundings.kept(name))
            for name, pose in self._scene.fixed_poses.items()
        ]
        self._moving: dict[tuple[str, int], list[Thing]] = {}
        self._standing: dict[tuple[str, tuple[float, ...], int], list[Thing]] = {}
        self._bodies: dict[tuple[object, ...], Thing] = {}

    def enclosures(self) -> dict[str, Enclosure]:
        """The enclosure of every mesh, by its hash."""
        names = [
            f"{robot.name}.{link.name}"
            for robot in self._scene.robots.values()
            for link in robot.links.values()
            if link.mesh is not None
        ]
        made: dict[str, Enclosure] = {}
        for name in [*names, *self._scene.bodies]:
            digest = self._mesh(name)
            if digest not in made:
                made[digest] = self._surroundings.enclosure(name)
        return made

    def cuttable(self) -> dict[str, Mesh]:
        """The meshes of bodies that are nothing but this mesh, by their hashes: their parts may be refined."""
        names = [f"{r.name}.{link}" for r in self._scene.robots.values() for link in r.links]
        found: dict[str, Mesh] = {}
        others: set[str] = set()
        for name in [*names, *self._scene.bodies]:
            mesh, elements = self._surroundings.mesh(name), self._surroundings.elements(name)
            if mesh is not None:
                alone = (
                    len(elements) == 1 and elements[0].corners is None and elements[0].mesh.digest == mesh.digest
                )
                others |= set() if alone else {mesh.digest}
                found[mesh.digest] = mesh
        return {digest: mesh for digest, mesh in found.items() if digest not in others}

    def of(
        self, node: str, situation: MotionSituation, first: Mapping[str, int]
    ) -> tuple[list[Thing], list[Thing]]:
        """The moving bodies, on joints of the joined tree, and the standing ones.

        Args:
            node: the node whose motion it is.
            situation: what holds during the stretch.
            first: the number of the first joint of each moving robot in the joined tree.
        """
        moving: list[Thing] = []
        standing = list(self._fixed)
        for name in self._scene.robots:
            if name in first:
                moving += self._links(name, first[name])
            elif name in situation.q:
                standing += self._links_at(name, tuple(situation.q[name].tolist()), 0)
            else:
                for place, q in enumerate(self._values.configurations(node, name)):
                    standing += self._links_at(name, q, place)
        for body in self._scene.movable:
            where = situation.mounted(body) if body in situation.hung else None
            if where is not None and where.robot in first:
                joint = where.joint + first[where.robot] if where.joint else 0
                moving.append(self._body(body, 0, where.joint_T, where.robot, joint, where.joint))
            else:
                poses = situation.places[body] if body in situation.places else [situation.pose(body)]
                robot = None if where is None else where.robot
                standing += [self._body(body, place, pose, robot) for place, pose in enumerate(poses)]
        return moving, standing

    def _mesh(self, name: str) -> str:
        mesh = self._surroundings.mesh(name)
        assert mesh is not None
        return mesh.digest

    def _body(
        self, name: str, place: int, pose: Array, carrier: str | None, joint: int = 0, own_joint: int = -1
    ) -> Thing:
        """A movable body on a joint of a robot that moves, or at a place in the world; `carrier` holds it."""
        key = name, place, pose.tobytes(), carrier, joint, own_joint
        if key not in self._bodies:
            moves = carrier is not None and own_joint >= 0
            hand = self._scene.robots[carrier].hand(own_joint) if carrier is not None and moves else 0
            body = PlacedBody(self._scene.bodies[name].mesh.digest, joint, flat(pose))
            kept = self._surroundings.kept(name, carrier)
            self._bodies[key] = Thing(name, place, body, carrier if moves else None, kept, hand)
        return self._bodies[key]

    def _links(self, name: str, shift: int) -> list[Thing]:
        """The links of a robot that moves, on joints that are counted from `shift` on."""
        if (name, shift) not in self._moving:
            robot = self._scene.robots[name]
            self._moving[name, shift] = [
                self._link(robot, link.name, link.joint + shift if link.joint else 0, flat(link.joint_T_link))
                for link in robot.links.values()
                if link.mesh is not None
            ]
        return self._moving[name, shift]

    def _link(self, robot: Robot, link: str, joint: int, pose: Array, place: int = 0, moves: bool = True) -> Thing:
        name, own = f"{robot.name}.{link}", robot.links[link]
        body, hand = PlacedBody(self._mesh(name), joint, pose), robot.hand(own.joint)
        return Thing(name, place, body, robot.name if moves else None, self._surroundings.kept(name), hand)

    def _links_at(self, name: str, q: tuple[float, ...], place: int) -> list[Thing]:
        """The links of a robot that stands."""
        if (name, q, place) not in self._standing:
            robot = self._scene.robots[name]
            poses = link_poses(robot, q)
            self._standing[name, q, place] = [
                self._link(robot, link.name, 0, flat(poses[link.name]), place, moves=False)
                for link in robot.links.values()
                if link.mesh is not None
            ]
        return self._standing[name, q, place]
