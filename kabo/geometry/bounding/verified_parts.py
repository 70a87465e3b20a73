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
from kabo.geometry.bounding.cells import Cell, cut, inside_planes, whole
from kabo.geometry.bounding.containment import hull_planes
from kabo.geometry.bounding.nearness import proven_near
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.triangles.solids import Solid

PROOF_VERSION = 3  # to be incremented when the proof changes
MAX_PARTS = 2000  # in a file; decompositions never have more
PROOFS_FOLDER = "proven"  # in the cache: an empty file for each proof

_PROVEN: ContentCache[bool] = ContentCache(1 << 20, lambda _: len(hashlib.sha256().hexdigest()))


def are_verified(solid: Solid, cover: Cover, within: Array | None = None) -> bool:
    """Whether parts are proven to cover a solid, each within its deviation of it.

    False if a proof fails or takes too long; such parts are computed again.

    Args:
        within: the corners (V, 3) of a convex part: only what lies inside it must be covered; None: all.
    """
    if not _plausible(solid, cover.parts, cover.deviations):
        return False
    name = _name(solid, cover, within)
    return _PROVEN.get_or_make(name, lambda: _proof_file(name).is_file() or _proven(solid, cover, within, name))


def _proven(solid: Solid, cover: Cover, within: Array | None, name: str) -> bool:
    try:
        cell = whole(solid.vertices, solid.faces)
        if within is not None:
            cell = inside_planes(cell, hull_planes(within))
            if not len(cell.segments) and within.tobytes() not in [part.tobytes() for part in cover.parts]:
                return False  # what lies inside the solid altogether has no segments
        holds = not uncovered(cell, cover.parts) and all(
            proven_near(solid, *each) for each in zip(cover.parts, cover.deviations, strict=True)
        )
    except (QhullError, ValueError):  # a flat part encloses nothing
        return False
    if holds:
        _write_proof(name)
    return holds


def record_proof(solid: Solid, cover: Cover, within: Array | None = None) -> None:
    """Records that parts were proven when they were computed, so that they need no proof when they are read."""
    name = _name(solid, cover, within)
    _write_proof(name)
    _PROVEN.get_or_make(name, lambda: True)


def uncovered(cell: Cell, parts: Sequence[Array]) -> list[Cell]:
    """The cells of a cell outside all parts (V, 3); an empty list proves that the parts cover the cell."""
    cells = [cell] if len(cell.segments) else []
    for part in sorted(parts, key=lambda part: -float(np.prod(np.ptp(part, axis=0)))):
        planes = hull_planes(part)
        cells = [left for cell in cells for left in _outside(cell, planes)]
    return cells


def _outside(cell: Cell, planes: Array) -> list[Cell]:
    """The cells of a cell's solid outside a convex part, given by planes (H, 4); the cell itself if they do not meet."""
    heights = cell.segments.reshape(-1, 3) @ planes[:, :3].T - planes[:, 3]
    if (heights.min(axis=0) >= 0.0).any():
        return [cell]
    highest = heights.max(axis=0)
    left: list[Cell] = []
    inside = cell
    for row in np.argsort(-highest, kind="stable"):  # first the plane that most lies behind
        if highest[row] < 0.0:
            break
        inside, outside = cut(inside, planes[row, :3], float(planes[row, 3]))
        if not len(inside.segments):
            return [cell]
        if len(outside.segments):
            left.append(outside)
    return left


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


def _name(solid: Solid, cover: Cover, within: Array | None) -> str:
    sizes = [len(part) for part in cover.parts]
    digest = hashlib.sha256(repr((PROOF_VERSION, len(solid.faces), sizes, within is None)).encode())
    inner = np.empty(0) if within is None else within
    for numbers in (solid.vertices[solid.faces], inner, *cover.parts, np.array(cover.deviations)):
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
