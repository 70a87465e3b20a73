"""Tasks that callers in Python plan from files, and their reports."""

import re
from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.tasks import InitialisationError, Task
from kabo.tasks.files import load_task_file
from kabo.tasks.files.describing import describe_report
from kabo.tasks.files.report_form import read_report, report_bytes
from kabo.tasks.robots import CurrentState, MoveTo

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pick_and_place"


def test_a_task_is_planned_in_the_scene_of_a_file_and_its_report_is_shown_and_saved(tmp_path, capsys):
    report = kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1)
    assert repr(report).startswith("<TaskReport pick and place: 1 solution, the best costs ")
    assert len(report.solutions) == 1
    report.print()
    assert "grasp pose IK" in capsys.readouterr().out
    report.save(tmp_path / "report.json")
    saved = (tmp_path / "report.json").read_bytes()
    assert saved == report_bytes(report.content) == report_bytes(read_report(saved, "report.json"))
    assert "1 solution" in report._repr_html_()


def test_a_task_of_robots_without_a_scene_is_refused_with_the_remedy():
    with pytest.raises(InputError, match="needs a scene") as refused:
        kabo.plan_task(EXAMPLE / "task.yaml")
    assert refused.value.diagnostics[0].hint == "give `scene`"


def test_things_that_the_scene_does_not_have_are_refused_by_name():
    with pytest.raises(InputError, match="amr, which is no robot of the scene"):
        kabo.plan_task(EXAMPLE / "task.yaml", kabo.load_scene(EXAMPLE / "scene.yaml"), {"robot": "amr"})
    for many in (["object"], {"object": 1}):
        with pytest.raises(InputError, match="which is no body of the scene"):
            kabo.plan_task("pick", EXAMPLE / "scene.yaml", {"robot": "arm", "object": many})


def test_a_task_built_in_python_is_planned_as_one_of_a_file():
    task = Task("up", CurrentState("now"), MoveTo("up", goal={"joint_1": 0.4}), robot="arm", seed=3)
    report = kabo.plan_task(task, EXAMPLE / "scene.yaml", max_solutions=1)
    assert repr(report) == "<TaskReport up: 1 solution, the best costs 0.4>"
    assert report.content["file"] is None and report.runs[0].seed == 3  # noqa: PLR2004
    assert kabo.verify(report.scene, kabo.task_plan(report)).ok


def test_faults_of_a_task_built_in_python_are_told_by_stage():
    task = Task("up", CurrentState("now"), MoveTo("up", goal="home"), robot="ram")
    with pytest.raises(InitialisationError, match="ram"):
        kabo.plan_task(task, EXAMPLE / "scene.yaml", max_solutions=1)
    with pytest.raises(InputError, match="needs a scene"):
        kabo.plan_task(task)


def test_a_name_takes_the_task_of_the_library():
    assert load_task_file("pick").name == "pick"
    with pytest.raises(InputError, match="pik"):
        load_task_file("pik")


def test_a_clearance_that_cannot_be_had_is_told_with_the_pair_and_how_much_there_is():
    report = kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=1, clearance=0.05)
    why = report.content["runs"][0]["explanation"]
    (told,) = why["examples"]
    found = re.fullmatch(r"arm\.link_5 and arm\.link_7 are ([\d.]+) mm apart, but 50 mm are to be kept", told)
    assert found is not None, told
    assert 10.0 < float(found[1]) < 50.0  # noqa: PLR2004
    assert told in describe_report(report.content)


def test_a_collision_that_no_clearance_decides_is_told_by_its_pair_alone():
    """Else a smaller clearance would seem to help."""
    task = Task("down", CurrentState("now"), MoveTo("down", goal={"joint_2": 2.0}), robot="arm")
    report = kabo.plan_task(task, EXAMPLE / "scene.yaml", max_solutions=1, clearance=0.002)
    why = report.content["runs"][0]["explanation"]
    assert why["examples"] and not any("to be kept" in told for told in why["examples"]), why
