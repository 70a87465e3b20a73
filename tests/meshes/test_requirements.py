"""What a mesh must be: every fault has its count in one sentence, with the remedy; sound ones pass."""

import numpy as np
import pytest

from kabo.errors import MeshError
from kabo.meshes import Mesh, examine, require_closed, require_solid, units_warning
from tests.meshes.solids import box, side, together, without

CUBE = box()
ROUND = np.vstack([CUBE.vertices, [[0.5, 0.5, 0.0]]])  # a vertex in the middle of an edge


def with_face(mesh: Mesh, *corners: int) -> Mesh:
    return Mesh(mesh.vertices, np.vstack([mesh.faces, [corners]]))


FAULTS = {
    "has 0 vertices and 0 triangles": Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64)),
    "2 of 8 vertices are not finite": Mesh(np.where(np.arange(8)[:, None] < 2, np.nan, CUBE.vertices), CUBE.faces),
    "1 of 13 triangles name a vertex that is not there": with_face(CUBE, 0, 1, 8),
    "vertices up to 5e\\+11 m": Mesh(CUBE.vertices * 1e12, CUBE.faces),
    "is a single triangle": Mesh(np.eye(3), np.array([[0, 1, 2]])),
    "is only 1e-12 m large": Mesh(CUBE.vertices * 1e-12, CUBE.faces),
    "1 triangle naming a vertex twice": with_face(CUBE, 0, 1, 1),
    "1 triangle without area": Mesh(ROUND * 0.5, np.vstack([CUBE.faces, [[6, 8, 7]]])),
    "1 triangle repeating another one and 3 edges of more than two": with_face(CUBE, *CUBE.faces[0]),
    "it has 3 open edges around 1 hole": without(CUBE, 0),
    "8 open edges around 2 holes": without(CUBE, *side(CUBE, 1, 1), *side(CUBE, 1, -1)),
    "1 edge of more than two triangles": together(box(), box(at=(1.0, 1.0, 0.0))),
    "1 vertex in which surfaces only touch": together(box(), box(at=(1.0, 1.0, 1.0))),
    "3 edges between triangles that are turned against each other": Mesh(
        CUBE.vertices, np.vstack([CUBE.faces[:1, ::-1], CUBE.faces[1:]])
    ),
    "1 component of 1 turned inside out": box(inverted=True),
    "1 component of 2 turned inside out": together(box(), box(at=(3.0, 0.0, 0.0), inverted=True)),
    "1 component of 3 turned inside out": together(box(), box(0.5, inverted=True), box(0.2, inverted=True)),
    "2 components of 2 turned inside out": together(box(inverted=True), box(0.5)),
}


@pytest.mark.parametrize("message", FAULTS)
def test_each_fault_has_its_count_in_one_sentence_with_a_remedy(message: str) -> None:
    with pytest.raises(MeshError, match=message) as caught:
        require_solid(FAULTS[message])
    (found,) = caught.value.diagnostics
    assert "\n" not in found.message and found.hint


@pytest.mark.parametrize(
    "mesh",
    [
        box(),
        together(box(), box(0.5, inverted=True)),
        together(box(), box(0.5)),
        together(box(), box(0.6, inverted=True), box(0.3)),
        together(box(), box(at=(0.4, 0.3, 0.2))),
        together(*(box(at=(2.0 * k, 0.0, 0.0)) for k in range(5))),
    ],
    ids=["cube", "cavity", "solid in solid", "solid in a cavity", "overlap", "five"],
)
def test_sound_solids_pass(mesh: Mesh) -> None:
    require_solid(mesh)
    require_closed(mesh)


def test_open_borders_may_be_kept_but_nothing_else() -> None:
    require_solid(without(CUBE, 0), borders="keep")
    require_solid(without(box(inverted=True), 0), borders="keep")  # what is open has no inside to be turned out
    with pytest.raises(MeshError, match="turned against"):
        require_solid(Mesh(CUBE.vertices, np.vstack([CUBE.faces[:1, ::-1], CUBE.faces[2:]])), borders="keep")


def test_closed_is_what_winding_numbers_need() -> None:
    require_closed(together(box(), box(at=(1.0, 1.0, 0.0))))
    require_closed(Mesh(CUBE.vertices[CUBE.faces].reshape(-1, 3), np.arange(36).reshape(-1, 3)))
    with pytest.raises(MeshError, match="not closed: 3 of its 18 edges"):
        require_closed(without(CUBE, 0))


def test_what_looks_like_millimetres_is_a_warning_with_the_fix() -> None:
    found = units_warning(box(120.0))
    assert found is not None and found.severity == "warning"
    assert "millimetres" in found.message and "0.001" in (found.hint or "")
    assert units_warning(box(2.0)) is None


def test_counts_do_not_depend_on_the_order_of_faces() -> None:
    mesh = without(together(box(), box(at=(1.0, 1.0, 0.0))), 3, 17)
    turned = Mesh(mesh.vertices, np.roll(mesh.faces[::-1], 1, axis=1))
    assert examine(mesh) == examine(turned)
