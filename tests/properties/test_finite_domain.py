"""Searches and estimates against the slow and obvious, on random tasks."""

import os

from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.finite_domain import RelaxedOperator, RelaxedTask

EXAMPLES = max(30, int(3000 * float(os.environ.get("KABO_PROPERTY_SCALE", "0.1"))))
FACTS = 12
facts = st.integers(0, FACTS - 1)
operators = st.builds(
    RelaxedOperator,
    st.lists(facts, max_size=3).map(tuple),
    st.lists(facts, max_size=3).map(tuple),
    st.sampled_from([0, 0, 1, 1, 2, 5, 700, 40_000]),
    st.integers(-1, 6),
)


def fixpoint(true, operators):
    """All that can become true, one operator at a time."""
    true, grown = set(true), True
    while grown:
        grown = False
        for o in operators:
            if true.issuperset(o.preconditions) and not true.issuperset(o.adds):
                true.update(o.adds)
                grown = True
    return true


@settings(max_examples=EXAMPLES)
@given(
    st.lists(operators, max_size=25),
    st.lists(
        st.tuples(st.sets(facts, max_size=4), st.lists(facts, min_size=1, max_size=4)), min_size=1, max_size=4
    ),
)
def test_relaxed_plans_reach_the_goal_and_both_twins_find_the_same(operators, questions):
    compiled = RelaxedTask(
        FACTS, operators, (), engine="compiled"
    )  # nothing of one question may be left in the next
    for true, goal in questions:
        ask(compiled, operators, true, tuple(goal))


def ask(compiled, operators, true, goal):
    plain = RelaxedTask(FACTS, operators, goal, engine="python")
    reached = fixpoint(true, operators)
    estimate = plain.evaluate(sorted(true))
    assert {f for f in range(FACTS) if plain.reachable(sorted(true))[f]} == reached
    assert (estimate.value is None) == (not reached.issuperset(goal))
    event("unreachable" if estimate.value is None else f"{len(estimate.plan_facts)} facts to make")
    assert compiled.evaluate(sorted(true), goal) == estimate
    assert compiled.evaluate(sum(1 << f for f in true), goal) == estimate
    if estimate.value is not None:
        judge(estimate, operators, true, goal)


def judge(estimate, operators, true, goal):
    """The facts of the plan can be made from each other, and with axioms reach the goal; the preferred can go."""
    axioms = [o for o in operators if o.cost == 0 and o.owner < 0]
    now = fixpoint(true, axioms)
    inside = now | set(estimate.plan_facts)
    assert not now & set(estimate.plan_facts)
    useful = [o for o in operators if inside.issuperset(o.preconditions)]
    limited = [
        RelaxedOperator(o.preconditions, tuple(inside.intersection(o.adds)), o.cost, o.owner) for o in useful
    ]
    assert fixpoint(true, limited) == inside
    assert inside.issuperset(goal)
    for owner in estimate.preferred:
        assert any(o.owner == owner and now.issuperset(o.preconditions) for o in operators)
    needed = fixpoint(true, [o for o in operators if o.cost == 0])
    assert estimate.value > 0 or needed.issuperset(goal)
