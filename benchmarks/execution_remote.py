"""How soon both sides of a run over zenoh notice that the other is lost, and how soon robots begin to stop then.

A client drives a robot server without forces in another process; an observer hears its states. Processes are killed
(SIGKILL) or stalled (SIGSTOP) while robots move; so is a relay, through which all messages of a run go, in place of the
network. Times are those of one machine's clock, from the signal to the first state that tells of the loss, with which the
robots begin to stop, or to the executor's last record. Whole runs are counted, with others working beside them if asked.

    python -m benchmarks.execution_remote [--runs 20] [--whole 10] [--realtime] [--busy 4] [-o FILE]
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import zenoh

import kabo
from benchmarks.table import Table, finish
from kabo.execution import KnownTruth, Log, execute
from kabo.plan import Plan, load_plan, write_plan
from kabo.remote import StateMessage, ZenohRobot
from kabo.service import client_config, keys, open_session

PROBLEM = Path(__file__).parents[1] / "domains" / "stacked" / "n2.yaml"
LIMIT_S = 0.05
PRIORITY = 10  # of SCHED_FIFO
RELAY = """
import socket, sys, threading
def pump(one, other):
    while data := one.recv(65536):
        other.sendall(data)
here = socket.create_server(("127.0.0.1", int(sys.argv[1])))
print("ready", flush=True)
while True:
    near, _ = here.accept()
    far = socket.create_connection(("127.0.0.1", int(sys.argv[2])))
    for pair in ((near, far), (far, near)):
        pair[0].setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        threading.Thread(target=pump, args=pair, daemon=True).start()
"""

STARTED: list[Any] = []  # processes
USUALLY, SPIN = ["chrt", "--other", "0"], "while True: pass"
WHOLE = {  # names, and what the server is given
    "without forces": ("--kinematic",),
    "in physics": ("--speed", "1"),
    "without forces, 0.2 s of silence": ("--kinematic", "--silence", "0.2"),
}


class NotBegunError(Exception):
    """A run that ended before its side could be lost, since the machine did something else."""


class Observer:
    """Hears states and heartbeats of all servers, with the time at which they came [s]."""

    def __init__(self, endpoint: str) -> None:
        self.states: list[tuple[float, StateMessage]] = []
        self.beats: list[float] = []
        self.session = open_session(client_config([endpoint]))
        self._subscriber = self.session.declare_subscriber(keys.robot("*", "state"), self._state)

    def close(self) -> None:
        """Ends the session; a subscriber that is not undeclared keeps its thread, and the process from ending."""
        self._subscriber.undeclare()
        self.session.close()

    def _state(self, sample: zenoh.Sample) -> None:
        self.states.append((time.monotonic(), msgspec.json.decode(sample.payload.to_bytes(), type=StateMessage)))

    def until(self, happened: Callable[[StateMessage], bool]) -> None:
        """Waits for a state."""
        end = time.monotonic() + 30.0
        while not (self.states and happened(self.states[-1][1])):
            if time.monotonic() > end:
                raise NotBegunError
            time.sleep(0.002)


def endpoint_for(number: int) -> str:
    """An endpoint for each run: none is used twice."""
    return f"tcp/127.0.0.1:{21000 + os.getpid() % 4000 + number}"


def serve(endpoint: str, *more: str) -> "subprocess.Popen[str]":
    """A robot server, ready."""
    given = ["simulate", str(PROBLEM), "--serve", *(more or ("--kinematic",)), "--endpoint", endpoint]
    process = subprocess.Popen([sys.executable, "-m", "kabo.cli", *given], stderr=subprocess.PIPE, text=True)
    STARTED.append(process)
    assert process.stderr is not None
    next(line for line in process.stderr if "serves" in line)
    threading.Thread(target=process.stderr.read, daemon=True).start()
    return process


def drive(endpoint: str, plan: Plan, told: Callable[[dict[str, Any]], None] | None = None) -> Any:
    """Carries the plan out; a process of high priority first pays back what the kernel has granted its start."""
    scene = kabo.load_scene(PROBLEM)
    time.sleep(1.5)
    with ZenohRobot(client_config([endpoint]), scene, patience_s=30.0) as robot:
        return execute(plan, scene, robot, KnownTruth(poses=robot.poses), log=Log(listener=told))


def lost_client(number: int, plan_file: Path, sent: signal.Signals) -> dict[str, float]:
    """From the signal to a client, which moves its robot, to the first state that tells of its loss."""
    endpoint = endpoint_for(number)
    serve(endpoint)
    observer = Observer(endpoint)
    program = (
        f"from benchmarks.execution_remote import *; drive({endpoint!r}, load_plan(Path({str(plan_file)!r})))"
    )
    client = subprocess.Popen([sys.executable, "-c", program])
    STARTED.append(client)
    observer.until(lambda state: state.moving and state.motion_time > 0.3)
    time.sleep(0.01 * (number % 7))
    client.send_signal(sent)
    begun = time.monotonic()
    observer.until(lambda state: state.driver is None)
    found = next(when for when, state in observer.states if when > begun and state.driver is None)
    observer.until(lambda state: not state.moving)
    still = next(when for when, state in observer.states if when > begun and not state.moving)
    observer.close()
    return {"noticed": found - begun, "stands": still - begun}


def lost_server(number: int, plan_file: Path, sent: signal.Signals) -> dict[str, float]:
    """From the signal to a server to the end of the run."""
    endpoint = endpoint_for(number)
    server = serve(endpoint)
    plan, begun = load_plan(plan_file), []

    def lose() -> None:
        server.send_signal(sent)
        begun.append(time.monotonic())

    timer = threading.Timer(0.4 + 0.01 * (number % 7), lose)

    def told(record: dict[str, Any]) -> None:
        if record["event"] == "moving" and not timer.is_alive() and not begun:
            timer.start()
        elif record["event"] == "stopped":
            begun.append(time.monotonic())

    run = drive(endpoint, plan, told)
    if run.reached_goal or len(begun) != 2 or begun[1] < begun[0]:
        raise NotBegunError(run.reason)
    return {"noticed": begun[1] - begun[0]}


def lost_link(number: int, plan_file: Path, sent: signal.Signals) -> dict[str, float]:
    """From the signal to the relay between client and server, until each of them notices."""
    endpoint, near = endpoint_for(number), endpoint_for(number + 500)
    serve(endpoint)
    observer = Observer(endpoint)
    ports = [each.rpartition(":")[2] for each in (near, endpoint)]
    relay = subprocess.Popen([sys.executable, "-c", RELAY, *ports], stdout=subprocess.PIPE, text=True)
    STARTED.append(relay)
    assert relay.stdout is not None and relay.stdout.readline() == "ready\n"
    plan, begun = load_plan(plan_file), []

    def lose() -> None:
        relay.send_signal(sent)
        begun.append(time.monotonic())

    timer = threading.Timer(0.4 + 0.01 * (number % 7), lose)

    def told(record: dict[str, Any]) -> None:
        if record["event"] == "moving" and not timer.is_alive() and not begun:
            timer.start()
        elif record["event"] == "stopped":
            begun.append(time.monotonic())

    run = drive(near, plan, told)
    if run.reached_goal or len(begun) != 2 or begun[1] < begun[0]:
        raise NotBegunError(run.reason)
    observer.until(lambda state: state.driver is None and not state.moving)
    found = next(when for when, state in observer.states if when > begun[0] and state.driver is None)
    still = next(when for when, state in observer.states if when > begun[0] and not state.moving)
    observer.close()
    return {"noticed": max(begun[1], found) - begun[0], "server": found - begun[0], "stands": still - begun[0]}


def whole_run(number: int, plan_file: Path, *more: str) -> dict[str, float]:
    """A whole plan, with the greatest time between two states."""
    endpoint = endpoint_for(number)
    server = serve(endpoint, *more)
    observer, plan = Observer(endpoint), load_plan(plan_file)
    begun, taken = time.monotonic(), _taken_by_others()
    run = drive(endpoint, plan)
    taken = _taken_by_others() - taken
    seconds = time.monotonic() - begun
    if not run.reached_goal:
        sys.stderr.write(f"whole run {number}: {run.reason}\n")
    driven = [when for when, state in observer.states if state.driver is not None]
    gaps = np.diff(driven)
    server.kill()
    server.wait()
    observer.close()
    return {
        "reached": float(run.reached_goal),
        "seconds": seconds,
        "rate": 1.0 / float(gaps.mean()),
        "p99_gap": float(np.quantile(gaps, 0.99)),
        "greatest_gap": float(gaps.max()),
        "steal": taken,
    }


def main() -> None:
    """Measures, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--whole", type=int, default=10, help="whole runs of each kind")
    parser.add_argument(
        "--realtime", action="store_true", help="as processes that go before all others (needs root)"
    )
    parser.add_argument("--busy", type=int, default=0, help="processes that work beside the whole runs")
    parser.add_argument("-o", dest="output", type=Path)
    options = parser.parse_args()
    if options.realtime:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    plan = kabo.solve(kabo.load_problem(PROBLEM)).plan
    assert plan is not None
    cases: dict[str, Callable[[int, Path], dict[str, float]]] = {
        "client killed": lambda n, file: lost_client(n, file, signal.SIGKILL),
        "client stalled": lambda n, file: lost_client(n, file, signal.SIGSTOP),
        "server killed": lambda n, file: lost_server(n, file, signal.SIGKILL),
        "server stalled": lambda n, file: lost_server(n, file, signal.SIGSTOP),
        "link cut": lambda n, file: lost_link(n, file, signal.SIGKILL),
        "link stalled": lambda n, file: lost_link(n, file, signal.SIGSTOP),
    }
    rows: dict[str, Any] = {}
    again: list[int] = []
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plan.json"
        write_plan(plan, file)
        for place, (name, case) in enumerate(cases.items()):
            first = 200 + place * options.runs
            rows[name] = [measured(case, first + number, file, again) for number in range(options.runs)]
            sys.stderr.write(f"{name}: {[round(1000 * row['noticed']) for row in rows[name]]}, again {again}\n")
        workers = [subprocess.Popen([*USUALLY, sys.executable, "-c", SPIN]) for _ in range(options.busy)]
        for place, (name, given) in enumerate(WHOLE.items()):
            first = place * options.whole
            rows[name] = [whole_run(first + number, file, *given) for number in range(options.whole)]
        for each in workers:
            each.kill()
    settings = {"runs": options.runs, "whole": options.whole, "realtime": options.realtime, "busy": options.busy}
    settings["not_begun"] = len(again)
    finish(tables_of(rows, list(cases)), options.output, **settings)


def _taken_by_others() -> float:
    """The processor time that a machine around this one has taken from it since it started [s], on Linux."""
    words = Path("/proc/stat").read_text().split("\n", 1)[0].split()
    return int(words[8]) / os.sysconf("SC_CLK_TCK")


def measured(
    case: Callable[[int, Path], dict[str, float]], number: int, plan_file: Path, again: list[int]
) -> dict[str, float]:
    """A case, once more if it did not begin; `again` gets the numbers of those."""
    for tried in range(5):
        try:
            return case(number + 1000 * tried, plan_file)
        except NotBegunError:
            again.append(number)
        finally:
            for process in STARTED:
                process.kill()
                process.wait()
            STARTED.clear()
    raise NotBegunError(f"{number}: five times")


def tables_of(rows: dict[str, list[dict[str, float]]], cases: list[str]) -> list[Table]:
    """What was found, as tables."""
    lost = Table("a side is lost: how soon the other notices")
    for name in cases if rows[cases[0]] else ():
        noticed = 1000.0 * np.array([row["noticed"] for row in rows[name]])
        within = int((noticed <= 1000.0 * LIMIT_S).sum())
        figures = {"runs": len(noticed), "median_ms": float(np.median(noticed)), "most_ms": float(noticed.max())}
        stands = [1000.0 * row["stands"] for row in rows[name] if "stands" in row]
        stood = {"stands_after_ms": max(stands)} if stands else {}
        lost.add(name, **figures, within_50_ms=within, **stood)
    whole = Table("whole runs, STACKED n = 2")
    for name in WHOLE if rows[next(iter(WHOLE))] else ():
        of = {key: np.array([row[key] for row in rows[name]]) for key in rows[name][0]}
        whole.add(
            name,
            runs=len(of["reached"]),
            reached=int(of["reached"].sum()),
            seconds=float(np.median(of["seconds"])),
            rate=float(np.median(of["rate"])),
            p99_gap_ms=1000.0 * float(np.median(of["p99_gap"])),
            greatest_gap_ms=1000.0 * float(of["greatest_gap"].max()),
            steal=float(of["steal"].max()),
        )
    return [table for table in (lost, whole) if table.rows]


if __name__ == "__main__":
    main()
