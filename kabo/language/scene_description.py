"""A scene as described in its file, with defaults filled in; no mesh or URDF has been opened.

Lengths are in metres, angles in radians, quaternions are (x, y, z, w). Models have been copied into the bodies and
robots that use them, and the bodies and regions that a problem adds are included.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.formulas import Place
from kabo.language.semantic_description import SemanticDescription

FARTHEST = 1000.0  # m: of a position from its frame, of a size
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

BASE_JOINTS = ("base_x", "base_y", "base_yaw")
FRICTION = 0.5  # of what a gripper holds, where the scene does not say
MATE_TOLERANCE = 1e-4  # m: how far a part may leave the way of its insertion, where its mate does not say


@dataclass(frozen=True)
class PoseDescription:
    """A pose in a frame: `world`, an object, or `robot.link`."""

    frame: str = "world"
    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0)
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Feature:
    """A point, directed line or plane in its owner's frame; `direction` is that of the line or normal (unit)."""

    kind: Literal["point", "line", "plane"]
    origin: Vector
    direction: Vector | None = None


@dataclass(frozen=True)
class FeatureName:
    """The name of a feature in a constraint, such as `tool.tcp`; `feature` is None for a whole body."""

    owner: str
    feature: str | None = None

    def __str__(self) -> str:
        return self.owner if self.feature is None else f"{self.owner}.{self.feature}"


@dataclass(frozen=True)
class Constraint:
    """A constraint between two features; `lower` and `upper` bound the quantity of its kind (None: unbounded)."""

    kind: str  # a name in CONSTRAINT_KINDS
    first: FeatureName
    second: FeatureName
    lower: float | None = None
    upper: float | None = None
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class Stroke:
    """A straight motion along (`sign` 1) or against (`sign` -1) a directed line, by a length within bounds [m]."""

    along: FeatureName
    sign: int
    minimum: float
    maximum: float


@dataclass(frozen=True)
class GraspFamily:
    """A family of grasps of a body; its constraints may use the roles `tool`, `this`, `world`.

    `robots`: the robots that may use the family; None: all robots that have the features in its constraints.
    """

    name: str
    constraints: tuple[Constraint, ...]
    robots: tuple[str, ...] | None = None
    approach: Stroke | None = None
    lift: Stroke | None = None
    fingers: Mapping[str, float] | None = None  # None: the gripper's `closed`


@dataclass(frozen=True)
class PlacementFamily:
    """A family of placements of a body; its constraints may use the roles `this`, `support`, `region`, `world`."""

    name: str
    constraints: tuple[Constraint, ...]
    retreat: Stroke | None = None


@dataclass(frozen=True)
class Shape:
    """The shape of a body: a mesh file with a scale, or a primitive with full side lengths [m]."""

    kind: Literal["mesh", "box", "cylinder", "sphere", "capsule"]
    path: Path | None = None
    scale: float = 1.0
    size: Vector | None = (
        None  # box: x, y, z; cylinder and capsule: radius, radius, height; sphere: radius three times
    )
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class BodyDescription:
    """An object of the scene or a body that a problem adds. `features` includes the implicit ones (origin, axes)."""

    name: str
    shape: Shape
    pose: PoseDescription
    movable: bool
    model: str | None = None
    mass: float | None = None
    features: Mapping[str, Feature] = field(default_factory=dict)
    grasps: Mapping[str, GraspFamily] = field(default_factory=dict)
    placements: Mapping[str, PlacementFamily] = field(default_factory=dict)
    place: Place | None = field(default=None, compare=False, repr=False)
    srdf: Path | None = None  # the file that gives some of its features and grasps


@dataclass(frozen=True)
class RegionDescription:
    """A closed convex volume, and the body that supports objects placed in it."""

    name: str
    shape: Shape
    pose: PoseDescription
    support: str | None = None
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class ContactPattern:
    """A pair of links of one robot that may touch: names of links, patterns with `*` and `?`, groups of its SRDF."""

    first: str
    second: str
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class RateLimit:
    """A limit of a joint's velocity, acceleration or jerk, and where the joint and the number are written."""

    value: float
    place: Place | None = field(default=None, compare=False, repr=False)
    value_place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class RateLimits:
    """Limits of the velocities, accelerations or jerks of a robot: of single joints, and of `every` other joint."""

    every: RateLimit | None = None
    joints: Mapping[str, RateLimit] = field(default_factory=dict)


@dataclass(frozen=True)
class GripperDescription:
    """A gripper: a URDF of its own, at a pose in the frame of a mount link, or joints of the robot's URDF."""

    urdf: Path | None = None
    mount: str | None = None
    joints: tuple[str, ...] | None = None
    open: Mapping[str, float] = field(default_factory=dict)
    closed: Mapping[str, float] = field(default_factory=dict)
    touch_links: tuple[str, ...] = ()
    place: Place | None = field(default=None, compare=False, repr=False)
    pose: PoseDescription = PoseDescription()
    force: float | None = None  # N, with which it holds: the sum of the normal forces; None: nothing slips
    friction: float = FRICTION  # the coefficient between gripper and object
    force_place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class SensorDescription:
    """A camera on a link of a robot: it looks from the origin of its own frame along z, with x to the right.

    `position` and `quaternion` are the pose of its frame in the frame of the link `frame`. `field_of_view` has full
    angles [rad]: one of a cone, or the horizontal and the vertical one of a pyramid. `range` has the least and the
    greatest distance of what it sees [m]. `allowed` are links of the robot that may be in the way of its view.
    """

    name: str
    frame: str
    field_of_view: tuple[float, ...]
    range: tuple[float, float]
    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0)
    allowed: tuple[str, ...] = ()
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class DriveDescription:
    """How a robot's base drives on the floor: along x and y and about z of the base's written pose.

    `within` is the region whose outline, seen from above, the base's own links never leave. `joints` are the names of
    the three joints; those that the URDF has are used, else they are added before its first link.
    """

    within: str
    joints: tuple[str, str, str] = BASE_JOINTS
    speed: float = 0.5  # m/s, along x and along y
    turn_speed: float = 1.0  # rad/s
    turn: tuple[float, float] = (-2.0 * math.pi, 2.0 * math.pi)  # rad
    travel: str | None = None  # a configuration: of the arm on long drives, where it can be had
    place: Place | None = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class RobotDescription:
    """A robot as described in a scene file.

    `joints` are the planned joints; None: all movable joints except mimic joints and those of the gripper.
    `limits` of positions and `velocity` can only narrow the limits in the URDF. `analytic` is the place in the file that
    requests closed-form inverse kinematics. `hulls` are links of which bounded predicates take open meshes as their
    convex hulls. A robot that drives has the joints of its base before those in `joints`. What stands in the scene file
    wins over its SRDF file.
    """

    name: str
    urdf: Path
    base: PoseDescription
    joints: tuple[str, ...] | None = None
    inverse_kinematics: Literal["analytic", "automatic", "projection"] = "automatic"
    gripper: GripperDescription | None = None
    tool_frame: str | None = None
    tool_features: Mapping[str, Feature] = field(default_factory=dict)
    configurations: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    model: str | None = None
    place: Place | None = field(default=None, compare=False, repr=False)
    limits: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    analytic: Place | None = field(default=None, compare=False, repr=False)
    hulls: tuple[str, ...] = ()
    velocity: RateLimits = RateLimits()
    acceleration: RateLimits = RateLimits()
    jerk: RateLimits = RateLimits()
    limit_places: Mapping[str, Place] = field(default_factory=dict, compare=False, repr=False)
    sensors: Mapping[str, SensorDescription] = field(default_factory=dict)
    drive: DriveDescription | None = None  # None: the base stands
    semantics: SemanticDescription | None = None  # of its SRDF file
    joint_group: str | None = None  # the group of the SRDF whose joints are planned, in place of `joints`
    contacts: tuple[ContactPattern, ...] = ()  # of its own links with each other


@dataclass(frozen=True)
class Mate:
    """The constraints by which one part is joined to another part; they use the roles `moving` and `fixed`.

    `tolerance`: the greatest distance of any point of the moving part from its straight insertion path [m]. `holds`:
    whether the parts stay together by themselves from then on, as in a press fit; planning takes it that all do.
    """

    name: str
    moving: str
    fixed: str
    constraints: tuple[Constraint, ...]
    insertion: Stroke | None = None
    tolerance: float = MATE_TOLERANCE
    holds: bool = False


@dataclass(frozen=True)
class SceneDescription:
    """A scene: the content of a scene file, with the problem's additions."""

    name: str
    epsilon: float
    robots: Mapping[str, RobotDescription]
    bodies: Mapping[str, BodyDescription]
    regions: Mapping[str, RegionDescription]
    mates: Mapping[str, Mate]
    motion_constraints: Mapping[str, tuple[Constraint, ...]]
    allowed_contacts: tuple[tuple[str, str], ...]
    packages: Mapping[str, Path]
    path: Path
    uncertain: Mapping[str, float] = field(default_factory=dict)  # m: errors of bodies' poses, of robots' tracking
    contact_places: tuple[Place, ...] = field(default=(), compare=False, repr=False)  # of the `allowed_contacts`
