"""Grippers that open less than an object is wide: both measured on the meshes, along the line on which fingers close.

The line goes through the tool's point of a grasp, in the direction in which the fingers move towards each other. The
opening is the distance between the fingers' surfaces on it; the width is that between the object's surfaces.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry import Solid
from kabo.geometry_server.configurations import joints_at
from kabo.geometry_server.foresight.measures import Measure, millimetres
from kabo.geometry_server.frames import Frame, fits, rows, tool_frame
from kabo.kinematics import FREE_BODY, sample
from kabo.language.scene_description import Constraint, Feature, GraspFamily
from kabo.scene import Body, Mesh, Robot, link_poses
from kabo.scene.transforms import inverse, unflat
from kabo.streams import stream_key

GRASPS_TRIED = 64  # grasps at which the width is measured
GRASPS_FIRST = 4  # of them, which are sampled before the others: mostly one of them is narrow enough
STILL = 1e-4  # [m]: a finger that moves less does not close
SAME_DIRECTION = 1e-6  # of a cosine
SPACING = 1e-3  # [m] of the points of a line that are examined
MAX_POINTS = 200  # of them


@dataclass(frozen=True)
class Opening:
    """The room between a gripper's open fingers, on a line through a point of the tool.

    Args:
        direction: of the line (3,), in the tool's frame.
        before, behind: the distances from the point to the fingers' surfaces, against and along the direction [m].
    """

    direction: Array
    before: float
    behind: float

    @property
    def metres(self) -> float:
        """The distance between the fingers."""
        return self.before + self.behind


def opening_of(robot: Robot, hand: Sequence[float], point: Array) -> Opening | None:
    """The room between the fingers at a point (3,) of the tool's frame; None if no two fingers close on it.

    `hand` has the values of the gripper's joints. A gripper whose fingers close outwards, in a bore, has no opening.
    """
    gripper = robot.gripper
    if gripper is None or robot.tool is None:
        return None
    closed = [gripper.closed.get(joint, value) for joint, value in zip(robot.gripper_joints, hand, strict=True)]
    names = [name.partition(".")[2] for name in gripper.touch_links]
    links = [name for name in names if (mesh := robot.links[name].mesh) is not None and len(mesh.faces)]
    now, then = _poses(robot, hand, links), _poses(robot, closed, links)
    middles = [_mesh(robot, name).vertices.mean(axis=0) for name in links]
    moves = [_moved(then[name], at) - _moved(now[name], at) for name, at in zip(links, middles, strict=True)]
    moving = [move for move in moves if float(np.linalg.norm(move)) > STILL]
    if not moving:
        return None
    direction = moving[0] / np.linalg.norm(moving[0])
    before = behind = np.inf
    for name, move in zip(links, moves, strict=True):
        hits = _hits(_mesh(robot, name), inverse(now[name]), point, direction)
        if float(move @ direction) > STILL:  # closes along the direction: it stands before the point
            before = min(before, -float(hits[hits < 0.0].max(initial=-np.inf)))
        elif float(move @ direction) < -STILL:
            behind = min(behind, float(hits[hits > 0.0].min(initial=np.inf)))
    return Opening(direction, before, behind) if np.isfinite(before + behind) else None


def too_wide(robot: Robot, body: Body, family: GraspFamily, hand: Sequence[float]) -> Measure | None:
    """The width of a body beyond the gripper's opening in every grasp of a family; None if some grasp may be narrow enough.

    It is a proof where the grasp leaves neither the tool's point nor the closing line open, or where a ball about the
    point is within the body and meets a finger.
    """
    own = [c for c in family.constraints if "world" not in (c.first.owner, c.second.owner)]
    roles = {
        "tool": replace(tool_frame(robot), joint=0, joint_T_frame=np.eye(4)),
        "this": Frame(6, np.eye(4), body.features),
    }
    tool = _tool_point(own)
    if tool is None or not fits(own, roles) or tool not in roles["tool"].features:
        return None
    point = np.asarray(roles["tool"].features[tool].origin, dtype=np.float64)
    opening = opening_of(robot, hand, point)
    if opening is None or opening.metres >= body.mesh.diagonal:
        return None
    width = _least_width(_grasps(robot, body, rows(own, roles)), body.mesh, point, opening)
    if width is None:
        return None
    proven = _is_proven(body, own, opening, roles["tool"].features)
    said = (
        f"{body.name} is {millimetres(width)} wide where grasp {family.name} holds it, the gripper of {robot.name} "
        f"opens {millimetres(opening.metres)}: {millimetres(width - opening.metres)} too little"
    )
    return Measure(f"{body.name}.{family.name}", said, opening.metres, width, proven=proven)


# -------------------------------------------------------------------------------------------------------- widths
def _grasps(robot: Robot, body: Body, constraints: Array) -> Iterator[Array]:
    """Poses (4, 4) of a body in the tool's frame that fulfil constraint rows, a sample of them."""
    key = stream_key("opening", robot.name, body.mesh.digest)
    anywhere = FREE_BODY.lower, FREE_BODY.upper, np.ones(6, dtype=bool)
    for first, end in ((0, GRASPS_FIRST), (GRASPS_FIRST, GRASPS_TRIED)):
        found, valid = sample(FREE_BODY, constraints, key, first, end - first, *anywhere)
        for q in found[valid]:
            yield unflat(joints_at(FREE_BODY, q)[6])


def _least_width(grasps: Iterator[Array], mesh: Mesh, point: Array, opening: Opening) -> float | None:
    """The least width of a mesh on the closing line over grasps; None if there is none, or if one is narrow enough."""
    least = None
    for pose in grasps:
        hits = _hits(mesh, inverse(pose), point, opening.direction)
        width = float(hits.max() - hits.min()) if len(hits) else 0.0
        if width <= opening.metres:
            return None
        least = width if least is None else min(width, least)
    return least


def _is_proven(body: Body, own: Sequence[Constraint], opening: Opening, tool: Any) -> bool:
    """Whether a finger's surface on the closing line lies within the body in every grasp of the family."""
    solid = Solid(body.mesh.vertices, body.mesh.faces)
    points = _held_points(body, own)
    if points is None:
        return False
    spacing = float(np.linalg.norm(points[1] - points[0])) if len(points) > 1 else 0.0
    balls = np.where(solid.insides(points), solid.surface_distances(points), 0.0)
    if float(balls.min()) - 0.5 * spacing > min(opening.before, opening.behind):
        return True
    axis = _axis_across(body, own, opening, tool)
    # Discs about both ends are within a convex body, hence so are those about all points between.
    ends = (points[0], points[-1]) if axis is not None and solid.is_convex else ()
    discs = [_disc(body.mesh, end, axis) for end in ends if axis is not None]
    if discs and min(discs) > min(opening.before, opening.behind):
        return True
    direction = _held_direction(body, own, opening, tool)
    if direction is None or len(points) > 1 or not solid.insides(points)[0]:
        return False
    hits = _hits(body.mesh, np.eye(4), points[0], direction)
    ahead, back = float(hits[hits > 0.0].min(initial=np.inf)), -float(hits[hits < 0.0].max(initial=-np.inf))
    fits_one_way = (ahead <= opening.behind and back <= opening.before) or (
        ahead <= opening.before and back <= opening.behind
    )
    return not fits_one_way


def _held_points(body: Body, own: Sequence[Constraint]) -> Array | None:
    """The points (N, 3) of a body at which the tool's point may be, evenly spaced; None if that is not known."""
    line, ends = None, None
    for c in own:
        tool, this = (c.first, c.second) if c.first.owner == "tool" else (c.second, c.first)
        if tool.owner != "tool" or this.owner != "this" or this.feature is None:
            continue
        feature = body.features[this.feature]
        if c.kind == "coincident" and feature.kind == "point":
            return np.array([feature.origin], dtype=np.float64)
        if c.kind == "coincident" and feature.kind == "line":
            line = feature
        if c.kind == "height" and c.lower is not None and c.upper is not None:
            ends = feature, c.lower, c.upper
    if line is None or line.direction is None or ends is None or ends[0].direction is None:
        return None
    through, along = np.asarray(line.origin), np.asarray(line.direction)
    normal, foot = np.asarray(ends[0].direction), np.asarray(ends[0].origin)
    rise = float(normal @ along)
    if abs(rise) < SAME_DIRECTION:
        return None
    first, last = (through + along * ((height - normal @ (through - foot)) / rise) for height in ends[1:])
    count = min(MAX_POINTS, 2 + int(np.linalg.norm(last - first) / SPACING))
    return np.linspace(first, last, count)


def _axis_across(body: Body, own: Sequence[Constraint], opening: Opening, tool: Any) -> Array | None:
    """A direction of the body that is across the closing line in every grasp; None if no constraint makes one so."""
    for c in own:
        first, this = (c.first, c.second) if c.first.owner == "tool" else (c.second, c.first)
        ours, theirs = _unit(tool.get(first.feature or "")), _unit(body.features.get(this.feature or ""))
        across = ours is not None and abs(float(ours @ opening.direction)) < SAME_DIRECTION
        if c.kind in ("parallel", "aligned", "opposed") and across and theirs is not None:
            return theirs
    return None


def _disc(mesh: Mesh, middle: Array, axis: Array) -> float:
    """The radius of the greatest disc about a point, across an axis, within a convex mesh [m]; negative outside."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 0.0] / lengths[lengths > 0.0, None]
    room = np.einsum("ij,ij->i", normals, corners[lengths > 0.0, 0] - middle)
    across = np.linalg.norm(normals - np.outer(normals @ axis, axis), axis=1)
    if float(room.min()) < 0.0:
        return -1.0
    return float((room[across > SAME_DIRECTION] / across[across > SAME_DIRECTION]).min())


def _held_direction(body: Body, own: Sequence[Constraint], opening: Opening, tool: Any) -> Array | None:
    """The closing direction in the body's frame, up to its sign, where a constraint fixes it; None if none does."""
    for c in own:
        first, this = (c.first, c.second) if c.first.owner == "tool" else (c.second, c.first)
        ours, theirs = _unit(tool.get(first.feature or "")), _unit(body.features.get(this.feature or ""))
        along = ours is not None and abs(float(ours @ opening.direction)) > 1.0 - SAME_DIRECTION
        if c.kind in ("parallel", "aligned", "opposed") and along and theirs is not None:
            return theirs
    return None


def _unit(feature: Feature | None) -> Array | None:
    """The unit direction (3,) of a line; None for any other feature."""
    if feature is None or feature.kind != "line" or feature.direction is None:
        return None
    direction = np.asarray(feature.direction, dtype=np.float64)
    return np.asarray(direction / np.linalg.norm(direction))


def _tool_point(own: Sequence[Constraint]) -> str | None:
    """The feature of the tool that a grasp puts onto a feature of the object."""
    for c in own:
        for name, other in ((c.first, c.second), (c.second, c.first)):
            if c.kind == "coincident" and name.owner == "tool" and other.owner == "this":
                return name.feature
    return None


# -------------------------------------------------------------------------------------------------------- meshes
def _poses(robot: Robot, hand: Sequence[float], links: Sequence[str]) -> dict[str, Array]:
    """The poses tool_T_link (4, 4) of links with the gripper at some values."""
    assert robot.tool is not None
    found = link_poses(robot, (*(0.0,) * robot.planned, *hand))
    tool = inverse(found[robot.tool.frame])
    return {name: tool @ found[name] for name in links}


def _mesh(robot: Robot, link: str) -> Mesh:
    mesh = robot.links[link].mesh
    assert mesh is not None
    return mesh


def _moved(pose: Array, point: Array) -> Array:
    return np.asarray(pose[:3, :3] @ point + pose[:3, 3])


def _hits(mesh: Mesh, mesh_T_line: Array, point: Array, direction: Array) -> Array:
    """Where a line crosses a mesh: distances along the direction from the point, both moved by `mesh_T_line` [m]."""
    origin, along = _moved(mesh_T_line, point), mesh_T_line[:3, :3] @ direction
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    first, second = b - a, c - a
    across = np.cross(along, second)
    volume = np.einsum("ij,ij->i", first, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.einsum("ij,ij->i", origin - a, across) / volume
        turned = np.cross(origin - a, first)
        v = turned @ along / volume
        t = np.einsum("ij,ij->i", second, turned) / volume
        met = (np.abs(volume) > 1e-18) & (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1.0 + 1e-9)
    return np.asarray(t[met])
