"""BARTENDER in a simulation of another process: which bottles are empty is known there only, and hands find out.

    python examples/execution/over_zenoh.py [SEED ...] [--speed 5] [--silence 0.2]

For each seed other bottles are empty. The server is `kabo simulate --serve` with the truth in a file; this process has the
plan, asks for weights, and looks in the end where bottles are seen to stand.
"""

import argparse
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import kabo
from kabo.execution import Log, execute
from kabo.language import load_sensors
from kabo.recovery import Replanner
from kabo.remote import RemoteSensors, ZenohRobot
from kabo.scene import world_T
from kabo.service import client_config

FOLDER = Path(__file__).parent
PROBLEM, SENSORS = FOLDER / "problem.yaml", FOLDER / "sensors.yaml"
EMPTY, FULL = 0.1, 0.45  # kg; the scene says 0.3


def free_endpoint():
    """An endpoint on this machine where nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as found:
        return f"tcp/127.0.0.1:{found.getsockname()[1]}"


def serve(endpoint, masses, seed, options):
    """A robot server in another process, with its truth."""
    with tempfile.TemporaryDirectory() as folder:
        truth = Path(folder) / "truth.yaml"
        truth.write_text(f"truth: seed_{seed}\nmasses: {{{', '.join(f'{o}: {m}' for o, m in masses.items())}}}\n")
        given = ["--sensors", SENSORS, "--truth-file", truth, "--seed", seed, "--endpoint", endpoint]
        given += ["--speed", options.speed, "--silence", options.silence]
        command = [sys.executable, "-m", "kabo.cli", "simulate", PROBLEM, "--serve", *given]
        process = subprocess.Popen(list(map(str, command)), stderr=subprocess.PIPE, text=True)  # noqa: S603
        if not any("serves" in line for line in process.stderr):
            sys.exit("the robot server has ended")
        return process


def carried_out(problem, plan, scene, endpoint):
    """The run, and the bottles that are seen in the dishwasher after it."""
    log, sensors = Log(), load_sensors(SENSORS, problem)
    with ZenohRobot(client_config([endpoint]), scene) as robot:
        recovery = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
        run = execute(plan, scene, robot, RemoteSensors(sensors, robot, log), log=log, recovery=recovery)
        crate = world_T(scene, scene.start, "crate")[:3, 3]
        washed = {o for o, pose in robot.poses().items() if (abs(pose[:3, 3] - crate) < [0.16, 0.16, 0.05]).all()}
    return run, washed


def main(options):
    """Plans once, and carries the plan out in a world for each seed."""
    problem, scene = kabo.load_problem(PROBLEM), kabo.load_scene(PROBLEM)
    plan = kabo.solve(problem).plan
    for seed in options.seeds or [0, 5, 9, 15]:
        masses = {f"bottle_{k + 1}": EMPTY if seed >> k & 1 else FULL for k in range(4)}
        endpoint = free_endpoint()
        server = serve(endpoint, masses, seed, options)
        try:
            run, washed = carried_out(problem, plan, scene, endpoint)
        finally:
            server.terminate()
            server.wait()
        right = run.reached_goal and washed == {bottle for bottle, mass in masses.items() if mass == EMPTY}
        looks = sum(record["looks"] for record in run.log.of("looked"))
        told = f"{run.reason}; {looks} looks, washed {sorted(washed)}: {'right' if right else 'WRONG'}"
        sys.stdout.write(f"seed {seed}: {told}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="*", type=int, metavar="SEED")
    parser.add_argument("--speed", type=float, default=5.0, help="of the simulation")
    parser.add_argument("--silence", type=float, default=0.2, help="after which both sides give up [s]")
    main(parser.parse_args())
