"""The geometry room: bodies as enclosing convex parts, bounded predicates on them, one collision kernel.

Arrays, metres and epsilon; it knows nothing of robots, names of objects or formulas. Names that need compiled
kernels or mesh libraries load when they are first used.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # files that are called like what they offer
    from kabo.geometry.bounding.bounding_decomposition import bounding_decomposition as bounding_decomposition
    from kabo.geometry.bounding.bounding_mesh import bounding_mesh as bounding_mesh
    from kabo.geometry.collision.swept_volume import swept_volume as swept_volume

_HOMES = {
    "BoundingMesh": "bounding.bounding_mesh",
    "Bounds": "collision.predicates",
    "Budget": "budget",
    "CollisionView": "collision.views",
    "Container": "collision.predicates",
    "Counters": "collision.views",
    "Decomposition": "bounding.bounding_decomposition",
    "Enclosure": "parts",
    "ExactView": "collision.exact",
    "FixedGroup": "parts",
    "Motion": "collision.motions",
    "MovingGroup": "parts",
    "SweptVolume": "collision.swept_volume",
    "bounding_decomposition": "bounding.bounding_decomposition",
    "bounding_mesh": "bounding.bounding_mesh",
    "collides": "collision.predicates",
    "contains": "collision.inclusion",
    "digest_beside": "bounding.stored_parts",
    "crossing_faces": "triangles.crossings",
    "distance": "collision.predicates",
    "enclosing_parts": "bounding.enclosure",
    "exact_collides": "collision.exact_predicates",
    "exact_distance": "collision.exact_predicates",
    "exact_includes": "collision.exact_predicates",
    "exact_sweep_collides": "collision.exact_predicates",
    "hausdorff_bound": "bounding.hausdorff",
    "includes": "collision.predicates",
    "penetration": "collision.penetration",
    "signed_distance": "collision.penetration",
    "sweep_collides": "collision.predicates",
    "swept_volume": "collision.swept_volume",
    "write_parts": "bounding.enclosure",
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
