"""Pages in Python: opened from a file, kept in memory, or shown by a notebook."""

import html
import re
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError

REPOSITORY = Path(__file__).parents[2]
BARTENDER = REPOSITORY / "domains" / "bartender" / "four_bottles.yaml"
PARCEL = REPOSITORY / "tests" / "acceptance" / "parcels" / "one.yaml"
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


@pytest.fixture(scope="module")
def problem() -> kabo.Problem:
    return kabo.load_problem(BARTENDER)


def framed(thing: object) -> str:
    """The page that a notebook shows of a thing."""
    (source,) = re.findall(r'srcdoc="([^"]*)"', thing._repr_html_())
    return html.unescape(source)


def test_a_problem_is_shown_by_the_page_that_kabo_view_writes(problem, tmp_path):
    page = kabo.view(problem, tmp_path / "page.html", open=False)
    assert page.path.read_bytes() == page.html == kabo.view(BARTENDER, open=False).html
    assert framed(page).encode() == page.html
    assert framed(problem).startswith("<!DOCTYPE html>") and framed(kabo.load_scene(BARTENDER))


def test_nothing_is_written_when_nothing_is_asked_for(problem, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert kabo.view(problem, open=False).path is None
    assert not [*tmp_path.iterdir()]


def test_a_result_is_shown_with_its_scene_and_a_plan_alone_without_one(problem):
    moved = kabo.solve(problem, geometry="none")
    assert len(framed(moved)) > len(framed(moved.plan)) + 100_000, "the scene has meshes"
    assert kabo.view(moved.plan, problem=problem, open=False).html == kabo.view(moved, open=False).html
    assert framed(kabo.solve(kabo.load_problem(PARCEL))), "a problem without a scene"


def test_what_cannot_be_shown_is_refused():
    result = kabo.solve(kabo.load_problem(PARCEL))
    with pytest.raises(ValueError, match="has no scene"):
        kabo.view(result.problem, open=False)
    with pytest.raises(ValueError, match="no plan to show"):
        kabo.view(replace(result, plan=None), open=False)
    with pytest.raises(InputError):
        kabo.view("nothing.yaml", open=False)


def test_a_thing_whose_page_cannot_be_made_is_still_shown_as_figures(problem, tmp_path):
    name, body = next((name, body) for name, body in problem.scene.bodies.items() if body.shape.path is not None)
    lost = replace(body, shape=replace(body.shape, path=tmp_path / "lost.stl"))
    scene = replace(problem.scene, bodies={**problem.scene.bodies, name: lost})
    shown = replace(problem, scene=scene)._repr_html_()
    assert "iframe" not in shown and "<table>" in shown


def test_a_mesh_its_bounding_mesh_and_its_parts_are_shown(tmp_path):
    (tmp_path / "mesh.off").write_text(TETRAHEDRON)
    mesh = kabo.load_mesh(tmp_path / "mesh.off")
    outer = kabo.bounding_mesh(mesh, 0.01)
    parts = kabo.bounding_decomposition(mesh, 0.01, cache=tmp_path)
    assert repr(mesh) == "<Mesh mesh.off: 4 vertices, 4 faces, diagonal 1.73 m>"
    assert repr(outer).startswith("<BoundingMesh outer: 4 vertices, 4 faces, within ")
    assert repr(parts).startswith("<Decomposition: 1 convex part, 4 vertices, within ")
    assert framed(outer) and framed(parts) and kabo.view(mesh, open=False).html
