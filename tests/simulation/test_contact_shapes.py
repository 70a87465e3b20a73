"""Contact shapes that child processes make are those that are made one after the other."""

from pathlib import Path

import pytest
import trimesh

import kabo
from kabo.phases import Phase, heard_by
from kabo.scene import Scene
from kabo.simulation.contact_shapes import contact_shapes, make_contact_shapes

MESHES = Path(__file__).parents[2] / "meshes"
NAMES = "bottle", "cup"


def scene_in(folder: Path, *, flat: bool = False) -> Scene:
    meshes = {name: MESHES / name / f"{name}.stl" for name in NAMES}
    if flat:
        sheet = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        for _ in range(5):
            sheet = sheet.subdivide()
        meshes["sheet"] = folder / "sheet.stl"
        sheet.export(meshes["sheet"])
    models = "".join(f"  {name}: {{mesh: {mesh}}}\n" for name, mesh in meshes.items())
    things = "".join(f"  {n}: {{model: {n}, pose: {{position: [{k}, 0, 0]}}}}\n" for k, n in enumerate(meshes))
    file = folder / "scene.yaml"
    file.write_text(f"scene: things\nepsilon: 0.01\nmodels:\n{models}objects:\n{things}")
    return kabo.load_scene(file)


def corners_of(scene: Scene, thing: str) -> list[list[list[float]]]:
    return [shape.corners.tolist() for shape in contact_shapes(scene, thing) if shape.corners is not None]


def test_children_make_the_shapes_that_this_process_would_make(tmp_path: Path) -> None:
    expected = {name: corners_of(scene_in(tmp_path), name) for name in NAMES}
    scene, heard = scene_in(tmp_path), list[Phase]()
    with heard_by(heard.append):
        make_contact_shapes(scene)
    assert ("making contact shapes", 2, "meshes") in {(each.doing, each.total, each.unit) for each in heard}
    assert len(scene.memory["contact shapes"]) == 2
    assert {name: corners_of(scene, name) for name in NAMES} == expected
    assert all(len(shapes) >= 2 for shapes in expected.values())
    make_contact_shapes(scene)  # nothing is left to make
    assert len(scene.memory["contact shapes"]) == 2


def test_a_mesh_of_which_no_shape_can_be_made_is_refused_where_it_is_asked_for(tmp_path: Path) -> None:
    scene = scene_in(tmp_path, flat=True)
    make_contact_shapes(scene)
    assert len(scene.memory["contact shapes"]) == 2
    with pytest.raises(kabo.MeshError):
        contact_shapes(scene, "sheet")
