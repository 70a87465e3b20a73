"""The page of a run in a browser: charts and decisions, the true state on the stage, and a log that grows."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import kabo
from kabo.execution import ExecutionSettings, KinematicRobot, execute
from kabo.viewer import RunFollower, ViewOptions, document_of_run, page_of
from tests.execution.test_executor import Pushed
from tests.viewer.browser.conftest import READY_MS, OpenPage

STACKED = Path(__file__).parents[3] / "domains" / "stacked" / "n2.yaml"

RECORDS: list[dict[str, Any]] = [
    {"time": 0.0, "event": "start", "problem": "p"},
    {"time": 0.0, "event": "node", "node": "n0", "kind": "action", "action": "go", "arguments": {"to": "b"}},
    {"time": 0.5, "event": "followed", "tracking": 0.001, "permitted": 0.01, "bodies": {"cup": 0.002}},
    {"time": 0.6, "event": "stopped", "node": "n0", "reason": "cup is elsewhere"},
]


def test_the_page_of_a_log_is_accessible_and_tells_the_reason(
    open_page: Callable[..., OpenPage], tmp_path: Path
) -> None:
    path = tmp_path / "run.html"
    path.write_bytes(page_of(document_of_run(RECORDS, "log.jsonl")))
    shown = open_page(path)
    assert "stopped at n0: cup is elsewhere" in shown.page.inner_text("#panel-run")
    assert "go(to=b)" in shown.page.inner_text("#panel-run [aria-label='decisions']")
    assert "at most 1 mm" in shown.run("document.querySelector('.run-chart').getAttribute('aria-label')")
    shown.require_accessible()
    shown.require_clean()


def test_a_log_that_grows_is_shown_as_it_grows(browser: Any, tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    follower = RunFollower(log, None, ViewOptions())
    try:
        page = browser.new_context().new_page()
        page.goto(follower.address)
        page.wait_for_selector("html[data-ready=yes]", state="attached", timeout=READY_MS)
        for count, text in ((2, "the run goes on"), (4, "stopped at n0")):
            log.write_text("".join(json.dumps(each) + "\n" for each in RECORDS[:count]))
            page.wait_for_selector(f"#panel-run .headline:has-text('{text}')", timeout=READY_MS)
        page.close()
    finally:
        follower.close()


def test_the_answer_to_a_surprise_is_told_with_its_kind_and_for_all_that_follows_it(
    open_page: Callable[..., OpenPage], tmp_path: Path
) -> None:
    path = tmp_path / "run.html"
    answered = {"time": 0.6, "event": "answer", "kind": "replan", "reason": "other actions are proven"}
    again = [{**each, "time": each["time"] + 1.0} for each in RECORDS[1:3]]
    path.write_bytes(page_of(document_of_run([*RECORDS[:3], answered, *again], "log.jsonl")))
    shown = open_page(path)
    decisions = shown.page.inner_text("[aria-label='decisions']")
    assert "replan: other actions are proven (from here on by a plan of its own" in decisions
    for time, told in ((0.3, False), (1.2, True)):
        shown.run(f"window.kabo.run.pick({time})")
        assert ("after replan at 0.60 s" in shown.page.inner_text("#panel-run .told")) == told
    shown.require_clean()


def test_where_the_plan_has_what_is_off_is_shown_beside_it_with_its_margin(
    open_page: Callable[..., OpenPage], tmp_path: Path
) -> None:
    problem, plan, path = kabo.load_problem(STACKED), tmp_path / "plan.json", tmp_path / "run.html"
    solved = kabo.solve(problem).plan
    assert solved is not None
    plan.write_bytes(kabo.plan_to_json(solved))
    scene = kabo.load_scene(STACKED)
    robot = KinematicRobot(scene)
    sensor = Pushed(robot, "o2", np.array([0.004, 0.0, 0.0]), 1.0)
    report = kabo.verify(problem, solved, scene=scene)
    run = execute(solved, scene, robot, sensor, report=report, settings=ExecutionSettings(log_rate=5.0))
    answered = [{"time": 1.5, "event": "answer", "kind": "replan", "reason": "for this test", "node": "n0"}]
    records = sorted(run.log.records + answered, key=lambda each: each["time"])
    path.write_bytes(page_of(document_of_run(records, "log.jsonl", plan, ViewOptions(problem=STACKED))))
    shown = open_page(path)
    for time, ghosts in ((0.5, 0), (1.4, 1), (2.5, 1)):
        shown.run(f"window.kabo.run.pick({time})")
        found = shown.run("(window.kabo.run.ghost.stage.overlays?.get('ghost')?.children ?? []).length")
        assert found == ghosts, f"at {time} s"
    table = shown.page.inner_text("[aria-label='margins of bodies']")
    assert "4 mm" in table and "o2" in table and "proven, any way" in table
    shown.require_accessible()
    shown.require_clean()
    older = [{key: value for key, value in each.items() if key not in ("planned", "margins")} for each in records]
    path.write_bytes(page_of(document_of_run(older, "log.jsonl", plan, ViewOptions(problem=STACKED))))
    shown = open_page(path)
    shown.run("window.kabo.run.pick(1.4)")
    shown.require_clean()
