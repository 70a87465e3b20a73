"""What reports tell for the eye: the motions of solutions and the samples of failures are where the plan says they are."""

from pathlib import Path

import pytest

from kabo.language import load_scene_description
from kabo.scene import Scene, load_scene
from kabo.tasks.files import load_task_file
from kabo.tasks.files.films import MAX_FILMS
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.files.report_form import Report, read_report, report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import PlanningOptions, plan_file

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


@pytest.fixture(scope="module")
def found(scene: Scene) -> Report:
    """The report of the example: ten solutions, and what failed beside them."""
    file = load_task_file(EXAMPLE / "task.yaml")
    runs = plan_file(file, {}, scene, PlanningOptions(max_solutions=MAX_FILMS + 1))
    return report(runs, file="task.yaml", scene=scene, scene_file="scene.yaml")


def test_a_film_leads_from_the_start_of_the_scene_to_where_the_object_was_to_be(found: Report) -> None:
    film = found["runs"][0]["solutions"][0]["film"]
    assert film["start"] == {}, "it begins as the scene does"
    assert film["after"]["objects"]["object"]["position"] == pytest.approx([0.6, -0.15, 0.125], abs=1e-6)
    attached = [(each["object"], each["to"]) for segment in film["segments"] for each in segment["attach"]]
    assert attached == [("object", "arm.tool0")] and [s["detach"] for s in film["segments"]].count(["object"]) == 1
    for before, after in zip(film["segments"], film["segments"][1:], strict=False):
        assert after["times"][0] == pytest.approx(before["times"][-1], abs=1e-6)


def test_segments_name_the_stages_of_the_report(found: Report) -> None:
    paths = {stage["path"] for stage in found["stages"]}
    assert {s["stage"] for s in found["runs"][0]["solutions"][0]["film"]["segments"]} <= paths


def test_only_the_first_solutions_have_a_film(found: Report) -> None:
    told = ["film" in whole for whole in found["runs"][0]["solutions"]]
    assert told == [True] * MAX_FILMS + [False]


def test_a_failed_retreat_is_shown_with_the_object_put_down(found: Report) -> None:
    (first, *_) = found["runs"][0]["stages"]["place/retreat"]["refusals"]
    state = first["sample"]["state"]
    assert state["objects"]["object"]["parent"] == "world"
    assert set(state["robots"]) == {"arm"} and len(state["robots"]["arm"]["joints"]) == 8  # noqa: PLR2004


def test_reports_with_films_are_read_again_and_are_the_same_bytes(found: Report) -> None:
    content = report_bytes(found)
    assert report_bytes(read_report(content, "r.json")) == content
    assert found["scene"] == "scene.yaml"


def test_a_sample_in_collision_is_where_the_pair_that_it_names_collides(scene: Scene) -> None:
    file = load_task_file(EXAMPLE / "task.yaml")
    low = {
        "destination": {"position": [0.6, -0.15, 0.05]}
    }  # the object would stand in the table, and the hand near it
    made = report(plan_file(file, low, scene, PlanningOptions(max_solutions=1, timeout=4.0)), scene=scene)
    refusals = made["runs"][0]["stages"]["place/place pose IK"]["refusals"]
    samples = [each["sample"] for each in refusals if each["reason"] == "collision"]
    assert samples
    first = first_scene(scene, 0, lambda: False)
    for sample in samples[:5]:
        there = first.at("arm", sample["state"]["robots"]["arm"]["joints"].values())
        assert set(sample["between"]) == {"arm.link_5", "table"}
        assert there.hit("arm") is not None
