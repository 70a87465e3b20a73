"""The canonical file of a plan: equal plans have equal bytes, so that hashes tell whether two plans are the same.

Keys are sorted; there are no blanks, and one line feed at the end. Numbers are written as by Python's `repr`,
joint values rounded to 1e-9, times to 1e-6, coefficients by their effect, never as -0.0 or NaN
(docs/reference/plans.md). A plan is rounded before it is verified, so that the verifier reads the same numbers as
executors.
"""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from kabo.given import require_given
from kabo.plan.certificate_json import certificate_to_json
from kabo.plan.plan import Done, Learned, Node, ObjectPose, Plan, Segment, StateChange, ValueOf
from kabo.plan.trajectory_json import TIME_DECIMALS, rounded_trajectory, trajectory_to_json
from kabo.whole_files import write_atomically

FORMAT = "kabo-plan/2"
READABLE_FORMATS = ("kabo-plan/1", FORMAT)  # in the first, segments have no trajectory
JOINT_DECIMALS, LEARNED_DIGITS = 9, 9


def plan_to_json(plan: Plan) -> bytes:
    """The canonical file of a plan, as bytes.

    Args:
        plan: the plan; its numbers are rounded as in files.

    Raises:
        ArgumentError: `plan` is none.
        ValueError: a number is NaN or infinite.
    """
    require_given("plan", plan, Plan)
    return canonical(_plan(plan)) + b"\n"


def plan_hash(plan: Plan) -> str:
    """`sha256:…` of the plan's canonical file."""
    return "sha256:" + hashlib.sha256(plan_to_json(plan)).hexdigest()


def write_plan(plan: Plan, path: Path) -> str:
    """Writes the plan's file, completely or not at all; returns its hash."""
    write_atomically(path, plan_to_json(plan))
    return plan_hash(plan)


def canonical(value: Any) -> bytes:
    """A JSON value as bytes, with sorted keys and without blanks or a line feed; raises ValueError for NaN or infinity."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()


def rounded(node: Node) -> Node:
    """The node with its numbers rounded as in a file: joints to 1e-9, times to 1e-6, coefficients by effect."""
    after = None if node.after is None else rounded_state(node.after)
    arguments = {name: _argument(value) for name, value in node.arguments.items()}
    motion, overlap = tuple(map(_rounded_segment, node.motion)), _number(node.overlap, TIME_DECIMALS)
    learned = tuple(map(rounded_learned, node.learned))
    return replace(node, motion=motion, after=after, arguments=arguments, overlap=overlap, learned=learned)


def rounded_state(state: StateChange) -> StateChange:
    """The state with its numbers rounded as in a file: joints to 1e-9, no negative zeros."""
    robots = {
        robot: {joint: _number(value, JOINT_DECIMALS) for joint, value in joints.items()}
        for robot, joints in state.robots.items()
    }
    return StateChange(robots, {name: _rounded_pose(pose) for name, pose in state.objects.items()})


def node_to_json(node: Node) -> dict[str, Any]:
    """The node as a JSON object that contains only the keys for the kind of the node."""
    return rounded_to_json(rounded(node))


def rounded_to_json(node: Node) -> dict[str, Any]:
    """The JSON object of a node that is `rounded`."""
    result: dict[str, Any] = {"kind": node.kind}
    if node.kind in ("action", "sense"):
        result["action"] = node.action
        result["arguments"] = {name: argument_to_json(value) for name, value in node.arguments.items()}
    if node.branches:
        result |= {"on": node.on, "branches": dict(node.branches)}
    elif node.kind != "goal":
        result["next"] = node.next
    if node.delivers:
        result["delivers"] = list(node.delivers)
    if node.motion:
        result["motion"] = [_segment_json(segment) for segment in node.motion]
    if node.after is not None and (node.after.robots or node.after.objects):
        result["after"] = _change_json(node.after)
    if node.overlap > 0.0:
        result["overlap"] = node.overlap
    if node.learned:
        result["learned"] = learned_json(node.learned)
    return result


def rounded_learned(learned: Learned) -> Learned:
    """The record with validity and expected outcomes rounded to 9 digits, and no negative zeros."""
    parameters = {name: _number(value) for name, value in learned.parameters.items()}
    expected = {name: _number(float(f"{value:.{LEARNED_DIGITS}g}")) for name, value in learned.expected.items()}
    validity = _number(learned.validity, LEARNED_DIGITS)
    return replace(learned, parameters=parameters, expected=expected, validity=validity)


def learned_json(learned: Sequence[Learned]) -> Any:
    """Records of learned parameters as JSON: one as an object, several as a list."""
    made = [
        {
            "model": each.model,
            "case": dict(each.case),
            "parameters": dict(each.parameters),
            "validity": each.validity,
            "expected": dict(each.expected),
        }
        for each in map(rounded_learned, learned)
    ]
    return made[0] if len(made) == 1 else made


def _number(value: float, decimals: int | None = None) -> float:
    return (float(value) if decimals is None else round(float(value), decimals)) + 0.0  # + 0.0 turns -0.0 into 0.0


def _argument(value: str | float | ValueOf) -> str | float | ValueOf:
    return value if isinstance(value, str | ValueOf) else _number(value)


def _rounded_pose(pose: ObjectPose) -> ObjectPose:
    x, y, z = map(_number, pose.position)
    qx, qy, qz, qw = map(_number, pose.quaternion)
    return ObjectPose(pose.parent, (x, y, z), (qx, qy, qz, qw))


def _rounded_segment(segment: Segment) -> Segment:
    waypoints = tuple(
        [tuple([round(float(value), JOINT_DECIMALS) + 0.0 for value in row]) for row in segment.waypoints]
    )
    times = tuple([round(float(t), TIME_DECIMALS) + 0.0 for t in segment.times])
    own = segment.trajectory
    trajectory = None if own is None else rounded_trajectory(own, waypoints)
    return replace(segment, waypoints=waypoints, times=times, trajectory=trajectory)


def argument_to_json(value: str | float | ValueOf) -> Any:
    """The JSON value of an argument."""
    return {"value_of": value.term} if isinstance(value, ValueOf) else value


def _segment_json(segment: Segment) -> dict[str, Any]:
    grants = [{"kind": each.kind, "bodies": list(each.bodies), "by": each.by} for each in segment.grants]
    motion = {} if segment.trajectory is None else {"trajectory": trajectory_to_json(segment.trajectory)}
    return (
        motion
        | ({"grants": grants} if grants else {})
        | {
            "robot": segment.robot,
            "joints": list(segment.joints),
            "waypoints": [list(row) for row in segment.waypoints],
            "times": list(segment.times),
            "procedure": segment.procedure,
            "stage": segment.stage,
            "attach": [{"object": name, "to": link} for name, link in segment.attach],
            "detach": list(segment.detach),
            "allowed_contacts": [list(pair) for pair in segment.allowed_contacts],
            "constraint": segment.constraint,
        }
    )


def _robots_json(robots: Mapping[str, Mapping[str, float]]) -> dict[str, Any]:
    return {name: {"joints": dict(joints)} for name, joints in robots.items()}


def _objects_json(objects: Mapping[str, ObjectPose]) -> dict[str, Any]:
    return {
        name: {"parent": pose.parent, "position": list(pose.position), "quaternion": list(pose.quaternion)}
        for name, pose in objects.items()
    }


def done_to_json(done: Done) -> dict[str, Any]:
    """The JSON object of a step of a run."""
    result: dict[str, Any] = {}
    if done.action is not None:
        arguments = {name: argument_to_json(_argument(value)) for name, value in done.arguments.items()}
        result |= {"action": done.action, "arguments": arguments}
    return result if done.on is None else result | {"on": done.on, "outcome": done.outcome}


def state_to_json(state: StateChange) -> dict[str, Any]:
    """The JSON object of a whole state that is `rounded_state`."""
    return {"robots": _robots_json(state.robots), "objects": _objects_json(state.objects)}


def _change_json(change: StateChange) -> dict[str, Any]:
    parts = {"robots": _robots_json(change.robots), "objects": _objects_json(change.objects)}
    return {key: value for key, value in parts.items() if value}


def _plan(plan: Plan) -> dict[str, Any]:
    result: dict[str, Any] = {
        "format": FORMAT,
        "problem": {"name": plan.problem, "files": dict(plan.files)},
        "options": {name: _option(value) for name, value in plan.options.items()},
        "root": plan.root,
        "nodes": {name: node_to_json(node) for name, node in plan.nodes.items()},
    }
    if plan.start is not None:
        result["start"] = state_to_json(rounded_state(plan.start))
    if plan.done is not None:
        result["done"] = [done_to_json(done) for done in plan.done]
    if plan.certificate is not None:
        result["certificate"] = certificate_to_json(plan.certificate)
    if plan.certificate_gaps:
        result["certificate_gaps"] = list(plan.certificate_gaps)
    return result


def _option(value: Any) -> Any:
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"an option of a plan is {value}")
        return _number(value)
    return value
