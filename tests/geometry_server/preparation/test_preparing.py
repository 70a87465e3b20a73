"""Preparation: parts of all links and bodies, in processes, told line by line, kept when cut off, faults all at once."""

import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.children import never
from kabo.errors import CutOff, MeshError
from kabo.geometry_server import PreparationCutOff, Preparing, SceneEnclosures, prepare_scene
from kabo.language.yaml.loading import load_scene_description
from kabo.scene import Scene, load_scene

EPSILON = 0.02
LINK = '  <link name="{0}">{1}</link>\n'
JOINT = """  <joint name="j{1}" type="revolute"><parent link="{0}"/><child link="{1}"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
"""
MESH = '<collision><geometry><mesh filename="{}.stl"/></geometry></collision>'


def angle(size: float) -> trimesh.Trimesh:
    """A closed body of two plates, which no single part encloses."""
    corners = np.array([[0, 0], [1, 0], [1, 0.2], [0.2, 0.2], [0.2, 1], [0, 1]]) * size
    return trimesh.creation.extrude_triangulation(
        corners, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]), height=0.1
    )


def channel() -> trimesh.Trimesh:
    """A box without its ends."""
    box = trimesh.creation.box((0.2, 0.2, 0.2))
    return trimesh.Trimesh(box.vertices, box.faces[np.abs(box.face_normals[:, 0]) < 0.5], process=False)


def scene(folder: Path, extra: str = "", **meshes: trimesh.Trimesh) -> Scene:
    """A robot with a link for each mesh, and a ball; with caches of its own."""
    links, joints = LINK.format("base", ""), ""
    for name, mesh in meshes.items():
        mesh.export(folder / f"{name}.stl")
        links += LINK.format(name, MESH.format(name))
        joints += JOINT.format("base", name)
    (folder / "one.urdf").write_text(f'<robot name="one">\n{links}{joints}</robot>\n')
    ball = "  ball: {box: [0.1, 0.1, 0.1], pose: {position: [3, 0, 0]}}\n"
    text = f"scene: some\nepsilon: {EPSILON}\nrobots:\n  r: {{urdf: one.urdf{extra}}}\nobjects:\n{ball}"
    (folder / "scene.yaml").write_text(text)
    return load_scene(load_scene_description(folder / "scene.yaml"))


@pytest.fixture(autouse=True)
def own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Parts are kept in a new folder; compiled kernels stay where they are."""
    monkeypatch.setattr("kabo.geometry.bounding.enclosure.cache_folder", lambda: tmp_path / "cache")


def test_each_thing_whose_parts_are_made_has_a_line_and_the_next_run_is_silent(tmp_path: Path) -> None:
    meshes = {"upper": angle(0.31), "lower": angle(0.42)}
    states: list[Preparing] = []
    made = prepare_scene(scene(tmp_path, **meshes), told=states.append)
    assert [each.name for each in made] == ["r.lower", "r.upper", "ball"]  # in the order of the robot's model
    assert all(each.parts >= 1 and each.vertices >= 8 for each in made)
    lines = [state.line for state in states]
    assert len(lines) == 4  # the beginning, two links, the end; the box costs nothing
    for name in ("r.upper", "r.lower"):
        assert sum(line.startswith(f"{name}: 20 triangles, ") and " parts, " in line for line in lines) == 1
    assert states[-1].missing == () and states[-1].fraction == 1.0
    again: list[Preparing] = []
    assert [each.parts for each in prepare_scene(scene(tmp_path, **meshes), told=again.append)] == [
        each.parts for each in made
    ]
    assert again == []


def test_parts_depend_on_no_number_of_processes_and_are_those_of_first_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = []
    for processes in (1, 3, None):
        folder = tmp_path / str(processes)
        folder.mkdir()
        monkeypatch.setattr("kabo.geometry.bounding.enclosure.cache_folder", lambda own=folder: own / "cache")
        monkeypatch.setattr("kabo.geometry_server.preparation.enclosures._ENCLOSURES", _Forgetful())
        made = scene(folder, upper=angle(0.33), lower=angle(0.44), third=angle(0.2))
        if processes is not None:
            prepare_scene(made, processes=processes)
        enclosures = SceneEnclosures(made, 0.4 * EPSILON)
        found.append([enclosures.of(name).parts for name in enclosures.things])
    for other in found[1:]:
        for one, two in zip(found[0], other, strict=True):
            assert len(one) == len(two)
            assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))


class _Forgetful:
    """A cache that keeps nothing."""

    def get_or_make(self, _, make):
        return make()


def test_all_meshes_that_cannot_be_enclosed_are_told_at_once_with_what_helps(tmp_path: Path) -> None:
    turned = angle(0.3)
    torn = trimesh.Trimesh(
        np.concatenate([turned.vertices, turned.vertices[turned.faces[0]] + 1e-9]),
        np.concatenate([turned.faces[1:], len(turned.vertices) + np.arange(3)[None]]),
        process=False,
    )
    with pytest.raises(MeshError) as refused:
        prepare_scene(scene(tmp_path, ", hulls: [good]", good=angle(0.2), open=channel(), torn=torn))
    first, second = refused.value.diagnostics
    assert first.file.endswith("one.urdf") and (first.line, second.line) == (4, 5)
    assert first.source is not None and "open.stl" in first.source
    assert f'link "open" of robot "r": mesh file "{tmp_path / "open.stl"}" is not closed' in first.message
    assert first.hint is not None and "`hulls: [good, open, torn]`" in first.hint
    assert "`--repair` does not close it" in first.hint
    assert second.hint is not None and "`kabo bound torn.stl --repair" in second.hint


def test_a_mesh_that_fails_is_told_though_others_of_its_link_have_no_parts_yet(tmp_path: Path) -> None:
    angle(0.21).export(tmp_path / "sound.stl")
    made = scene(tmp_path, ", hulls: [hull]", hull=channel(), both=channel(), open=channel())
    text = (tmp_path / "one.urdf").read_text()
    (tmp_path / "one.urdf").write_text(
        text.replace(MESH.format("both"), MESH.format("both") + MESH.format("sound"))
    )
    made = load_scene(load_scene_description(tmp_path / "scene.yaml"))
    with pytest.raises(MeshError) as refused:
        prepare_scene(made)
    first, second = refused.value.diagnostics
    assert ("both.stl" in first.message, "open.stl" in second.message) == (True, True)
    # The first finding that a person reads has the line, whatever the order of links in the robot's model.
    assert first.hint is not None and "`hulls: [hull, both, open]`" in first.hint
    assert second.hint is not None and second.hint.startswith("its convex hull, as above")


def test_what_is_done_before_a_cut_is_kept_and_the_error_says_what_is_not(tmp_path: Path) -> None:
    meshes = {"upper": angle(0.35), "lower": angle(0.46)}
    before = children_of(os.getpid())
    done: list[str] = []

    def look() -> None:
        if len(done) >= 2:  # the line at the beginning, and the first link
            raise CutOff

    with pytest.raises(PreparationCutOff) as cut:
        prepare_scene(
            scene(tmp_path, **meshes), processes=1, look=look, told=lambda state: done.append(state.line)
        )
    assert children_of(os.getpid()) == before
    assert (
        "for 2 of 3 links and bodies, not for r.upper" in cut.value.details[0]
    )  # large meshes come first, then by name
    states: list[Preparing] = []
    prepare_scene(scene(tmp_path, **meshes), told=states.append)
    assert sum(state.line.startswith("r.") for state in states) == 1


def test_a_cut_at_any_look_leaves_no_process(tmp_path: Path) -> None:
    made = scene(tmp_path, upper=angle(0.37), lower=angle(0.48))
    before = children_of(os.getpid())
    for last in range(4):
        looks: list[None] = []

        def look(looks: list[None] = looks, last: int = last) -> None:
            looks.append(None)
            if len(looks) > last:
                raise CutOff

        with pytest.raises(CutOff):
            prepare_scene(made, processes=2, look=look)
        assert children_of(os.getpid()) == before
    assert prepare_scene(made, look=never)


def children_of(process: int) -> set[str]:
    """The process ids of the children of a process."""
    return set(Path(f"/proc/{process}/task/{process}/children").read_text().split())
