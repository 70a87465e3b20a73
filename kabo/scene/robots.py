"""Robots: the model that pinocchio reads from URDF files, the kinematic tree as arrays, links with their meshes."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array
from kabo.displays import counted
from kabo.language.formulas import Place
from kabo.language.scene_description import FRICTION, Feature, RobotDescription
from kabo.meshes import Mesh
from kabo.scene.drives import BASE_VALUES, Drive
from kabo.scene.elements import Element, one_mesh
from kabo.scene.semantics import Groups
from kabo.scene.sensors import Sensor
from kabo.scene.state import Configuration
from kabo.scene.structure import NoStructure, Structure, structure_of
from kabo.scene.tree import KinematicTree

GRAVITY = 9.81  # [m/s2]
LEAST_SPARE = 1e-6  # share of gravity that a gripper must be able to hold besides


@dataclass(frozen=True)
class Link:
    """A link: the joint that carries it, its pose in the joint's frame, and the elements of which it consists."""

    name: str
    joint: int
    joint_T_link: Array  # (4, 4)
    elements: tuple[Element, ...] = ()  # in the link's frame
    place: Place | None = field(default=None, compare=False)  # of its element in the URDF
    is_zone: bool = False  # its shape is for collisions alone: to be kept free, such as a box around a hand

    @cached_property
    def mesh(self) -> Mesh | None:
        """The elements as one mesh in the link's frame; None for a link without geometry."""
        return one_mesh([element.mesh for element in self.elements])


@dataclass(frozen=True)
class Tool:
    """The tool: the link whose frame is the tool frame, and the features given in this frame."""

    frame: str
    features: Mapping[str, Feature]


@dataclass(frozen=True)
class Gripper:
    """A gripper: values of its joints when open and closed, and the links (`robot.link`) that touch a held object."""

    joints: tuple[str, ...]
    open: Mapping[str, float]
    closed: Mapping[str, float]
    touch_links: tuple[str, ...]
    force: float | None = None  # [N], the sum of the normal forces on what it holds; None: nothing slips
    friction: float = FRICTION

    def greatest_acceleration(self, mass: float | None) -> float | None:
        """The greatest norm of acceleration minus gravity with which it holds a mass [kg], in m/s²; None: any."""
        return None if self.force is None or mass is None else self.friction * self.force / mass

    def holds(self, mass: float | None) -> bool:
        """Whether it can hold a mass [kg] at rest, with something to spare for moving it."""
        greatest = self.greatest_acceleration(mass)
        return greatest is None or greatest > GRAVITY * (1.0 + LEAST_SPARE)

    def too_weak_for(self, mass: float | None) -> str:
        """Why it cannot hold a mass [kg]: the weight beside what friction holds."""
        weight, force = GRAVITY * (mass or 0.0), self.force or 0.0
        text = f"{mass or 0.0:g} kg weigh {weight:.3g} N"
        return f"{text}, friction {self.friction:g} times force {force:g} N holds {self.friction * force:.3g} N"


@dataclass(frozen=True)
class Actuation:
    """The map from a configuration to pinocchio's joint values: joint j takes ratio[j] * q[source[j]] + shift[j]."""

    source: tuple[int, ...]
    ratio: tuple[float, ...]
    shift: tuple[float, ...]


_SHARED: "WeakValueDictionary[int, Robot]" = WeakValueDictionary()
_NUMBERS = count()


def shared(number: int) -> "Robot":
    """The robot with index `number`, looked up in the process that loaded the robot or in a later fork of it.

    Raises:
        KeyError: the robot was loaded in another process.
    """
    return _SHARED[number]


@dataclass(frozen=True)
class Robot:
    """A robot in the world; it is pickled as an index, since forked workers already hold the robots.

    `model` is pinocchio's, with gripper and base placement. `joint_names` lists all actuated joints, the first
    `planned` of them are the arm's, the others the gripper's; a Configuration has their values in this order.
    `hulls`: the links of which bounded predicates take hulls, as `with_hulls` does.
    """

    name: str
    model: Any
    links: Mapping[str, Link]
    joint_names: tuple[str, ...]
    planned: int
    tree: KinematicTree
    actuation: Actuation
    tool: Tool | None
    gripper: Gripper | None
    configurations: Mapping[str, tuple[float, ...]]
    inverse_kinematics: str = "automatic"  # analytic where the axes allow it; or one of both
    hulls: tuple[str, ...] = ()
    acceleration: Mapping[str, float] = field(default_factory=dict)  # of some joints [rad/s2 or m/s2]
    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    drive: Drive | None = None  # how the base drives, whose values are then the first; None: it stands
    allowed: frozenset[frozenset[str]] = frozenset()  # pairs of links that may touch
    groups: Groups = field(default_factory=lambda: Groups({}, {}))  # of its SRDF
    jerk: Mapping[str, float] = field(default_factory=dict)  # of some joints [rad/s3 or m/s3]

    def __post_init__(self) -> None:
        """Registers the robot under a new index."""
        object.__setattr__(self, "_number", next(_NUMBERS))
        _SHARED[self._number] = self  # type: ignore[attr-defined]

    def __repr__(self) -> str:
        joints, links = counted(self.planned, "planned joint"), counted(len(self.links), "link")
        hand = "no gripper" if self.gripper is None else "a gripper"
        return f"<Robot {self.name}: {joints}, {links}, {hand}>"

    def __reduce__(self) -> "tuple[Callable[[int], Robot], tuple[int]]":
        return shared, (self._number,)  # type: ignore[attr-defined]

    @property
    def planned_joints(self) -> tuple[str, ...]:
        """The names of the arm's joints, which motions are planned for."""
        return self.joint_names[: self.planned]

    @property
    def gripper_joints(self) -> tuple[str, ...]:
        """The names of the gripper's joints."""
        return self.joint_names[self.planned :]

    def columns(self, joints: Sequence[str]) -> list[int]:
        """Where the values of some joints are in a configuration; raises KeyError for a joint that the robot has not."""
        return [self._column[joint] for joint in joints]

    @cached_property
    def _column(self) -> dict[str, int]:
        return {joint: number for number, joint in enumerate(self.joint_names)}

    @cached_property
    def data(self) -> Any:
        """Pinocchio's `Data` for this robot: scratch memory of its algorithms."""
        return self.model.createData()

    @cached_property
    def memory(self) -> dict[object, Any]:
        """What other rooms have computed of the robot, by key; no part of it."""
        return {}

    @cached_property
    def structure(self) -> Structure | NoStructure:
        """The axis structure by which inverse kinematics of the planned joints has a closed form, or why it has none."""
        return structure_of(self.tree, self.planned, self.base_values)

    @property
    def base_values(self) -> int:
        """The number of values, the first of a configuration, that move the base: three if it drives, else none."""
        return 0 if self.drive is None else BASE_VALUES

    @property
    def arm(self) -> NDArray[np.bool_]:
        """Which values of a configuration (n,) belong to planned joints other than the base's."""
        numbers = np.arange(self.tree.size)
        return (self.base_values <= numbers) & (numbers < self.planned)

    def links_on(self, joint: int) -> tuple[str, ...]:
        """The links with a mesh that a moving joint carries, without any other moving joint between."""
        return tuple(
            name
            for name, link in self.links.items()
            if link.mesh is not None and self._moving_joint(name) == joint
        )

    def expand(self, q: Sequence[float]) -> Array:
        """A configuration in pinocchio's form: with mimic and locked joints, and continuous joints as cosine and sine."""
        source, ratio, shift, single, places, continuous = self._expansion
        values, full = ratio * np.asarray(q, np.float64)[source] + shift, np.zeros(self.model.nq)
        full[places] = values[single]
        for j, place in continuous:
            full[place : place + 2] = np.cos(values[j]), np.sin(values[j])
        return full

    @cached_property
    def _expansion(self) -> tuple[Any, ...]:
        """`actuation` as arrays from joint 1 on: source, ratio, shift; joints of one value, their places; the others."""
        joints, own = list(self.model.joints)[1:], self.actuation
        single = [j for j, joint in enumerate(joints) if joint.nq == 1]
        continuous = [(j, joint.idx_q) for j, joint in enumerate(joints) if joint.nq != 1]
        places = np.array([joints[j].idx_q for j in single], np.int64)
        source = np.array(own.source[1:], np.int64)
        return (
            source,
            np.array(own.ratio[1:]),
            np.array(own.shift[1:]),
            np.array(single, np.int64),
            places,
            continuous,
        )

    @cached_property
    def placements(self) -> dict[str, tuple[int, Array]]:
        """Of each link, pinocchio's joint that carries it, and its pose (4, 4) in the frame of this joint."""
        import pinocchio

        frames = (frame for frame in self.model.frames if frame.type == pinocchio.FrameType.BODY)
        return {
            frame.name: (frame.parentJoint, frame.placement.homogeneous)
            for frame in frames
            if frame.name in self.links
        }

    def neighbours(self, first: str, second: str) -> bool:
        """Whether two links belong to one moving joint, or to a joint and its parent: such pairs are never checked."""
        a, b = self._moving_joint(first), self._moving_joint(second)
        return a == b or self._moving_parent(a) == b or self._moving_parent(b) == a

    def values_between(self, first: str, second: str) -> frozenset[int]:
        """The values of a configuration that move one of two links against the other."""
        ways = [set(self._joints_to(self.links[name].joint)) for name in (first, second)]
        joints = [joint for joint in ways[0] ^ ways[1] if self.tree.ratio[joint] != 0.0]
        return frozenset(int(self.tree.source[joint]) for joint in joints)

    def moving(self, joints: Iterable[int]) -> NDArray[np.bool_]:
        """Which values of a configuration (n,) move one of some joints."""
        tree, found = self.tree, np.zeros(self.tree.size, np.bool_)
        ways = {other for joint in joints for other in self._joints_to(joint) if tree.ratio[other] != 0.0}
        found[[int(tree.source[joint]) for joint in ways]] = True
        return found

    def hand(self, joint: int) -> int:
        """The last planned joint that carries a joint of the tree, itself included; 0 if only the base does.

        Of bodies with the same one, only joints of the gripper move one relative to the other.
        """
        tree = self.tree
        while joint > 0 and (tree.ratio[joint] == 0.0 or tree.source[joint] >= self.planned):
            joint = int(tree.parent[joint])
        return joint

    def stands(self, link: str) -> bool:
        """Whether no moving joint carries the link, so that it is fixed to the base."""
        return self._moving_joint(link) == 0

    def _joints_to(self, joint: int) -> Iterator[int]:
        while joint > 0:
            yield joint
            joint = int(self.tree.parent[joint])

    def _moving_joint(self, link: str) -> int:
        return self._settle(self.links[link].joint)

    def _moving_parent(self, joint: int) -> int:
        return -1 if joint == 0 else self._settle(int(self.tree.parent[joint]))

    def _settle(self, joint: int) -> int:
        while joint > 0 and self.tree.ratio[joint] == 0.0:
            joint = int(self.tree.parent[joint])
        return joint

    def start(self, description: RobotDescription) -> Configuration:
        """The first configuration: `home`, or else zeros clipped to the limits, with the gripper open."""
        lower, upper = self.tree.lower, self.tree.upper
        values = [float(min(max(0.0, lower[i]), upper[i])) for i in range(len(self.joint_names))]
        home = self.configurations.get("home")
        if home is not None:
            values[: self.planned] = home
        if self.gripper is not None:
            for i, joint in enumerate(self.gripper.joints, self.planned):
                values[i] = float(self.gripper.open.get(joint, values[i]))
        return tuple(round(value, 9) + 0.0 for value in values)


def link_poses(robot: Robot, q: Sequence[float]) -> dict[str, Array]:
    """The pose world_T_link (4, 4) of every link, computed by pinocchio; kernels are compared with it."""
    return _poses(robot, q, robot.placements)


def link_pose(robot: Robot, q: Sequence[float], link: str) -> Array:
    """The pose world_T_link (4, 4) of one link, as `link_poses` has it, without those of the others.

    Raises:
        KeyError: the robot has no such link.
    """
    return _poses(robot, q, {link: robot.placements[link]})[link]


def _poses(robot: Robot, q: Sequence[float], placements: Mapping[str, tuple[int, Array]]) -> dict[str, Array]:
    import pinocchio

    pinocchio.forwardKinematics(robot.model, robot.data, robot.expand(q))
    placed = robot.data.oMi
    joints = {joint: placed[joint].homogeneous for joint in {joint for joint, _ in placements.values()}}
    return {name: joints[joint] @ local for name, (joint, local) in placements.items()}
