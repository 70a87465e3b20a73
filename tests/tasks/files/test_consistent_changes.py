"""Reports whose changes of the scene say something else than the segments of their motion are refused."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.requests import verify_task_report
from kabo.tasks import TaskReport
from kabo.tasks.files.report_form import report_bytes

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"


@pytest.fixture(scope="module")
def report() -> TaskReport:
    return kabo.plan_task(EXAMPLE / "task.yaml", EXAMPLE / "scene.yaml", max_solutions=2)


@pytest.mark.parametrize(
    ("kind", "spoilt", "told"),
    [
        ("attach", {"object": "table"}, "segment 2 attaches table to arm.tool0, as its changes say, but not the segment"),
        ("attach", {"to": "arm.link_7"}, "segment 2 attaches object to arm.link_7, as its changes say, but not"),
        ("attach", {"segment": 3, "time": None}, "segment 2 attaches object to arm.tool0, as the segment says, but not"),
        ("detach", {"of": "nobody"}, "segment 6 lets object go from nobody, as its changes say, but not"),
        ("detach", {"time": 0.5}, "detach has the time 0.500 s, but segment 6 ends at "),
    ],
)  # fmt: skip
def test_changes_that_say_something_else_than_the_segments_are_told(report: TaskReport, kind, spoilt, told):
    """A program may carry out the changes, and what is verified are the segments."""
    content = deepcopy(report.content)
    motion = content["runs"][0]["solutions"][0]["motion"]
    change = next(each for each in motion["changes"] if each["change"] == kind)
    change.update(spoilt)
    if change["time"] is None:
        change["time"] = motion["segments"][change["segment"]]["times"][-1]
    with pytest.raises(InputError) as refused:
        kabo.task_plan(replace(report, content=content), 1)
    assert told in str(refused.value)


def test_a_report_whose_segments_alone_are_verified_is_no_verified_report(report: TaskReport, tmp_path: Path):
    content = deepcopy(report.content)
    changes = content["runs"][0]["solutions"][0]["motion"]["changes"]
    next(each for each in changes if each["change"] == "attach")["to"] = "arm.link_7"
    (tmp_path / "r.json").write_bytes(report_bytes(content))
    with pytest.raises(InputError, match="segment 2 attaches object to arm.link_7, as its changes say"):
        list(verify_task_report(EXAMPLE / "scene.yaml", tmp_path / "r.json", 1))
