"""Checks the plan as a graph: every successor exists, every node is reached, there is no cycle, and one goal."""

from collections.abc import Iterator

from kabo.plan import Plan, topological_order
from kabo.verify.report import Finding


def check_structure(plan: Plan) -> tuple[list[str], list[Finding]]:
    """The reached nodes in topological order (none if the plan has a cycle), and the findings about the graph."""
    findings = list(_missing(plan))
    if plan.root not in plan.nodes:
        findings.append(Finding(plan.root, "the root is no node of the plan"))
    order = topological_order(plan)
    if order is None:
        return [], [*findings, Finding(_on_cycle(plan), "the plan runs in a circle through this node")]
    reached = set(order)
    findings.extend(Finding(name, "no way leads to this node") for name in plan.nodes if name not in reached)
    return order, findings


def _missing(plan: Plan) -> Iterator[Finding]:
    for name, node in plan.nodes.items():
        if node.kind != "goal" and not node.successors:
            yield Finding(name, "nothing follows, and it is no goal")
        for successor in node.successors:
            if successor not in plan.nodes:
                yield Finding(name, f"continues at {successor}, which is no node of the plan")


def _on_cycle(plan: Plan) -> str | None:
    """A node on a cycle or before one, which is left after nodes without successors are removed repeatedly."""
    rest = {name: {s for s in node.successors if s in plan.nodes} for name, node in plan.nodes.items()}
    while True:
        ends = [name for name, successors in rest.items() if not successors & rest.keys()]
        if not ends:
            return next(iter(rest), None)
        for name in ends:
            del rest[name]
