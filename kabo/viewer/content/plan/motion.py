"""The motions of a plan for the player: segments as in the plan file, and where objects hang after each hand-over.

The page evaluates trajectories; without one it interpolates way points in time. What a hand takes or lets go keeps
its pose in the world; its pose in the frame of its new parent follows from kinematics and is computed here, so that
the page needs none to say the state.
"""

from collections.abc import Mapping
from typing import Any

from kabo.arrays import Array
from kabo.plan import Grant, Node, ObjectPose, Plan, Segment, StateChange
from kabo.planner.certify.component_values import ComponentValues
from kabo.planner.certify.motion_situation import MotionSituation
from kabo.planner.certify.motion_stretches import stretches
from kabo.scene import Scene
from kabo.scene.transforms import quaternion
from kabo.viewer.content.trajectories import shown_trajectory

DIGITS = 12  # of hand-over poses; far below what the page promises


def state_view(change: StateChange | None) -> dict[str, Any] | None:
    """A geometric state, or the part of it that a node changes, in the form of the plan file."""
    if change is None:
        return None
    return {
        "robots": {name: dict(joints) for name, joints in change.robots.items()},
        "objects": {name: _pose(pose) for name, pose in change.objects.items()},
    }


def motion_view(node: Node, handovers: list[dict[str, Any]]) -> dict[str, Any] | None:
    """The motion of a node with what it changes; None if the node moves nothing."""
    if not node.motion and node.after is None:
        return None
    return {
        "segments": [_segment(segment) for segment in node.motion],
        "handovers": handovers,
        "after": state_view(node.after),
        "overlap": node.overlap,
        "duration": max((segment.times[-1] for segment in node.motion), default=0.0),
    }


def handovers_of(name: str, plan: Plan, values: ComponentValues, scene: Scene) -> list[dict[str, Any]]:
    """Where the objects hang that a node's motion takes or lets go: `time` [s], `object`, `parent`, and the pose there.

    Raises:
        ValueError: something that moves may be in several places.
    """
    motion = plan.nodes[name].motion
    if not any(segment.attach or segment.detach for segment in motion):
        return []
    situation = MotionSituation.at(name, values, scene, [segment.robot for segment in motion])
    found: list[dict[str, Any]] = []
    for stretch in stretches(motion, dict(scene.robots), situation.q):
        before = dict(situation.hung)
        for i in stretch.ending:
            situation.end(motion[i])
        found.extend(_changed(before, situation, float(stretch.times[-1])))
    return found


def _changed(
    before: Mapping[str, tuple[str, Array]], situation: MotionSituation, time: float
) -> list[dict[str, Any]]:
    return [
        {
            "time": time,
            "object": name,
            "parent": parent,
            "position": [round(float(x), DIGITS) for x in pose[:3, 3]],
            "quaternion": [round(float(x), DIGITS) for x in quaternion(pose)],
        }
        for name, (parent, pose) in situation.hung.items()
        if before[name][1] is not pose
    ]


def _pose(pose: ObjectPose) -> dict[str, Any]:
    return {"parent": pose.parent, "position": list(pose.position), "quaternion": list(pose.quaternion)}


def _segment(segment: Segment) -> dict[str, Any]:
    return {
        "robot": segment.robot,
        "joints": list(segment.joints),
        "waypoints": [list(row) for row in segment.waypoints],
        "times": list(segment.times),
        "trajectory": None if segment.trajectory is None else shown_trajectory(segment.trajectory),
        "attach": [list(pair) for pair in segment.attach],
        "detach": list(segment.detach),
        "allowed": [list(pair) for pair in segment.allowed_contacts],
        "grants": [_grant(grant) for grant in segment.grants],
        "constraint": segment.constraint,
        "procedure": segment.procedure,
        "stage": segment.stage,
    }


def _grant(grant: Grant) -> dict[str, Any]:
    return {"kind": grant.kind, "bodies": list(grant.bodies), "by": grant.by}
