"""Draws a run in physics that was surprised and reached its goal, for the documentation: `python -m scripts.picture_run`.

STACKED with two blocks: one is pushed while the arm is on its way to it; the arm stops, goes back, and plans anew.
"""

from pathlib import Path

import numpy as np

import kabo
from kabo.execution import ExecutionSettings, KnownTruth, Log, execute
from kabo.pictures import ViewWishes, Witness, run_animation
from kabo.recovery import Replanner
from kabo.simulation import Physics, SimulatedRobot
from kabo.whole_files import write_atomically

ROOT = Path(__file__).resolve().parent.parent
PICTURE = "docs/pictures/run.gif"
PROBLEM = "domains/stacked/n2.yaml"
BODY, PUSHED_AT, PUSH = "o2", 0.7, (0.02, -0.01, 0.0)  # [s], [m]
PATIENCE = 600.0  # [s] for an answer: a busy machine draws the same picture
STATES = 20.0  # [Hz]
# What is drawn does not depend on how the run goes, which physics decides on each processor a little otherwise.
VIEW = ViewWishes(camera=(1.7, 0.9, 0.95), look_at=(0.25, 0.0, 0.28), size=(440, 330))


def made() -> bytes:
    """The run as an animated GIF."""
    problem = kabo.load_problem(ROOT / PROBLEM)
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    scene = kabo.load_scene(problem.scene)
    robot = SimulatedRobot(scene, disturb=_push)
    witness = Witness(robot)
    run = execute(
        plan,
        scene,
        robot,
        KnownTruth(poses=robot.poses),
        ExecutionSettings(log_rate=STATES),
        Log(listener=witness),
        recovery=Replanner(problem, scene, {"timeout": PATIENCE}),
    )
    assert run.reached_goal, run.reason
    return run_animation(witness.records, scene, PICTURE, VIEW)


def _push(physics: Physics) -> None:
    if abs(physics.time - PUSHED_AT) < 0.5 * physics.settings.timestep:
        physics.displace(BODY, np.array(PUSH))


if __name__ == "__main__":
    write_atomically(ROOT / PICTURE, made())
