"""Builds a plan from its leaves: equal content becomes one node, so 2^n branches may share few nodes.

Source: docs/reference/plans.md.

Nodes are added bottom-up with the handles of their successors; `build` numbers the nodes that the root reaches.
"""

import hashlib
from collections.abc import Hashable, Mapping
from dataclasses import replace

from kabo.plan.plan import Node, Plan, StateChange
from kabo.plan.writing import canonical, rounded, rounded_state, rounded_to_json

_FIRST = {"false": 0, "true": 1}


class PlanBuilder:
    """Hash-conses nodes: `add` returns the same handle for the same content.

    Two nodes are equal if their actions, arguments, motions, `after`, continuations, and the starting values of
    the components that the motion moves are equal. Starting values are not part of a node, so `add` takes them as
    `moved`.
    """

    def __init__(self) -> None:
        self._nodes: dict[str, Node] = {}
        self._handles: dict[tuple[bytes, Hashable, Hashable], str] = {}

    def goal(self) -> str:
        """The handle of the only goal node."""
        return self.add(Node("goal"))

    def add(self, node: Node, moved: Hashable = ()) -> str:
        """The handle of a node; `next` and `branches` are handles that `add` has returned before.

        Args:
            node: the node; its joints and times are rounded as in the plan's file.
            moved: the values, at the node's start, of the components that its motion moves or refers to.

        Raises:
            ValueError: a successor was not added before.
        """
        node = replace(rounded(node), branches=_in_order(node.branches))
        for successor in node.successors:
            if successor not in self._nodes:
                raise ValueError(f"add the successor {successor!r} first: plans are built from their leaves")
        # Motions are compared as they are: most of a node are their numbers, which are much slower to write.
        rest = canonical(rounded_to_json(replace(node, motion=())))
        key = hashlib.sha256(rest).digest(), node.motion, moved
        handle = self._handles.setdefault(key, f"#{len(self._handles)}")
        self._nodes.setdefault(handle, node)
        return handle

    def node(self, handle: str) -> Node:
        """The node that belongs to a handle."""
        return self._nodes[handle]

    def build(
        self,
        root: str,
        *,
        problem: str,
        files: Mapping[str, str],
        options: Mapping[str, str | float | int | None],
        start: StateChange | None = None,
    ) -> Plan:
        """The plan that begins at `root`, its nodes numbered breadth-first and the goal last."""
        order = self._breadth_first(root)
        names = {handle: f"n{i}" for i, handle in enumerate(order)}
        nodes = {names[handle]: _renamed(self._nodes[handle], names) for handle in order}
        first = None if start is None else rounded_state(start)
        return Plan(problem, dict(files), dict(options), names[root], nodes, first)

    def _breadth_first(self, root: str) -> list[str]:
        order, seen = [root], {root}
        for handle in order:  # the list grows during the loop
            for successor in self._nodes[handle].successors:
                if successor not in seen:
                    seen.add(successor)
                    order.append(successor)
        goals = [handle for handle in order if self._nodes[handle].kind == "goal"]
        return [handle for handle in order if self._nodes[handle].kind != "goal"] + goals


def _in_order(branches: Mapping[str, str]) -> dict[str, str]:
    """The branches with `false` before `true`, and values in the order of their declaration, as they were added."""
    return dict(sorted(branches.items(), key=lambda branch: _FIRST.get(branch[0], 0)))


def _renamed(node: Node, names: Mapping[str, str]) -> Node:
    following = None if node.next is None else names[node.next]
    return replace(node, next=following, branches={o: names[s] for o, s in node.branches.items()})
