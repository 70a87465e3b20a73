"""Trees of parts: children cover what their part covers of the body, whatever was refined before, and are near it."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from kabo.geometry import Enclosure, enclosing_parts
from kabo.geometry.bounding.decomposition import finer_tolerance
from kabo.meshes import Mesh
from kabo.meshes.nesting import winding_number

COARSE, FINE = 0.03, 0.004


def ring() -> Mesh:
    made = trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24)
    return Mesh(np.array(made.vertices, np.float64), np.array(made.faces, np.int64))


def inside(part: np.ndarray, points: np.ndarray, margin: float = 0.0) -> np.ndarray:
    planes = ConvexHull(part).equations
    return np.asarray((points @ planes[:, :3].T + planes[:, 3] <= margin).all(axis=1))


def children(made: Enclosure) -> dict[bytes, list[bytes]]:
    """The children of each part that has some, by content."""
    return {
        part.tobytes(): [made.parts[i].tobytes() for i in made.children_of(number)]
        for number, part in enumerate(made.parts)
        if made.children_of(number)
    }


def refined(made: Enclosure, order: int) -> Enclosure:
    """The enclosure after all open parts were refined, the first ones first or last."""
    while True:
        open_ones = [i for i in range(len(made.parts)) if not made.children_of(i) and made.deviation_of(i) > FINE]
        if not open_ones:
            return made
        assert made.finer is not None
        made = made.finer(open_ones[::order][0])


@pytest.fixture(scope="module")
def both(tmp_path_factory: pytest.TempPathFactory) -> tuple[Enclosure, Enclosure, Enclosure]:
    """The roots of a ring, and all parts refined in two orders."""
    folders = [tmp_path_factory.mktemp("cache") for _ in range(2)]
    roots = [enclosing_parts(ring(), FINE, cache=folder, coarse=COARSE) for folder in folders]
    return roots[0], refined(roots[0], 1), refined(roots[1], -1)


def test_coarse_roots_are_refined_to_the_tolerance(both: tuple[Enclosure, Enclosure, Enclosure]) -> None:
    roots, first, _ = both
    assert FINE < roots.deviation <= COARSE
    assert first.deviation <= FINE
    assert first.roots == len(roots.parts) < len(first.parts)


def test_children_are_the_same_in_every_order(both: tuple[Enclosure, Enclosure, Enclosure]) -> None:
    _, first, last = both
    assert children(first) == children(last)


def test_children_cover_what_their_part_covers_of_the_solid(both: tuple[Enclosure, Enclosure, Enclosure]) -> None:
    _, made, _ = both
    mesh = ring()
    rng = np.random.default_rng(0)
    points = rng.uniform(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0), (4000, 3))
    points = points[np.abs(winding_number(points, mesh.vertices, mesh.faces)) > 0.5]
    for i in range(len(made.parts)):
        own = points[inside(made.parts[i], points)]
        if made.children_of(i) and len(own):
            assert np.any([inside(made.parts[j], own) for j in made.children_of(i)], axis=0).all()
    assert np.any([inside(made.parts[i], points) for i in made.root_parts], axis=0).all()


def test_parts_are_as_near_as_they_claim(both: tuple[Enclosure, Enclosure, Enclosure]) -> None:
    _, made, _ = both
    mesh = ring()
    triangles = mesh.vertices[mesh.faces]
    rng = np.random.default_rng(1)
    for i, part in enumerate(made.parts):
        points = np.vstack([part, rng.dirichlet(np.full(len(part), 0.3), 60) @ part])
        points = points[np.abs(winding_number(points, mesh.vertices, mesh.faces)) < 0.5]
        pairs = np.repeat(triangles, len(points), axis=0), np.tile(points, (len(triangles), 1))
        away = np.linalg.norm(trimesh.triangles.closest_point(*pairs) - pairs[1], axis=1)
        nearest = away.reshape(len(triangles), len(points)).min(axis=0)
        assert not len(points) or nearest.max() <= made.deviation_of(i)


def test_a_tree_is_sent_to_another_process_and_refined_there(both: tuple[Enclosure, Enclosure, Enclosure]) -> None:
    roots, made, _ = both
    sent = pickle.loads(pickle.dumps(roots))  # noqa: S301 - our own bytes
    assert sent.finer is not None
    assert children(sent.finer(0)).items() <= children(made).items()


def test_a_damaged_file_of_children_is_made_again(tmp_path: Path) -> None:
    roots = enclosing_parts(ring(), FINE, cache=tmp_path, coarse=COARSE)
    assert roots.finer is not None
    before = set(tmp_path.iterdir())
    first = roots.finer(0)
    (kept,) = set(tmp_path.iterdir()) - before
    whole = kept.read_bytes()
    kept.write_bytes(whole[:-8])
    assert children(roots.finer(0)) == children(first)
    assert kept.read_bytes() == whole


@pytest.mark.parametrize(
    ("tolerance", "finest", "expected"), [(0.016, 0.004, 0.004), (0.016, 0.001, 0.004), (0.004, 0.003, 0.003)]
)
def test_levels_are_powers_of_four_above_the_finest(tolerance: float, finest: float, expected: float) -> None:
    assert finer_tolerance(tolerance, finest) == pytest.approx(expected)
