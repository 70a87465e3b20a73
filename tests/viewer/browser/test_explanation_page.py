"""The page of an explanation in a real browser: samples, the body in the way, what one change would do."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from kabo.cli.main import main
from tests.explain.infeasible import roof, too_far


def explained(folder: Path, problem: Path, capfd: pytest.CaptureFixture[str]) -> Path:
    """The explanation of a problem, as a file beside it."""
    capfd.readouterr()
    main(["explain", str(problem), "--max-samples", "500", "--json"])
    path = folder / "explanation.json"
    path.write_text(capfd.readouterr().out)
    return path


def page_of(explanation: Path) -> Path:
    page = explanation.with_suffix(".html")
    assert main(["view", str(explanation), "-o", str(page), "--no-open"]) == 0
    return page


def test_samples_are_shown_with_what_is_in_the_way(
    tmp_path: Path, open_page: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    explanation = explained(tmp_path, roof(tmp_path), capfd)
    samples = json.loads(explanation.read_text())["procedures"][0]["samples"]
    shown = open_page(page_of(explanation))
    assert "blocked by board" in shown.page.locator("#panel-explanation").inner_text()
    shown.require_accessible()
    buttons = shown.page.locator("details.call").first.locator("button.sample")
    assert buttons.count() == len(samples)
    for number, sample in enumerate(samples):
        buttons.nth(number).click()
        joints = sample["state"]["robots"]["mobile"]["joints"]
        now = shown.run("kabo.stage.stateNow().robots.mobile")
        assert {name: now[name] for name in joints} == joints
        assert sample["between"][1] == "board" and _colour(shown, "board") == "d0342c"
    shown.page.get_by_role("button", name="without board").click()
    assert shown.run("kabo.stage.overlays.has('change')") and _colour(shown, "board") == "2c9a4b"
    assert shown.run("kabo.stage.stateNow()") == shown.run("kabo.document.scene.start")
    shown.require_clean()


def test_a_base_that_would_have_to_move_is_drawn_where_it_would_stand(
    tmp_path: Path, open_page: Callable[..., Any], capfd: pytest.CaptureFixture[str]
) -> None:
    explanation = explained(tmp_path, too_far(tmp_path), capfd)
    moved = [
        each for each in json.loads(explanation.read_text())["counterfactuals"] if "move_base" in each["change"]
    ]
    assert moved, "something can be moved"
    shown = open_page(page_of(explanation))
    button = shown.page.get_by_role("button", name=moved[0]["said"])
    button.click()
    assert button.get_attribute("aria-pressed") == "true" and shown.run("kabo.stage.overlays.has('change')")
    button.click()
    assert not shown.run("kabo.stage.overlays.has('change')")
    shown.require_clean()


def _colour(shown: Any, name: str) -> str:
    script = "(name) => kabo.stage.things.get(name).layers.get('original').material.color.getHexString()"
    found: str = shown.run(script, name)
    return found
