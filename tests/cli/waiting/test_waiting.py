"""Commands in real terminals and pipes: what those who wait are told, and that it costs nothing of the answer."""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
ERASED = "\r\x1b[K"
# A generator that takes a while and says its phases, as a slow command does.
SLOW = """
import time
from kabo.phases import phase
def problem(n, home, seconds=3.0):
    with phase("baking", 20, "loaves") as step:
        for _ in range(20):
            time.sleep(seconds / 20)
            step()
    print("done")
    return "problem: p"
"""


def command(tmp_path: Path, *more: str) -> list[str]:
    """A slow `kabo generate`."""
    folder = tmp_path / "slow"
    folder.mkdir(exist_ok=True)
    (folder / "generate.py").write_text(SLOW)
    return [sys.executable, "-m", "kabo.cli", "generate", str(folder), "--n", "1", "-o", "p.yaml", *more]


def environment(**changes: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "TERM")}
    return {**kept, "TERM": "xterm", "PYTHONIOENCODING": "utf-8", **changes}


def in_terminal(arguments: list[str], folder: Path, *, stop_after: float | None = None, **changes: str) -> str:
    """What a command writes to a terminal of 100 columns; it gets Ctrl-C after `stop_after` seconds."""
    child, screen = pty.fork()
    if child == 0:
        os.chdir(folder)
        os.execvpe(arguments[0], arguments, environment(**changes))
    fcntl.ioctl(screen, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 100, 0, 0))
    began, written, stopped = time.monotonic(), b"", False
    while time.monotonic() < began + 60:
        if stop_after is not None and not stopped and time.monotonic() > began + stop_after:
            os.write(screen, b"\x03")
            stopped = True
        if select.select([screen], [], [], 0.1)[0]:
            try:
                more = os.read(screen, 65536)
            except OSError:  # the other end is closed
                break
            if not more:
                break
            written += more
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    os.close(screen)
    return written.decode()


def left_on_screen(written: str) -> list[str]:
    """The lines that stay on the screen: what was erased is gone."""
    return [line.rsplit(ERASED, 1)[-1].strip("\r") for line in written.split("\n")]


@pytest.fixture(scope="module", autouse=True)
def slow(tmp_path_factory: pytest.TempPathFactory) -> Iterator["subprocess.Popen[str]"]:
    """A command of 23 seconds with pipes, which runs beside the other tests of this file."""
    folder = tmp_path_factory.mktemp("slow")
    with subprocess.Popen(
        command(folder, "--set", "seconds=23"),
        cwd=folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        yield process
        process.kill()


def test_a_terminal_shows_one_row_with_a_bar_and_an_estimate_that_is_gone_at_the_end(tmp_path):
    written = in_terminal(command(tmp_path), tmp_path)
    rows = [row for row in written.split(ERASED) if "baking" in row]
    assert len(rows) > 5
    assert any(re.search(r"baking: \d+ of 20 loaves .*━.* \d+ s, about \d+ s left", row) for row in rows)
    assert max(len(re.sub(r"\x1b\[\d*m", "", row.split("\n")[0])) for row in rows) < 100
    assert left_on_screen(written) == ["done", "p.yaml", ""]


def test_without_colours_there_are_none(tmp_path):
    written = in_terminal(command(tmp_path), tmp_path, NO_COLOR="1")
    assert "baking" in written and set(re.findall(r"\x1b\[[^K]*[a-zA-Z]", written)) <= {"\x1b[K"}


@pytest.mark.parametrize("quiet", [{"TERM": "dumb"}, {}])
def test_a_dumb_terminal_and_a_quiet_command_show_no_row(tmp_path, quiet):
    written = in_terminal(command(tmp_path, *([] if quiet else ["-q"])), tmp_path, **quiet)
    assert left_on_screen(written) == ["done", "p.yaml", ""] and "\x1b" not in written


def test_ctrl_c_leaves_a_clean_screen(tmp_path):
    written = in_terminal(command(tmp_path, "--set", "seconds=30"), tmp_path, stop_after=4.0)
    shown = left_on_screen(written)
    # On a busy machine the command is slow to answer, and is cut off "while baking: … (interrupted)": that is no row.
    assert "interrupted" in shown[-2] and not any("━" in line or " left" in line for line in shown)
    assert not (tmp_path / "p.yaml").exists()


@pytest.mark.parametrize("redirected", ["2>&-", "2>/dev/full", ">&- 2>&-"])
def test_nobody_need_read_what_is_told(tmp_path, redirected):
    words = " ".join(f"'{word}'" for word in command(tmp_path, "-v", "--set", "seconds=0.1"))
    done = subprocess.run(
        f"{words} {redirected}", shell=True, cwd=tmp_path, env=environment(), stdout=subprocess.PIPE, check=False
    )
    assert done.returncode == 0
    assert (tmp_path / "p.yaml").read_text() == "problem: p"
    assert done.stdout.split() in ([b"done", b"p.yaml"], [])


def test_progress_changes_no_plan(tmp_path):
    problem = ROOT / "domains" / "doors" / "n5.yaml"
    plans = []
    for more in ([], ["-vv", "--log", str(tmp_path / "log.jsonl")]):
        plan = tmp_path / f"plan{len(plans)}.json"
        program = [sys.executable, "-m", "kabo.cli", "solve", str(problem), "-o", str(plan), *more]
        subprocess.run(program, env=environment(), capture_output=True, check=True)
        plans.append(plan.read_bytes())
    assert plans[0] == plans[1]
    logged = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert {"kabo.cli", "kabo.language", "kabo.planner", "kabo.requests"} <= {line["logger"] for line in logged}


def test_a_pipe_gets_a_line_every_ten_seconds_and_quick_commands_none(tmp_path, slow):
    quick = subprocess.run(command(tmp_path), cwd=tmp_path, env=environment(), capture_output=True, check=True)
    assert quick.stderr == b""
    said, told = slow.communicate(timeout=120)
    assert slow.returncode == 0 and said.split() == ["done", "p.yaml"]
    lines = told.splitlines()
    assert [
        bool(re.fullmatch(r"kabo: baking: \d+ of 20 loaves \(\d+ %\); [12]\d s so far.*", line)) for line in lines
    ] == [
        True,
        True,
    ]
    assert "about" in lines[1]
