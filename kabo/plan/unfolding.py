"""A plan as a tree: every branch has nodes of its own, for readers that do not support shared nodes."""

from dataclasses import replace

from kabo.given import require_given, require_number
from kabo.plan.plan import Node, Plan
from kabo.plan.statistics import plan_statistics

MAX_LEAVES = 100_000  # of the tree; n binary observations one after the other have 2^n


def unfold(plan: Plan, limit: int = MAX_LEAVES) -> Plan:
    """The plan without shared nodes; its branches are the same and in the same order.

    Nodes, goals included, are numbered breadth-first; the certificate, which refers to nodes, is left out.

    Args:
        plan: a plan without cycles.
        limit: the greatest number of leaves of the tree.

    Raises:
        ArgumentError: `plan` is none, or `limit` is no whole number.
        ValueError: the plan has a cycle, or more branches than `limit`.
    """
    require_given("plan", plan, Plan)
    require_number("limit", limit, 1, whole=True)
    leaves = plan_statistics(plan).plan_leaves
    if leaves > limit:
        raise ValueError(f"the tree would have {leaves} leaves, more than {limit}")
    nodes: dict[str, Node] = {}
    order = [plan.root]
    for number, name in enumerate(order):  # the list grows during the loop
        node = plan.nodes[name]
        after = len(order)
        order += node.successors
        if node.branches:
            branches = {outcome: f"n{after + i}" for i, outcome in enumerate(node.branches)}
            node = replace(node, branches=branches)
        elif node.next is not None:
            node = replace(node, next=f"n{after}")
        nodes[f"n{number}"] = node
    return replace(plan, root="n0", nodes=nodes, certificate=None)
