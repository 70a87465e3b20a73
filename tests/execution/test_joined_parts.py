"""Parts that a hand joins to others: nobody presses them from then on, and they go where the others go."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import KinematicRobot, KnownTruth, execute, motion_of
from kabo.execution.belief import Belief
from kabo.execution.interruptions import observed
from kabo.scene import Attachment, with_change, world_T

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


@pytest.mark.parametrize("holder", [None, "robot_1"])
@pytest.mark.parametrize("exact", [False, True])
def test_parts_that_were_pushed_together_are_joined_as_they_were(holder: str | None, exact: bool) -> None:
    """A tree with a bearing on it, on the table or in a hand, is 12 mm beside its place: so is the bearing, once."""
    problem = kabo.load_problem(DOMAINS / "assembly" / "gearbox.yaml")
    plan, scene = kabo.solve(problem, geometry="none").plan, kabo.load_scene(problem.scene)
    assert plan is not None
    belief = Belief(scene, scene.start.replace({"o1": Attachment("o4", (0.0, 0.0, 0.07), (0.0, 0.0, 0.0, 1.0))}))
    if holder is not None:
        held = Attachment(f"{holder}.tool0", (0.0, 0.0, 0.13), (0.0, 0.0, 0.0, 1.0))
        belief = Belief(scene, belief.state.replace({"o4": held}))
    seen = {name: pose.copy() for name, pose in belief.poses().items()}
    for name in ("o4", "o1"):
        seen[name][:2, 3] += (0.010, 0.006)
    found, lost = observed(scene, plan, belief, {name: seen[name] for name in ("o1", "o4")}, {}, exact=exact)
    assert lost == ()
    state = with_change(scene, belief.state, found)
    for name in ("o4", "o1"):
        assert np.allclose(world_T(scene, state, name), seen[name], atol=1e-6), name
    if holder is not None:  # what a hand has lost is joined still
        for name in ("o4", "o1"):
            seen[name][2, 3] -= 0.2
        found, lost = observed(scene, plan, belief, {name: seen[name] for name in ("o1", "o4")}, {}, exact=exact)
        assert lost == (("o4", holder),) and found.objects["o4"].parent == "world"
        assert found.objects["o1"].parent == "o4"
