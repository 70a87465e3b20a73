"""Nested closed components: which are turned inside out, and which are proper cavities.

Inside a component, the components around it add up: +1 for each that points outwards, -1 for each that points
inwards. In a sound solid the sum is never below 0. So an inward component within an outward one is a cavity; one
that lies free, or in a cavity already, is inside out. An outward one within another is solid in solid, which does
no harm.
"""

from dataclasses import dataclass

import numpy as np

from kabo.meshes.mesh import Faces, Vertices
from kabo.meshes.topology import Mask

_POINTS_PER_SHELL = 9
_PAIRS_PER_CHUNK = 4_000_000  # point-triangle pairs at a time


@dataclass(frozen=True)
class Shell:
    """A closed component: its number, faces (F, 3), signed volume [m3] and box (2, 3) [m]."""

    number: int
    faces: Faces
    volume: float
    box: Vertices


def shells(vertices: Vertices, faces: Faces, component: Faces, closed: Mask) -> list[Shell]:
    """The closed components that enclose anything; `closed` (C,) says which are."""
    order = np.argsort(component, kind="stable")
    starts = np.searchsorted(component[order], np.arange(len(closed) + 1))
    found = []
    for number in np.flatnonzero(closed):
        own = faces[order[starts[number] : starts[number + 1]]]
        corners = vertices[own]
        box = np.stack([corners.min(axis=(0, 1)), corners.max(axis=(0, 1))])
        corners = corners - box.mean(axis=0)
        volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0
        found.append(Shell(int(number), own, volume, box))
    return found


def inside_out(vertices: Vertices, found: list[Shell]) -> list[int]:
    """The numbers of the components whose orientation must be reversed, so that none is inside out."""
    signs = {shell.number: 1 if shell.volume > 0.0 else -1 for shell in found if shell.volume != 0.0}
    if all(sign > 0 for sign in signs.values()):
        return []
    around = _enclosing(vertices, found)
    turned: set[int] = set()
    for number in sorted(signs, key=lambda number: (len(around[number]), number)):  # from the outside inwards
        depth = sum(signs.get(outer, 0) for outer in around[number])
        if depth + signs[number] < 0:
            subtree = [number, *(inner for inner, outers in around.items() if number in outers)]
            turned ^= set(subtree)
            for member in subtree:
                signs[member] = -signs.get(member, 0)
    return sorted(turned)


def _enclosing(vertices: Vertices, found: list[Shell]) -> dict[int, list[int]]:
    """For each component the others that it lies in: those of larger boxes and volumes that wind around its points."""
    low, high = np.stack([shell.box[0] for shell in found]), np.stack([shell.box[1] for shell in found])
    sizes = np.abs([shell.volume for shell in found])
    around: dict[int, list[int]] = {}
    for index, inner in enumerate(found):
        wider = (low <= low[index]).all(axis=1) & (high >= high[index]).all(axis=1)
        wider &= (sizes >= sizes[index]) & (sizes > 0.0)
        wider[index] = False
        outers = [found[other] for other in np.flatnonzero(wider)]
        around[inner.number] = [outer.number for outer in outers if _winds_around(vertices, outer, inner)]
    return around


def _winds_around(vertices: Vertices, outer: Shell, inner: Shell) -> bool:
    """Whether most of nine sample points of the inner surface lie within the outer one."""
    chosen = np.unique(np.linspace(0, len(inner.faces) - 1, _POINTS_PER_SHELL).astype(np.int64))
    points = vertices[inner.faces[chosen]].mean(axis=1)
    within = np.abs(winding_number(points, vertices, outer.faces)) > 0.5
    return bool(2 * within.sum() > len(within))


def winding_number(points: Vertices, vertices: Vertices, faces: Faces) -> Vertices:
    """The winding number of a surface around each point (P, 3): solid angles over 4 pi [van Oosterom, Strackee 1983]."""
    result = np.zeros(len(points))
    step = max(1, _PAIRS_PER_CHUNK // max(1, len(faces)))
    for start in range(0, len(points), step):
        a, b, c = (vertices[faces[None, :, k]] - points[start : start + step, None] for k in range(3))
        la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
        volume = np.einsum("pfk,pfk->pf", a, np.cross(b, c))
        below = la * lb * lc + (
            np.einsum("pfk,pfk->pf", a, b) * lc
            + np.einsum("pfk,pfk->pf", b, c) * la
            + np.einsum("pfk,pfk->pf", c, a) * lb
        )
        result[start : start + step] = np.arctan2(volume, below).sum(axis=1) / (2.0 * np.pi)
    return result
