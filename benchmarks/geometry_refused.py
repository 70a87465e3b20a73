"""Meshes that cannot be used: the sentence that is said of each; a result would have to be one-sided."""

from itertools import groupby
from typing import Any

import numpy as np
from geometry_bounding import Triangles
from geometry_growth import sphere
from table import Table

from kabo.errors import KaboError
from kabo.geometry import bounding_mesh


def bad_meshes() -> dict[str, Triangles]:
    """One mesh for each thing that can be wrong."""
    good = sphere(2)
    vertices, faces = good.vertices, good.faces

    def moved(value: float) -> Any:
        wrong = vertices.copy()
        wrong[7, 1] = value
        return wrong

    def with_face(number: int, *corners: int) -> Any:
        wrong = faces.copy()
        wrong[number] = corners
        return wrong

    first = faces[0].tolist()
    wing = np.concatenate([vertices, vertices[:1] * 3.0])
    return {
        "open: a face missing": Triangles(vertices, faces[1:]),
        "open: half a sphere": Triangles(vertices, faces[vertices[faces].mean(axis=1)[:, 2] > 0]),
        "non-manifold: a wing on an edge": Triangles(
            wing, np.concatenate([faces, [[first[0], first[1], len(vertices)]]])
        ),
        "two faces the same": Triangles(vertices, np.concatenate([faces, faces[:1]])),
        "one face turned": Triangles(vertices, with_face(0, *first[::-1])),
        "inside out": Triangles(vertices, faces[:, ::-1].copy()),
        "NaN": Triangles(moved(np.nan), faces),
        "infinite": Triangles(moved(np.inf), faces),
        "index out of range": Triangles(vertices, with_face(0, first[0], first[1], len(vertices))),
        "negative index": Triangles(vertices, with_face(0, first[0], first[1], -1)),
        "repeated index": Triangles(vertices, with_face(0, first[0], first[1], first[1])),
        "a single triangle": Triangles(vertices[first], np.array([[0, 1, 2]])),
        "a triangle and its back": Triangles(vertices[first], np.array([[0, 1, 2], [0, 2, 1]])),
        "no faces": Triangles(vertices, faces[:0]),
        "nothing": Triangles(vertices[:0], faces[:0]),
    }


def bad_table() -> Table:
    """What is said of each mesh; `a result` is a defect, except where a mesh is sound after all."""
    table = Table("Meshes that cannot be used")
    for name, mesh in bad_meshes().items():
        for outcome, sides in groupby(("outer", "inner"), key=lambda side, mesh=mesh: _answer(mesh, side)):
            table.add(name, side=" and ".join(sides), outcome=outcome[0], said=outcome[1])
    return table


def _answer(mesh: Triangles, side: Any) -> tuple[str, str]:
    try:
        made = bounding_mesh(mesh, 0.01, side)
    except (KaboError, ValueError) as refusal:
        return type(refusal).__name__, " ".join(str(refusal).split())
    return "A RESULT", f"{len(made.vertices)} vertices"
