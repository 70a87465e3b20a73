"""The example of docs/how-to/explain.md, run as it stands there."""

import re
import shutil
from pathlib import Path

import pytest

import kabo
from kabo.cli import main

REPOSITORY = Path(__file__).parents[2]
BLOCKS = re.findall(
    r"^```(\w*)\n(.*?)^```", (REPOSITORY / "docs" / "how-to" / "explain.md").read_text(), re.M | re.S
)
PROBLEM = next(text for kind, text in BLOCKS if kind == "yaml")
SOLVED, EXPLAINED = (text for kind, text in BLOCKS if not kind)


@pytest.fixture
def problem(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The example's file beside the domain that it names."""
    folder = tmp_path / "domains" / "stacked"
    shutil.copytree(REPOSITORY / "domains" / "stacked", folder)
    (tmp_path / "meshes").symlink_to(REPOSITORY / "meshes")
    (folder / "shelf.yaml").write_text(PROBLEM)
    monkeypatch.chdir(tmp_path)
    return folder / "shelf.yaml"


def test_the_report_of_the_page_is_what_is_printed(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["explain", str(problem), "--max-samples", "2000", "--timeout", "600"]) == 4
    assert capsys.readouterr().out == EXPLAINED


def test_the_lines_of_solve_are_what_is_told(problem: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["solve", str(problem), "--max-samples", "2000"]) == 4
    assert re.sub(r"\d+", "N", capsys.readouterr().err) == re.sub(r"\d+", "N", SOLVED)


def test_who_waits_is_told_what_is_refused_most_and_by_what(
    problem: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("kabo.planner.run.COUNTED_EVERY_S", 0.0)
    told: list[str] = []
    kabo.solve(
        kabo.load_problem(problem), max_samples=2000, progress=lambda progress: told.append(progress.refused)
    )
    assert re.fullmatch(r"restack\(mobile, o1, stack_1\) refused \d+ times, mostly by board", told[-1])
