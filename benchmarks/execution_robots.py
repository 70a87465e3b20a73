"""Robots that are not kabo's in physics: at rest under gravity, and along proven motions."""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

from robots import LIMIT_S, ROBOTS
from table import Table, percentile

HERE = Path(__file__).resolve()
PACKAGE = "package://example-robot-data/robots/"
MOTIONS = 3  # random goals of each robot
DRAWN = 200  # configurations in which a goal is looked for
SAMPLES = 20_000  # of the search for a way
RATE = 1000.0  # [Hz]
BARS = {"p50": 1.0, "p99": 3.0}  # of tracking [mrad, or mm of joints that slide]


def robots(options: argparse.Namespace) -> list[Table]:
    """Each robot of the wheel in a process of its own."""
    table = Table(
        "Robots of example-robot-data in physics, from their URDF alone; tracking at 1 kHz in mrad or mm"
    )
    for name, urdf in ROBOTS.items():
        if not options.robots or name in options.robots:
            table.add(name, **_process(urdf, options.seed))
    done = [row for row in table.rows if "p50" in row]
    bars = Table("Robots in physics: what must be reached")
    for figure, bar in BARS.items():
        worst = max(done, key=lambda row: row[figure], default=None)
        if worst is not None:
            above = sum(row[figure] > bar for row in done)
            bars.add(
                f"{figure}, the most of {len(done)} robots", bar=f"<= {bar:g}", found=worst[figure], of=worst[""],
                above=above, met="NO" if above else "yes",
            )  # fmt: skip
    lost = [row[""] for row in table.rows if "p50" not in row]
    bars.add("robots without a run", bar="0", found=len(lost), of=", ".join(lost), met="NO" if lost else "yes")
    return [table, bars]


def _process(urdf: str, seed: int) -> dict[str, Any]:
    command = [sys.executable, str(HERE), urdf, str(seed)]
    try:
        answer = subprocess.run(
            command, env=os.environ, capture_output=True, text=True, timeout=LIMIT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"no end after {LIMIT_S:g} s"}
    if answer.returncode != 0:
        return {"failed": (answer.stderr.strip().splitlines() or ["no word"])[-1]}
    found: dict[str, Any] = json.loads(answer.stdout.splitlines()[-1])
    return found


def one(urdf: str, seed: int) -> dict[str, Any]:
    """A robot as `kabo robot` describes it, settled, and sent to random configurations that are proven to be reached."""
    import kabo
    from kabo.errors import InputError
    from kabo.simulation import SimulatedRobot

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        try:
            path.write_text(kabo.robot_scene(PACKAGE + urdf, name="arm", folder=folder))
            scene = kabo.load_scene(path)
        except InputError as error:
            return {"failed": error.diagnostics[0].message}
        began = process_time()
        robot = SimulatedRobot(scene, rate=RATE)
        made = process_time() - began
    own, physics = scene.robots["arm"], robot.physics
    sag = max(abs(a - b) for a, b in zip(physics.configuration("arm"), scene.start.robots["arm"], strict=True))
    touching = {" and ".join(contact.things) for contact in physics.contacts(1e-4)}
    row = {
        "joints": len(own.joint_names),
        "moved": len(own.planned_joints),
        "model": made,
        "sag": 1000.0 * sag,
        "touching": ", ".join(sorted(touching)),
        "doubts": len(robot.doubts),
    }
    errors, seconds, used, moved = [], 0.0, 0.0, 0
    last: Any = "start"
    for goal in goals(scene, seed):
        try:
            trajectory = kabo.plan_motion(scene, "arm", last, goal, seed=seed, samples=SAMPLES)
        except (kabo.NoMotionError, InputError):
            continue
        before = process_time()
        errors += followed(robot, trajectory)
        used += process_time() - before
        seconds += trajectory.duration
        last, moved = goal, moved + 1
        if moved == MOTIONS:
            break
    if not errors:
        return {**row, "failed": "no motion was found"}
    return {
        **row,
        "motions": moved,
        "seconds": seconds,
        "p50": 1000.0 * percentile(errors, 0.5),
        "p99": 1000.0 * percentile(errors, 0.99),
        "most": 1000.0 * max(errors),
        "times real time": seconds / used,
    }


def goals(scene: Any, seed: int) -> Any:
    """Configurations of the planned joints (n,): anywhere within the limits at first, later ones nearer to the start."""
    import numpy as np

    from kabo.streams import stream_key, uniforms

    tree, count = scene.robots["arm"].tree, scene.robots["arm"].planned
    low, high = np.maximum(tree.lower[:count], -3.0), np.minimum(tree.upper[:count], 3.0)
    home = np.array(scene.start.robots["arm"][:count])
    drawn = uniforms(stream_key("robots in physics", seed), 0, DRAWN, count)
    for number, row in enumerate(low + (0.05 + 0.9 * drawn) * (high - low)):
        yield (home + (1.0 - number / DRAWN) * (row - home)).tolist()


def followed(robot: Any, trajectory: Any) -> list[float]:
    """How far each planned joint is from the trajectory, at each millisecond [rad or m]."""
    from kabo.execution.motions import Motion, Stretch

    motion = Motion((Stretch("n0", 0, "arm", trajectory),), (), ("n0",), 0.0, trajectory.duration)
    count, found = len(trajectory.joints), []
    robot.follow(motion)
    while True:
        robot.wait(0.001)
        state = robot.state()
        wanted = trajectory.at(min(state.motion_time, trajectory.duration))
        found += [abs(a - b) for a, b in zip(state.positions["arm"][:count], wanted.tolist(), strict=True)]
        if not state.moving:
            return found


if __name__ == "__main__":
    print(json.dumps(one(sys.argv[1], int(sys.argv[2]))))
