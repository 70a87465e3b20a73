"""A plan as a tree: every branch with nodes of its own, for readers that know no sharing."""

from dataclasses import replace

from kabo.plan.plan import Node, Plan
from kabo.plan.statistics import plan_statistics

LIMIT = 100_000  # leaves; n binary observations one after the other have 2^n


def unfold(plan: Plan, limit: int = LIMIT) -> Plan:
    """The same plan with nothing shared: its branches are those of the plan, in the same order.

    Nodes are numbered breadth-first, goals among them; the certificate, which speaks of nodes, is left out.

    Args:
        plan: a plan without cycles.
        limit: leaves of the tree at most.

    Raises:
        ValueError: the plan has a cycle, or more branches than `limit`.
    """
    leaves = plan_statistics(plan).plan_leaves
    if leaves > limit:
        raise ValueError(f"the tree would have {leaves} leaves, more than {limit}")
    nodes: dict[str, Node] = {}
    order = [plan.root]
    for number, name in enumerate(order):  # the list grows while it is walked
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
