"""Bounding decompositions: what comes back, what is refused, and a cache that survives whatever happens to it."""

import multiprocessing
import os
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from kabo.errors import MeshError
from kabo.geometry import bounding_decomposition
from kabo.geometry.bounding import enclosing_union, stored_parts
from kabo.geometry.bounding.bounding_decomposition import Decomposition
from kabo.geometry.bounding.stored_parts import Cover
from kabo.meshes import Mesh

EPSILON = 0.008


def mesh_of(shape: trimesh.Trimesh) -> Mesh:
    return Mesh(np.array(shape.vertices, np.float64), np.array(shape.faces, np.int64))


def bracket() -> Mesh:
    """Two plates that overlap in a corner: an L."""
    plates = [
        trimesh.creation.box(bounds=[[0, 0, 0], [0.1, 0.06, 0.01]]),
        trimesh.creation.box(bounds=[[0, 0, 0], [0.01, 0.06, 0.08]]),
    ]
    return mesh_of(trimesh.util.concatenate(plates))


def as_bytes(made: Decomposition) -> bytes:
    return b"".join(part.tobytes() for part in made.parts) + np.array(made.deviations).tobytes()


def shuffled(mesh: Mesh, seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(mesh.vertices))
    faces = np.argsort(order)[mesh.faces][rng.permutation(len(mesh.faces))]
    return Mesh(mesh.vertices[order], np.roll(faces, 1, axis=1))


def test_a_box_is_one_part_of_eight_vertices_and_an_angle_is_two(tmp_path: Path) -> None:
    box = bounding_decomposition(mesh_of(trimesh.creation.box((0.1, 0.2, 0.3))), 1e-4, cache=tmp_path)
    assert [len(part) for part in box.parts] == [8]
    angle = bounding_decomposition(bracket(), 1e-3, cache=tmp_path)
    assert [len(part) for part in angle.parts] == [8, 8]
    assert angle.hausdorff_upper_bound == max(angle.deviations) <= angle.epsilon
    assert angle.deviations[angle.worst] == angle.hausdorff_upper_bound


def test_the_same_triangles_give_the_same_bytes_in_any_order(tmp_path: Path) -> None:
    ring = mesh_of(trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24))
    first = bounding_decomposition(ring, EPSILON, cache=tmp_path / "first")
    second = bounding_decomposition(shuffled(ring, 1), EPSILON, cache=tmp_path / "second")
    assert as_bytes(first) == as_bytes(second)


def test_targets_make_parts_tighter_and_corners_fewer(tmp_path: Path) -> None:
    ring = mesh_of(trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24))
    few = bounding_decomposition(ring, EPSILON, cache=tmp_path)
    more = bounding_decomposition(ring, EPSILON, parts=4 * len(few.parts), cache=tmp_path)
    assert len(few.parts) <= len(more.parts) <= 4 * len(few.parts)
    assert more.hausdorff_upper_bound < few.hausdorff_upper_bound
    ball = mesh_of(trimesh.creation.icosphere(subdivisions=3, radius=0.05))
    small = bounding_decomposition(ball, 0.003, vertices_per_part=12, cache=tmp_path)
    assert max(map(len, small.parts)) <= 12 < len(bounding_decomposition(ball, 0.003, cache=tmp_path).parts[0])


@pytest.mark.parametrize("epsilon", [0.0, -0.01, np.nan, np.inf])
def test_an_epsilon_that_is_no_length_is_refused(epsilon: float, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must be a length above 0"):
        bounding_decomposition(bracket(), epsilon, cache=tmp_path)


@pytest.mark.parametrize("targets", [{"parts": 0}, {"vertices_per_part": 3}])
def test_targets_that_nothing_can_reach_are_refused(targets: dict[str, int], tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="must be a whole number from [14] on"):
        bounding_decomposition(bracket(), 0.01, cache=tmp_path, **targets)


def test_an_open_mesh_is_refused(tmp_path: Path) -> None:
    angle = bracket()
    with pytest.raises(MeshError, match="not closed"):
        bounding_decomposition(Mesh(angle.vertices, angle.faces[1:]), 0.01, cache=tmp_path)


def test_hollows_that_no_part_can_be_proven_to_avoid_are_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(enclosing_union, "enclosing_part", lambda *_: None)
    with pytest.raises(MeshError, match=r"its 24 triangles have hollows .* within 0\.001 m"):
        bounding_decomposition(bracket(), 1e-3, cache=tmp_path)


def test_damaged_files_of_the_cache_are_made_again(tmp_path: Path) -> None:
    first = bounding_decomposition(bracket(), 1e-3, cache=tmp_path)
    files = sorted(tmp_path.iterdir())
    assert files
    for spoil in (b"", files[0].read_bytes()[:-9], files[0].read_bytes()[:-1] + b"\x00", b"\xff" * 99):
        for file in files:
            file.write_bytes(spoil)
        assert as_bytes(bounding_decomposition(bracket(), 1e-3, cache=tmp_path)) == as_bytes(first)


def test_a_cache_that_cannot_be_written_costs_time_only(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    assert len(bounding_decomposition(bracket(), 1e-3, cache=blocked / "folder").parts) == 2


def _make(cache: Path, answers: "multiprocessing.Queue[bytes]") -> None:
    answers.put(as_bytes(bounding_decomposition(bracket(), 1e-3, cache=cache)))


def test_processes_that_make_the_same_at_once_get_the_same(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    answers: multiprocessing.Queue[bytes] = context.Queue()
    makers = [context.Process(target=_make, args=(tmp_path, answers)) for _ in range(3)]
    for maker in makers:
        maker.start()
    found = {answers.get(timeout=300) for _ in makers}
    for maker in makers:
        maker.join()
    assert found == {as_bytes(bounding_decomposition(bracket(), 1e-3, cache=tmp_path))}
    assert all(file.suffix == ".parts" for file in tmp_path.iterdir()), "no temporary file is left"


NAME = "0" * 64


def _corners(seed: int) -> NDArray[np.float64]:
    return np.full((4000, 3), float(seed))


def _write_for_ever(folder: Path) -> None:
    for seed in range(10**9):
        made = Cover((_corners(seed % 7),), (float(seed % 7),), 7.0)
        stored_parts.write(folder / "file.parts", NAME, [made])


def test_a_writer_that_is_killed_leaves_a_whole_file(tmp_path: Path) -> None:
    writer = multiprocessing.get_context("spawn").Process(target=_write_for_ever, args=(tmp_path,))
    writer.start()
    seen = 0
    until = time.monotonic() + 120.0
    while seen < 50 and time.monotonic() < until:
        for found in stored_parts.read(tmp_path / "file.parts", NAME):
            assert np.array_equal(found.parts[0], _corners(int(found.deviations[0])))
            seen += 1
    os.kill(writer.pid or 0, 9)
    writer.join()
    assert seen == 50
    (after,) = stored_parts.read(tmp_path / "file.parts", NAME)
    assert np.array_equal(after.parts[0], _corners(int(after.deviations[0])))


def hollow_block(radius: float) -> Mesh:
    """A block with a closed spherical hollow in it."""
    block = trimesh.creation.box((0.2, 0.16, 0.12))
    hollow = trimesh.creation.icosphere(subdivisions=1, radius=radius)
    hollow.invert()
    hollow.apply_translation((0.041, -0.027, 0.013))
    return mesh_of(trimesh.util.concatenate([block, hollow]))


@pytest.mark.parametrize("share", [1.1, 1.3])
def test_a_small_closed_hollow_in_a_large_block_is_kept_out_of_all_parts(share: float, tmp_path: Path) -> None:
    epsilon = 0.0028
    block = hollow_block(share * epsilon)
    made = bounding_decomposition(block, epsilon, cache=tmp_path)
    middle = np.array([0.041, -0.027, 0.013])
    planes = [ConvexHull(part).equations for part in made.parts]
    assert not any((own[:, :3] @ middle + own[:, 3] <= 0.0).all() for own in planes)
    assert made.hausdorff_upper_bound <= epsilon
