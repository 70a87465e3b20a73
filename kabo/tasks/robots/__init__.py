"""Robot stages: on kabo's geometry server, with every motion proven free by the bounded sweep check [T 3.2].

A stage sees a `TaskScene` and gives motion as `Stretch`es. Streams of grasps and places are keyed by what is sampled,
so the same candidates come in the same order wherever the robot starts [docs/plans.md#sharing].
"""

from importlib import import_module
from typing import Any

_STAGES = {
    "AddGeometry": "stages.geometry",
    "AllowContact": "stages.changes",
    "Attach": "stages.changes",
    "ComputeIK": "stages.solving",
    "Connect": "stages.connecting",
    "CurrentState": "stages.states",
    "Detach": "stages.changes",
    "FixedState": "stages.states",
    "ForbidContact": "stages.changes",
    "GraspPoses": "stages.symmetries",
    "Join": "stages.changes",
    "Merger": "stages.merging",
    "MonitoredPoses": "stages.poses",
    "MoveRelative": "stages.strokes",
    "MoveTo": "stages.moves",
    "NoOp": "stages.filters",
    "Pad": "stages.geometry",
    "PlacePoses": "stages.symmetries",
    "PoseGenerator": "stages.poses",
    "Pour": "stages.pouring",
    "PredicateFilter": "stages.filters",
    "RecogniseGrasp": "stages.grasps",
    "RemoveGeometry": "stages.geometry",
    "Reparameterise": "stages.reparameterising",
    "SampleConfiguration": "stages.states",
    "SampleGrasp": "stages.grasps",
    "SampleMate": "stages.placements",
    "SampleMeeting": "stages.meeting",
    "SamplePlacement": "stages.placements",
    "Unpad": "stages.geometry",
    "Wait": "stages.filters",
}
_HOME = _STAGES | {
    "Details": "declaring",
    "Direction": "motion.directions",
    "RobotStage": "declaring",
    "Stretch": "scenes",
    "TaskScene": "scenes",
    "changed": "motion.exporting",
    "check_meaning": "declaring",
    "check_names": "declaring",
    "clearance": "motion.costs",
    "distance_to_reference": "motion.costs",
    "duration": "motion.costs",
    "path_length": "motion.costs",
    "refusal": "declaring",
    "segments": "motion.exporting",
    "stretch": "scenes",
    "stretches": "motion.exporting",
    "tool_distance": "motion.costs",
}
NAMES = tuple(sorted(_STAGES))  # of the stages, in task files
__all__ = sorted([*_HOME, "NAMES", "STAGES"])  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used; `STAGES` maps the names of task files to classes."""
    if name == "STAGES":
        return {stage: getattr(import_module(f"{__name__}.{home}"), stage) for stage, home in _STAGES.items()}
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
