"""A tool in physics is never farther from its path than the clearance that its segment proves."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import ExecutionSettings, KnownTruth, Margins, Motion, execute
from kabo.scene import link_pose
from kabo.simulation import Physics, SimulatedRobot

pytest.importorskip("mujoco")
DOMAINS = Path(__file__).parents[2] / "domains"
pytestmark = pytest.mark.slow


class Compared:
    """Compares tools with their paths, at each look of a judge: the least clearance that is left [m], and how often."""

    def __init__(self, robot: SimulatedRobot, plan: kabo.Plan) -> None:
        self.robot, self.margins = robot, Margins(plan)
        self.left, self.looks = float("inf"), 0
        robot.judge = self.look

    def look(self, physics: Physics, motion: Motion | None, time: float, holding: list[tuple[str, str]]) -> None:
        for stretch in () if motion is None else motion.at(time):
            own = self.robot.scene.robots[stretch.robot]
            if stretch.trajectory.joints != own.planned_joints:
                continue
            assert own.tool is not None
            now = physics.configuration(stretch.robot)
            wanted = (*stretch.trajectory.at(time).tolist(), *now[own.planned :])
            there, planned = (link_pose(own, q, own.tool.frame)[:3, 3] for q in (now, wanted))
            proven = self.margins.of_segment(stretch.node, stretch.segment)
            self.left = min(self.left, proven - float(np.linalg.norm(there - planned)))
            self.looks += 1


def compared(name: str, *, late: bool = False) -> tuple[Compared, "kabo.execution.Run"]:
    problem = kabo.load_problem(DOMAINS / name)
    plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
    assert plan is not None
    robot = SimulatedRobot(scene, delay=0.05 if late else 0.0)
    seen = Compared(robot, plan)
    settings = ExecutionSettings(delay=0.0, despite_margins=late)
    return seen, execute(plan, scene, robot, KnownTruth(poses=robot.poses), settings)


@pytest.mark.parametrize("name", ["circular_rearrange/n2.yaml", "stacked/n2.yaml", "waiter/two_cups.yaml"])
def test_a_tool_is_nearer_to_its_path_than_what_is_proven(name: str) -> None:
    seen, run = compared(name)
    assert run.reached_goal, run.reason
    assert seen.looks > 1000
    assert seen.left > 0.0


def test_a_robot_that_is_late_is_seen_to_be_elsewhere() -> None:
    seen, _ = compared("circular_rearrange/n2.yaml", late=True)
    assert seen.left < 0.0
