"""One branch of a plan, chosen by its outcomes or by a node that it leads through."""

from collections.abc import Mapping, Sequence

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.plan.plan import Plan
from kabo.plan.statistics import topological_order

Step = tuple[str, str | None]  # a node of a branch, and the outcome by which the branch goes on


def branch_of(plan: Plan, wanted: str | None, file: str) -> list[Step]:
    """The nodes of one branch with their outcomes.

    Args:
        plan: a plan without cycles. wanted: outcomes in order, separated by commas; or a node that the branch leads
            through; None for the branch with most actions. file: the plan's name in errors.

    Raises:
        InputError: there is no such node, or no such outcome where it is asked for.
    """
    order = topological_order(plan)
    if order is None:
        raise InputError([Diagnostic(file, 1, 1, "the plan has a cycle", "see `kabo verify`")])
    if wanted is None:
        return _following(plan, plan.root, _longest(plan, order))
    if wanted in plan.nodes:
        return _through(plan, wanted, order)
    words = [word.strip() for word in wanted.split(",")]
    if len(words) == 1 and not any(words[0] in node.branches for node in plan.nodes.values()):
        outcomes = {outcome for node in plan.nodes.values() for outcome in node.branches}
        hint = did_you_mean(words[0], [*plan.nodes, *outcomes])
        raise _refusal(file, f'"{words[0]}" is neither a node nor an outcome of this plan', hint or _nodes(plan))
    return _by_outcomes(plan, words, _longest(plan, order), file)


def _by_outcomes(plan: Plan, words: Sequence[str], longest: Mapping[str, str | None], file: str) -> list[Step]:
    steps: list[Step] = []
    name, left = plan.root, list(words)
    while left:
        node = plan.nodes[name]
        outcome = None
        if node.branches:
            outcome = left.pop(0)
            if outcome not in node.branches:
                hint = did_you_mean(outcome, node.branches) or f"its outcomes: {', '.join(node.branches)}"
                raise _refusal(file, f'{name} ({node.on}) has no outcome "{outcome}"', hint)
        elif not node.successors:
            said = f"the branch ends at {name}: nothing is left to observe for {', '.join(left)}"
            raise _refusal(file, said, f"give {len(words) - len(left)} outcomes")
        steps.append((name, outcome))
        name = node.branches[outcome] if outcome is not None else str(node.next)
    return steps + _following(plan, name, longest)


def _through(plan: Plan, node: str, order: Sequence[str]) -> list[Step]:
    """The shortest way to a node, in observations and actions, and the longest branch after it."""
    way: dict[str, list[Step]] = {plan.root: []}
    for name in order:  # each before its successors
        each = plan.nodes[name]
        following = each.branches.items() if each.branches else [(None, s) for s in each.successors]
        for outcome, after in following:
            longer = [*way[name], (name, outcome)]
            if after not in way or len(longer) < len(way[after]):
                way[after] = longer
    return way[node] + _following(plan, node, _longest(plan, order))


def _following(plan: Plan, name: str, longest: Mapping[str, str | None]) -> list[Step]:
    steps: list[Step] = []
    at: str | None = name
    while at is not None:
        node, after = plan.nodes[at], longest[at]
        outcome = next((key for key, value in node.branches.items() if value == after), None)
        steps.append((at, outcome))
        at = after
    return steps


def _longest(plan: Plan, order: Sequence[str]) -> dict[str, str | None]:
    """For every node the successor with most motions to the goal; the first of them among equals."""
    counts: dict[str, int] = {}
    best: dict[str, str | None] = {}
    for name in reversed(order):
        node = plan.nodes[name]
        best[name] = max(node.successors, key=lambda after: counts[after], default=None)
        after = best[name]
        counts[name] = bool(node.motion) + (0 if after is None else counts[after])
    return best


def _refusal(file: str, message: str, hint: str) -> InputError:
    return InputError([Diagnostic(file, 1, 1, message, hint)])


def _nodes(plan: Plan) -> str:
    return f"nodes are {plan.root} to n{len(plan.nodes) - 1}; outcomes stand in the printed plan"
