"""docs/reference/tasks.md is true: its files are read, its commands run, and names every key, stage, type and cost term."""

import json
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from kabo.language.task_description import KINDS
from kabo.language.yaml.task_file import INPUT_KEYS, STAGE_KEYS, TASK_KEYS
from kabo.tasks.files import costs, registry

REPOSITORY = Path(__file__).parents[2]
PAGE = (REPOSITORY / "docs" / "reference" / "tasks.md").read_text()

pytestmark = pytest.mark.xdist_group("tasks page")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize(
    "word",
    sorted({*TASK_KEYS, *STAGE_KEYS, *INPUT_KEYS, "only", "cost", *KINDS, *costs.names(), *registry._CONTAINERS,
            *registry._LEARNED, *registry._robot_names()}),
)  # fmt: skip
def test_the_page_names_every_key_type_stage_and_cost_term(word):
    assert f"`{word}`" in PAGE or f"{{{word}:" in PAGE


def test_every_stage_that_the_page_names_exists():
    table = PAGE.split("## Stages\n")[1].split("###")[0]
    named = set(re.findall(r"`([A-Z][A-Za-z]+)`", table))
    assert {name for name in named if registry.find(name) is None} == set()


def run(command, folder):
    """Runs a command line of the page in a folder."""
    arguments = shlex.split(command)
    if arguments[0] == "kabo":
        arguments = [sys.executable, "-m", "kabo.cli", *arguments[1:]]
    done = subprocess.run(
        arguments, cwd=folder, capture_output=True, text=True, timeout=120,
        check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    return done


def test_the_pages_example_is_planned_shown_and_compared_as_it_says(tmp_path):
    (tmp_path / "walk.yaml").write_text(blocks("yaml")[0])
    own, example = blocks("python")
    (tmp_path / "walk.py").write_text(own)
    commands = blocks("sh")[0].splitlines()
    done = [run(command, tmp_path) for command in commands]
    assert [each.returncode for each in done] == [0, 0, 4, 0, 0, 0]
    assert done[0].stdout.startswith("walk: 2 solutions, best cost 3,")
    refused = PAGE.split("is to blame")[1].split("```")[1].strip()
    assert refused in done[2].stdout
    assert (tmp_path / "report.html").read_text().startswith("<!DOCTYPE html>")
    assert json.loads((tmp_path / "report.json").read_text())["format"] == "kabo-task/2"
    assert re.search(r"^go$", done[5].stdout, re.MULTILINE) and "*" in done[5].stdout

    (tmp_path / "example.py").write_text(f"{own}\n{example}")
    said = run(f"{shlex.quote(sys.executable)} example.py", tmp_path)
    assert said.returncode == 0, said.stderr
    assert said.stdout.splitlines()[0] == "3.0 ['', '', 'point 3']"
