"""What a report tells for the eye: the motion of a solution, and the sample at which a failure was found.

States are told as in plan files, and only where they differ from the start of the scene. Numbers of motions are rounded
to 1e-6, because nothing is proven of them here.
"""

from typing import TYPE_CHECKING

from kabo.geometry_server.answers import Refusal
from kabo.plan import Node, node_to_json
from kabo.tasks.core import Solution
from kabo.tasks.files.report_form import FilmReport, SampleReport, SegmentReport, StateReport

if TYPE_CHECKING:
    from kabo.geometry_server import Situation
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need

MAX_FILMS = 10  # solutions of one run, the first ones, whose motion is reported
DECIMALS = 6  # of joint values [rad or m] and times [s] of motions


def film_of(solution: Solution, scene: "Scene") -> FilmReport | None:
    """The motion of a whole solution; None if its scenes are not of robots, or nothing moves."""
    if solution.start is None or solution.end is None or not hasattr(solution.start.scene, "situation"):
        return None
    # Loads kernels, as a task that moves robots has done.
    from kabo.tasks.robots import segments

    motion = segments(solution, scene, "")
    if not motion:
        return None
    told = node_to_json(Node("action", solution.stage.name, motion=motion))["motion"]
    return {
        "start": state_of(solution.start.scene.situation, scene),
        "segments": [_short(segment) for segment in told],
        "after": state_of(solution.end.scene.situation, scene),
    }


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


def _short(segment: SegmentReport) -> SegmentReport:
    """A segment of a plan without what is only proven in plans."""
    return {
        "robot": segment["robot"],
        "joints": segment["joints"],
        "waypoints": [[round(value, DECIMALS) + 0.0 for value in row] for row in segment["waypoints"]],
        "times": [round(t, DECIMALS) for t in segment["times"]],
        "stage": segment["stage"],
        "attach": segment["attach"],
        "detach": segment["detach"],
    }
