"""Of a mesh that is not closed, closed pieces that are far from convex are told from the rest; nothing is lost."""

import numpy as np
import trimesh

from kabo.meshes import Mesh, examine, hollow_pieces, hull_of
from tests.meshes.solids import box, together, volume, without

CASES = 40


def frame(width: float = 1.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A flat ring with a wide hole, closed."""
    ring = trimesh.creation.annulus(r_min=0.42 * width, r_max=0.5 * width, height=0.1 * width)
    return Mesh(np.array(ring.vertices) + np.array(at), np.array(ring.faces, np.int64))


def places(*meshes: Mesh) -> list[tuple[float, ...]]:
    """The corners of all triangles, sorted."""
    corners = [mesh.vertices[mesh.faces].reshape(-1, 9) for mesh in meshes]
    return sorted(map(tuple, np.concatenate(corners).round(9).tolist()))


def test_a_frame_beside_an_open_housing_is_kept_and_the_hull_is_that_of_the_housing():
    housing = without(box(0.3, (0.0, 0.0, 0.5)), 0)
    kept, rest = hollow_pieces(together(housing, frame()))
    assert rest is not None and places(rest) == places(housing)
    assert len(kept) == 1 and places(*kept) == places(frame())
    assert volume(hull_of(rest)) == np.float64(volume(hull_of(housing)))


def test_what_gains_nothing_is_left_in_the_hull():
    housing = without(box(2.0), 0)
    for inner in (frame(0.5), box(0.4, (0.0, 0.0, 3.0)), frame(0.1, (1.2, 0.0, 0.0))):
        mesh = together(housing, inner)  # within the housing; convex; too small to matter
        assert hollow_pieces(mesh) == ([], mesh)


def test_a_triangle_that_is_only_a_line_may_lie_between_pieces_and_so_all_are_within_one_hull():
    mesh = together(without(box(0.3, (0.0, 0.0, 0.5)), 0), frame())
    line = Mesh(mesh.vertices, np.vstack([mesh.faces, [[0, 0, len(mesh.vertices) - 1]]]))
    assert len(hollow_pieces(mesh)[0]) == 1 and hollow_pieces(line) == ([], line)


def test_a_frame_that_is_inside_out_is_no_solid():
    ring = frame()
    turned = Mesh(ring.vertices, ring.faces[:, ::-1])
    mesh = together(without(box(0.3, (0.0, 0.0, 0.5)), 0), turned)
    assert hollow_pieces(mesh) == ([], mesh)


def test_every_triangle_is_in_one_of_the_pieces_and_those_that_are_kept_are_closed():
    some = 0
    for seed in range(CASES):
        rng = np.random.default_rng(seed)
        pieces = [without(box(rng.uniform(0.1, 0.6), tuple(rng.uniform(-2, 2, 3))), int(rng.integers(12)))]
        for _ in range(rng.integers(0, 4)):
            at = tuple(rng.uniform(-2, 2, 3))
            pieces.append(
                frame(rng.uniform(0.2, 2.0), at) if rng.random() < 0.7 else box(rng.uniform(0.1, 0.5), at)
            )
        mesh = together(*pieces)
        kept, rest = hollow_pieces(mesh)
        assert rest is not None and places(*kept, rest) == places(mesh)
        assert all(examine(each).is_closed and volume(each) > 0.0 for each in kept)
        some += bool(kept)
    assert CASES // 4 < some < CASES
