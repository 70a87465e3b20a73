"""Whether convex parts that come from a file keep what they say; only then are they used.

A digest in a file shows that the file is whole, not that it is true: a small box somewhere else would make every
collision of a body disappear. So parts are asked two questions: does their union cover the solid, and is no point of
theirs farther from it than they say. A proof is remembered by the content of mesh and parts: within the process, and
by a name in the cache, whose owner and mode are checked [kabo.compilation]; who could write that name there could
write compiled code there as well.
"""

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from scipy.spatial import QhullError

from kabo.arrays import Array
from kabo.compilation import cache_folder
from kabo.content_cache import ContentCache
from kabo.geometry.bounding.nearness import proven_near
from kabo.geometry.bounding.pieces import uncovered
from kabo.geometry.bounding.reduction import hull_planes
from kabo.geometry.triangles.solids import Solid

METHOD = 1  # to be counted up when what is proven, or how, changes
MOST_PARTS = 2000  # more are never made; what a file may announce is bounded before anything is computed
NOTED = "proven"  # the folder of the cache that remembers proofs by their names

_PROVEN: ContentCache[bool] = ContentCache(1 << 20, lambda _: len(hashlib.sha256().hexdigest()))


def believed(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> bool:
    """Whether parts (V, 3) [m] are proven to cover a solid, each within its deviation [m] of it.

    False where a proof fails or takes too long: such parts are made again.
    """
    if not _sensible(solid, parts, deviations):
        return False
    name = _name(solid, parts, deviations)
    return _PROVEN.get_or_make(name, lambda: _noted(name).is_file() or _proven(solid, parts, deviations, name))


def _proven(solid: Solid, parts: Sequence[Array], deviations: Sequence[float], name: str) -> bool:
    try:
        holds = not uncovered(solid, parts) and all(
            _near(solid, *each) for each in zip(parts, deviations, strict=True)
        )
    except (QhullError, ValueError):  # a flat part encloses nothing
        return False
    if holds:
        _note(name)
    return holds


def remember(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> None:
    """Notes that parts were proven while they were made, so that they need not be proven when they are read again."""
    name = _name(solid, parts, deviations)
    _note(name)
    _PROVEN.get_or_make(name, lambda: True)


def _sensible(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> bool:
    """Whether the numbers can be what they should be: corners enough, finite, and none far outside the solid's box."""
    if not 1 <= len(parts) <= MOST_PARTS or len(parts) != len(deviations):
        return False
    sizes = {len(part) for part in parts}
    if min(sizes) < 4 or not all(np.isfinite(deviations)) or min(deviations) < 0.0:
        return False
    slack = max(deviations) * (1 + 1e-9) + 1e-9
    low, high = solid.vertices.min(axis=0) - slack, solid.vertices.max(axis=0) + slack
    corners = np.concatenate(list(parts))
    return bool(((corners >= low) & (corners <= high)).all())  # NaN is outside


def _near(solid: Solid, part: Array, deviation: float) -> bool:
    """Whether a part is proven near the solid, by the quicker of two proofs first."""
    near = proven_near(solid, part, deviation)
    return solid.proves_within(part, hull_planes(part), deviation) if near is None else near


def _name(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> str:
    digest = hashlib.sha256(repr((METHOD, len(solid.faces), [len(part) for part in parts])).encode())
    for numbers in (solid.vertices[solid.faces], *parts, np.array(deviations)):
        digest.update(np.ascontiguousarray(numbers, "<f8").tobytes())
    return digest.hexdigest()


def _noted(name: str) -> Path:
    """The empty file in the cache that says that a proof was found."""
    return cache_folder() / NOTED / name


def _note(name: str) -> None:
    with suppress(OSError):  # a full disk costs time, never an answer
        noted = _noted(name)
        noted.parent.mkdir(mode=0o700, exist_ok=True)
        noted.touch()
