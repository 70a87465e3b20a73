"""TIAGo from its URDF to a verified plan: `examples/tiago_inspection/` is planned and verified."""

from pathlib import Path

import pytest

import kabo
from kabo.geometry_server import GeometryServer
from kabo.geometry_server.robot_models.findings import robot_findings
from kabo.geometry_server.robot_models.model import make_robot_model
from kabo.language import load_scene_description
from kabo.language.recorded_paths import installed_folder
from kabo.scene import load_scene

FOLDER = Path(__file__).parents[2] / "examples" / "tiago_inspection"


@pytest.mark.slow
def test_what_hides_a_box_from_the_head_is_put_aside_and_the_plan_is_verified() -> None:
    problem = kabo.load_problem(FOLDER / "problem.yaml")
    result = kabo.solve(problem, timeout=600)
    assert result.plan is not None, result.reason
    assert kabo.verify(problem, result.plan).ok
    assert {"read_barcode", "pick_up", "put_aside", "sort"} <= {node.action for node in result.plan.nodes.values()}


@pytest.mark.slow
def test_the_scene_has_what_kabo_robot_finds() -> None:
    description = load_scene_description(FOLDER / "scene.yaml")
    assert [each for each in robot_findings(description) if each.severity == "error"] == []
    scene = load_scene(description)
    assert not GeometryServer(scene).collides("arm", list(scene.start.robots["arm"]))
    folder = installed_folder("example-robot-data")
    assert folder is not None
    model = make_robot_model(
        folder / "robots/tiago_description/robots/tiago.urdf", None, name="tiago", epsilon=0.01
    )
    assert model.home is not None
    own = description.robots["arm"]
    assert set(own.hulls) == set(model.hulls)
    assert {(each.first, each.second) for each in own.contacts} == {
        (each.first, each.second) for each in model.always
    }
