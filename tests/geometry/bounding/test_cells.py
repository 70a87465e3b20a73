"""Cells of solids: the hull of a cell contains what the solid has in it, also where components overlap."""

import numpy as np
import pytest

from kabo.arrays import Array
from kabo.geometry.bounding.cells import cut, whole
from kabo.geometry.bounding.containment import hull_of


def _box(low: Array, high: Array) -> tuple[Array, Array]:
    """The corners (8, 3) and outward faces (12, 3) of a box."""
    corners = np.array([[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)])
    hull = hull_of(corners)
    a, b, c = corners[hull.simplices].transpose(1, 0, 2)
    outwards = (np.cross(b - a, c - a) * hull.equations[:, :3]).sum(axis=1) > 0.0
    return corners, np.where(outwards[:, None], hull.simplices, hull.simplices[:, ::-1]).astype(np.int64)


@pytest.mark.parametrize("overlap", ["crossed", "nested"])
def test_a_cell_holds_what_overlapping_boxes_have_in_it(overlap: str) -> None:
    boxes = [(np.zeros(3), np.ones(3)), (np.array([0.4, -0.3, -0.2]), np.array([1.6, 1.2, 1.3]))]
    if overlap == "nested":
        boxes[1] = (np.full(3, 0.3), np.full(3, 0.7))
    (corners, faces), (others, other_faces) = (_box(*box) for box in boxes)
    vertices, all_faces = np.vstack([corners, others]), np.vstack([faces, other_faces + 8])
    rng, held = np.random.default_rng(0), 0
    for _ in range(40):
        cell, normals = whole(vertices, all_faces), rng.normal(size=(4, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        offsets = normals @ rng.uniform(0.4, 0.8, 3) + 0.02
        for normal, offset in zip(normals, offsets, strict=True):
            cell = cut(cell, normal, float(offset))[0]
        points = rng.uniform(-0.4, 1.7, (4000, 3))
        within = np.logical_or.reduce([((points >= low) & (points <= high)).all(axis=1) for low, high in boxes])
        points = points[within & (points @ normals.T <= offsets).all(axis=1)]
        if not len(points):
            continue
        planes = hull_of(cell.points).equations
        assert (points @ planes[:, :3].T + planes[:, 3]).max() <= 1e-9
        held += len(points)
    assert held > 1000
