"""docs/how-to/exploration.md is true: its files are read, its commands and programs run in the order of the page."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from kabo.exploration import load_exploration
from kabo.language.yaml.exploration_file import EXPLORATION_KEYS

REPOSITORY = Path(__file__).parents[2]
PAGE = (REPOSITORY / "docs" / "how-to" / "exploration.md").read_text()

pytestmark = pytest.mark.xdist_group("exploration page")


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the files of the page."""
    folder = tmp_path_factory.mktemp("exploration")
    throws, _, _, stages, _ = blocks("python")
    (folder / "throw.py").write_text(f"{throws}\n{stages}")
    throw, task = blocks("yaml")
    (folder / "throw.yaml").write_text(throw)
    (folder / "throw_far.yaml").write_text(task)
    return folder


def run(command: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Runs a command line of the page in a folder."""
    arguments = shlex.split(command, comments=True)
    if arguments[0] == "kabo":
        arguments = [sys.executable, "-m", "kabo.cli", *arguments[1:]]
    done = subprocess.run(
        arguments, cwd=folder, capture_output=True, text=True, timeout=120,
        check=False,
    )  # fmt: skip
    assert "Traceback" not in done.stderr, done.stderr
    return done


def program(number: int, folder: Path) -> str:
    """What a Python block of the page prints."""
    (folder / f"program{number}.py").write_text(blocks("python")[number])
    done = run(f"{shlex.quote(sys.executable)} program{number}.py", folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_page_names_every_key_of_exploration_files():
    assert {key for key in EXPLORATION_KEYS if f"| `{key}` |" not in PAGE} == set()


def test_the_ball_is_explored_asked_for_and_thrown_by_a_task_as_the_page_says(folder):
    install, *commands = blocks("sh")[0].splitlines()
    assert install == 'pip install "kabo[explore]"'
    done = [run(command, folder) for command in [*commands, *blocks("sh")[1].splitlines()]]
    assert [each.returncode for each in done] == [0, 0, 0, 4], [each.stderr for each in done]
    first = load_exploration(folder / "throws.jsonl").trials[:3]
    assert [each.reason for each in first] == ["hits_fence", "hits_fence", ""]
    assert "distance 4" in done[2].stdout or "distance 3.9" in done[2].stdout
    assert "distance 9 cannot be had: the nearest is distance" in done[3].stderr

    said = program(1, folder)
    assert said.splitlines()[-1].startswith("out_of_range Inferred(")

    planned = run(blocks("sh")[3], folder)
    assert planned.returncode == 0 and "throw far: 1 solution" in planned.stdout, planned.stderr


def test_a_robot_asks_and_tells(folder):
    commands = blocks("sh")[2].splitlines()
    done = [run(command, folder) for command in commands]
    assert [each.returncode for each in done] == [0, 0, 0, 0], [each.stderr for each in done]
    assert program(2, folder) == ""
    assert len(load_exploration(folder / "real.jsonl").trials) == 40


def test_a_line_is_fitted_to_contacts(folder):
    assert "[ True  True  True False]" in program(4, folder)
