"""What README says, run as a user runs it: new processes, `kabo` on the path, files where the user stands."""

import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from kabo.plan import load_plan, plan_statistics

REPOSITORY = Path(__file__).parents[2]
README = (REPOSITORY / "README.md").read_text()
SOLVE = "kabo solve domains/bartender/four_bottles.yaml -o plan.json"

pytestmark = pytest.mark.xdist_group("readme")


def blocks(language: str) -> list[str]:
    """The code blocks of README in a language."""
    return re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)


class Shell:
    """A folder in which commands of README are run; `kabo` there is the one that is tested."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        commands = folder / "bin"
        commands.mkdir()
        (commands / "kabo").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m kabo.cli "$@"\n')
        (commands / "kabo").chmod(0o755)
        for name in ("domains", "examples", "meshes", "tests"):
            (folder / name).symlink_to(REPOSITORY / name)
        self.environment = {**os.environ, "PATH": f"{commands}:{os.environ['PATH']}"}

    def run(self, command: str) -> subprocess.CompletedProcess[str]:
        """Runs a command line to its end."""
        return subprocess.run(
            command,
            shell=True,
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=300,
            check=False,
        )


@pytest.fixture(scope="module")
def shell(tmp_path_factory: pytest.TempPathFactory) -> Shell:
    """One folder for all commands: what one writes, the next may read."""
    return Shell(tmp_path_factory.mktemp("readme"))


@pytest.fixture(scope="module")
def solved(shell: Shell) -> subprocess.CompletedProcess[str]:
    """BARTENDER with four bottles, solved once."""
    return shell.run(SOLVE)


def test_the_first_two_commands_are_those_of_a_fresh_machine():
    assert blocks("sh")[0] == f"python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/{SOLVE}\n"
    assert blocks("sh")[1] == ".venv/bin/kabo view plan.json\n"
    assert "`.venv/bin/pip install '.[dev]' && .venv/bin/pytest`" in README


def test_the_plan_is_shown_as_one_page(shell, solved):
    done = shell.run("kabo view plan.json -o page.html --no-open")
    assert done.returncode == 0, done.stderr
    assert (shell.folder / "page.html").read_bytes().startswith(b"<!DOCTYPE html>")


def test_four_bottles_become_a_branched_plan_that_is_printed_and_verified(shell, solved):
    assert solved.returncode == 0, solved.stderr
    assert solved.stdout.count("\n") >= 20 and "\x1b" not in solved.stdout + solved.stderr
    assert plan_statistics(load_plan(shell.folder / "plan.json")).plan_leaves == 16
    verified = shell.run("kabo verify domains/bartender/four_bottles.yaml plan.json")
    assert verified.returncode == 0, verified.stderr
    assert "verified" in verified.stderr


def test_the_other_commands_do_what_they_say(shell):
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("kabo ")]
    rest = [line for line in lines if not re.match(r"kabo (solve|verify|serve|request)", line)]
    assert len(rest) >= 2
    for line in rest:
        done = shell.run(line)
        assert done.returncode == 0, f"{line}: {done.stderr}"


def test_the_plan_in_readme_is_the_one_that_kabo_prints(shell):
    done = shell.run("kabo solve tests/acceptance/parcels/one.yaml -o parcel.json")
    assert done.returncode == 0, done.stderr
    assert f"```\n{done.stdout}```" in README


@pytest.fixture
def server(shell: Shell) -> Iterator[str]:
    """`kabo serve` on an endpoint of its own: the default one may be in use."""
    from tests.service.conftest import free_endpoint

    endpoint = free_endpoint()
    with subprocess.Popen(
        ["kabo", "serve", "--listen", endpoint],
        cwd=shell.folder,
        env=shell.environment,
        stderr=subprocess.PIPE,
        text=True,
        executable=str(shell.folder / "bin" / "kabo"),
    ) as process:
        assert process.stderr is not None and any("is ready" in line for line in process.stderr)
        yield endpoint
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 0


def test_a_scene_is_solved_by_a_server_and_by_python_with_the_same_answer(shell, server):
    service = (REPOSITORY / "docs" / "reference" / "service.md").read_text()
    request = next(line for line in service.splitlines() if line.startswith("kabo request"))
    done = shell.run(f"{request} --connect {server} --seed 1")
    assert done.returncode == 0, done.stderr
    (program,) = blocks("python")
    (shell.folder / "program.py").write_text(
        program + "open('own.json', 'wb').write(kabo.plan_to_json(result.plan))\n"
    )
    ran = shell.run(f"{sys.executable} program.py")
    assert ran.returncode == 0, ran.stderr
    assert re.fullmatch(r"solved \d+\nTrue\n", ran.stdout)
    assert (shell.folder / "own.json").read_bytes() == (shell.folder / "plan.json").read_bytes()
