"""A scene as a model of physics in MJCF, MuJoCo's format, written without MuJoCo.

Joints of robots are bodies `robot:joint` with a motor each; joints that mimic another one are coupled to it. Links and
bodies keep their names, `robot.link` and `body`. What planning never checks of a robot with itself does not touch.

Source: the MuJoCo documentation, XML reference.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations, product
from types import NoneType
from xml.etree.ElementTree import Element as Tag
from xml.etree.ElementTree import SubElement, indent, tostring

import numpy as np

from kabo.arrays import Array
from kabo.given import require_given
from kabo.scene import REVOLUTE, Robot, Scene, world_T
from kabo.scene.state import GeometricState
from kabo.scene.transforms import quaternion, transform
from kabo.simulation.bearable import movable_inertia
from kabo.simulation.contact_shapes import calm, contact_shapes, make_contact_shapes
from kabo.simulation.joined_parts import holding_mates
from kabo.simulation.masses import Mass, mass_of_body, masses_of_joints
from kabo.simulation.settings import USUAL, PhysicsSettings
from kabo.simulation.turning_fingers import arm_of

FARTHEST_TURN = 6.0  # [rad]: joints with wider limits turn without end
COLOURS = {"link": "0.62 0.64 0.68 1", "movable": "0.85 0.45 0.2 1", "fixed": "0.5 0.66 0.5 1"}
SOFTNESS = {"solref": "0.003 1", "solimp": "0.99 0.999 0.001", "condim": "4"}  # of contacts: stiff, without bounce
STIFF = {"solref": "0.004 1", "solimp": "0.99 0.999 0.001"}  # of ends of joints, and of joints that are coupled
TORSION = 0.005  # [m]: of friction about the normal, per normal force; as of a contact some millimetres wide


@dataclass(frozen=True)
class Motor:
    """A joint that a motor drives, and the joints that are coupled to it.

    Attributes:
        name: of the joint in the model, `robot:joint`.
        robot, joint: whose, and its name in configurations.
        gripper: whether it is a gripper's.
        effort: the greatest force or torque [N or Nm]; None: without limit.
        followers: the names of coupled joints, with ratio and shift of their values.
    """

    name: str
    robot: str
    joint: str
    gripper: bool
    effort: float | None
    followers: tuple[tuple[str, float, float], ...] = ()


@dataclass(frozen=True)
class PhysicsModel:
    """A model of physics: its text in MJCF, and what its joints and shapes are in the scene.

    Attributes:
        xml: the model.
        motors: in the order of the model's actuators.
        things: of each shape's name, the body or `robot.link` that it is of.
    """

    xml: str
    motors: tuple[Motor, ...]
    things: dict[str, str]


def physics_model(
    scene: Scene, settings: PhysicsSettings = USUAL, start: GeometricState | None = None
) -> PhysicsModel:
    """A scene as a model of physics, with bodies where they are in `start`, or as the scene says.

    Raises:
        ArgumentError: an argument is of a wrong kind.
        MeshError: a mesh has no volume, and no hull.
    """
    require_given("scene", scene, Scene)
    require_given("settings", settings, PhysicsSettings)
    require_given("start", start, GeometricState, NoneType)
    return _Writer(scene, settings, start or scene.start).model()


class _Writer:
    def __init__(self, scene: Scene, settings: PhysicsSettings, start: GeometricState) -> None:
        self.scene, self.settings, self.start = scene, settings, start
        self.top = Tag("mujoco", model=scene.name)
        self.assets: dict[bytes, str] = {}
        self.things: dict[str, str] = {}
        self.motors: list[Motor] = []

    def model(self) -> PhysicsModel:
        make_contact_shapes(self.scene, self.settings.contact_precision)
        self._options()
        self.meshes = SubElement(self.top, "asset")
        self.world = SubElement(self.top, "worldbody")
        SubElement(self.world, "light", pos="0 0 3", directional="true")
        self.contacts = SubElement(self.top, "contact")
        self.equalities = SubElement(self.top, "equality")
        self.actuators = SubElement(self.top, "actuator")
        for robot in self.scene.robots.values():
            self._robot(robot)
        for name in self.scene.bodies:
            self._body(name)
        self._welds()
        self._exclusions()
        indent(self.top)
        text = tostring(self.top, encoding="unicode") + "\n"
        return PhysicsModel(text, tuple(self.motors), self.things)

    def _options(self) -> None:
        SubElement(self.top, "compiler", angle="radian", autolimits="true")
        option = SubElement(self.top, "option", timestep=f"{self.settings.timestep:g}", integrator="implicitfast")
        option.set("cone", "elliptic")
        option.set("impratio", "50")
        SubElement(option, "flag", multiccd="enable")
        SubElement(SubElement(self.top, "visual"), "global", offwidth="1280", offheight="960")
        default = SubElement(self.top, "default")
        SubElement(default, "geom", {**SOFTNESS, "friction": _numbers([self.settings.friction, TORSION, 1e-4])})

    def _robot(self, robot: Robot) -> None:
        tree, masses = robot.tree, masses_of_joints(robot, self.settings)
        base = SubElement(self.world, "body", name=f"{robot.name}:")
        bodies = {0: base}
        for joint in range(1, len(tree.parent)):
            placed = np.eye(4)
            placed[:3, :3], placed[:3, 3] = tree.placement[joint, :9].reshape(3, 3), tree.placement[joint, 9:]
            moves = tree.ratio[joint] != 0.0
            if not moves:
                placed = placed @ _moved(int(tree.kind[joint]), float(tree.shift[joint]))
            name = f"{robot.name}:{robot.model.names[joint]}"
            body = SubElement(bodies[int(tree.parent[joint])], "body", {"name": name, **_pose(placed)})
            bodies[joint] = body
            if moves:
                self._joint(robot, joint, body)
            _inertial(body, masses[joint])
        for link in robot.links.values():
            if link.elements:
                own = SubElement(bodies[link.joint], "body", name=f"{robot.name}.{link.name}")
                own.attrib.update(_pose(link.joint_T_link))
                self._shapes(own, f"{robot.name}.{link.name}", "link")
        self._motors(robot)

    def _joint(self, robot: Robot, joint: int, body: Tag) -> None:
        tree, revolute = robot.tree, robot.tree.kind[joint] == REVOLUTE
        tag = SubElement(body, "joint", name=body.attrib["name"], type="hinge" if revolute else "slide")
        tag.set("axis", "0 0 1")
        ratio, shift, source = float(tree.ratio[joint]), float(tree.shift[joint]), int(tree.source[joint])
        low, high = sorted((ratio * tree.lower[source] + shift, ratio * tree.upper[source] + shift))
        if high - low < 2.0 * FARTHEST_TURN or not revolute:
            tag.set("range", _numbers([low, high]))
            tag.set("solreflimit", STIFF["solref"])  # else a hand's light fingers are pressed beyond their ends
            tag.set("solimplimit", STIFF["solimp"])
        inertia = min(self.settings.rotor_inertia, movable_inertia(robot, joint))
        if revolute and robot.joint_names[source] in robot.gripper_joints:
            inertia *= arm_of(robot, joint) ** 2  # of fingers as heavy as those that slide
        tag.set("armature", f"{inertia:g}")

    def _motors(self, robot: Robot) -> None:
        """A motor for each value of a configuration, and couplings for the joints that share it."""
        tree = robot.tree
        for number, joint_name in enumerate(robot.joint_names):
            joints = [j for j in range(1, len(tree.parent)) if tree.source[j] == number and tree.ratio[j] != 0.0]
            leader = next(j for j in joints if robot.model.names[j] == joint_name)
            name = f"{robot.name}:{joint_name}"
            followers = []
            for joint in joints:
                if joint != leader:
                    other = f"{robot.name}:{robot.model.names[joint]}"
                    ratio, shift = float(tree.ratio[joint]), float(tree.shift[joint])
                    couple = SubElement(self.equalities, "joint", joint1=other, joint2=name)
                    couple.set("polycoef", _numbers([shift, ratio, 0, 0, 0]))
                    couple.attrib.update(STIFF)
                    followers.append((other, ratio, shift))
            given = float(robot.model.effortLimit[robot.model.joints[leader].idx_v])
            effort = given if 0.0 < given < 1e6 else None
            motor = SubElement(self.actuators, "motor", name=name, joint=name)
            if effort is not None:
                motor.set("forcerange", _numbers([-effort, effort]))
            gripper = joint_name in robot.gripper_joints
            self.motors.append(Motor(name, robot.name, joint_name, gripper, effort, tuple(followers)))

    def _body(self, name: str) -> None:
        body = self.scene.bodies[name]
        tag = SubElement(self.world, "body", {"name": name, **_pose(world_T(self.scene, self.start, name))})
        if body.movable:
            SubElement(tag, "freejoint", name=name)
            _inertial(tag, mass_of_body(body, self.settings))
        self._shapes(tag, name, "movable" if body.movable else "fixed")

    def _shapes(self, tag: Tag, thing: str, kind: str) -> None:
        robot, dot, _ = thing.partition(".")
        gripper = self.scene.robots[robot].gripper if dot else None
        for number, shape in enumerate(contact_shapes(self.scene, thing, self.settings.contact_precision)):
            name = f"{thing}#{number}"
            self.things[name] = thing
            if kind == "movable":
                shape = calm(shape)
            geom = SubElement(tag, "geom", name=name, type=shape.kind, rgba=COLOURS[kind], mass="0")
            if shape.corners is not None:
                geom.set("mesh", self._mesh(shape.corners))
            elif shape.pose is not None:
                geom.set("size", _numbers(shape.size))
                geom.attrib.update(_pose(shape.pose))
            if gripper is not None and thing.partition(".")[2] in _links(gripper.touch_links):
                geom.set("friction", _numbers([gripper.friction, TORSION, 1e-4]))
                geom.set("priority", "1")  # its friction counts, whatever it touches

    def _mesh(self, corners: Array) -> str:
        key = np.ascontiguousarray(corners).tobytes()
        if key not in self.assets:
            self.assets[key] = f"part{len(self.assets)}"
            SubElement(
                self.meshes, "mesh", name=self.assets[key], inertia="shell", vertex=_numbers(corners.ravel())
            )
        return self.assets[key]

    def _welds(self) -> None:
        """What can be fixed to something: bodies to hands that lock, parts to those with which they hold together."""
        for robot in self.scene.robots.values() if self.settings.welds else ():
            if robot.gripper is None or robot.tool is None:
                continue
            carrier = _carrier(robot, robot.links[robot.tool.frame].joint)
            for name in self.scene.movable:
                self._weld(robot.name, carrier, name)
        for fixed, moving in dict.fromkeys((fixed, moving) for _, moving, fixed in holding_mates(self.scene)):
            self._weld(fixed, fixed, moving).attrib.update(STIFF)

    def _weld(self, holder: str, carrier: str, body: str) -> Tag:
        weld = SubElement(self.equalities, "weld", name=f"{holder}:{body}", body1=carrier, body2=body)
        weld.set("active", "false")
        return weld

    def _exclusions(self) -> None:
        """Pairs that do not touch in physics, since planning never checks them.

        They are of a robot with itself, or standing; or of a zone of a robot, such as a box around a hand that only the
        URDF's collision geometry has, and a body that the scene permits in it.
        """
        links = [
            f"{r.name}.{link.name}"
            for r in self.scene.robots.values()
            for link in r.links.values()
            if link.elements
        ]
        fixed = [name for name, body in self.scene.bodies.items() if not body.movable]
        for first, second in combinations([*links, *fixed], 2):
            if self.scene.never_collide(first, second):
                SubElement(self.contacts, "exclude", body1=first, body2=second)
        for zone, body in product(self._zones(), self.scene.movable):
            if self.scene.never_collide(zone, body):
                SubElement(self.contacts, "exclude", body1=zone, body2=body)

    def _zones(self) -> list[str]:
        robots = self.scene.robots.values()
        return [f"{r.name}.{link.name}" for r in robots for link in r.links.values() if link.is_zone]


def _carrier(robot: Robot, joint: int) -> str:
    return f"{robot.name}:{robot.model.names[joint] if joint else ''}"


def _links(names: Iterable[str]) -> Iterator[str]:
    return (name.partition(".")[2] or name for name in names)


def _moved(kind: int, value: float) -> Array:
    """The motion (4, 4) of a joint about or along z."""
    if kind != REVOLUTE:
        return transform((0.0, 0.0, value))
    return transform((0.0, 0.0, 0.0), (0.0, 0.0, float(np.sin(0.5 * value)), float(np.cos(0.5 * value))))


def _inertial(tag: Tag, mass: Mass) -> None:
    found = SubElement(tag, "inertial", pos=_numbers(mass.centre), mass=f"{mass.mass:.9g}")
    i = mass.inertia
    found.set("fullinertia", _numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]]))


def _pose(pose: Array) -> dict[str, str]:
    x, y, z, w = quaternion(pose)
    return {"pos": _numbers(pose[:3, 3]), "quat": _numbers([w, x, y, z])}


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{float(value) + 0.0:.12g}" for value in values)
