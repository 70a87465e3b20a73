"""Contact shapes that child processes make are those that are made one after the other."""

from pathlib import Path

import pytest
import trimesh

import kabo
from kabo.phases import Phase, heard_by
from kabo.simulation.contact_shapes import contact_shapes, make_contact_shapes

BARTENDER = Path(__file__).parents[2] / "domains" / "bartender" / "four_bottles.yaml"
THINGS = "bottle_1", "left.link_2"


def corners_of(scene: kabo.Scene, thing: str) -> list[list[list[float]]]:
    return [shape.corners.tolist() for shape in contact_shapes(scene, thing) if shape.corners is not None]


def test_children_make_the_shapes_that_this_process_would_make() -> None:
    alone, scene, heard = kabo.load_scene(BARTENDER), kabo.load_scene(BARTENDER), list[Phase]()
    with heard_by(heard.append):
        make_contact_shapes(scene)
    made = dict(scene.memory["contact shapes"])
    assert ("making contact shapes", len(made), "meshes") in {
        (each.doing, each.total, each.unit) for each in heard
    }
    for thing in THINGS:
        assert corners_of(scene, thing) == corners_of(alone, thing) != []
    assert scene.memory["contact shapes"] == made  # both were there
    make_contact_shapes(scene)
    assert scene.memory["contact shapes"] == made  # nothing was left to make


def test_meshes_of_which_no_shape_can_be_made_are_refused_where_they_are_asked_for(tmp_path: Path) -> None:
    sheet = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for _ in range(5):
        sheet = sheet.subdivide()
    for number in (1, 2):
        sheet.apply_scale(number).export(tmp_path / f"{number}.stl")
    lines = [f"  o{n}: {{mesh: {n}.stl, pose: {{position: [{n}, 0, 0]}}}}" for n in (1, 2)]
    (tmp_path / "scene.yaml").write_text("\n".join(["scene: sheets", "epsilon: 0.01", "objects:", *lines]) + "\n")
    scene = kabo.load_scene(tmp_path / "scene.yaml")
    make_contact_shapes(scene)
    assert scene.memory["contact shapes"] == {}
    with pytest.raises(kabo.MeshError):
        contact_shapes(scene, "o1")
