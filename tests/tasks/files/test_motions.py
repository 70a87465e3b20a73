"""What reports tell of motion: the segments of solutions, the changes of their scenes, and the samples of failures."""

import json
from pathlib import Path

import pytest

from kabo.language import load_scene_description
from kabo.scene import Scene, load_scene
from kabo.tasks.files import load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.files.report_form import Report, read_report, report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import PlanningOptions, TaskRun, plan_file
from kabo.tasks.robots import segments

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


@pytest.fixture(scope="module")
def runs(scene: Scene) -> list[TaskRun]:
    return plan_file(load_task_file(EXAMPLE / "task.yaml"), {}, scene, PlanningOptions(max_solutions=2))


@pytest.fixture(scope="module")
def found(scene: Scene, runs: list[TaskRun]) -> Report:
    """The report of the example: two solutions, and what failed beside them."""
    return report(runs, file="task.yaml", scene=scene, scene_file="scene.yaml")


def test_a_motion_leads_from_the_start_of_the_scene_to_where_the_object_was_to_be(found: Report) -> None:
    motion = found["runs"][0]["solutions"][0]["motion"]
    assert motion["start"] == {}, "it begins as the scene does"
    assert motion["after"]["objects"]["object"]["position"] == pytest.approx([0.6, -0.15, 0.125], abs=1e-6)
    attached = [(each["object"], each["to"]) for segment in motion["segments"] for each in segment["attach"]]
    assert (
        attached == [("object", "arm.tool0")] and [s["detach"] for s in motion["segments"]].count(["object"]) == 1
    )
    for before, after in zip(motion["segments"], motion["segments"][1:], strict=False):
        assert after["times"][0] == pytest.approx(before["times"][-1], abs=1e-6)


def test_segments_name_the_stages_of_the_report(found: Report) -> None:
    paths = {stage["path"] for stage in found["stages"]}
    assert {s["stage"] for s in found["runs"][0]["solutions"][0]["motion"]["segments"]} <= paths


def test_segments_are_those_of_plans_digit_for_digit(found: Report, runs: list[TaskRun], scene: Scene) -> None:
    for solution, told in zip(runs[0].task.solutions, found["runs"][0]["solutions"], strict=True):
        for segment, written in zip(segments(solution, scene, ""), told["motion"]["segments"], strict=True):
            assert written["waypoints"] == [list(row) for row in segment.waypoints]
            assert written["times"] == list(segment.times)
            assert [tuple(pair) for pair in written["allowed_contacts"]] == list(segment.allowed_contacts)


def test_changes_of_the_scene_are_data_in_the_order_of_time(found: Report) -> None:
    """In the example's order; and each is in force from the end of the segment that it names."""
    for solution in found["runs"][0]["solutions"]:
        motion = solution["motion"]
        kinds = ["permit", "permit", "attach", "forbid", "permit", "detach", "forbid"]
        assert [each["change"] for each in motion["changes"]] == kinds
        taken, let_go = (
            next(c for c in motion["changes"] if c["change"] == kind) for kind in ("attach", "detach")
        )
        assert (taken["object"], taken["to"], taken["stage"]) == ("object", "arm.tool0", "pick/attach")
        assert (let_go["object"], let_go["of"], let_go["stage"]) == ("object", "arm", "place/detach")
        for change in motion["changes"]:
            segment = motion["segments"][change["segment"]]
            assert change["time"] == segment["times"][-1]
        assert motion["segments"][taken["segment"]]["attach"] and motion["segments"][let_go["segment"]]["detach"]


def test_contacts_of_a_segment_are_those_that_changes_before_it_have_permitted(found: Report) -> None:
    motion = found["runs"][0]["solutions"][0]["motion"]
    for number, segment in enumerate(motion["segments"]):
        permitted: set[tuple[str, ...]] = set()
        for change in motion["changes"]:
            if change["segment"] is None or change["segment"] < number:
                pairs = {tuple(pair) for pair in change.get("pairs", [])}
                permitted = permitted | pairs if change["change"] == "permit" else permitted - pairs
        assert {tuple(pair) for pair in segment["allowed_contacts"]} <= permitted


def test_padding_is_told_when_it_is_added_and_when_it_is_gone() -> None:
    folder = EXAMPLE.parent / "retract_transit_approach"
    scene = load_scene(load_scene_description(folder / "scene.yaml"))
    made = report(plan_file(load_task_file(folder / "task.yaml"), {}, scene, PlanningOptions(1)), scene=scene)
    changes = made["runs"][0]["solutions"][0]["motion"]["changes"]
    padded = [each for each in changes if each["change"] in ("pad", "unpad")]
    assert [each["change"] for each in padded] == ["pad", "unpad"]
    assert padded[0]["body"]["parent"] == padded[1]["object"]
    assert padded[0]["time"] < padded[1]["time"] and list(padded[0]["body"]["shape"]) == ["cylinder"]


def test_reports_of_the_first_format_are_read(found: Report) -> None:
    old = json.loads(report_bytes(found))
    old["format"] = "kabo-task/1"
    for solution in old["runs"][0]["solutions"]:
        motion = solution.pop("motion")
        del motion["changes"]
        for segment in motion["segments"]:
            segment.pop("allowed_contacts"), segment.pop("constraint"), segment.pop("trajectory", None)
        solution["film"] = motion
    read = read_report(json.dumps(old).encode(), "old.json")
    assert read["format"] == "kabo-task/2"
    assert read["runs"][0]["solutions"][0]["motion"]["changes"] == []


def test_a_failed_retreat_is_shown_with_the_object_put_down(found: Report) -> None:
    (first, *_) = found["runs"][0]["stages"]["place/retreat"]["refusals"]
    state = first["sample"]["state"]
    assert state["objects"]["object"]["parent"] == "world"
    assert set(state["robots"]) == {"arm"} and len(state["robots"]["arm"]["joints"]) == 8  # noqa: PLR2004


def test_reports_with_motions_are_read_again_and_are_the_same_bytes(found: Report) -> None:
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
