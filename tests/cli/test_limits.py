"""Time, memory and Ctrl-C end every command, whatever it does; what was found by then is kept; no process is left."""

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import jsonschema
import pytest

from kabo.budgets import StopFlag, default_memory, held_bytes
from kabo.cli.limits import Surrounding, add_limits, memory, seconds
from kabo.cli.main import parser
from kabo.cli.solving import add_search_arguments
from kabo.cli.terminal import interruptible
from kabo.cli.waiting.watch import limited
from kabo.plan import plan_to_json, schema
from kabo.planner.result import result_to_json
from kabo.planner.solve import solve
from tests.planner.gantry import gantry_problem

RESULT = schema("kabo-result-1")
LONG_S = 600.0
ROOT = Path(__file__).parents[2]


def options(*arguments: str, search: bool = False) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    if search:
        add_search_arguments(parser)
    else:
        parser.add_argument("--json", action="store_true")
        add_limits(parser)
    return parser.parse_args([*(["problem.yaml"] if search else []), *arguments])


def endless(_: argparse.Namespace) -> int:
    time.sleep(LONG_S)
    return 0


def children() -> set[str]:
    """The processes that this one has started and not waited for, those of other tests, too."""
    return {child for path in Path("/proc/self/task").glob("*/children") for child in path.read_text().split()}


def held(_: argparse.Namespace) -> int:
    kept = bytearray(400 << 20)
    kept[:: 1 << 12] = b"x" * len(kept[:: 1 << 12])
    return endless(_)


@pytest.mark.parametrize(
    ("run", "limits", "spent"), [(endless, ("--timeout", "0.2"), "time"), (held, ("--memory", "200M"), "memory")]
)
def test_a_limit_ends_what_looks_at_no_flag(run, limits, spent, capfd, monkeypatch):
    monkeypatch.setattr("kabo.cli.waiting.watch.process_began", time.perf_counter)  # not that of pytest, long ago
    before = children()
    assert limited(options("--json", *limits), run) == 4
    said, told = capfd.readouterr()
    assert json.loads(said)["code"] == "cut_off" and f"{spent} exhausted" in json.loads(said)["message"]
    assert told.count("\n") == 1
    assert children() <= before


def test_a_command_within_its_limits_has_its_own_exit_code():
    day = "86400"  # counted from the start of this process, which has run many tests
    assert limited(options("--timeout", day, "--memory", "none"), lambda _: 5) == 5


def test_a_search_that_is_ended_by_force_has_a_result(capfd):
    assert limited(options("--json", "--timeout", "0.2", search=True), endless) == 4
    said = json.loads(capfd.readouterr().out)
    jsonschema.validate(said, RESULT)
    assert said["status"] == "exhausted" and said["reason"]["budget"] == "time" and not said["reason"]["proved"]


@pytest.mark.parametrize("ended", ["time", "interrupt", "crash"])
def test_a_plan_that_was_found_is_written_however_its_certificate_ends(ended, tmp_path, capfd):
    result = solve(gantry_problem(tmp_path), certificate=False)
    body, plan = result_to_json(result), plan_to_json(result.plan)

    def run(options: argparse.Namespace) -> int:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        options.surrounding.on_found()(body, plan)
        if ended == "interrupt":
            os.kill(os.getppid(), signal.SIGINT)
        elif ended == "crash":
            os.kill(os.getpid(), signal.SIGKILL)
        return endless(options)

    output = tmp_path / "found.json"
    limits = ["--timeout", "0.5"] if ended == "time" else []
    assert limited(options("-o", str(output), "--json", *limits, search=True), run) == 0
    assert output.read_bytes() == plan
    said = json.loads(capfd.readouterr().out)
    jsonschema.validate(said, RESULT)
    assert said["status"] == "solved" and said["plan"] == str(output) and len(said["cut_off"]) == 1


def test_an_interrupt_ends_the_child_with_what_it_has(capfd):
    def run(_: argparse.Namespace) -> int:
        with interruptible() as stop:
            os.kill(os.getppid(), signal.SIGINT)
            while not stop():
                time.sleep(0.01)
        return 7

    assert limited(options(), run) == 7
    assert "ending with what there is" in capfd.readouterr().err


@pytest.mark.parametrize("form", [(), ("--json",)])
def test_a_search_that_is_killed_still_says_what_was_refused(form, tmp_path, capfd):
    problem = gantry_problem(tmp_path, walls={"lid": ((0.2, 0.2, 0.01), (0.2, 0.0, 0.1))})

    def run(given):
        def refused(result):
            if result.reason.details:
                given.surrounding.on_known(result_to_json(result), "")
                os.kill(os.getppid(), signal.SIGINT)
                time.sleep(LONG_S)

        with interruptible():
            solve(problem, on_refused=refused)
        return 0

    assert limited(options(*form, search=True), run) == 4
    said, told = capfd.readouterr()
    assert "cut off while working (interrupted)" in told and "pick(gantry, cube): blocked by lid in " in told
    if form:
        jsonschema.validate(json.loads(said), RESULT)
        assert "blocked by lid in" in json.loads(said)["reason"]["details"][0]


def test_a_child_that_crashes_is_told(capfd):
    assert limited(options(), lambda _: os.kill(os.getpid(), signal.SIGKILL)) == 1
    assert "SIGKILL" in capfd.readouterr().err


COMMANDS = {
    "solve": ["one.yaml"],
    "explain": ["one.yaml"],
    "verify": ["one.yaml", "plan.json"],
    "check": ["one.yaml"],
    "task plan": ["task.yaml"],
    "task compare": ["a.json", "b.json"],
    "bound": ["mesh.off", "--epsilon", "1", "-o", "out.off"],
    "decompose": ["mesh.off", "--epsilon", "1", "-o", "out.off"],
    "generate": ["bartender", "--n", "1", "-o", "problem.yaml"],
    "request": ["one.yaml"],
}
# Python runs this before anything else: what does the work sleeps for good, wherever it looks at no flag.
ASLEEP = """
import os, time
fork = os.fork
def asleep():
    child = fork()
    if child == 0:
        time.sleep(600)
    return child
os.fork = asleep
"""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_ends_at_its_time_limit_whatever_it_does(command, tmp_path):
    (tmp_path / "sitecustomize.py").write_text(ASLEEP)
    paths = os.pathsep.join([str(tmp_path), os.environ["PYTHONPATH"]])
    arguments = [sys.executable, "-B", "-m", "kabo.cli", *command.split(), *COMMANDS[command], "--timeout", "0.5"]
    done = subprocess.run(
        arguments,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        env={**os.environ, "PYTHONPATH": paths},
    )
    assert done.returncode == 4, done
    assert "time exhausted" in done.stderr + done.stdout and "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["sitecustomize.py"]


def test_nothing_lives_on_when_kabo_is_killed(tmp_path):
    slow = tmp_path / "slow"
    slow.mkdir()
    (slow / "generate.py").write_text("import time\ndef problem(n, home): time.sleep(600)\n")
    command = [sys.executable, "-m", "kabo.cli", "generate", str(slow), "--n", "1", "-o", str(tmp_path / "p.yaml")]
    with subprocess.Popen(command) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        until = time.monotonic() + 60
        while not (found := children.read_text().split()) and time.monotonic() < until:
            time.sleep(0.02)
        time.sleep(0.2)  # it has still to say that it wants to end with its parent
        process.kill()
    assert found
    while is_alive(int(found[0])) and time.monotonic() < until:
        time.sleep(0.02)
    assert not is_alive(int(found[0]))


def is_alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_command_stops_early_enough_to_say_what_it_found_out():
    left = Surrounding().left
    assert 8.0 < left(10.0) <= 9.8
    assert 597.0 < left(600.0) <= 599.0
    assert left(float("inf")) == float("inf") and left(None) is None


@pytest.mark.parametrize(
    ("text", "value"),
    [("10", 10.0), ("0.5", 0.5), ("none", float("inf")), ("0", float("inf"))],
)
def test_spans_of_time(text, value):
    assert seconds(text) == value


@pytest.mark.parametrize(
    ("text", "value"),
    [("500M", 500 << 20), ("4G", 4 << 30), ("1.5 GiB", 1.5 * (1 << 30)), ("2048", 2048), ("none", float("inf"))],
)
def test_sizes(text, value):
    assert memory(text) == value


@pytest.mark.parametrize("text", ["-1", "nan", "inf", "much", ""])
def test_what_is_no_limit_is_refused(text):
    for read in (seconds, memory):
        with pytest.raises(argparse.ArgumentTypeError):
            read(text)


def test_a_flag_that_has_said_stop_goes_on_saying_so():
    answers = iter([False, True, False])
    flag = StopFlag(cancelled=lambda: next(answers))
    assert [flag(), flag(), flag()] == [False, True, True]
    assert flag.spent == "time" and flag.interrupted
    assert StopFlag(memory=1.0)() and not StopFlag(seconds=60.0, memory=default_memory())()
    assert held_bytes(os.getpid(), 0.0) > 1 << 20


PICK_AND_PLACE = Path(__file__).parents[2] / "examples" / "pick_and_place"


def test_a_task_whose_time_is_up_writes_what_it_found(tmp_path):
    """Timing a hundred solutions takes seconds: that is part of planning, and ends in time."""
    output = tmp_path / "report.json"
    task, scene = (str(PICK_AND_PLACE / name) for name in ("task.yaml", "scene.yaml"))
    limits = ["--timeout", "9", "--max-solutions", "100000"]
    given = [sys.executable, "-m", "kabo", "task", "plan", task, "--scene", scene, *limits, "-o", str(output)]
    ended = subprocess.run(given, capture_output=True, text=True, timeout=60, check=False)
    assert ended.returncode == 0, ended.stderr
    (run,) = json.loads(output.read_bytes())["runs"]
    assert run["stopped"] and len(run["solutions"]) == min(100, len(run["found"]))
    assert min(each["cost"] for each in run["solutions"]) == min(each["cost"] for each in run["found"])


@pytest.mark.parametrize(("form", "code"), [((), 0), (("--json",), 4)])
def test_a_task_that_is_killed_after_its_report_is_written_says_so(form, code, tmp_path, capfd, monkeypatch):
    monkeypatch.setattr("kabo.cli.waiting.watch.process_began", time.perf_counter)
    given = parser().parse_args(
        ["task", "plan", "t.yaml", "-o", str(tmp_path / "r.json"), "--timeout", "0.2", *form]
    )

    def run(options: argparse.Namespace) -> int:
        options.surrounding.on_known({"exit_code": 0}, "r.json")
        time.sleep(LONG_S)
        return 1

    assert limited(given, run) == code
    said, told = capfd.readouterr()
    assert ("r.json: the report" in told) is (code == 0)
    assert ("nothing was written" in told) is (code != 0)
