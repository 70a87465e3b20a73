"""Covers made from the hulls of CoACD [Wei 2022], for those who choose it: widened until they cover, or refused.

CoACD's hulls miss some of the solid and may stick out of it by any length. What they miss is given to the hulls that
grow least by it; then every hull is simplified and proven like any other part.
"""

import os
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from scipy.spatial import QhullError

from kabo.arrays import Array
from kabo.children import made_in_child
from kabo.errors import KaboError
from kabo.geometry.bounding.cells import whole
from kabo.geometry.bounding.containment import hull_of
from kabo.geometry.bounding.enclosing_union import Aims, Undecided, deviation
from kabo.geometry.bounding.simplification import enclosing_part
from kabo.geometry.bounding.stored_parts import Cover
from kabo.geometry.bounding.verified_parts import uncovered
from kabo.geometry.triangles.solids import Solid

PROCESSOR_SECONDS = 300  # allowed to CoACD
FINEST, COARSEST = 0.01, 1.0  # of CoACD's threshold, for a mesh scaled to [-1, 1]
GROWTH_ROUNDS = 4  # of giving what is missed to hulls


def coacd_cover(solid: Solid, aims: Aims, seed: int) -> Cover:
    """The cover of a shape's solid by hulls of CoACD, each proven within the tolerance.

    Raises:
        Undecided: CoACD ends without hulls, or hulls that cover the solid stick out too far.
    """
    longest = float(np.ptp(solid.vertices, axis=0).max())
    threshold = min(max(2.0 * aims.tolerance / longest, FINEST), COARSEST)
    hulls = _covering(solid, _hulls(solid, threshold=threshold, preprocess_mode="auto", seed=seed))
    parts = [enclosing_part(solid, points, aims.tolerance) for points in hulls]
    found = [part for part in parts if part is not None]
    if not found or len(found) < len(parts) or uncovered(whole(solid.vertices, solid.faces), found):
        raise Undecided
    ordered = sorted(found, key=lambda part: tuple(part.mean(axis=0)))
    return Cover(tuple(ordered), tuple(deviation(solid, part, aims.tolerance) for part in ordered), aims.tolerance)


def _covering(solid: Solid, hulls: Sequence[Array]) -> list[Array]:
    """The corners (V, 3) of hulls after each cell of the solid that they miss was given to the hull that grows least."""
    grown: list[Array] = []
    for corners in hulls:
        with suppress(QhullError):  # a flat one covers nothing
            grown.append(corners[hull_of(corners).vertices])
    for _ in range(GROWTH_ROUNDS):
        missed = uncovered(whole(solid.vertices, solid.faces), grown) if grown else []
        if not missed:
            break
        planes = [hull_of(each).equations for each in grown]
        given: dict[int, list[Array]] = {}
        for cell in missed:
            beyond = [float((cell.points @ own[:, :3].T + own[:, 3]).max()) for own in planes]
            given.setdefault(int(np.argmin(np.round(beyond, 9))), []).append(cell.points)
        for index, points in given.items():
            joined = np.vstack([grown[index], *points])
            grown[index] = joined[np.sort(hull_of(joined).vertices)]
    return grown


def _hulls(solid: Solid, **parameters: Any) -> list[Array]:
    """The corners (V, 3) of the hulls into which CoACD cuts a mesh; none if it crashes or takes too long.

    It runs in a process of its own: it may crash on unusual meshes, and its threads do not survive a fork.
    """
    try:
        return made_in_child(lambda: _by_coacd(solid, parameters))
    except KaboError:
        return []


def _by_coacd(solid: Solid, parameters: dict[str, Any]) -> list[Array]:
    with suppress(ImportError):  # a system without such limits
        import resource

        resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_SECONDS, PROCESSOR_SECONDS))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(2, 1)  # what the library says is no answer of a command
    import coacd

    coacd.set_log_level("off")
    mesh = coacd.Mesh(solid.vertices, solid.faces)
    return [np.asarray(hull[0], np.float64) for hull in coacd.run_coacd(mesh, **parameters)]
