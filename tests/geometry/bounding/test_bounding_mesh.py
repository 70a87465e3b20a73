"""Bounding meshes of known shapes: what becomes of them is known, and every promise is judged by exact arithmetic."""

import hashlib
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from kabo.errors import MeshError
from kabo.geometry import bounding_mesh, hausdorff_bound
from kabo.geometry.bounding.bounding_mesh import COSTS
from kabo.meshes import Mesh
from tests.geometry.surfaces import distances_to_surface
from tests.support import oracles_meshes as oracles
from tests.support.shapes import joined

SIDES = ("outer", "inner")
TINY = pytest.mark.xfail(
    reason="at a millionth of the size flat faces are not all proven within the budget",
    raises=AssertionError,
    strict=False,
)


OCTAHEDRON = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


def mesh_of(made):
    return Mesh(np.array(made.vertices, np.float64), np.array(made.faces, np.int64))


def ball(subdivisions=2, radius=1.0, at=(0.0, 0.0, 0.0)):
    made = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return Mesh(np.array(made.vertices) + np.array(at), np.array(made.faces, np.int64))


def cube(extents=(1.0, 1.0, 1.0), times=2):
    """A box, every face cut into 4^times triangles."""
    made = trimesh.creation.box(extents=extents)
    for _ in range(times):
        made = made.subdivide()
    return mesh_of(made)


def together(*meshes):
    return Mesh(*joined(*((mesh.vertices, mesh.faces) for mesh in meshes)))


def diagonal(mesh):
    return float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))


def volume(mesh):
    corners = mesh.vertices[mesh.faces] - mesh.vertices.mean(axis=0)
    return float(np.linalg.det(corners).sum() / 6.0)


def contains(outer, inner, most=40):
    """Whether the outer mesh winds around, or touches, every vertex of the inner one, exactly."""
    vertices = inner.vertices[:: max(1, len(inner.vertices) // most)]
    return all(oracles.winding_number(vertex, outer.vertices, outer.faces) != 0 for vertex in vertices)


def farthest(first, second, most=120):
    """The greatest distance of corners and middles of either mesh from the other [m]."""
    found = 0.0
    for one, other in ((first, second), (second, first)):
        points = np.concatenate([one.vertices, one.vertices[one.faces].mean(axis=1)])
        points = points[:: max(1, len(points) // most)]
        found = max(found, distances_to_surface(points, other.vertices, other.faces).max())
    return found


def require_promises(mesh, made):
    """All that is promised with `certify`."""
    assert oracles.lonely_edges(made.faces) == 0
    inner, outer = (mesh, made) if made.side == "outer" else (made, mesh)
    assert contains(outer, inner)
    assert farthest(mesh, made) <= made.hausdorff_upper_bound + 1e-12 * diagonal(mesh)
    assert made.hausdorff_upper_bound <= made.epsilon
    before = oracles.crossing_pairs(mesh.vertices, mesh.faces)
    assert oracles.crossing_pairs(made.vertices, made.faces) <= before
    assert oracles.crossing_faces(made.vertices, made.faces) <= oracles.crossing_faces(mesh.vertices, mesh.faces)
    assert made.one_sided and made.contractions == len(mesh.vertices) - len(made.vertices)


@pytest.mark.slow
@pytest.mark.parametrize("side", SIDES)
def test_a_tetrahedron_cannot_become_less(side):
    mesh = Mesh(np.eye(4, 3), np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    mesh = mesh if volume(mesh) > 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])
    made = bounding_mesh(mesh, 10.0, side)
    assert np.array_equal(made.vertices, mesh.vertices) and len(made.faces) == 4
    assert made.contractions == 0 and made.hausdorff_upper_bound < 1e-12
    require_promises(mesh, made)


@pytest.mark.parametrize("side", SIDES)
def test_an_octahedron_stays_valid_at_any_epsilon(side):
    mesh = Mesh(np.concatenate([np.eye(3), -np.eye(3)]), OCTAHEDRON)
    for epsilon in (1e-6, 0.3, 50.0):
        require_promises(mesh, bounding_mesh(mesh, epsilon, side))


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("epsilon", [0.02, pytest.param(1e-6, marks=TINY)])
def test_a_cube_of_many_faces_becomes_its_eight_corners(side, epsilon):
    mesh = cube()
    made = bounding_mesh(mesh, epsilon, side)
    assert len(made.vertices) == 8 and len(made.faces) == 12
    assert np.abs(np.abs(made.vertices) - 0.5).max() < max(1e-9, 0.01 * epsilon)
    require_promises(mesh, made)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("epsilon", [0.05, 0.2])
def test_a_ball_is_bounded_within_epsilon(side, epsilon):
    mesh = ball(2)
    made = bounding_mesh(mesh, epsilon, side)
    require_promises(mesh, made)
    assert len(made.vertices) < (0.7 if epsilon < 0.1 else 0.3) * len(mesh.vertices)
    assert (volume(made) > volume(mesh)) == (side == "outer")


@pytest.mark.slow
@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("cost", COSTS)
def test_every_cost_function_keeps_every_promise(cost, side):
    for mesh in (ball(), mesh_of(trimesh.creation.torus(1.0, 0.4, 20, 10))):
        made = bounding_mesh(mesh, 0.05, side, cost=cost)
        require_promises(mesh, made)
        assert len(made.vertices) < len(mesh.vertices)


@pytest.mark.parametrize("mesh", [ball(), mesh_of(trimesh.creation.capsule(1.0, 0.4, count=(10, 10)))])
def test_distances_to_triangles_keep_a_convex_mesh_nearly_convex(mesh):
    """[K A.2] says convex, by a sketch of a proof; dents stay below half of epsilon."""
    made = bounding_mesh(mesh, 0.05, cost="triangles")
    corners = made.vertices[made.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    above = np.einsum("fk,fvk->fv", normals, made.vertices[None] - corners[:, :1])
    assert made.contractions > 0 and above.max() < 0.5 * made.epsilon


@pytest.mark.parametrize("target", [4, 60, 161, 162, 500])
def test_contraction_stops_at_the_number_of_vertices(target):
    mesh = ball()  # 162 vertices
    made = bounding_mesh(mesh, 0.5, vertices=target)
    assert min(target, 162) <= len(made.vertices) <= 162
    assert len(made.vertices) == min(target, 162) or target == 4
    require_promises(mesh, made)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("cost", ["memoryless", "planes"])
def test_the_bound_without_certificate_is_proven_all_the_same(side, cost):
    for mesh in (ball(), cube((1.0, 1.0, 0.02))):
        made = bounding_mesh(mesh, 0.1, side, certify=False, cost=cost)
        assert oracles.lonely_edges(made.faces) == 0
        assert farthest(mesh, made) <= made.hausdorff_upper_bound
        low, _ = hausdorff_bound(mesh.vertices, mesh.faces, made.vertices, made.faces)
        assert low <= made.hausdorff_upper_bound <= 1.02 * low + 1e-3 * diagonal(mesh)
        assert contains(made, mesh) if side == "outer" else True


def bowl():
    """Half a ball, open at the top."""
    whole = ball(3)
    keep = whole.vertices[whole.faces].mean(axis=1)[:, 2] < 0.2
    used, faces = np.unique(whole.faces[keep], return_inverse=True)
    return Mesh(whole.vertices[used], faces.reshape(-1, 3))


def border(mesh):
    """The edges with one face only, by the coordinates of their ends, in the face's direction."""
    edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    directed = {tuple(edge) for edge in edges.tolist()}
    return {
        (mesh.vertices[a].tobytes(), mesh.vertices[b].tobytes()) for a, b in directed if (b, a) not in directed
    }


@pytest.mark.parametrize("side", SIDES)
def test_borders_that_are_kept_stay_bit_by_bit(side):
    mesh = bowl()
    made = bounding_mesh(mesh, 0.1, side, borders="keep")
    assert made.contractions > 50
    assert len(border(mesh)) > 20 and border(made) == border(mesh)
    assert farthest(mesh, made) <= made.hausdorff_upper_bound <= 0.1


def digest(made):
    return hashlib.sha256(made.vertices.tobytes() + made.faces.tobytes()).hexdigest()


PROGRAM = """
import hashlib, trimesh, numpy as np
from kabo.geometry import bounding_mesh
from kabo.meshes import Mesh
ball = trimesh.creation.icosphere(subdivisions=2, radius=1.0)
made = bounding_mesh(Mesh(np.array(ball.vertices), np.array(ball.faces, np.int64)), 0.05)
print(hashlib.sha256(made.vertices.tobytes() + made.faces.tobytes()).hexdigest())
"""


def test_the_same_mesh_gives_the_same_bytes_in_every_process():
    first, second = (bounding_mesh(ball(), 0.05) for _ in range(2))
    assert digest(first) == digest(second)
    other = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert other.stdout.strip() == digest(first)


def test_what_is_given_stays_as_it_was():
    mesh = ball()
    before = mesh.vertices.copy(), mesh.faces.copy()
    bounding_mesh(mesh, 0.05)
    bounding_mesh(mesh, 0.05, "inner")
    assert np.array_equal(mesh.vertices, before[0]) and np.array_equal(mesh.faces, before[1])


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("scale", "offset"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1000.0), (0.05, 1000.0)])
def test_scale_and_place_change_nothing_that_matters(side, scale, offset):
    here = bounding_mesh(ball(), 0.05, side)
    moved = Mesh(ball().vertices * scale + offset, ball().faces)
    made = bounding_mesh(moved, 0.05 * scale, side)
    require_promises(moved, made)
    assert len(made.vertices) == pytest.approx(len(here.vertices), rel=0.2)


@pytest.mark.parametrize("side", SIDES)
def test_components_are_bounded_together(side):
    """Three apart, one of them hollow; and the gap between two is less than epsilon."""
    cavity = ball(1, 0.4, (2.0, 0.0, 0.0))
    mesh = together(ball(2), ball(2, 0.97, (2.0, 0.0, 0.0)), Mesh(cavity.vertices, cavity.faces[:, ::-1]))
    made = bounding_mesh(mesh, 0.05, side)
    require_promises(mesh, made)
    assert oracles.crossing_pairs(made.vertices, made.faces) == 0
    assert made.contractions > 100


@pytest.mark.parametrize("side", SIDES)
def test_components_that_cross_go_on_crossing_and_no_more(side):
    mesh = together(cube(times=1), Mesh(cube(times=1).vertices * 0.9 + [0.41, 0.33, 0.27], cube(times=1).faces))
    before = oracles.crossing_pairs(mesh.vertices, mesh.faces)
    made = bounding_mesh(mesh, 0.02, side)
    assert before > 0 and made.contractions > 0
    require_promises(mesh, made)
    assert oracles.crossing_pairs(made.vertices, made.faces) > 0


# A flat lid whose middle is folded over itself, as on a robot's link [0.1 micrometres]; the last vertex is below all.
FOLD = [(-19246, -549741, 5001), (-14898, -522836, 5000), (-13512, -521070, 5002), (-1962, -519902, 5000)]
FOLD += [(-1842, -519747, 6484), (-1501, -519621, 5000), (-168, -518191, 5001), (0, -504981, 5000)]
FOLD += [(9724, -549953, 5000), (35113, -548939, 5000), (0, -300000, 200000)]
LID = [
    (6, 9, 8),
    (7, 9, 6),
    (5, 2, 7),
    (5, 7, 6),
    (2, 3, 1),
    (3, 0, 1),
    (3, 8, 0),
    (6, 8, 3),
    (4, 3, 2),
    (4, 6, 3),
]
LID += [(6, 4, 5), (4, 2, 5)]
RIM = [(1, 2), (0, 1), (2, 7), (8, 0), (9, 8), (7, 9)]


@pytest.mark.parametrize("epsilon", [5e-4, 2e-3])
def test_a_fold_smaller_than_epsilon_crosses_with_fewer_faces(epsilon):
    """What is crossed may change, as long as there are not more crossings: no single face stands in the way."""
    mesh = Mesh(1e-7 * np.array(FOLD, np.float64), np.array(LID + [(b, a, 10) for a, b in RIM]))
    before = oracles.crossing_faces(mesh.vertices, mesh.faces)
    made = bounding_mesh(mesh, epsilon)
    assert before == 4 and volume(mesh) > 0.0
    assert oracles.crossing_faces(made.vertices, made.faces) < before
    require_promises(mesh, made)
    with pytest.raises(MeshError, match="crosses itself: 4 of the 18 triangles"):
        bounding_mesh(mesh, epsilon, "inner")


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("thickness", [1e-2, 1e-5])
def test_a_plate_thinner_than_epsilon_keeps_both_its_sides(side, thickness):
    mesh = cube((1.0, 0.7, thickness))
    made = bounding_mesh(mesh, 0.1, side)
    require_promises(mesh, made)
    assert oracles.crossing_pairs(made.vertices, made.faces) == 0
    assert volume(made) > 0.0


def test_a_high_apex_is_no_hang():
    mesh = mesh_of(trimesh.creation.cone(radius=1.0, height=1.0, sections=80))
    for side in SIDES:
        made = bounding_mesh(mesh, 0.02, side)
        require_promises(mesh, made)
        assert len(made.vertices) < 60


def broken(vertices=None, faces=None):
    mesh = ball(1)
    return Mesh(mesh.vertices if vertices is None else vertices, mesh.faces if faces is None else faces)


def not_a_number():
    vertices = ball(1).vertices.copy()
    vertices[3, 1] = np.nan
    return broken(vertices)


def with_face(*corners):
    return broken(faces=np.concatenate([ball(1).faces, [corners]]))


FAULTS = {
    "open": (broken(faces=ball(1).faces[1:]), "open edge"),
    "more than two at an edge": (with_face(*ball(1).faces[0]), "triangle repeating another"),
    "not a number": (not_a_number(), "not finite"),
    "no such vertex": (with_face(0, 1, 99), "not there"),
    "negative index": (with_face(0, 1, -1), "not there"),
    "repeated index": (with_face(0, 1, 1), "naming a vertex twice"),
    "single triangle": (Mesh(np.eye(3), np.array([[0, 1, 2]])), "single triangle"),
    "inside out": (broken(faces=ball(1).faces[:, ::-1]), "inside out"),
    "one face turned": (
        broken(faces=np.concatenate([ball(1).faces[:1, ::-1], ball(1).faces[1:]])),
        "turned against each other",
    ),
    "empty": (Mesh(np.empty((0, 3)), np.empty((0, 3), np.int64)), "0 triangles"),
}


@pytest.mark.parametrize("borders", ["refuse", "keep"])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_mesh_that_cannot_be_used_is_refused_in_one_sentence(fault, borders):
    mesh, words = FAULTS[fault]
    if fault == "open" and borders == "keep":
        assert bounding_mesh(mesh, 0.1, borders=borders).contractions >= 0
        return
    with pytest.raises(MeshError, match=words) as caught:
        bounding_mesh(mesh, 0.1, borders=borders)
    (found,) = caught.value.diagnostics
    assert "\n" not in found.message and found.hint


@pytest.mark.parametrize("epsilon", [0.0, -1.0, np.nan, np.inf])
def test_an_epsilon_that_is_no_distance_is_refused(epsilon):
    with pytest.raises(ValueError, match="epsilon"):
        bounding_mesh(ball(1), epsilon)


@pytest.mark.parametrize("option", [{"side": "both"}, {"side": ""}, {"cost": "volume"}])
def test_an_unknown_option_is_refused_by_its_name(option):
    with pytest.raises(ValueError, match=next(iter(option))):
        bounding_mesh(ball(1), 0.1, **option)


def test_an_epsilon_below_rounding_is_refused_far_from_the_origin():
    far = Mesh(ball(1).vertices + 1e5, ball(1).faces)
    with pytest.raises(ValueError, match="rounding"):
        bounding_mesh(far, 1e-9)
    require_promises(far, bounding_mesh(far, 0.1))


def test_a_mesh_beyond_the_earth_is_refused():
    with pytest.raises(MeshError, match="from the origin"):
        bounding_mesh(Mesh(ball(1).vertices + 1e9, ball(1).faces), 0.1)
