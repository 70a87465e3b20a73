"""Trees of py_trees on kabo's robots and sensors: the executor's own run, tick by tick."""

import py_trees
import pytest

import kabo
from kabo.execution import ExecutionSettings, KinematicRobot, KnownTruth, execute
from kabo.exporting import PlanLeaves, export
from tests.exporting.conftest import DOMAINS

Status = py_trees.common.Status


def tree_of(plan: kabo.Plan, leaves: PlanLeaves) -> py_trees.trees.BehaviourTree:
    names: dict = {}
    exec(export(plan, "py_trees"), names)
    return py_trees.trees.BehaviourTree(names["create_tree"](leaves))


@pytest.mark.parametrize("seed", range(4))
def test_a_tree_does_what_the_executor_does(seed: int) -> None:
    plan = kabo.solve(kabo.load_problem(DOMAINS / "doors" / "n3.yaml")).plan
    leaves = PlanLeaves(plan, None, None, KnownTruth(seed=seed))
    tree = tree_of(plan, leaves)
    tree.tick()
    run = execute(plan, None, None, KnownTruth(seed=seed))
    assert tree.root.status == Status.SUCCESS and leaves.run.history == run.history


def test_an_outcome_without_a_branch_fails_with_the_reason() -> None:
    plan = kabo.solve(kabo.load_problem(DOMAINS / "doors" / "n3.yaml")).plan
    formula = kabo.policy(plan)().observe
    tree = tree_of(plan, PlanLeaves(plan, None, None, KnownTruth({formula: "ajar"})))
    tree.tick()
    assert (
        tree.root.status == Status.FAILURE
        and "for which the plan has no branch" in tree.root.tip().feedback_message
    )


def test_motions_run_over_many_ticks_and_an_interrupted_tree_stops_the_robot() -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
    for interrupted in (False, True):
        robot = KinematicRobot(scene)
        leaves = PlanLeaves(plan, scene, robot, KnownTruth(poses=robot.poses), ExecutionSettings())
        tree, ticks = tree_of(plan, leaves), 0
        while ticks == 0 or tree.root.status == Status.RUNNING:
            tree.tick()
            ticks += 1
            if interrupted and ticks == 60:
                tree.interrupt()
                tree.root.stop(Status.INVALID)
        if not interrupted:
            assert ticks > 100 and leaves.run.reached_goal
        else:
            assert leaves.run is None and robot.state().moving  # slowing down
            robot.wait(4.0)
            assert not robot.state().moving
