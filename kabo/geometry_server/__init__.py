"""The geometry server room: bounded predicates, streams of candidates, proven motions, the symbolic-geometric map.

It knows scenes, motion, kinematics and geometry; it knows nothing of knowledge, search, files or plans beyond the
segments of motion that it makes.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "Answer": "answers",
    "Failure": "answers",
    "MAX_EFFORT": "answers",
    "Pair": "answers",
    "Statistics": "answers",
    "Success": "answers",
    "Candidate": "candidates",
    "GraspStream": "candidates",
    "PlacementStream": "candidates",
    "Stream": "candidates",
    "BATCH": "candidates",
    "candidate": "candidates",
    "from_home": "candidates",
    "grasp_roles": "candidates",
    "grasp_stream": "candidates",
    "Context": "context",
    "Extra": "extras",
    "extra": "extras",
    "padding": "extras",
    "grasps_there": "foresight",
    "may_place": "foresight",
    "Frame": "frames",
    "Roles": "frames",
    "WORLD": "frames",
    "carried_frame": "frames",
    "fits": "frames",
    "rows": "frames",
    "standing_frame": "frames",
    "tool_frame": "frames",
    "IdentifierMap": "identifiers",
    "Place": "placing",
    "placement_streams": "placing",
    "HELD_EXACTLY": "placing",
    "recognised": "placing",
    "ScenePredicates": "predicates",
    "grasp_missing": "reach",
    "region_missing": "reach",
    "GeometryServer": "server",
    "Shortfall": "shortfall",
    "shortfall_of": "shortfall",
    "Situation": "situation",
    "lies_inside": "standing",
    "supports": "standing",
    "why_unsupported": "standing",
    "Keep": "stretches",
    "Refused": "stretches",
    "keep_constraint": "stretches",
    "LINE": "stretches",
    "LINE_TILT": "stretches",
    "line": "stretches",
    "way_to": "stretches",
    "Team": "teams",
    "TeamStream": "teams",
    "Contacts": "workspace",
    "Surroundings": "surroundings",
    "Workspace": "workspace",
    "contacts": "workspace",
    "workspace_of": "workspace",
}
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used: kernels cost half a second to import."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
