"""Meshes of a view document: each kept once, its vertices as 16-bit numbers within its bounding box."""

from typing import Any, Literal

import numpy as np

from kabo.meshes import Mesh
from kabo.viewer.content.arrays import Arrays

Detail = Literal["low", "original"]
LOW_FACES = 1200  # of one mesh with low detail, above which it is reduced
AGGRESSIVENESS = 4  # of the reduction: at 7, its default, the base of a tap became a spike
STEPS = 65535  # of a bounding box along each axis: 15 um of a metre


class Meshes:
    """The list `meshes` of a scene view, which grows as meshes are asked for."""

    def __init__(self, arrays: Arrays) -> None:
        self.listed: list[dict[str, Any]] = []
        self._arrays = arrays
        self._numbers: dict[str, int] = {}

    def shape(self, mesh: Mesh) -> dict[str, int]:
        """A shape that refers to a mesh."""
        if mesh.digest not in self._numbers:
            self._numbers[mesh.digest] = len(self.listed)
            self.listed.append(self._quantised(mesh))
        return {"mesh": self._numbers[mesh.digest]}

    def _quantised(self, mesh: Mesh) -> dict[str, Any]:
        low, high = mesh.bounds
        size = high - low
        step = np.where(size > 0.0, size / STEPS, 1.0)
        numbers = np.rint((mesh.vertices - low) / step).astype(np.uint16)
        kind = np.uint16 if len(mesh.vertices) <= STEPS else np.uint32
        return {
            "vertices": self._arrays.add(numbers),
            "faces": self._arrays.add(mesh.faces.astype(kind)),
            "low": low.tolist(),
            "step": step.tolist(),
        }


def reduced(mesh: Mesh, faces: int = LOW_FACES) -> Mesh:
    """A mesh with about so many faces that looks like another one, by quadric decimation; itself if it has no more."""
    if len(mesh.faces) <= faces:
        return mesh
    from fast_simplification import simplify  # a page of a scene without large meshes does not need it

    points, triangles = simplify(
        mesh.vertices, mesh.faces.astype(np.int32), target_count=faces, agg=AGGRESSIVENESS
    )
    return Mesh(np.ascontiguousarray(points, np.float64), np.ascontiguousarray(triangles, np.int64))
