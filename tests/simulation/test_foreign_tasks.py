"""Whole tasks with a robot that is not kabo's, in physics: the Panda's own fingers hold by friction alone."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import KnownTruth, Run, execute
from kabo.language.recorded_paths import installed_folder
from kabo.plan import Plan
from kabo.scene import Scene
from kabo.scene.transforms import transform
from kabo.simulation import ContactJudge, SimulatedRobot

pytest.importorskip("mujoco")
EXAMPLES = Path(__file__).parents[2] / "examples"
PLACED, UPRIGHT = 0.003, np.cos(np.radians(1.0))  # [m]
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        installed_folder("example-robot-data") is None, reason="the extra `robots` is not installed"
    ),
]


def carried_out(plan: Plan, scene: Scene, truth: dict[str, str]) -> tuple[SimulatedRobot, Run]:
    robot, judge = SimulatedRobot(scene), ContactJudge(scene)
    robot.judge = judge.look
    run = execute(plan, scene, robot, KnownTruth(truth, poses=robot.poses))
    assert judge.looks > 100 and judge.faults == {}
    return robot, run


def test_the_panda_puts_a_cylinder_where_the_task_wants_it() -> None:
    folder = EXAMPLES / "pick_and_place"
    report = kabo.plan_task(folder / "task.yaml", folder / "panda.yaml", max_solutions=1)
    plan, scene = kabo.task_plan(report), report.scene
    assert scene is not None
    robot, run = carried_out(plan, scene, {})
    assert run.reached_goal, run.reason
    pose = robot.poses()["object"]
    assert np.linalg.norm(pose[:3, 3] - [0.6, -0.15, 0.125]) < PLACED
    assert pose[2, 2] > UPRIGHT


@pytest.mark.parametrize("empty", [("can_1", "can_2"), ("can_2",)])
def test_the_panda_throws_away_the_cans_that_are_empty_and_no_other(empty: tuple[str, ...]) -> None:
    problem = kabo.load_problem(EXAMPLES / "two_cans" / "problem.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    scene = kabo.load_scene(problem.scene)
    truth = {f"empty({can})": str(can in empty).lower() for can in ("can_1", "can_2")}
    robot, run = carried_out(plan, scene, truth)
    assert run.reached_goal, run.reason
    region = scene.regions["bin"]
    for can in ("can_1", "can_2"):
        pose = robot.poses()[can]
        inside = np.linalg.inv(region.world_T_region) @ pose[:, 3]
        in_bin = bool((region.normals @ inside[:3] <= region.offsets).all())
        assert in_bin == (can in empty), can
        assert pose[2, 2] > UPRIGHT
    final = {body: pose for name, _ in run.history for body, pose in _after(plan, name).items()}
    for body in empty:
        wanted = transform(final[body].position, final[body].quaternion)
        assert np.linalg.norm(wanted[:3, 3] - robot.poses()[body][:3, 3]) < PLACED


def _after(plan: Plan, name: str) -> dict:
    change = plan.nodes[name].after
    return {} if change is None else dict(change.objects)
