"""What was done before a plan begins, as nodes before its root: both judges of knowledge follow it by their own rules."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from kabo.plan import Node, Plan, State, StateChange
from kabo.plan.writing import rounded_state
from kabo.verify.report import Finding

_PAST = "done "  # no id of a plan begins like this


def is_past(name: str) -> bool:
    """Whether a node was done before the plan begins: other outcomes of it than the observed one need no branch."""
    return name.startswith(_PAST)


def with_past(plan: Plan, order: Sequence[str]) -> tuple[Plan, list[str]]:
    """The plan with what was done before it as nodes, and all its nodes in topological order."""
    done = plan.done or ()
    names = [*(f"{_PAST}{number}" for number in range(len(done))), plan.root]
    before: dict[str, Node] = {}
    for name, following, step in zip(names, names[1:], done, strict=False):
        branches = {} if step.outcome is None else {step.outcome: following}
        kind = "branch" if step.action is None else "action" if step.on is None else "sense"
        successor = following if step.on is None else None
        before[name] = Node(kind, step.action, step.arguments, successor, step.on, branches)  # type: ignore[arg-type]
    return replace(plan, root=names[0], nodes={**before, **plan.nodes}), [*before, *order]


def begins_elsewhere(plan: Plan, start: State | None) -> Iterator[Finding]:
    """A finding if the plan does not begin in the state of a run in which it is to begin."""
    if start is None:
        return
    if plan.done != start.done:
        yield Finding(None, "what was done before the plan begins is not what was done in the run")
    if plan.start is not None and (start.geometry is None or plan.start != rounded_state(start.geometry)):
        run = {} if start.geometry is None else _things(rounded_state(start.geometry))
        first = min((name for name, own in _things(plan.start).items() if run.get(name) != own), default="a thing")
        yield Finding(None, f"start: {first} is not where it is in the run")


def _things(state: StateChange) -> dict[str, object]:
    """What a state says where it is: robots and objects by name."""
    return {**state.robots, **state.objects}


def told_of_past(plan: Plan, start: State | None) -> Iterator[str]:
    """A note if the plan begins in the state of a run that nobody else vouches for."""
    if plan.done is not None and start is None:
        steps = sum(1 for step in plan.done if step.action is not None)
        yield f"the plan begins after {steps} actions of a run, where its `done` and `start` say"
