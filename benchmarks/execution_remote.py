"""How soon both sides of a run over zenoh notice that the other is lost, and how soon robots begin to stop then.

A client drives a robot server without forces in another process; an observer hears its states. Processes are killed
(SIGKILL) or stalled (SIGSTOP) while robots move. Times are those of one machine's clock, from the signal to the first state
that tells of the loss, with which the robots begin to stop, or to the executor's last record.

    python -m benchmarks.execution_remote [--runs 20] [-o FILE]
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


class Observer:
    """Hears states and heartbeats of all servers, with the time at which they came [s]."""

    def __init__(self, endpoint: str) -> None:
        self.states: list[tuple[float, StateMessage]] = []
        self.beats: list[float] = []
        self.session = open_session(client_config([endpoint]))
        self.session.declare_subscriber(keys.robot("*", "state"), self._state)

    def _state(self, sample: zenoh.Sample) -> None:
        self.states.append((time.monotonic(), msgspec.json.decode(sample.payload.to_bytes(), type=StateMessage)))

    def until(self, happened: Callable[[StateMessage], bool]) -> None:
        """Waits for a state."""
        end = time.monotonic() + 60.0
        while not (self.states and happened(self.states[-1][1])):
            assert time.monotonic() < end, "it does not happen"
            time.sleep(0.002)


def endpoint_for(number: int) -> str:
    """An endpoint for each run: none is used twice."""
    return f"tcp/127.0.0.1:{21000 + os.getpid() % 4000 + number}"


def serve(endpoint: str) -> "subprocess.Popen[str]":
    """A robot server, ready."""
    given = ["simulate", str(PROBLEM), "--serve", "--kinematic", "--endpoint", endpoint]
    process = subprocess.Popen([sys.executable, "-m", "kabo.cli", *given], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    next(line for line in process.stderr if "serves" in line)
    threading.Thread(target=process.stderr.read, daemon=True).start()
    return process


def drive(endpoint: str, plan: Plan, told: Callable[[dict[str, Any]], None] | None = None) -> Any:
    """Carries the plan out."""
    scene = kabo.load_scene(PROBLEM)
    with ZenohRobot(client_config([endpoint]), scene, patience_s=30.0) as robot:
        return execute(plan, scene, robot, KnownTruth(poses=robot.poses), log=Log(listener=told))


def lost_client(number: int, plan_file: Path, sent: signal.Signals) -> dict[str, float]:
    """From the signal to a client, which moves its robot, to the first state that tells of its loss."""
    endpoint = endpoint_for(number)
    server = serve(endpoint)
    observer = Observer(endpoint)
    program = (
        f"from benchmarks.execution_remote import *; drive({endpoint!r}, load_plan(Path({str(plan_file)!r})))"
    )
    client = subprocess.Popen([sys.executable, "-c", program])
    observer.until(lambda state: state.moving and state.motion_time > 0.3)
    time.sleep(0.01 * (number % 7))
    client.send_signal(sent)
    begun = time.monotonic()
    observer.until(lambda state: state.driver is None)
    found = next(when for when, state in observer.states if when > begun and state.driver is None)
    observer.until(lambda state: not state.moving)
    still = next(when for when, state in observer.states if when > begun and not state.moving)
    for process in (client, server):
        process.kill()
        process.wait()
    observer.session.close()
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
    assert not run.reached_goal and len(begun) == 2, run.reason
    server.kill()
    server.wait()
    return {"noticed": begun[1] - begun[0]}


def whole_run(number: int, plan_file: Path) -> dict[str, float]:
    """A whole plan, with the greatest time between two states."""
    endpoint = endpoint_for(number)
    server = serve(endpoint)
    observer, plan = Observer(endpoint), load_plan(plan_file)
    begun = time.monotonic()
    run = drive(endpoint, plan)
    seconds = time.monotonic() - begun
    gaps = np.diff([when for when, _ in observer.states])
    server.kill()
    server.wait()
    observer.session.close()
    return {
        "reached": float(run.reached_goal),
        "seconds": seconds,
        "rate": 1.0 / float(gaps.mean()),
        "p99_gap": float(np.quantile(gaps, 0.99)),
        "greatest_gap": float(gaps.max()),
    }


def main() -> None:
    """Measures, and prints a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("-o", dest="output", type=Path)
    options = parser.parse_args()
    plan = kabo.solve(kabo.load_problem(PROBLEM)).plan
    assert plan is not None
    cases: dict[str, Callable[[int, Path], dict[str, float]]] = {
        "client killed": lambda n, file: lost_client(n, file, signal.SIGKILL),
        "client stalled": lambda n, file: lost_client(n, file, signal.SIGSTOP),
        "server killed": lambda n, file: lost_server(n, file, signal.SIGKILL),
        "server stalled": lambda n, file: lost_server(n, file, signal.SIGSTOP),
    }
    rows: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "plan.json"
        write_plan(plan, file)
        rows["whole run"] = [whole_run(number, file) for number in range(3)]
        for place, (name, case) in enumerate(cases.items()):
            rows[name] = [case(10 + place * options.runs + number, file) for number in range(options.runs)]
    finish(tables_of(rows, list(cases)), options.output, runs=options.runs)


def tables_of(rows: dict[str, list[dict[str, float]]], cases: list[str]) -> list[Table]:
    """What was found, as tables."""
    lost = Table("a side is lost: how soon the other notices")
    for name in cases:
        noticed = 1000.0 * np.array([row["noticed"] for row in rows[name]])
        within = int((noticed <= 1000.0 * LIMIT_S).sum())
        figures = {"runs": len(noticed), "median_ms": float(np.median(noticed)), "most_ms": float(noticed.max())}
        stands = [1000.0 * row["stands"] for row in rows[name] if "stands" in row]
        stood = {"stands_after_ms": max(stands)} if stands else {}
        lost.add(name, **figures, within_50_ms=within, **stood)
    whole = Table("whole runs, STACKED n = 2")
    for row in rows["whole run"]:
        whole.add("two blocks", **row)
    return [lost, whole]


if __name__ == "__main__":
    main()
