"""Two readings of docs/explanation/knowledge.md agree: what the planner finds, the verifier's own interpreter accepts."""

from dataclasses import replace

from hypothesis import event, given
from hypothesis import strategies as st

from kabo.planner.solve import solve
from kabo.verify import verify_plan
from tests.support import small_problems


@given(problem=st.one_of(small_problems.problems(), small_problems.branching_problems()))
def test_every_plan_that_is_found_is_verified(problem):
    plan = solve(problem, max_expansions=300).plan
    if plan is None:
        event("no plan")
        return
    report = verify_plan(problem, plan)
    event(f"branches: {min(report.branches, 3)}")
    assert report.ok, f"{report}\n{plan}"


@given(problem=small_problems.branching_problems(), data=st.data())
def test_a_plan_that_lacks_a_branch_is_not_verified(problem, data):
    """The planner branches only where both outcomes are possible."""
    plan = solve(problem, max_expansions=300).plan
    if plan is None:
        return
    branching = [name for name, node in plan.nodes.items() if len(node.branches) > 1]
    if branching:
        name = data.draw(st.sampled_from(branching))
        outcome = data.draw(st.sampled_from(sorted(plan.nodes[name].branches)))
        rest = {o: s for o, s in plan.nodes[name].branches.items() if o != outcome}
        spoiled = replace(plan, nodes={**plan.nodes, name: replace(plan.nodes[name], branches=rest)})
        event("a branch is missing")
        assert not verify_plan(problem, spoiled).ok
