"""The page of a task's report in a real browser: films end where the report says, failures are shown where they are."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kabo.cli.main import main
from kabo.tasks.core import Result, Task, forward
from kabo.tasks.files.report_form import report_bytes
from kabo.tasks.files.reports import report as made_report
from kabo.tasks.files.running import TaskRun

EXAMPLE = Path(__file__).parents[3] / "examples" / "pick_and_place"
SAME_M = 1e-6


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of two solutions, with failures beside them."""
    path = tmp_path_factory.mktemp("report") / "report.json"
    given = ["task", "plan", str(EXAMPLE / "task.yaml"), "--scene", str(EXAMPLE / "scene.yaml")]
    assert main([*given, "--max-solutions", "2", "-o", str(path)]) == 0
    return path


@pytest.fixture
def shown(report: Path, open_page: Callable[..., Any]) -> Any:
    page = report.with_suffix(".html")
    if not page.exists():
        assert main(["view", str(report), "-o", str(page), "--no-open"]) == 0
    return open_page(page)


def test_every_film_ends_where_the_report_says(report: Path, shown: Any) -> None:
    solutions = json.loads(report.read_text())["runs"][0]["solutions"]
    assert len(solutions) == 2  # noqa: PLR2004
    for number, solution in enumerate(solutions):
        shown.page.select_option("select[aria-label=Solution]", str(number))
        shown.run("kabo.player.scrub(kabo.player.film.duration)")
        wanted = solution["motion"]["after"]["objects"]["object"]["position"]
        pose = shown.run("Array.from(kabo.stage.poseOf('object'))")
        assert np.allclose([pose[3], pose[7], pose[11]], wanted, atol=SAME_M)
    shown.require_clean()


def test_a_held_object_moves_with_the_hand_and_a_part_is_reached_by_its_button(shown: Any) -> None:
    lift = shown.page.locator("tr", has_text="pick/lift").get_by_role("button")
    lift.click()
    held = "JSON.stringify(kabo.stage.stateNow().objects.object.parent)"
    assert shown.run(held) == '"arm.tool0"'
    before = shown.run("kabo.stage.poseOf('object')[11]")
    shown.page.get_by_role("button", name="next part (right)").click()
    assert shown.run("kabo.stage.poseOf('object')[11]") > before + 0.005
    assert shown.page.locator(".doing").inner_text() == "move to place"
    shown.require_clean()


def test_a_failure_is_shown_at_its_pose_and_the_film_is_left(report: Path, shown: Any) -> None:
    stages = json.loads(report.read_text())["runs"][0]["stages"]
    path, figures = next(
        (path, each)
        for path, each in stages.items()
        if any("robots" in r["sample"]["state"] for r in each["refusals"])
    )
    shown.page.get_by_role("button", name=path, exact=True).click()
    button = shown.page.locator("button.sample[aria-pressed=true]")
    assert button.count() == 1 and "show failure 1" in button.get_attribute("aria-label")
    (robot,) = figures["refusals"][0]["sample"]["state"]["robots"].items()
    assert shown.run(f"kabo.stage.stateNow().robots['{robot[0]}']") == robot[1]["joints"]
    shown.page.get_by_role("button", name="next part (right)").click()
    assert shown.page.locator("button.sample[aria-pressed=true]").count() == 0
    shown.require_clean()


def test_nothing_serious_is_wrong_for_those_who_do_not_see_well(shown: Any) -> None:
    shown.page.locator("summary").evaluate_all("all => all.forEach(each => { each.parentElement.open = true; })")
    shown.require_accessible()


def test_comments_are_never_markup(tmp_path: Path, report: Path, open_page: Callable[..., Any]) -> None:
    content = json.loads(report.read_text())
    hostile = "<img src=x onerror=alert(1)></script>"
    content["task"], content["runs"][0]["solutions"][0]["comment"] = hostile, hostile
    (tmp_path / "hostile.json").write_text(json.dumps(content))
    assert main(["view", str(tmp_path / "hostile.json"), "-o", str(tmp_path / "h.html"), "--no-open"]) == 0
    shown = open_page(tmp_path / "h.html")
    assert shown.page.locator("img").count() == 0 and hostile in shown.page.locator("h1").inner_text()
    shown.require_clean()


def test_a_report_without_a_scene_is_a_page_without_a_stage(tmp_path: Path, open_page: Callable[..., Any]) -> None:
    task = Task("small", forward()(lambda scene, properties, seed: Result(1))("step"))
    (tmp_path / "r.json").write_bytes(report_bytes(made_report([TaskRun(task, 0, 0.1)])))
    assert main(["task", "show", str(tmp_path / "r.json"), "--html", str(tmp_path / "r.html")]) == 0
    shown = open_page(tmp_path / "r.html")
    assert shown.run("kabo.stage") is None and "step" in shown.page.locator("#panel-report").inner_text()
    shown.require_clean()
