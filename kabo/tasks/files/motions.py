"""What a report tells of motion: that of a solution, with the changes of its scene, and the sample of a failure.

States are told as in plan files, and only where they differ from the start of the scene. Segments are those of plans,
digit for digit: what was proven is what is written.
"""

from typing import TYPE_CHECKING, Any

from kabo.geometry_server.answers import Refusal
from kabo.plan import Node, node_to_json
from kabo.tasks.core import Solution
from kabo.tasks.files.report_form import MotionReport, SampleReport, StateReport
from kabo.tasks.files.scene_changes import scene_changes

if TYPE_CHECKING:
    from kabo.geometry_server import Situation
    from kabo.plan import Segment
    from kabo.scene import GeometricState, Scene  # loads meshes, which tasks without robots do not need

NOT_TOLD = ("procedure", "grants")  # keys of a plan's segments: there is no procedure; grants are found for plans


def motion_of(solution: Solution, scene: "Scene") -> MotionReport | None:
    """The motion of a whole solution; None if its scenes are not of robots, or nothing moves."""
    if solution.start is None or solution.end is None or not hasattr(solution.start.scene, "situation"):
        return None
    # Loads kernels, as a task that moves robots has done.
    from kabo.tasks.robots import segments

    motion = segments(solution, scene, "")
    if not motion:
        return None
    return {
        "start": state_of(solution.start.scene.situation, scene),
        "segments": _told(motion),
        "changes": list(scene_changes(solution, motion)),
        "after": state_of(solution.end.scene.situation, scene),
    }


def _told(motion: "tuple[Segment, ...]") -> Any:
    """The segments as in plan files, without what only plans have."""
    written = node_to_json(Node("action", "", motion=motion))["motion"]
    return [{key: value for key, value in each.items() if key not in NOT_TOLD} for each in written]


def sample_of(failure: Solution, scene: "Scene") -> SampleReport | None:
    """Where a failure was found, and which two things came too close; None if its scenes are not of robots."""
    refusal = failure.details if isinstance(failure.details, Refusal) else None
    if refusal is not None and refusal.question is not None:
        situation = refusal.question.sample()
    else:
        sides = (side.scene for side in (failure.start, failure.end) if side is not None)
        situation = next((given.situation for given in sides if hasattr(given, "situation")), None)
    if situation is None:
        return None
    made: SampleReport = {"state": state_of(situation, scene)}
    if refusal is not None and refusal.pairs:
        made["between"] = refusal.pairs[0][0]
    return made


def state_of(situation: "Situation", scene: "Scene") -> StateReport:
    """What a situation changes in the start of its scene, as `after` of a plan's node; empty if nothing."""
    # As above.
    from kabo.geometry_server import Situation, whole_state
    from kabo.tasks.robots import changed_between

    changes = whole_state(scene, changed_between(Situation.of(scene.start), situation))
    made: StateReport = {}
    if changes.robots:
        made["robots"] = {name: {"joints": dict(joints)} for name, joints in changes.robots.items()}
    if changes.objects:
        made["objects"] = {
            name: {"parent": pose.parent, "position": pose.position, "quaternion": pose.quaternion}
            for name, pose in changes.objects.items()
        }
    return made


def state_in(state: StateReport, scene: "Scene") -> "GeometricState":
    """A state of a report as the whole state of its scene: what is not in it is as at the start.

    Raises:
        KeyError: the scene lacks a robot or a joint of the state.
    """
    from kabo.scene import Attachment, GeometricState  # as above

    robots, objects = dict(scene.start.robots), dict(scene.start.objects)
    for name, robot in state.get("robots", {}).items():
        before = dict(zip(scene.robots[name].joint_names, robots[name], strict=True))
        robots[name] = tuple({**before, **robot["joints"]}.values())
    for name, pose in state.get("objects", {}).items():
        objects[name] = Attachment(pose["parent"], pose["position"], pose["quaternion"])
    return GeometricState(robots, objects)
