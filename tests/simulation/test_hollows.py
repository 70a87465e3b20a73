"""Convex parts that do not bridge hollows into which others are put, beside rings whose bore is known."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

import kabo
from kabo.arrays import Array
from kabo.simulation import hollows
from kabo.simulation.contact_shapes import contact_shapes
from kabo.simulation.hollows import BRIDGED, WIDTH, Hollows, unbridged

DOMAINS = Path(__file__).parents[2] / "domains"
BORE, OUTER, HEIGHT = 0.018, 0.035, 0.024
SEAT, SEAT_RADIUS = 0.09, 0.0352  # [m] of the pipe


def ring(bore: float = BORE) -> kabo.Mesh:
    made = trimesh.creation.annulus(bore, OUTER, HEIGHT, sections=48)
    return kabo.Mesh(np.asarray(made.vertices), np.asarray(made.faces))


def inside(parts: list[Array], points: Array) -> Array:
    """Whether each point is in a part."""
    hulls = [ConvexHull(part).equations for part in parts]
    return np.any([(points @ h[:, :3].T + h[:, 3]).max(axis=1) < -1e-9 for h in hulls], axis=0)


def on_cylinder(radius: float, heights: Array) -> Array:
    turns = np.linspace(0.0, 2.0 * np.pi, 181)
    return np.array([[radius * np.cos(a), radius * np.sin(a), z] for a in turns for z in heights])


def test_a_ring_of_one_part_becomes_parts_that_leave_its_bore_free() -> None:
    mesh = ring()
    box = trimesh.creation.box((0.072, 0.072, 0.026)).vertices
    parts = unbridged(mesh, [np.asarray(box, float)])
    inscribed = BORE * np.cos(np.pi / 48) - 2.0 * BRIDGED  # of the polygon that stands for the circle
    heights = np.linspace(-0.5 * HEIGHT, 0.5 * HEIGHT, 13)
    assert not inside(parts, on_cylinder(inscribed, heights)).any()
    assert inside(parts, on_cylinder(0.5 * (BORE + OUTER), heights[1:-1])).mean() > 0.5  # the ring itself is there
    assert len(parts) <= 80  # 48 wedges would be enough, as bore and rim are polygons of 48 corners
    hull = ConvexHull(np.concatenate(parts))
    assert np.isclose(hull.volume, ConvexHull(mesh.vertices).volume, rtol=1e-6)


def test_a_bore_that_is_too_narrow_for_what_counts_is_left_alone() -> None:
    assert len(Hollows(ring()).notches.points) > 100
    assert len(Hollows(ring(0.5 * WIDTH)).notches.points) == 0


@pytest.mark.slow
def test_the_bearing_of_the_gearbox_fits_its_journal_in_physics() -> None:
    shapes = contact_shapes(kabo.load_scene(DOMAINS / "assembly" / "gearbox.yaml"), "o1")
    parts = [shape.corners for shape in shapes if shape.corners is not None]
    heights = np.linspace(0.003, 0.021, 7)
    assert not inside(parts, on_cylinder(BORE - 0.0002 - 1e-5, heights)).any()
    assert len(parts) < 400


@pytest.mark.slow
def test_the_pipe_of_the_gearbox_leaves_its_seat_free_down_to_the_corner() -> None:
    shapes = contact_shapes(kabo.load_scene(DOMAINS / "assembly" / "gearbox.yaml"), "o3")
    parts = [shape.corners for shape in shapes if shape.corners is not None]
    heights = np.linspace(SEAT + 1.5e-4, SEAT + 0.024, 9)
    assert inside(parts, on_cylinder(SEAT_RADIUS - 1.5e-4, heights)).mean() < 0.003
    assert not inside(parts, on_cylinder(SEAT_RADIUS - 1e-3, heights)).any()
    assert len(parts) < 1500


def test_parts_that_were_cut_once_are_taken_from_the_cache_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("KABO_CACHE", str(tmp_path / "cache"))
    box = [np.asarray(trimesh.creation.box((0.072, 0.072, 0.026)).vertices, float)]
    made = unbridged(ring(), box)
    monkeypatch.setattr(hollows, "_unbridged", lambda *_: pytest.fail("they were cut again"))
    again = unbridged(ring(), box)
    assert len(again) == len(made) > 1
    assert all(np.array_equal(first, second) for first, second in zip(made, again, strict=True))
