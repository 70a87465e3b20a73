"""Parts that a hand joins to others: nobody presses them from then on, and they go where the others go."""

from pathlib import Path

import numpy as np

import kabo
from kabo.execution import KinematicRobot, KnownTruth, execute, motion_of

DOMAINS = Path(__file__).parents[2] / "domains"


def test_a_gearbox_is_put_together_without_forces() -> None:
    problem = kabo.load_problem(DOMAINS / "assembly" / "gearbox.yaml")
    plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
    assert plan is not None
    robot = KinematicRobot(scene)
    run = execute(plan, scene, robot, KnownTruth(poses=robot.poses))
    assert run.reached_goal, run.reason
    joined = {
        body
        for node in plan.nodes.values()
        for segment in node.motion
        for body, parent in segment.attach
        if parent in scene.bodies
    }
    assert len(joined) == 3  # two bearings and the pipe
    assert np.ptp([robot.poses()[body][:2, 3] for body in joined], axis=0).max() < 1e-3  # all on one axis
    kinds = {
        each.kind
        for name in plan.nodes
        if plan.nodes[name].motion
        for each in motion_of(plan, name, scene).actions
        if each.attach and each.attach[0][1] in scene.bodies
    }
    assert kinds == {"detach"}
