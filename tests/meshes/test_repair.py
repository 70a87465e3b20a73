"""Repairs: each is safe, is told, and leads to a solid of the right volume; what needs a guess is left alone."""

import numpy as np
import pytest

from kabo.errors import MeshError
from kabo.meshes import Mesh, load_mesh, repaired, require_solid, write_off
from tests.meshes.solids import box, side, together, volume, without

CUBE = box()


def split_vertices(mesh: Mesh, by: float) -> Mesh:
    """Every face with vertices of its own, each moved a little."""
    shift = by * (np.arange(len(mesh.faces) * 3) % 7 - 3).reshape(-1, 1) / 6.0
    vertices = mesh.vertices[mesh.faces].reshape(-1, 3) + shift
    return Mesh(vertices, np.arange(len(vertices)).reshape(-1, 3))


def with_midpoint(mesh: Mesh) -> Mesh:
    """A face with a corner in the middle of its long side, which makes the face beside it one without area."""
    a, b, c = mesh.faces[0]
    sides = [(a, b, c), (b, c, a), (c, a, b)]
    start, end, tip = max(
        sides, key=lambda side: float(np.linalg.norm(mesh.vertices[side[0]] - mesh.vertices[side[1]]))
    )
    middle = (mesh.vertices[start] + mesh.vertices[end]) / 2.0
    new = len(mesh.vertices)
    faces = [(start, new, tip), (new, end, tip), (start, end, new)]
    return Mesh(np.vstack([mesh.vertices, middle]), np.vstack([faces, mesh.faces[1:]]))


CASES = {
    "welded 28 vertices": (split_vertices(CUBE, 1e-8), 1.0),
    "dropped 1 vertex of no triangle": (Mesh(np.vstack([CUBE.vertices, [[0.0, 0.0, 0.0]]]), CUBE.faces), 1.0),
    "dropped 1 triangle with fewer": (Mesh(CUBE.vertices, np.vstack([CUBE.faces, [[0, 1, 1]]])), 1.0),
    "dropped 2 triangles that repeated": (
        Mesh(CUBE.vertices, np.vstack([CUBE.faces, CUBE.faces[:2, [1, 2, 0]]])),
        1.0,
    ),
    "flipped away 1 triangle": (with_midpoint(CUBE), 1.0),
    "turned 2 triangles the way": (Mesh(CUBE.vertices, np.vstack([CUBE.faces[:2, ::-1], CUBE.faces[2:]])), 1.0),
    "filled 1 hole with 1 triangle": (without(CUBE, 0), 1.0),
    "filled 2 holes with 2": (without(CUBE, side(CUBE, 0, 1)[0], side(CUBE, 0, -1)[0]), 1.0),
    "only touched, in 2 vertices": (together(box(), box(at=(1.0, 1.0, 0.0))), 2.0),
    "only touched, in 1 vertex": (together(box(), box(at=(1.0, 1.0, 1.0))), 2.0),
    "only touched, in 4 vertices": (together(box(), box(at=(1.0, 0.0, 0.0))), 2.0),
    "turned 1 component that was": (box(inverted=True), 1.0),
    "turned 2 components that were": (together(box(inverted=True), box(0.5)), 0.875),
}


@pytest.mark.parametrize("said", CASES)
def test_a_repair_is_told_and_leads_to_a_solid(said: str) -> None:
    mesh, expected = CASES[said]
    made, done = repaired(mesh)
    assert len(done) == 1 and said in done[0], done
    require_solid(made)
    assert volume(made) == pytest.approx(expected, abs=1e-6)
    again, nothing = repaired(made)
    assert nothing == [] or said.startswith("only touched")
    assert volume(again) == pytest.approx(expected, abs=1e-6)


def test_a_sound_mesh_is_returned_as_it_is() -> None:
    mesh = together(box(), box(0.5, inverted=True))
    made, done = repaired(mesh)
    assert made is mesh and done == []


def test_no_vertex_moves_farther_than_the_tolerance() -> None:
    chain = np.linspace(0.0, 1.0, 20)[:, None] * np.array([1.0, 0.0, 0.0]) * 1e-6
    mesh = Mesh(np.vstack([CUBE.vertices, chain]), np.vstack([CUBE.faces, [[0, 8 + k, 9 + k] for k in range(19)]]))
    made, _ = repaired(mesh)
    for point in mesh.vertices:
        assert np.linalg.norm(made.vertices - point, axis=1).min() <= 1e-7 * mesh.diagonal
    points = np.unique(made.vertices, axis=0)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    assert apart[~np.eye(len(apart), dtype=bool)].min() > 1e-7 * mesh.diagonal


@pytest.mark.parametrize(
    ("mesh", "left"),
    [
        (without(CUBE, *side(CUBE, 2, 1)), "4 open edges around 1 hole"),
        (Mesh(np.eye(3), np.array([[0, 1, 2]])), "single triangle"),
        (without(CUBE, *side(CUBE, 2, 1), *side(CUBE, 2, -1)), "8 open edges around 2 holes"),
        (Mesh(CUBE.vertices, CUBE.faces[list(side(CUBE, 0, 1))]), "4 open edges around 1 hole"),
    ],
    ids=["a whole side", "a single triangle", "a tube", "a flat pair"],
)
def test_what_needs_a_guess_is_refused(mesh: Mesh, left: str) -> None:
    made, _ = repaired(mesh)
    with pytest.raises(MeshError, match=left):
        require_solid(made, repair=True)


def test_a_surface_with_one_side_is_left_alone() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    rails = []
    for offset in (-0.2, 0.2):
        out = 1.0 + offset * np.cos(angles / 2)
        rails.append(np.c_[out * np.cos(angles), out * np.sin(angles), offset * np.sin(angles / 2)])
    faces = []
    for k in range(12):
        a, b = k, 12 + k
        c, d = (k + 1, 13 + k) if k < 11 else (12, 0)  # the ends meet half a turn later
        faces += [(a, c, b), (c, d, b)]
    made, _ = repaired(Mesh(np.vstack(rails), np.array(faces)))
    with pytest.raises(MeshError, match="open edges"):
        require_solid(made, repair=True)


def test_loading_can_repair(tmp_path) -> None:
    path = tmp_path / "open.off"
    broken = without(CUBE, 0)
    write_off(path, broken.vertices, broken.faces)
    require_solid(load_mesh(path, repair=True))
    with pytest.raises(MeshError):
        require_solid(load_mesh(path))
