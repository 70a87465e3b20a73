import pytest

from kabo.plan import Node, PlanBuilder, describe, plan_statistics

OPTIONS = {"search": "x", "seed": 0, "epsilon": None, "geometry": "none"}


def build(builder, root):
    return builder.build(root, problem="p", files={"f": "sha256:" + "0" * 64}, options=OPTIONS)


def test_equal_content_is_one_node():
    builder = PlanBuilder()
    goal = builder.goal()
    assert builder.goal() == goal
    first = builder.add(Node("action", "a", {"x": "one"}, next=goal))
    assert builder.add(Node("action", "a", {"x": "one"}, next=goal)) == first
    assert builder.add(Node("action", "a", {"x": "two"}, next=goal)) != first


def test_nodes_whose_motion_moves_something_else_at_its_start_are_different():
    builder = PlanBuilder()
    goal = builder.goal()
    node = Node("action", "a", next=goal)
    assert builder.add(node, moved=("held at 1",)) != builder.add(node, moved=("held at 2",))
    assert builder.add(node, moved=("held at 1",)) == builder.add(node, moved=("held at 1",))


def test_ids_are_breadth_first_false_before_true_values_as_declared_and_the_goal_last():
    builder = PlanBuilder()
    goal = builder.goal()
    a, b, c = (builder.add(Node("action", name, next=goal)) for name in "abc")
    colours = builder.add(Node("sense", "look", on="colour", branches={"red": c, "blue": b, "amber": a}))
    other = builder.add(Node("action", "d", next=goal))
    root = builder.add(Node("sense", "test", on="dark", branches={"true": colours, "false": other}))
    plan = build(builder, root)
    assert plan.root == "n0"
    assert [plan.nodes[f"n{i}"].action for i in range(6)] == ["test", "d", "look", "c", "b", "a"]
    assert plan.nodes["n6"].kind == "goal" and len(plan.nodes) == 7
    assert list(plan.nodes["n0"].branches) == ["false", "true"]


def test_nodes_that_the_root_does_not_reach_are_left_out():
    builder = PlanBuilder()
    goal = builder.goal()
    builder.add(Node("action", "unused", next=goal))
    assert list(build(builder, builder.add(Node("action", "a", next=goal))).nodes) == ["n0", "n1"]


def test_a_successor_must_be_added_first():
    with pytest.raises(ValueError, match="from their leaves"):
        PlanBuilder().add(Node("action", "a", next="#7"))


def test_shared_branches_are_counted_and_written_without_unfolding():
    """60 levels: 2^60 branches, 181 nodes."""
    builder = PlanBuilder()
    last = builder.goal()
    for level in range(60):
        sides = {o: builder.add(Node("action", "go", {"i": f"{o}_{level}"}, next=last)) for o in ("false", "true")}
        last = builder.add(Node("sense", "look", {"i": f"level_{level}"}, on=f"p(level_{level})", branches=sides))
    plan = build(builder, last)
    figures = plan_statistics(plan)
    assert (figures.plan_nodes, figures.plan_leaves, figures.plan_actions) == (181, 2**60, 120)
    assert len(describe(plan).splitlines()) < 500
