"""The geometry room: bodies as enclosing convex parts, bounded predicates on them, one collision kernel.

Arrays, metres and epsilon; it knows nothing of robots, names of objects or formulas. Names that need compiled
kernels or mesh libraries load when they are first used.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # files that are called like what they offer
    from kabo.geometry.bounding_decomposition import bounding_decomposition as bounding_decomposition
    from kabo.geometry.bounding_mesh import bounding_mesh as bounding_mesh
    from kabo.geometry.swept_volume import swept_volume as swept_volume

_HOMES = {
    "BoundingMesh": "bounding_mesh",
    "Bounds": "predicates",
    "Budget": "budget",
    "CollisionView": "views",
    "Container": "predicates",
    "Counters": "views",
    "Decomposition": "bounding_decomposition",
    "Enclosure": "parts",
    "ExactView": "exact",
    "FixedGroup": "parts",
    "Motion": "motions",
    "MovingGroup": "parts",
    "SweptVolume": "swept_volume",
    "bounding_decomposition": "bounding_decomposition",
    "bounding_mesh": "bounding_mesh",
    "collides": "predicates",
    "contains": "inclusion",
    "digest_beside": "stored_parts",
    "crossing_faces": "crossings",
    "distance": "predicates",
    "enclosing_parts": "enclosure",
    "exact_collides": "exact_predicates",
    "exact_distance": "exact_predicates",
    "exact_includes": "exact_predicates",
    "exact_sweep_collides": "exact_predicates",
    "hausdorff_bound": "hausdorff",
    "includes": "predicates",
    "penetration": "penetration",
    "signed_distance": "penetration",
    "sweep_collides": "predicates",
    "swept_volume": "swept_volume",
    "write_parts": "enclosure",
}

__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


class _Room(ModuleType):
    """A room whose names stay what `_HOMES` says, also where a file is called like the function that it offers."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not (
            name in _HOMES and isinstance(value, ModuleType)
        ):  # Python hangs every imported file on its package
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Room
