"""Skeleton nodes are shared when they are equal, and listed once from the root."""

from kabo.knowledge import ground
from kabo.planner.search.skeleton import Skeleton, SkeletonBuilder
from tests.support.small_problems import action, add, atom, lit, problem

TASK = ground(problem(actions=[action("do", effects=[add(lit("q"))]), action("look", sense=[atom("r")])]))
DO, LOOK = TASK.actions


def test_an_equal_node_is_the_same_object():
    builder = SkeletonBuilder()
    assert builder.act(DO, 0, (), builder.goal) is builder.act(DO, 0, (), builder.goal)
    assert builder.act(DO, 0, (), builder.goal) is not builder.act(DO, 1, (), builder.goal)


def test_a_branch_on_what_an_action_delivers_becomes_part_of_its_node():
    builder = SkeletonBuilder()
    done = builder.act(DO, 0, (), builder.goal)
    branch = builder.branch("r", (("false", done), ("true", builder.goal)))
    node = builder.act(LOOK, 0, ("r",), branch)
    assert (node.on, node.outcomes, node.next, node.delivers) == ("r", branch.outcomes, None, ())
    assert builder.act(DO, 0, (), branch).next is branch


def test_nodes_are_listed_breadth_first_with_the_goal_last():
    builder = SkeletonBuilder()
    done = builder.act(DO, 0, (), builder.goal)
    root = builder.act(LOOK, 0, ("r",), builder.branch("r", (("false", builder.goal), ("true", done))))
    assert list(Skeleton(root).nodes()) == [root, done, builder.goal]
