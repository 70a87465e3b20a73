"""Explanations that are cut off keep what is known: what the start shows, refusals with their numbers, what is not done."""

import argparse
import json
import os
import signal
import sys
import time
from itertools import count
from pathlib import Path

import jsonschema
import pytest

import kabo.explain.geometry  # noqa: F401 - a name of the façade hides it
from kabo.cli.explain import add_arguments
from kabo.cli.terminal import interruptible
from kabo.cli.waiting.watch import limited
from kabo.explain.explain import Explanation, explain, explanation_to_json
from kabo.language import load_problem
from kabo.plan import schema
from kabo.planner.solve import solve
from tests.planner.gantry import gantry

SCHEMA = schema("kabo-explain-1")
LID = {"lid": ((0.2, 0.2, 0.01), (0.2, 0.0, 0.1))}
TOO_FAR = {"cube": (0.9, 0.0, 0.02)}  # the gantry's tool reaches 0.5 m
HANGING = {"cube": (0.2, 0.0, 0.07)}


@pytest.fixture(autouse=True)
def _told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["kabo.explain.geometry"], "TOLD_EVERY_S", 0.02)


class Interrupted:
    """Somebody who presses Ctrl-C once something is known that they wait for."""

    def __init__(self, awaited: str) -> None:
        self.awaited, self.last = awaited, Explanation("exhausted", ("nothing yet",))

    def know(self, found: Explanation) -> None:
        """Notes what is known."""
        jsonschema.validate(explanation_to_json(found), SCHEMA)
        self.last = found

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed."""
        return self.awaited in str(self.last)


def interrupted(path: Path, awaited: str) -> Explanation:
    stop = Interrupted(awaited)
    found = explain(load_problem(path), cancelled=stop, known=stop.know, max_samples=4000, timeout=300.0)
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    return found


def test_refusals_are_kept_with_what_blocked_them_if_no_call_could_be_repeated(tmp_path: Path) -> None:
    found = interrupted(gantry(tmp_path, walls=LID), "Procedures that failed")
    assert found.verdict == "exhausted"
    assert found.summary[0] == "No plan was found so far: pick(gantry, cube) never succeeded."
    assert found.summary[1].startswith("It was blocked by lid in ") and not found.findings[0].repeated
    assert any("pick(gantry, cube)" in clause for clause in found.unfinished)
    assert "Not finished:" in str(found)


def test_numbers_are_kept_and_where_the_base_would_do(tmp_path: Path) -> None:
    found = interrupted(gantry(tmp_path, things=TOO_FAR), "Procedures that failed")
    (finding,) = (each for each in found.findings if each.call.procedure == "pick")
    assert finding.missing is not None and abs(finding.missing - 0.4) < 0.002
    assert "x of gantry would have to be at 900 mm, its limits are -500 mm to 500 mm" in found.summary[1]


def test_what_the_start_shows_is_kept_from_the_first_moment(tmp_path: Path) -> None:
    found = interrupted(gantry(tmp_path, walls=LID, things=HANGING), "hangs in the air")
    assert any("cube hangs in the air at the start: 50 mm above table" in said for said in found.start)
    assert "looking for motions" in found.unfinished


def test_a_solve_that_is_out_of_time_says_what_the_start_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("kabo.planner.telling.LOOKED_AFTER_S", 0.0)
    asked = count()
    found = solve(load_problem(gantry(tmp_path, walls=LID, things=HANGING)), cancelled=lambda: next(asked) > 100)
    assert found.status == "exhausted" and found.reason is not None
    assert found.reason.details[0] == "cube hangs in the air at the start: 50 mm above table"


def test_changes_that_were_not_tried_are_named(tmp_path: Path) -> None:
    found = interrupted(gantry(tmp_path, walls=LID), "what one change would do: without lid")
    assert found.findings[0].repeated and not found.counterfactuals
    assert found.unfinished == ("what one change would do: without lid",)


def test_what_is_finished_says_nothing_of_what_is_not(tmp_path: Path) -> None:
    found = explain(load_problem(gantry(tmp_path, walls=LID)), max_samples=2000, timeout=300.0)
    assert found.unfinished == () and "Not finished" not in str(found)


@pytest.mark.parametrize("form", ["--json", "text"])
def test_an_explanation_that_is_ended_by_force_is_printed_as_far_as_it_is_known(
    form: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The work never looks at a flag again once it has told what it knows."""
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    path = gantry(tmp_path, walls=LID)
    options = parser.parse_args([str(path), *([form] if form == "--json" else [])])
    options.needs_kernels = None

    def work(given: argparse.Namespace) -> int:
        def know(found: Explanation) -> None:
            given.surrounding.on_known(explanation_to_json(found), str(found))
            if found.findings:
                os.kill(os.getppid(), signal.SIGINT)
                time.sleep(600.0)

        with interruptible():
            explain(load_problem(path), known=know, max_samples=2000)
        return 0

    assert limited(options, work) == 4
    said = capfd.readouterr().out
    if form == "--json":
        body = json.loads(said)
        jsonschema.validate(body, SCHEMA)
        assert body["procedures"][0]["failures"][0]["between"][1] == "lid"
        assert body["unfinished"][-1].startswith("cut off while ")
    else:
        assert "It was blocked by lid in " in said
        assert said.strip().splitlines()[-1].startswith("  - cut off while ")
