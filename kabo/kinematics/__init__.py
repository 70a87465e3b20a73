"""Kinematics: constraints between features, configurations that fulfil them, straight lines of the tool.

A constraint becomes flat scalar rows (`rows_of`), rows are sampled and projected onto by one kernel (`sample`,
`project`), and a motion is proven to keep them (`keeps`). A pose becomes configurations (`solutions`), in closed form
where the axes allow it. Knows trees of joints; knows no obstacles and no goals.
"""

from importlib import import_module
from typing import Any

_HOME = {
    "FrameFeature": "constraints",
    "Rows": "constraints",
    "rows_of": "constraints",
    "stacked": "constraints",
    "jacobian": "projection",
    "project": "projection",
    "satisfied": "projection",
    "values": "projection",
    "Key": "sampling",
    "sample": "sampling",
    "seeds": "sampling",
    "stream_key": "sampling",
    "uniform": "sampling",
    "FREE_BODY": "several",
    "JoinedTree": "several",
    "joined": "several",
    "Tangent": "manifold",
    "tangent": "manifold",
    "OutOfReach": "closed_form",
    "Reached": "closed_form",
    "with_the_same_pose": "closed_form",
    "with_turns": "closed_form",
    "is_carried": "inverse",
    "reaching": "inverse",
    "solutions": "inverse",
    "OffLine": "line",
    "straight_line": "line",
    "Projector": "keeping",
    "keeps": "keeping",
    "projector": "keeping",
    "unkept_row": "keeping",
}
__all__ = sorted(_HOME)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Public names load when first used: kernels cost half a second to import."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
