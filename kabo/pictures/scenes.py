"""Drawings of scenes: robots, bodies and regions in a geometric state, with the names that people need."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from kabo.arrays import Array
from kabo.meshes import Mesh
from kabo.pictures.drawing import Drawing, Glass, Label, Solid
from kabo.scene import GeometricState, Region, Robot, Scene, link_poses, world_T
from kabo.viewer.content.colours import colour_of_name

STEEL, ORANGE, DARK = "#dfe3e8", "#f29f3d", "#4a5260"
FIXED = ("#e6cfa8", "#b9c0c8", "#d8c3a5", "#a9b7a4")
MOVABLE = ("#3f7fbf", "#4fa36b", "#b05fa0", "#c9593f", "#7a6fc0", "#c2a23a", "#58b0a8", "#8a6a4f")
GLASS, GLASS_OPACITY, PANEL_OPACITY = "#58a55c", 0.3, 0.35
WIDE_REGION = 0.3  # share of the floor that is drawn: larger regions would veil the picture
MAX_LABELS = 16
OBJECT_WEIGHT, LINK_WEIGHT, FIXED_WEIGHT = 2.0, 0.15, 0.25  # how much it matters that each is seen
FLOOR_SHARE = 1.5  # of the floor that all others stand on: a wider fixed body is a floor itself
ROBOT_RANK, OBJECT_RANK, REGION_RANK, BODY_RANK = 0, 1, 2, 3
BOX_FACES = np.array(
    [
        [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
        [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
    ]
)  # fmt: skip


def scene_drawing(scene: Scene, state: GeometricState | None = None, *, labels: bool = True) -> Drawing:
    """The drawing of a scene in a state, its start unless another is given."""
    state = scene.start if state is None else state
    poses = poses_in(scene, state)
    solids = _without_floors((*_robot_solids(scene, poses), *_body_solids(scene, poses)))
    drawing = Drawing(solids)
    regions = [region for region in scene.regions.values() if _is_drawn(region, drawing)]
    glass = tuple(_box(region) for region in regions)
    named = _labels(scene, poses, regions) if labels else ()
    return Drawing(solids, (Glass(glass, GLASS_OPACITY),) if glass else (), labels=named)


def poses_in(scene: Scene, state: GeometricState) -> dict[str, Array]:
    """world_T of every link with a mesh (`robot.link`) and of every body."""
    found: dict[str, Array] = {}
    for robot in scene.robots.values():
        poses = link_poses(robot, state.robots[robot.name])
        found |= {
            f"{robot.name}.{link.name}": poses[link.name] for link in robot.links.values() if link.mesh is not None
        }
    return found | {name: world_T(scene, state, name) for name in scene.bodies}


def object_colour(scene: Scene, name: str) -> str:
    """The colour of a body: that of its name, if it is called by one."""
    named = colour_of_name(name)
    if named is not None:
        return named
    body = scene.bodies[name]
    if body.movable:
        return MOVABLE[scene.movable.index(name) % len(MOVABLE)]
    fixed = [each for each, other in scene.bodies.items() if not other.movable]
    return FIXED[fixed.index(name) % len(FIXED)]


def _robot_solids(scene: Scene, poses: Mapping[str, Array]) -> tuple[Solid, ...]:
    return tuple(solid for robot in scene.robots.values() for solid in _link_solids(robot, poses))


def _link_solids(robot: Robot, poses: Mapping[str, Array]) -> tuple[Solid, ...]:
    hand = () if robot.gripper is None else carried_by_tool(robot)
    found: list[Solid] = []
    for name, link in robot.links.items():
        if link.mesh is not None and len(link.mesh.faces):
            full = f"{robot.name}.{name}"
            colour = DARK if name in hand else (STEEL, ORANGE)[len(found) % 2]
            found.append(Solid(full, link.mesh.vertices, link.mesh.faces, colour, poses[full], LINK_WEIGHT))
    return tuple(found)


def carried_by_tool(robot: Robot) -> tuple[str, ...]:
    """The links of the hand: those on the joint that carries the tool frame, and beyond; all links without a tool."""
    if robot.tool is None or robot.tool.frame not in robot.links:
        return tuple(robot.links)
    joint = robot.links[robot.tool.frame].joint
    return tuple(name for name, link in robot.links.items() if _is_beyond(robot, link.joint, joint))


def _is_beyond(robot: Robot, joint: int, carrier: int) -> bool:
    while joint > carrier:
        joint = int(robot.tree.parent[joint])
    return joint == carrier and carrier > 0


def _body_solids(scene: Scene, poses: Mapping[str, Array]) -> tuple[Solid, ...]:
    return tuple(
        Solid(
            name,
            body.mesh.vertices,
            body.mesh.faces,
            object_colour(scene, name),
            poses[name],
            OBJECT_WEIGHT if body.movable else FIXED_WEIGHT,
        )
        for name, body in scene.bodies.items()
        if len(body.mesh.faces)
    )


def _without_floors(solids: tuple[Solid, ...]) -> tuple[Solid, ...]:
    """The solids, with weight 0 for fixed bodies that are much wider than all others together: the picture cuts them."""
    found = list(solids)
    for number, solid in enumerate(solids):
        others = [other.world_points for other in found if other is not solid]
        if solid.weight != FIXED_WEIGHT or not others:
            continue
        if _footprint(solid.world_points) > FLOOR_SHARE * _footprint(np.concatenate(others)):
            found[number] = replace(solid, weight=0.0)
    return tuple(found)


def _footprint(points: Array) -> float:
    """The area of the bounding rectangle of points (N, 3), seen from above [m2]."""
    return float(np.prod(np.ptp(points[:, :2], axis=0)))


def _is_drawn(region: Region, drawing: Drawing) -> bool:
    """Whether a region is small enough, against the floor of what is drawn, not to veil the picture."""
    floor = _footprint(drawing.points) if drawing.solids else np.inf
    return _footprint(_corners(region)) <= WIDE_REGION * floor


def _corners(region: Region) -> Array:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], np.float64)
    local = signs * np.array(region.size)
    return np.asarray(local @ region.world_T_region[:3, :3].T + region.world_T_region[:3, 3])


def _box(region: Region) -> Solid:
    return Solid(region.name, _corners(region), BOX_FACES, GLASS, np.eye(4), 1.0, smooth=False)


def _labels(scene: Scene, poses: Mapping[str, Array], regions: Collection[Region]) -> tuple[Label, ...]:
    """Names of robots, objects, regions and fixed bodies; of these, in that order, no more than can be read."""
    found = []
    for name, robot in scene.robots.items():
        links = _named_links(robot)
        if links:
            found.append(Label(name, np.zeros(3), ORANGE, ROBOT_RANK, frozenset(links)))
    for name, body in scene.bodies.items():
        rank = OBJECT_RANK if body.movable else BODY_RANK
        if len(body.mesh.faces):
            anchor = _middle(body.mesh, poses[name])
            found.append(Label(name, anchor, object_colour(scene, name), rank, frozenset([name]), body.movable))
    found += [Label(region.name, _top(_corners(region)), GLASS, REGION_RANK) for region in regions]
    found.sort(key=lambda label: label.rank)  # stable: in the order of the file within a rank
    return tuple(found[:MAX_LABELS])


def _named_links(robot: Robot) -> list[str]:
    """The two largest links of a robot: what a name that points there is about is plain."""
    sizes = {
        name: float(np.prod(np.ptp(link.mesh.vertices, axis=0)))
        for name, link in robot.links.items()
        if link.mesh is not None and len(link.mesh.faces)
    }
    return [f"{robot.name}.{name}" for name in sorted(sizes, key=lambda name: -sizes[name])[:2]]


def _middle(mesh: Mesh, pose: Array) -> Array:
    """The middle of a mesh's bounding box, in the world."""
    low, high = mesh.bounds
    centre = (low + high) / 2.0
    return np.asarray(pose[:3, :3] @ centre + pose[:3, 3])


def _top(points: Array) -> Array:
    return np.array([*points[:, :2].mean(axis=0), points[:, 2].max()])
