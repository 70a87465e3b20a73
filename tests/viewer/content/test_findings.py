"""Findings in a scene: each says what it is about, so that a page can show its place."""

import pytest

from kabo.errors import About
from kabo.language import load_scene_description
from kabo.scene import load_scene
from kabo.viewer.content.findings import finding_view, scene_findings

SCENE = """scene: full
epsilon: 0.01
objects:
  table: {box: [1.0, 1.0, 0.04], pose: {position: [0, 0, -0.02]}}
  cup: {model: thing, pose: {position: [0.2, 0.0, 0.05]}}
  can: {model: thing, pose: {position: [0.26, 0.0, 0.05]}}
models:
  thing:
    cylinder: {radius: 0.04, height: 0.1}
    movable: true
    grasps: {top: {constraints: ["coincident(tool.tcp, this.center)"]}}
    placements: {standing: {constraints: ["coincident(this.bottom, support.top)", "inside(this, region)"]}}
regions:
  slot: {box: [0.05, 0.05, 0.3], pose: {position: [-0.3, 0, 0.15]}, support: table}
allowed_contacts:
  - [cup, table]
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("full") / "scene.yaml"
    path.write_text(SCENE)
    description = load_scene_description(path)
    scene = load_scene(description)
    return scene, scene_findings(scene, description, [path], prepared=True)


def about(found, said: str) -> About:
    (finding,) = (each for each in found[1] if said in each.message)
    assert finding.about is not None
    return finding.about


def test_an_overlap_is_about_both_things_and_as_deep_as_it_says(found):
    overlap = about(found, "overlap at the start")
    assert set(overlap.things) == {"cup", "can"}
    assert overlap.metres == pytest.approx(-0.02, abs=1e-3)


def test_a_region_that_is_too_small_is_about_itself_and_what_is_missing(found):
    assert about(found, 'region "slot"') == About(("slot",), pytest.approx(0.03, abs=1e-3))


def test_the_view_of_a_finding_has_its_pair_its_region_and_its_line(found):
    scene, findings = found
    views = [finding_view(each, scene) for each in findings]
    overlap = next(each for each in views if "overlap" in each["message"])
    assert (overlap["file"], overlap["line"], overlap["severity"]) == ("scene.yaml", 5, "warning")
    assert set(overlap["place"]["pair"]) == {"cup", "can"}
    assert next(each for each in views if "slot" in each["message"])["place"]["region"] == "slot"
