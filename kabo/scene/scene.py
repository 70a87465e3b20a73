"""The scene: robots, bodies and regions placed in the world, allowed collisions, and the first geometric state."""

import logging
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.displays import counted, display
from kabo.errors import Diagnostic, InputError
from kabo.given import require_function, require_path
from kabo.language import load_scene_description
from kabo.language.formulas import Place
from kabo.language.scene_description import (
    BodyDescription,
    Constraint,
    Feature,
    GraspFamily,
    Mate,
    PlacementFamily,
    PoseDescription,
    RegionDescription,
    SceneDescription,
    Shape,
)
from kabo.meshes import Mesh, unusable
from kabo.phases import phase
from kabo.scene.bounds import findings
from kabo.scene.elements import Element
from kabo.scene.graspers import with_users
from kabo.scene.robots import Robot, link_pose
from kabo.scene.semantics import links_named, unknown_links
from kabo.scene.shapes import CYLINDER_SIDES, element_of, mesh_of
from kabo.scene.state import Attachment, GeometricState
from kabo.scene.transforms import POSITION_DECIMALS, QUATERNION_DECIMALS, quaternion, rounded, transform
from kabo.scene.urdf import load_robot
from kabo.whole_files import file_hash

_LOG = logging.getLogger("kabo.scene")
ROOM_BELOW = (
    1e-3  # [m] below a region with a support: what stands on the support is inside, however flush they are
)
FACING_DOWN = 0.999  # cosine to straight down of a face that may lie on the support

_Described = TypeVar("_Described")
_Made = TypeVar("_Made")


@dataclass(frozen=True)
class Body:
    """An object or fixed body: its mesh in its own frame [m], and its entry in the scene file."""

    name: str
    mesh: Mesh
    shape: Shape
    movable: bool
    features: Mapping[str, Feature]
    grasps: Mapping[str, GraspFamily]
    placements: Mapping[str, PlacementFamily]
    mass: float | None = None

    def __repr__(self) -> str:
        shape = self.mesh if self.shape.path is not None else self.shape.kind
        return f"<Body {self.name}: {'movable' if self.movable else 'fixed'}, {shape}>"

    @cached_property
    def elements(self) -> tuple[Element, ...]:
        """The elements of which the body consists, in its own frame."""
        return (element_of(self.shape, None, self.mesh),)


@dataclass(frozen=True)
class Region:
    """A closed convex volume: all x of its frame with normals (H, 3) @ x <= offsets (H,) [m].

    Faces of a region with a support that face down lie a millimetre deeper than in the scene file.
    """

    name: str
    normals: Array
    offsets: Array
    world_T_region: Array
    support: str | None
    size: tuple[float, float, float]  # half extents of its bounding box [m], used for sampling


@dataclass(frozen=True)
class Scene:
    """Robots, bodies and regions by name, in the order of the file; `files` maps every file read to its hash.

    `memory` caches results that other packages derive from the scene, each under a key that the package chooses.
    """

    name: str
    epsilon: float
    robots: Mapping[str, Robot]
    bodies: Mapping[str, Body]
    regions: Mapping[str, Region]
    motion_constraints: Mapping[str, tuple[Constraint, ...]]
    allowed: frozenset[frozenset[str]]
    fixed_poses: Mapping[str, Array]  # world_T_body of the bodies that never move
    start: GeometricState
    files: Mapping[Path, str]
    mates: Mapping[str, Mate] = field(default_factory=dict)
    uncertain: Mapping[str, float] = field(default_factory=dict)  # [m] of a body's pose, of any point of a robot
    met: bool = False  # whether `start` is the state of a run, in which things stand as they have come to stand
    description: SceneDescription | None = field(
        default=None, compare=False, repr=False
    )  # that it was loaded from
    memory: dict[object, Any] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def movable(self) -> tuple[str, ...]:
        """The names of the movable bodies."""
        return tuple(name for name, body in self.bodies.items() if body.movable)

    def __repr__(self) -> str:
        return f"<Scene {self.name}: {self._sizes()}, epsilon {1000 * self.epsilon:g} mm>"

    def _repr_html_(self) -> str:
        figures = {
            "epsilon": f"{1000 * self.epsilon:g} mm",
            "robots": ", ".join(f"{one.name} ({counted(one.planned, 'joint')})" for one in self.robots.values()),
            "movable": ", ".join(self.movable),
            "fixed": ", ".join(name for name, body in self.bodies.items() if not body.movable),
            "regions": ", ".join(self.regions),
        }
        return display(f"Scene {self.name}", figures, self)

    def _sizes(self) -> str:
        robots, bodies = counted(len(self.robots), "robot"), counted(len(self.bodies), "body", "bodies")
        return f"{robots}, {bodies}, {counted(len(self.regions), 'region')}"

    def never_collide(self, first: str, second: str) -> bool:
        """Whether a pair of links or bodies is never checked: it may collide, is adjacent, or never moves."""
        if frozenset((first, second)) in self.allowed:
            return True
        robot, other = first.partition("."), second.partition(".")
        if robot[1] and other[1] and robot[0] == other[0]:
            return self.robots[robot[0]].neighbours(robot[2], other[2])
        return self._fixed(first) and self._fixed(second)

    def mates_between(self, first: str, second: str) -> Iterator[tuple[Mate, str, str]]:
        """The mates that can join two bodies, each with the body that it moves and the one that stays."""
        described = {} if self.description is None else self.description.bodies
        models = {name: described[name].model for name in (first, second) if name in described}
        for mate in self.mates.values():
            for moving, fixed in ((first, second), (second, first)):
                if (models.get(moving), models.get(fixed)) == (mate.moving, mate.fixed):
                    yield mate, moving, fixed

    def _fixed(self, name: str) -> bool:
        robot, dot, link = name.partition(".")
        return self.robots[robot].stands(link) if dot else not self.bodies[name].movable


def attachment(parent: str, parent_T_object: Array) -> Attachment:
    """An attachment with numbers rounded as in states and plans."""
    x, y, z = rounded(parent_T_object[:3, 3].tolist(), POSITION_DECIMALS)
    qx, qy, qz, qw = rounded(quaternion(parent_T_object), QUATERNION_DECIMALS)
    return Attachment(parent, (x, y, z), (qx, qy, qz, qw))


def world_T(scene: Scene, state: GeometricState, name: str) -> Array:
    """The pose (4, 4) of a body, a region, a `robot.link` or `world` in a geometric state."""
    if name == "world":
        return np.eye(4)
    if name in scene.fixed_poses:
        return scene.fixed_poses[name]
    if name in state.objects:
        held = state.objects[name]
        return world_T(scene, state, held.parent) @ transform(held.position, held.quaternion)
    if name in scene.regions:
        return scene.regions[name].world_T_region
    robot, _, link = name.partition(".")
    return link_pose(scene.robots[robot], state.robots[robot], link)


class _Loader:
    """Computes all poses; frames may refer to bodies, regions and links in any order of the file."""

    def __init__(self, description: SceneDescription, look: Callable[[], None]) -> None:
        self.description, self.look = description, look
        self.robots: dict[str, Robot] = {}
        self.files: list[Path] = []
        self.findings: list[Diagnostic] = []
        self.poses: dict[str, Array] = {"world": np.eye(4)}

    def robot(self, name: str) -> Robot:
        if name not in self.robots:
            described = self.description.robots[name]
            base = self.pose(described.base)
            floor = None if described.drive is None else self.floor(described.drive.within)
            self.robots[name], read = load_robot(described, base, self.description.packages, floor)
            self.files.extend(read)
        return self.robots[name]

    def pose(self, described: PoseDescription) -> Array:
        return self.frame(described.frame, described.place) @ transform(described.position, described.quaternion)

    def floor(self, region: str) -> Array:
        """Points (P, 3) in the world whose hull is a region."""
        described = self.description.regions[region]
        world_T = self.frame(region, described.place)
        return np.asarray(_hull_points(described) @ world_T[:3, :3].T + world_T[:3, 3])

    def frame(self, name: str, place: Place | None) -> Array:
        if name in self.poses:
            return self.poses[name]
        robot, dot, link = name.partition(".")
        if dot and robot in self.description.robots:
            found = self.robot(robot)
            if link not in found.links:
                at = place or Place("scene", 1, 1)
                text = f'unknown link "{link}" of robot "{robot}"'
                raise InputError([Diagnostic(at.file, at.line, at.column, text, None, at.length)])
            q = found.start(self.description.robots[robot])
            self.poses[name] = link_pose(found, q, link)
        elif name in self.description.bodies:
            self.poses[name] = self.pose(self.description.bodies[name].pose)
        else:
            self.poses[name] = self.pose(self.description.regions[name].pose)
        return self.poses[name]

    def body(self, described: BodyDescription) -> Body:
        if described.srdf is not None:
            self.files.append(described.srdf)
        if described.shape.path is not None:
            self.files.append(described.shape.path)
        mesh = mesh_of(described.shape, described.place)
        families = described.features, described.grasps, described.placements
        return Body(described.name, mesh, described.shape, described.movable, *families, described.mass)

    def region(self, described: RegionDescription) -> Region:
        if described.shape.path is not None:
            self.files.append(described.shape.path)
        normals, offsets = _half_spaces(described)
        pose = self.frame(described.name, described.place)
        size = _half_extents(described.shape, normals, offsets)
        if described.support is not None:
            offsets = _with_room_below(normals, offsets, pose)
        return Region(described.name, normals, offsets, pose, described.support, size)

    def collect(self, make: Callable[[_Described], _Made], items: Mapping[str, _Described]) -> dict[str, _Made]:
        result: dict[str, _Made] = {}
        for name, item in items.items():
            self.look()
            try:
                result[name] = make(item)
            except InputError as error:
                self.findings.extend(error.diagnostics)
        return result


def load_scene(description: SceneDescription | str | Path, look: Callable[[], None] = never) -> Scene:
    """The scene of a file or of a description, with every URDF and mesh loaded.

    Args:
        description: a scene file, a problem file with a scene, or what was read from one, such as `problem.scene`.
        look: called before each URDF and mesh; may raise an error to stop.

    Raises:
        ArgumentError: `description` is neither a path nor what was read from a file.
        InputError: something does not load; the error lists every failure with its place in the scene file.
    """
    require_function("look", look)
    if not isinstance(description, SceneDescription):
        description = load_scene_description(require_path("description", description))
    with phase("loading the scene", log=_LOG):
        loader = _Loader(description, look)
        robots = loader.collect(lambda robot: loader.robot(robot.name), description.robots)
        bodies = loader.collect(loader.body, description.bodies)
        regions = {} if loader.findings else loader.collect(loader.region, description.regions)
    if loader.findings:
        raise InputError(loader.findings)
    poses = {name: loader.frame(name, body.place) for name, body in description.bodies.items()}
    meshes = {name: body.mesh for name, body in bodies.items()}
    if beyond := list(findings(description, robots, meshes, poses)):
        raise InputError(beyond)
    bodies = {name: replace(body, grasps=with_users(body.grasps, robots)) for name, body in bodies.items()}
    start = GeometricState(
        {name: robot.start(description.robots[name]) for name, robot in robots.items()},
        {name: attachment("world", poses[name]) for name, body in bodies.items() if body.movable},
    )
    return Scene(
        description.name,
        description.epsilon,
        robots,
        bodies,
        regions,
        description.motion_constraints,
        _allowed(description, robots),
        {name: poses[name] for name, body in bodies.items() if not body.movable},
        start,
        hashes(loader.files),
        description.mates,
        description.uncertain,
        description=description,
    )


def hashes(paths: list[Path]) -> dict[Path, str]:
    """The hashes of files, and of the files with parts that stand beside them."""
    beside = [path.with_name(path.name + ".parts") for path in paths]
    read = sorted({*paths, *(path for path in beside if path.is_file())})
    return {path: file_hash(path) for path in read}


def _allowed(description: SceneDescription, robots: Mapping[str, Robot]) -> frozenset[frozenset[str]]:
    """The pairs that may touch: of the scene, and of each robot with itself.

    Raises:
        InputError: names that mean no link of a robot, each at its place.
    """
    wrong: list[Diagnostic] = []

    def things(name: str, place: Place | None) -> list[str]:
        robot, dot, word = name.partition(".")
        if robot not in robots:
            return [name]
        own = robots[robot]
        found = links_named(word, own.links, own.groups) if dot else tuple(own.links)
        if not found:
            wrong.append(unknown_links(word, tuple(own.links), own.groups, robot, place))
        return [f"{robot}.{link}" for link in found]

    places = description.contact_places or (None,) * len(description.allowed_contacts)
    pairs: set[frozenset[str]] = set()
    for (first, second), place in zip(description.allowed_contacts, places, strict=True):
        pairs.update(frozenset((a, b)) for a in things(first, place) for b in things(second, place))
    if wrong:
        raise InputError(wrong)
    for name, robot in robots.items():
        pairs.update(frozenset(f"{name}.{link}" for link in pair) for pair in robot.allowed)
    return frozenset(pairs)


def _half_spaces(described: RegionDescription) -> tuple[Array, Array]:
    """Half-spaces (normals, offsets) whose intersection lies *within* the region."""
    shape = described.shape
    if shape.kind == "box" and shape.size is not None:
        return np.concatenate([np.eye(3), -np.eye(3)]), np.tile(np.asarray(shape.size) / 2, 2)
    if shape.kind == "cylinder" and shape.size is not None:
        angles = 2 * np.pi * np.arange(CYLINDER_SIDES) / CYLINDER_SIDES
        sides = np.stack([np.cos(angles), np.sin(angles), np.zeros(CYLINDER_SIDES)], axis=1)
        ends = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
        inner = np.full(CYLINDER_SIDES, shape.size[0] * np.cos(np.pi / CYLINDER_SIDES))
        return np.concatenate([sides, ends]), np.concatenate([inner, np.full(2, shape.size[2] / 2)])
    mesh = mesh_of(shape, described.place)
    equations = np.unique(_hull(mesh, _hull_points(described), described).equations.round(12), axis=0)
    return np.ascontiguousarray(equations[:, :3]), np.ascontiguousarray(-equations[:, 3])


def _hull_points(described: RegionDescription) -> Array:
    """Points (P, 3) of a region's frame whose hull is the region that `_half_spaces` describes."""
    shape = described.shape
    if shape.kind == "box" and shape.size is not None:
        signs = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3)).reshape(3, -1).T
        return np.asarray(signs * np.asarray(shape.size))
    if shape.kind == "cylinder" and shape.size is not None:
        radius, _, height = shape.size
        angles = 2 * np.pi * (np.arange(CYLINDER_SIDES) + 0.5) / CYLINDER_SIDES
        ring = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return np.concatenate([np.c_[ring, np.full(CYLINDER_SIDES, z)] for z in (-0.5 * height, 0.5 * height)])
    points = mesh_of(shape, described.place).vertices
    if shape.kind in ("sphere", "capsule") and shape.size is not None:
        half = shape.size[2] / 2 if shape.kind == "capsule" else 0.0
        centres = np.clip(points, [0.0, 0.0, -half], [0.0, 0.0, half])  # the nearest point of the axis
        arms = points - centres
        points = centres + arms * (shape.size[0] / np.linalg.norm(arms, axis=1, keepdims=True))
    return np.asarray(points)


def _with_room_below(normals: Array, offsets: Array, world_T_region: Array) -> Array:
    """The offsets of a region's half-spaces with those that face down moved down by `ROOM_BELOW`."""
    facing_down = normals @ world_T_region[2, :3] < -FACING_DOWN
    return np.asarray(offsets + ROOM_BELOW * facing_down)


def _hull(mesh: Mesh, points: Array, described: RegionDescription) -> Any:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        raise unusable(mesh, described.shape.place, "is flat and holds no region") from None


def _half_extents(shape: Shape, normals: Array, offsets: Array) -> tuple[float, float, float]:
    if shape.kind == "box" and shape.size is not None:
        return shape.size[0] / 2, shape.size[1] / 2, shape.size[2] / 2
    if shape.kind == "cylinder" and shape.size is not None:
        return shape.size[0], shape.size[0], shape.size[2] / 2
    reach = np.abs(mesh_of(shape, None).vertices).max(axis=0)
    return float(reach[0]), float(reach[1]), float(reach[2])
