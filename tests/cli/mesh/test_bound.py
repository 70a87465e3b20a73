"""`kabo bound` and `kabo decompose`: figures, files that are whole or absent, one sentence for what cannot be used."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.cli.mesh.bound import COSTS
from kabo.geometry.bounding.bounding_mesh import COSTS as GEOMETRY_COSTS
from kabo.meshes import load_mesh, require_solid, write_off
from tests.meshes.solids import box, side, together, volume, without

BOUND = {
    "vertices_in",
    "vertices_out",
    "faces_out",
    "epsilon",
    "hausdorff_upper_bound",
    "one_sided",
    "contractions_per_s",
    "seconds",
    "repairs",
    "warnings",
}
DECOMPOSE = {
    "parts",
    "vertices",
    "vertices_max",
    "epsilon",
    "hausdorff_upper_bound",
    "covers",
    "seconds",
    "worst_part",
    "repairs",
    "warnings",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a ball, a box that is open on one side, and one that lacks a triangle."""
    monkeypatch.chdir(tmp_path)
    trimesh.creation.icosphere(subdivisions=3, radius=0.1).export("ball.stl")
    trimesh.creation.annulus(0.03, 0.05, 0.02, sections=24).export("ring.off")
    cube = box(0.1)
    for name, mesh in {
        "open.off": without(cube, *side(cube, 2, 1)),
        "gap.off": without(cube, 0),
        "large.off": box(100.0),
        "crossing.off": together(box(0.1), box(0.1, at=(0.03, 0.02, 0.01))),
    }.items():
        write_off(name, mesh.vertices, mesh.faces)
    return tmp_path


def written(folder: Path) -> set[str]:
    """What a command left in the folder beside its input, hidden files included."""
    given = {"ball.stl", "ring.off", "open.off", "gap.off", "large.off", "crossing.off"}
    return {path.name for path in folder.iterdir()} - given


@pytest.mark.parametrize(("way", "factor"), [("outer", 1.0), ("inner", -1.0)])
def test_a_ball_is_bounded_on_the_side_that_was_asked_for(kabo, folder, way, factor):
    said = kabo("bound", "ball.stl", "--epsilon", "2%", "--side", way, "-o", "out.off", "--json")
    assert said.code == 0, said.err
    figures = said.json
    assert set(figures) == BOUND
    before, after = load_mesh("ball.stl"), load_mesh("out.off")
    assert (figures["vertices_in"], figures["vertices_out"]) == (len(before.vertices), len(after.vertices))
    assert figures["faces_out"] == len(after.faces) and figures["one_sided"] is True
    assert figures["epsilon"] == pytest.approx(0.02 * before.diagonal)
    assert figures["hausdorff_upper_bound"] <= figures["epsilon"]
    assert len(after.vertices) < len(before.vertices) / 3
    assert factor * (volume(after) - volume(before)) > 0.0
    require_solid(after)
    assert "out.off" in said.err and way in said.err


def test_metres_and_a_scale_mean_the_same_as_in_the_scaled_file(kabo, folder):
    kabo("bound", "ball.stl", "--epsilon", "0.01", "-o", "a.off")
    large = load_mesh("ball.stl")
    write_off("millimetres.off", large.vertices * 1000.0, large.faces)
    said = kabo("bound", "millimetres.off", "--scale", "0.001", "--epsilon", "0.01", "-o", "b.ply", "--json")
    assert said.code == 0 and said.json["epsilon"] == 0.01 and said.json["warnings"] == []
    assert load_mesh("b.ply").diagonal == pytest.approx(load_mesh("a.off").diagonal, abs=0.02)


@pytest.mark.slow
def test_a_ring_is_covered_by_convex_parts_one_object_each(kabo, folder):
    said = kabo("decompose", "ring.off", "--epsilon", "0.006", "-o", "parts.obj", "--json")
    assert said.code == 0, said.err
    figures = said.json
    assert set(figures) == DECOMPOSE
    scene = trimesh.load_scene("parts.obj", process=False, split_objects=True)
    parts = list(scene.geometry.values())
    assert len(parts) == figures["parts"] > 1 and figures["covers"] is True
    assert all(part.is_convex for part in parts)
    assert figures["vertices"] == sum(len(part.vertices) for part in parts)
    assert figures["hausdorff_upper_bound"] <= figures["epsilon"] == 0.006
    points = trimesh.load("ring.off").sample(500, seed=0)
    covered = np.zeros(len(points), dtype=bool)
    for part in parts:
        away = np.einsum("pfk,fk->pf", points[:, None] - part.triangles[None, :, 0], part.face_normals)
        covered |= (away <= 1e-12).all(axis=1)
    assert covered.all()


@pytest.mark.parametrize("command", ["bound", "decompose"])
def test_an_open_mesh_is_refused_with_counts_and_a_gap_is_repaired_when_asked(kabo, folder, command):
    said = kabo(command, "open.off", "--epsilon", "1%", "-o", "out.off", "--json")
    assert said.code == 2 and "4 open edges around 1 hole" in said.err
    assert said.json["code"] == "bad_request" and "4 open edges" in said.json["message"]
    assert kabo(command, "open.off", "--epsilon", "1%", "-o", "out.off", "--repair").code == 2
    assert kabo(command, "gap.off", "--epsilon", "1%", "-o", "out.off").code == 2
    assert written(folder) == set()
    repaired = kabo(command, "gap.off", "--epsilon", "1%", "-o", "out.off", "--repair", "--json")
    assert repaired.code == 0 and repaired.json["repairs"] == ["filled 1 hole with 1 triangle"]
    assert "filled 1 hole" in repaired.err and written(folder) == {"out.off"}


def test_what_is_odd_but_usable_is_a_warning(kabo, folder):
    large = kabo("bound", "large.off", "--epsilon", "1%", "-o", "out.off", "--json")
    assert large.code == 0 and "millimetres" in large.json["warnings"][0] and "--scale 0.001" in large.err
    crossing = kabo("bound", "crossing.off", "--epsilon", "1%", "-o", "out.off", "--json")
    assert crossing.code == 0 and "triangles cross others" in crossing.json["warnings"][0]


@pytest.mark.parametrize("command", ["bound", "decompose"])
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"--epsilon": "5mm"}, "did you mean 0.005?"),
        ({"--epsilon": "1,5%"}, "did you mean 1.5%?"),
        ({"--epsilon": "1 percent"}, "did you mean 1%?"),
        ({"--epsilon": "0"}, "a length above 0"),
        ({"--epsilon": "-1%"}, "a length above 0"),
        ({"--epsilon": "nan"}, "a length above 0"),
        ({"--epsilon": "1e999"}, "a length above 0"),
        ({"--epsilon": "1e-14"}, "finer than coordinates"),
        ({"--scale": "mm"}, "did you mean 0.001?"),
        ({"--scale": "0"}, "above 0"),
        ({"-o": "out.stl"}, "single precision"),
        ({"-o": "out.glb"}, "write out.off, .ply or .obj"),
        ({"-o": "out.step"}, "writes no .step"),
        ({"-o": "absent/out.off"}, "folder that exists"),
        ({"--picture": "out.jpg"}, "does not end with .png"),
        ({"MESH": "absent.stl"}, "does not exist"),
        ({"MESH": "."}, "is not a file"),
        ({"MESH": "ball.step"}, "does not exist"),
    ],
)
def test_what_cannot_be_meant_is_exit_2_and_writes_nothing(kabo, folder, command, changes, message):
    chosen = {"MESH": "ball.stl", "--epsilon": "1%", "-o": "out.off", **changes}
    mesh = chosen.pop("MESH")
    options = [f"{name}={value}" if name.startswith("--") else f"{name}{value}" for name, value in chosen.items()]
    said = kabo(command, mesh, *options)
    assert said.code == 2 and said.out == "" and "Traceback" not in said.err
    assert message in said.err
    assert written(folder) == set()


@pytest.mark.parametrize(
    ("command", "option"),
    [("bound", "--vertices=3"), ("decompose", "--parts=0"), ("decompose", "--vertices-per-part=3")],
)
def test_targets_that_no_solid_can_reach_are_exit_2(kabo, folder, command, option):
    said = kabo(command, "ball.stl", "--epsilon", "1%", "-o", "out.off", option)
    assert said.code == 2 and "is not a whole number from" in said.err


def test_the_costs_are_those_of_the_geometry_room_and_an_unknown_one_is_corrected(kabo, folder):
    assert set(COSTS) == set(GEOMETRY_COSTS)
    said = kabo("bound", "ball.stl", "--epsilon", "1%", "-o", "out.off", "--cost", "memryless")
    assert said.code == 2 and 'did you mean "memoryless"?' in said.err


def test_a_picture_without_its_library_is_refused_before_the_work(kabo, folder, monkeypatch):
    monkeypatch.setattr("kabo.pictures.files.find_spec", lambda name: None)
    said = kabo("bound", "ball.stl", "--epsilon", "1%", "-o", "out.off", "--picture", "out.png", "--json")
    assert said.code == 2 and "pyvista" in said.json["message"] and "kabo[pictures]" in said.json["message"]
    assert written(folder) == set()


def test_pictures_are_drawn_without_a_display(kabo, folder, monkeypatch):
    pytest.importorskip("pyvista")
    from PIL import Image

    monkeypatch.delenv("DISPLAY", raising=False)
    for command, mesh in (("bound", "ball.stl"), ("decompose", "ring.off")):
        said = kabo(command, mesh, "--epsilon", "5%", "-o", "out.off", "--picture", "out.png", "--json")
        assert said.code == 0 and json.loads(said.out)
        picture = np.asarray(Image.open("out.png").convert("RGB")).reshape(-1, 3)
        assert len(np.unique(picture, axis=0)) > 100
        assert (picture == 255).all(axis=1).mean() < 0.95
