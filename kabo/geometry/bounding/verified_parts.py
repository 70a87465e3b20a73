"""Verification of convex parts that were read from a file: they are used only if their claims are proven.

A digest in a file shows that the file is complete, not that it is correct: a small box somewhere else would hide
every collision of a body. So two claims are proven: the union of the parts covers the solid, and no point of a
part is farther from the solid than its deviation. A proof is remembered by the content of mesh and parts: within
the process, and by a file name in the cache, whose owner and mode are checked [kabo.compilation]: anyone
who could forge such a file could replace the compiled code in the cache as well.
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
from kabo.geometry.bounding.enclosing_polytope import hull_planes
from kabo.geometry.bounding.nearness import proven_near
from kabo.geometry.bounding.pieces import uncovered
from kabo.geometry.triangles.solids import Solid

PROOF_VERSION = 1  # to be incremented when the proof changes
MAX_PARTS = 2000  # in a file; decompositions never have more
PROOFS_FOLDER = "proven"  # in the cache: an empty file for each proof

_PROVEN: ContentCache[bool] = ContentCache(1 << 20, lambda _: len(hashlib.sha256().hexdigest()))


def are_verified(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> bool:
    """Whether parts (V, 3) [m] are proven to cover a solid, each within its deviation [m] of it.

    False if a proof fails or takes too long; such parts are computed again.
    """
    if not _plausible(solid, parts, deviations):
        return False
    name = _name(solid, parts, deviations)
    return _PROVEN.get_or_make(
        name, lambda: _proof_file(name).is_file() or _proven(solid, parts, deviations, name)
    )


def _proven(solid: Solid, parts: Sequence[Array], deviations: Sequence[float], name: str) -> bool:
    try:
        holds = not uncovered(solid, parts) and all(
            _near(solid, *each) for each in zip(parts, deviations, strict=True)
        )
    except (QhullError, ValueError):  # a flat part encloses nothing
        return False
    if holds:
        _write_proof(name)
    return holds


def record_proof(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> None:
    """Records that parts were proven when they were computed, so that they need no proof when they are read."""
    name = _name(solid, parts, deviations)
    _write_proof(name)
    _PROVEN.get_or_make(name, lambda: True)


def _plausible(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> bool:
    """Whether the numbers are plausible: at least four finite corners a part, none far outside the solid's box."""
    if not 1 <= len(parts) <= MAX_PARTS or len(parts) != len(deviations):
        return False
    sizes = {len(part) for part in parts}
    if min(sizes) < 4 or not all(np.isfinite(deviations)) or min(deviations) < 0.0:
        return False
    slack = max(deviations) * (1 + 1e-9) + 1e-9
    low, high = solid.vertices.min(axis=0) - slack, solid.vertices.max(axis=0) + slack
    corners = np.concatenate(list(parts))
    return bool(((corners >= low) & (corners <= high)).all())  # NaN is outside


def _near(solid: Solid, part: Array, deviation: float) -> bool:
    """Whether a part is proven within its deviation of the solid, by one of two proofs, the quicker one first."""
    near = proven_near(solid, part, deviation)
    return solid.proves_within(part, hull_planes(part), deviation) if near is None else near


def _name(solid: Solid, parts: Sequence[Array], deviations: Sequence[float]) -> str:
    digest = hashlib.sha256(repr((PROOF_VERSION, len(solid.faces), [len(part) for part in parts])).encode())
    for numbers in (solid.vertices[solid.faces], *parts, np.array(deviations)):
        digest.update(np.ascontiguousarray(numbers, "<f8").tobytes())
    return digest.hexdigest()


def _proof_file(name: str) -> Path:
    """The path of the empty file that records a proof in the cache."""
    return cache_folder() / PROOFS_FOLDER / name


def _write_proof(name: str) -> None:
    with suppress(OSError):  # a full disk costs time, never an answer
        noted = _proof_file(name)
        noted.parent.mkdir(mode=0o700, exist_ok=True)
        noted.touch()
