"""Robot stages: on kabo's geometry server, with every motion proven free by the bounded sweep check [T 3.2].

A stage sees a `TaskScene` and gives motion as `Stretch`es. Streams of grasps and places are keyed by what is sampled,
so the same candidates come in the same order wherever the robot starts [docs/plans.md#sharing].
"""

from importlib import import_module
from typing import Any

_STAGES = {
    "AddGeometry": "geometry",
    "AllowContact": "changes",
    "Attach": "changes",
    "ComputeIK": "solving",
    "Connect": "connecting",
    "CurrentState": "states",
    "Detach": "changes",
    "FixedState": "states",
    "ForbidContact": "changes",
    "GraspPoses": "symmetries",
    "Join": "changes",
    "Merger": "merging",
    "MonitoredPoses": "poses",
    "MoveRelative": "strokes",
    "MoveTo": "moves",
    "NoOp": "filters",
    "Pad": "geometry",
    "PlacePoses": "symmetries",
    "PoseGenerator": "poses",
    "Pour": "pouring",
    "PredicateFilter": "filters",
    "RecogniseGrasp": "grasps",
    "RemoveGeometry": "geometry",
    "Reparameterise": "reparameterising",
    "SampleConfiguration": "states",
    "SampleGrasp": "grasps",
    "SampleMate": "placements",
    "SampleMeeting": "meeting",
    "SamplePlacement": "placements",
    "Unpad": "geometry",
    "Wait": "filters",
}
_HOME = _STAGES | {
    "Details": "declaring",
    "Direction": "directions",
    "RobotStage": "declaring",
    "Stretch": "scenes",
    "TaskScene": "scenes",
    "changed": "exporting",
    "check_meaning": "declaring",
    "check_names": "declaring",
    "clearance": "costs",
    "distance_to_reference": "costs",
    "duration": "costs",
    "path_length": "costs",
    "refusal": "declaring",
    "segments": "exporting",
    "stretch": "scenes",
    "stretches": "exporting",
    "tool_distance": "costs",
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
