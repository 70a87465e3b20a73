"""Tasks that callers in Python plan from files, and their reports."""

from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.tasks.files.report_form import read_report, report_bytes

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
