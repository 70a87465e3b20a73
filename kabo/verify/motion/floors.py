"""Proves that the base of a robot that drives stays over its floor region, seen from above, all along its way.

Between two way points the base's axis goes straight and the base turns evenly, so each corner of its outline is farthest
out at an end or where its velocity is along the edge: these places are computed, none is sampled.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.scene import Region
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.limits import LIMIT_TOLERANCE
from kabo.verify.report import Finding

BASE_JOINTS = 3  # the first values of a configuration: two slides and a turn


@dataclass(frozen=True)
class Floor:
    """A floor region seen from above: unit normals (E, 2) @ point <= offsets (E,) [m]; and the base's outline.

    `joint` turns the base; `outline` (V, 3) are the corners of the base's links, seen from above, in its frame.
    """

    region: str
    normals: Array
    offsets: Array
    joint: int
    outline: Array


def floor_of(arm: Arm, regions: Mapping[str, Region]) -> Floor | None:
    """The floor of a robot among the regions of its scene; None if its base stands."""
    drive = arm.robot.drive
    if drive is None:
        return None
    joint = next(j for j in range(1, len(arm.parents)) if _value(arm, j) == BASE_JOINTS - 1)
    return Floor(drive.floor, *_shadow(regions[drive.floor]), joint, _outline(arm, joint))


def _value(arm: Arm, joint: int) -> int:
    """The value of a configuration that moves a joint; -1 if none does."""
    actuation = arm.robot.actuation
    return actuation.source[joint] if actuation.ratio[joint] != 0.0 else -1


def _shadow(region: Region) -> tuple[Array, Array]:
    """The half-planes of a region seen from above: of the hull of its corners, which are met by its half-spaces."""
    from scipy.optimize import linprog
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    spaces = np.column_stack([region.normals, -region.offsets])
    # The middle of the greatest ball inside: normals @ x + r <= offsets.
    rows = np.column_stack([region.normals, np.ones(len(region.normals))])
    ball = linprog([0, 0, 0, -1], A_ub=rows, b_ub=region.offsets, bounds=[(None, None)] * 4)
    corners = HalfspaceIntersection(spaces, ball.x[:3]).intersections
    corners = corners @ region.world_T_region[:3, :3].T + region.world_T_region[:3, 3]
    equations = np.unique(ConvexHull(corners[:, :2]).equations.round(14), axis=0)
    return equations[:, :2], -equations[:, 2]


def _outline(arm: Arm, joint: int) -> Array:
    """The corners (V, 3) of the base's links in the frame of the joint that turns it, of the hull seen from above."""
    from scipy.spatial import ConvexHull, QhullError

    chain, points = arm.chains[joint], [np.zeros((1, 3))]
    zero = arm.joint_poses([0.0] * len(arm.robot.joint_names))
    upright = np.linalg.inv(zero[joint])
    for name, mount in arm.mounts.items():
        mesh = arm.robot.links[name].mesh
        if mesh is not None and arm.chains[mount.joint] == chain:
            pose = upright @ zero[mount.joint] @ mount.joint_T_body
            points.append(mesh.vertices @ pose[:3, :3].T + pose[:3, 3])
    corners = np.concatenate(points[1:] or points)
    try:
        return np.asarray(corners[ConvexHull((corners @ zero[joint][:3, :3].T)[:, :2]).vertices])
    except QhullError:  # a base without an area
        return corners


def check_floor(
    node: str, segment: Segment, arm: Arm, floor: Floor, start: Array, deviations: Array | None = None
) -> Iterator[Finding]:
    """A finding unless the base is proven to stay on its floor along a segment of the planned joints.

    Args:
        node: the id of its node.
        segment: the segment.
        arm: the robot.
        floor: its floor.
        start: the configuration (n,) of all joints when the segment begins.
        deviations: how far the joints may be from the path on each piece (K, planned) [rad or m]; None: nowhere.
    """
    if segment.joints != arm.robot.planned_joints:
        return
    waypoints = np.asarray(segment.waypoints)
    rows = np.tile(start, (len(waypoints), 1))
    rows[:, : waypoints.shape[1]] = waypoints
    poses = np.array([arm.joint_poses(q.tolist())[floor.joint] for q in rows])
    out = outside(floor, poses, np.diff(rows[:, BASE_JOINTS - 1]))
    if deviations is not None:
        lever = float(np.linalg.norm(floor.outline, axis=1).max())
        reach = arm.reach(floor.joint, lever, arm.chains[floor.joint])
        out = out + deviations[:, :BASE_JOINTS] @ reach[:BASE_JOINTS]
    k = int(out.argmax())
    if out[k] > LIMIT_TOLERANCE:
        text = f"the base of {segment.robot} leaves its floor {floor.region} by {1000 * out[k]:.3g} mm"
        yield Finding(node, text, float(segment.times[k]), (segment.robot,), float(out[k]))


def outside(floor: Floor, poses: Array, turns: Array) -> Array:
    """How far the outline reaches out of the floor at most on each piece (K,) [m] of a way; 0 or less: not at all.

    Args:
        floor: the floor and the outline.
        poses: the poses (K + 1, 4, 4) of the joint that turns the base at the way points.
        turns: by how much it turns about the vertical on each piece (K,) [rad].
    """
    axis, upwards = poses[:, :2, 3], np.sign(poses[0, 2, 2])
    arms = np.einsum("kij,vj->kvi", poses[:-1, :2, :3], floor.outline)
    lengths = np.linalg.norm(arms, axis=2)  # (K, V)
    directions = np.arctan2(floor.normals[:, 1], floor.normals[:, 0])
    begin = np.arctan2(arms[..., 1], arms[..., 0])[..., None] - directions  # (K, V, E)
    turned = (upwards * turns)[:, None, None]
    gone = (np.diff(axis, axis=0) @ floor.normals.T)[:, None, :]  # of the axis, along the normals
    first = (axis[:-1] @ floor.normals.T - floor.offsets)[:, None, :]

    def reached(share: Array) -> Array:
        return np.asarray(first + share * gone + lengths[..., None] * np.cos(begin + share * turned))

    worst = np.maximum(reached(np.zeros_like(begin)), reached(np.ones_like(begin)))
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = gone / (lengths[..., None] * turned)
        peak = np.arcsin(np.clip(sine, -1.0, 1.0))
        # Whole turns that bring the peak between the beginning and the end of the piece.
        low = np.minimum(begin, begin + turned)
        peak = peak + 2.0 * np.pi * np.ceil((low - peak) / (2.0 * np.pi))
        for _ in range(int(np.ceil(np.abs(turns).max(initial=0.0) / (2.0 * np.pi))) + 1):
            share = (peak - begin) / turned
            inside = np.isfinite(share) & (share >= 0.0) & (share <= 1.0)
            worst = np.where(inside, np.maximum(worst, reached(np.where(inside, share, 0.0))), worst)
            peak = peak + 2.0 * np.pi
    return np.asarray(worst.max(axis=(1, 2)))
