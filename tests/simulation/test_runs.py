"""Plans carried out in physics, by friction alone: goals, places of bodies, contacts that no segment permits."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import KnownTruth, execute
from kabo.execution.looks import rotation_vector
from kabo.scene.transforms import transform
from kabo.simulation import ContactJudge, Physics, SimulatedRobot

pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"
PLACED, TURNED = 0.003, np.radians(1.0)  # [m], [rad] from where the plan puts a body
pytestmark = pytest.mark.slow


def run_in_physics(
    name: str, seed: int = 0, **more: object
) -> tuple[SimulatedRobot, ContactJudge, "kabo.Plan", object]:
    problem = kabo.load_problem(DOMAINS / name)
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    scene = kabo.load_scene(problem.scene)
    robot, judge = SimulatedRobot(scene, **more), ContactJudge(scene)  # type: ignore[arg-type]
    robot.judge = judge.look
    return robot, judge, plan, execute(plan, scene, robot, KnownTruth(seed=seed, poses=robot.poses))


def placed_as_planned(robot: SimulatedRobot, plan: "kabo.Plan", run: "kabo.execution.Run") -> None:
    final = {}
    for name, _ in run.history:
        change = plan.nodes[name].after
        final |= {} if change is None else dict(change.objects)
    for body, pose in final.items():
        if pose.parent == "world":
            wanted, found = transform(pose.position, pose.quaternion), robot.poses()[body]
            assert np.linalg.norm(wanted[:3, 3] - found[:3, 3]) < PLACED, body
            assert np.linalg.norm(rotation_vector(wanted[:3, :3].T @ found[:3, :3])) < TURNED, body


@pytest.mark.parametrize(
    ("name", "seed"), [("stacked/n2.yaml", 0), ("bartender/four_bottles.yaml", 5), ("force_sensing/n1.yaml", 1)]
)
def test_the_goal_is_reached_and_bodies_are_where_the_plan_puts_them(name: str, seed: int) -> None:
    robot, judge, plan, run = run_in_physics(name, seed)
    assert run.reached_goal, run.reason
    assert judge.looks > 1000 and judge.faults == {}
    placed_as_planned(robot, plan, run)
    assert max(each["tracking"] for each in run.log.of("followed")) < 0.001


def test_a_body_that_is_pushed_away_stops_the_run_before_it_is_touched() -> None:
    def push(physics: Physics) -> None:
        if abs(physics.time - 1.0) < 1e-9:
            physics.displace("o2", np.array([0.03, 0.0, 0.0]))

    robot, judge, _, run = run_in_physics("stacked/n2.yaml", disturb=push)
    assert not run.reached_goal and run.surprise is not None
    assert run.surprise.kind in ("displaced", "grasp")
    velocities = robot.state().velocities["mobile"]
    assert np.abs(velocities[:5]).max() < 0.01
    assert judge.faults == {}


def test_the_same_seed_gives_the_same_run() -> None:
    first, second = (run_in_physics("stacked/n2.yaml")[3] for _ in range(2))
    assert first.log.records == second.log.records


def test_a_body_that_is_displaced_along_the_fingers_within_what_is_proven_is_carried_on() -> None:
    push_by = np.array([-0.00073, -0.00968, 0.0])  # 9.99 mm are proven: the hand must add next to nothing

    def push(physics: Physics) -> None:
        if abs(physics.time - 0.2) < 1e-9:
            physics.displace("o1", push_by)

    run = run_in_physics("stacked/n2.yaml", disturb=push)[3]
    assert run.reached_goal, run.reason
