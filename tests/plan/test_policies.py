"""A plan as policy and as tree: what to do after what was observed, with nothing shared."""

import pytest

from kabo.plan import Observation, plan_statistics, policy, unfold


def seen(*pairs: tuple[str, str]) -> list[Observation]:
    return [Observation(*pair) for pair in pairs]


def names(decision) -> list[str]:
    return [str(node.action) for node in decision.actions]


def test_a_policy_says_what_to_do_until_it_looks_again(plan):
    first = policy(plan)()
    assert (names(first), first.observe, first.outcomes) == (["look"], "dark", ("false", "true"))
    second = policy(plan)(seen(("dark", "false")))
    assert (names(second), second.observe) == (["pick", "read"], "open(vault)")
    last = policy(plan)(seen(("dark", "false"), ("open(vault)", "false")))
    assert names(last) == ["dial"]
    assert last.is_last
    assert names(policy(plan)(seen(("dark", "true")))) == []


def test_the_rules_are_every_history_in_the_order_of_the_plan(plan):
    rules = [
        ([f"{one.fact}={one.outcome}" for one in history], names(made)) for history, made in policy(plan).rules()
    ]
    assert rules == [
        ([], ["look"]),
        (["dark=false"], ["pick", "read"]),
        (["dark=false", "open(vault)=false"], ["dial"]),
        (["dark=false", "open(vault)=true"], []),
        (["dark=true"], []),
    ]


@pytest.mark.parametrize(
    ("history", "said"),
    [
        (seen(("dark", "dim")), "observation 1: dark is dim, expected was false, true"),
        (seen(("light", "true")), "observation 1: the plan observes dark here, not light"),
        (seen(("dark", "true"), ("dark", "true")), "observation 2: the goal is reached"),
    ],
)
def test_what_a_plan_cannot_come_to_is_told(plan, history, said):
    with pytest.raises(ValueError, match=said):
        policy(plan)(history)


def test_a_tree_shares_nothing(plan):
    tree = unfold(plan)
    parents = [successor for node in tree.nodes.values() for successor in node.successors]
    assert sorted(parents) == sorted(tree.nodes.keys() - {"n0"})
    assert plan_statistics(tree).plan_leaves == plan_statistics(plan).plan_leaves == 3
    assert list(tree.nodes) == [f"n{number}" for number in range(len(tree.nodes))]


def test_a_tree_that_would_be_too_large_is_refused(plan):
    with pytest.raises(ValueError, match="3 leaves, more than 2"):
        unfold(plan, limit=2)
