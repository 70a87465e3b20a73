"""Reports of runs: complete, readable again, told as text and as a page, and compared."""

import json
import math
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from kabo.errors import InputError
from kabo.tasks.core import Fallbacks, Result, Task
from kabo.tasks.files import load_task_file
from kabo.tasks.files.changes import changes
from kabo.tasks.files.comparing import compare, describe_comparison
from kabo.tasks.files.describing import describe_report, explain
from kabo.tasks.files.report_form import MAX_REPORTED, Report, read_report, report_bytes, schema
from kabo.tasks.files.reports import named_stages, plain, report
from kabo.tasks.files.running import PlanningOptions, TaskRun, plan_file
from tests.tasks.files.conftest import Points, Start, Step, Way, write

SCHEMA = Path(__file__).parents[3] / "kabo" / "plan" / "schemas" / "kabo-task-2.schema.json"


def made(folder: Path, target: list[float], **settings: Any) -> Report:
    """The report of the small task."""
    file = load_task_file(write(folder))
    arguments = {"target": target}
    runs = plan_file(file, arguments, None, PlanningOptions(**settings))
    return report(runs, file="task.yaml", arguments=arguments)


@pytest.fixture(autouse=True)
def start_at_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a scene file the first scene is nothing; these stages want a number."""
    monkeypatch.setattr(Start, "generate", lambda self, scene, properties, seed: [Result(0.0)])


def test_a_report_tells_structure_solutions_failures_and_when_they_came(tmp_path: Path) -> None:
    found = made(tmp_path, [3, -1, 60, 2])
    (run,) = found["runs"]
    assert [(stage["path"], stage["arrows"], stage["depth"]) for stage in found["stages"][:4]] == [
        ("line", "← →", 0), ("start", "← →", 1), ("go", "→ ←", 1), ("grasp", "← →", 1),
    ]  # fmt: skip
    assert [part["stage"] for part in run["solutions"][0]["parts"]] == [
        "start", "go", "grasp/approach", "grasp/low enough", "grasp/lift",
    ]  # fmt: skip
    assert sum(part["cost"] for part in run["solutions"][0]["parts"]) == run["solutions"][0]["cost"]
    assert run["exhausted"] and not run["stopped"] and run["explanation"] is None
    assert len(run["found"]) == len(run["solutions"]) == 2
    low = run["stages"]["grasp/low enough"]
    assert low["failures"] == {"too_high": 1}
    assert [each["comment"] for each in low["refusals"]] == ["60 is above 40"]
    pose = run["stages"]["grasp/low enough/pose"]
    assert (pose["successes"], pose["failures"], pose["costs"]) == (3, {"below_zero": 1}, [0.3, 6.0, 0.2])
    assert run["stages"]["grasp/lift"]["solutions"][0]["changes"] == ["3 → 3.25"]


def test_a_report_is_read_again_as_it_was_written(tmp_path: Path) -> None:
    found = made(tmp_path, [3, -1], repeat=2)
    assert read_report(report_bytes(found), "r.json") == found
    jsonschema.validate(json.loads(report_bytes(found)), json.loads(SCHEMA.read_text()))


def test_the_schema_is_that_of_the_code() -> None:
    assert json.loads(SCHEMA.read_text()) == schema()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "this is no JSON"),
        (b"[1]", "this is no report of planning: Expected `object`, got `array`"),
        (b"{}", "this is no report of planning: Object missing required field `format`"),
        (b'{"format": "kabo-plan/1"}', "this is no report of planning: it is a plan"),
        (b"1e999", "this is no report of planning: Number out of range"),
        (
            b'{"certificate": "' + b"a" * 300 + b'", "format": "kabo-plan/2"}',
            "this is no report of planning: it is a plan",
        ),
        (b'{"format": "kabo-state/1"}', "this is no report of planning: it is the state of a run"),
        (b'{"format": "kabo-trees/1"}', "this is no report of planning: format: Invalid enum value"),
        (b"\xff", "this is no JSON"),
        (b"[" * 100_000, "this is no"),
    ],
)
def test_what_is_no_report_is_told(content: bytes, message: str) -> None:
    with pytest.raises(InputError) as told:
        read_report(content, "r.json")
    assert told.value.diagnostics[0].message.startswith(message)


def test_a_report_that_ends_too_early_is_told_with_the_place(tmp_path: Path) -> None:
    whole = report_bytes(made(tmp_path, [3]))
    lines = whole.splitlines(keepends=True)[:7]
    with pytest.raises(InputError) as told:
        read_report(b"".join(lines), "r.json")
    assert told.value.diagnostics[0].line in (len(lines), len(lines) + 1)


@pytest.mark.parametrize("clearance", [-0.001, 0.31, "3mm", None])
def test_a_clearance_that_is_none_is_told(tmp_path: Path, clearance: Any) -> None:
    content = json.loads(report_bytes(made(tmp_path, [3]))) | {"clearance": clearance}
    with pytest.raises(InputError) as told:
        read_report(json.dumps(content).encode(), "r.json")
    assert told.value.diagnostics[0].message.startswith(
        "this is no report of planning: clearance: Expected `float`"
    )


def test_a_report_with_a_missing_stage_or_run_is_told(tmp_path: Path) -> None:
    found = made(tmp_path, [3])
    del found["runs"][0]["stages"]["go"]
    with pytest.raises(InputError, match=r"runs\[0\].stages are not those of the task"):
        read_report(report_bytes(found), "r.json")
    with pytest.raises(InputError, match="it has no run"):
        read_report(report_bytes({**found, "runs": []}), "r.json")


def test_stages_of_the_same_name_are_told_apart() -> None:
    task = Task(
        "t", Start("a"), Step("s", by=1), Step("s", by=2), Fallbacks("f", Step("s", by=3), Step("s", by=4))
    )
    assert [path for path, _ in named_stages(task)] == ["t", "a", "s", "s#2", "f", "f/s", "f/s#2"]
    task.plan(0.0)
    found = report([TaskRun(task, 0, 0.0)])
    figures = found["runs"][0]["stages"]
    assert [figures[path]["costs"] for path in ("s", "s#2", "f/s", "f/s#2")] == [[1.0], [2.0], [3.0], []]


def test_a_name_with_a_line_break_stays_in_its_line() -> None:
    task = Task("t\n", Start("a\nb\x1b[1m é"))
    task.plan(0.0)
    lines = describe_report(report([TaskRun(task, 0, 0.0)])).splitlines()
    assert lines[0].startswith("t\\n: ") and "  ← →  a\\nb\\x1b[1m é  [Start]" in lines[3], lines


def test_of_too_many_solutions_the_cheapest_is_in_the_report() -> None:
    points = [*range(1, 150), 0]
    task = Task("t", Start("a"), Way("w", reach=1e3), Points("p", points=points))
    task.plan(0.0)
    (run,) = report([TaskRun(task, 0, 0.0)])["runs"]
    costs = [solution["cost"] for solution in run["solutions"]]
    assert len(costs) == MAX_REPORTED < len(task.solutions) == len(points)
    assert costs[:-1] == [solution.cost for solution in task.solutions[: MAX_REPORTED - 1]]
    assert costs[-1] == 0.0 == min(solution.cost for solution in task.solutions)


def test_the_text_says_why_there_is_no_solution(tmp_path: Path) -> None:
    found = made(tmp_path, [60, 70, -1])
    text = describe_report(found)
    assert "line: no solutions" in text
    assert 'the stage "grasp/low enough" never succeeds' in text
    assert "    2 × too high" in text and "60 is above 40" in text
    assert "below zero 1" in text and "- below_zero: place -1 is below zero" in text


def test_pairs_that_never_fit_are_told_with_their_reason() -> None:
    task = Task("t", Start("a"), Way("w", reach=1.0), Points("p", points=[5, 6, 7]))
    task.plan(0.0)
    (run,) = report([TaskRun(task, 0, 0.0)])["runs"]
    assert run["explanation"] is not None and run["explanation"]["stage"] == "w"
    assert run["explanation"]["mismatches"] == {"too far apart": 3}
    assert explain(run["explanation"]).splitlines()[1:] == [
        "  pairs of states that it can never join:", "        3 × too far apart",
    ]  # fmt: skip


def test_figures_that_differ_are_found_and_equal_ones_are_not(tmp_path: Path) -> None:
    first, second = made(tmp_path, [3, -1], repeat=12), made(tmp_path, [3, 4, 60], repeat=12)
    found = compare(first, second)
    successes = found["stages"]["grasp/low enough"]["successes"]
    assert successes["means"] == [1.0, 2.0] and (successes["adjusted"] or 1) < 0.01
    same = compare(first, first)
    assert all(each["p"] in (1.0, None) for figures in same["stages"].values() for each in figures.values())
    assert "grasp/low enough" in describe_comparison(found) and "*" in describe_comparison(found)
    assert json.loads(json.dumps(found)) == found


def test_u_and_p_are_those_of_the_textbook() -> None:
    """Mann and Whitney's own small case: 5 above 5, no ties: U = 0, two-sided exact p = 2 / C(10, 5)."""
    from kabo.tasks.files.comparing import _compared

    found = _compared([1, 2, 3, 4, 5], [6, 7, 8, 9, 10])
    assert found["u"] == 0.0 and found["p"] == pytest.approx(2 / math.comb(10, 5))


def test_many_tests_are_corrected_as_holm_has_it() -> None:
    from kabo.tasks.files.comparing import FigureComparison, _adjust

    tests: list[FigureComparison] = [
        {"samples": [1, 1], "means": [0.0, 0.0], "u": 0.0, "p": p, "adjusted": None}
        for p in (0.01, 0.04, None, 0.03)
    ]
    _adjust(tests)
    assert [each["adjusted"] for each in tests] == pytest.approx([0.03, 0.06, None, 0.06])


def test_stages_that_only_one_report_has_are_named(tmp_path: Path) -> None:
    first = made(tmp_path, [3])
    second = report([TaskRun(Task("line", Start("start")), 0, 0.0)])
    found = compare(first, second)
    assert found["only"][0][0] == "go" and found["only"][1] == []
    assert "only in the first: go" in describe_comparison(found)


def test_planning_stops_when_time_is_up_and_says_so(tmp_path: Path) -> None:
    found = made(tmp_path, [3, 4], timeout=1e-9)
    assert found["runs"][0]["stopped"] and found["runs"][0]["found"] == []


def test_values_become_json() -> None:
    assert plain({"a": (1, math.inf, None), "b": {2: print}}) == {"a": [1, "inf", None], "b": {"2": str(print)}}


def test_changes_of_robot_scenes_are_told_in_words() -> None:
    class Scene:
        def __init__(
            self, q: float, parent: str, permitted: frozenset[frozenset[str]], extras: tuple[Any, ...]
        ) -> None:
            attachment = type("A", (), {"parent": parent, "position": (0.0, q, 0.0)})()
            self.situation = type("S", (), {"robots": {"left": ((0.0, q),)}, "objects": {"cup": (attachment,)}})()
            self.permitted, self.extras = permitted, extras

    pad = type("E", (), {"name": "pad"})()
    before = Scene(0.0, "world", frozenset(), ())
    after = Scene(1.0, "left.tool", frozenset([frozenset(["cup", "table"])]), (pad,))
    assert list(changes(before, after)) == [
        "left moves, joint 2 most: 0.000 → 1.000",
        "cup: from world to left.tool",
        "cup and table may touch",
        "pad is added",
    ]
    assert list(changes(after, before))[2:] == ["cup and table must not touch any more", "pad is removed"]
    assert list(changes(before, Scene(0.5, "world", frozenset(), ())))[1] == "cup is at (0.000, 0.500, 0.000)"
