"""Figures of a plan, counted on its graph without unfolding it, since 2^n branches may share n nodes."""

from dataclasses import dataclass

from kabo.plan.plan import Plan


@dataclass(frozen=True)
class PlanStatistics:
    """Counts for a plan: action and sense nodes on the longest branch, nodes, branches, way points."""

    plan_actions: int
    plan_nodes: int
    plan_leaves: int
    waypoints: int


def topological_order(plan: Plan) -> list[str] | None:
    """The ids of the nodes that the root reaches, each before its successors; None if the plan has a cycle.

    Successors that are not nodes of the plan are left out. Nodes that could come in any order are in the order of
    discovery, so the result is deterministic.
    """
    order: list[str] = []
    open_, done = set[str](), set[str]()
    stack = [(plan.root, False)] if plan.root in plan.nodes else []
    while stack:
        name, leave = stack.pop()
        if leave:
            open_.discard(name)
            done.add(name)
            order.append(name)
        elif name in open_:
            return None
        elif name not in done:
            open_.add(name)
            stack.append((name, True))
            successors = plan.nodes[name].successors
            if any(successor in open_ for successor in successors):
                return None
            stack.extend((s, False) for s in successors if s in plan.nodes and s not in done)
    order.reverse()
    return order


def plan_statistics(plan: Plan) -> PlanStatistics:
    """The statistics of a plan.

    Raises:
        ValueError: the plan has a cycle, so it has no longest branch.
    """
    order = topological_order(plan)
    if order is None:
        raise ValueError("the plan has a cycle")
    longest, leaves = dict.fromkeys(order, 0), dict.fromkeys(order, 0)
    for name in reversed(order):
        node = plan.nodes[name]
        after = [s for s in node.successors if s in longest]
        leaves[name] = 1 if node.kind == "goal" else sum(leaves[s] for s in after)
        longest[name] = (node.kind in ("action", "sense")) + max((longest[s] for s in after), default=0)
    waypoints = sum(len(segment.waypoints) for node in plan.nodes.values() for segment in node.motion)
    return PlanStatistics(longest.get(plan.root, 0), len(plan.nodes), leaves.get(plan.root, 0), waypoints)
