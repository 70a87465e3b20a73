"""Nogoods: nodes and choices that fail, each with the ancestors on which its failure depends.

A plan is acyclic, so while a node is being solved, its descendants must not lead back to it. A failure found
meanwhile says "there is no plan that avoids the nodes `blocked`". It holds wherever all of these nodes are
ancestors, and everywhere if `blocked` is empty. A node's own key is removed from its failure, since a plan for a
node never returns to the node anyway.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass

from kabo import tuning

Choice = Hashable  # what is tried at a node: (index of the action, attempt), or the entry that is branched on


@dataclass(frozen=True)
class Nogood:
    """The statement that no plan avoids the nodes `blocked`, attached to a node or a choice."""

    blocked: frozenset[Hashable]


class Nogoods:
    """The nogoods of nodes and of choices at nodes; `path` holds the keys of the nodes being solved.

    `less_is_less`: whether a state that knows less can never achieve more. A state proven to have no plan then
    rules out every state that knows only part of what it knows.
    """

    def __init__(self, *, less_is_less: bool = False) -> None:
        self._less_is_less = less_is_less
        self._hopeless: list[int] = []  # states without a plan, none of them a part of another one
        self.path: set[Hashable] = set()
        self._nodes: dict[Hashable, Nogood] = {}
        self._choices: dict[Hashable, dict[Choice, Nogood]] = {}

    def of_node(self, key: Hashable, state: int) -> Nogood | None:
        """The nogood that rules a node out while `path` is being solved, or None.

        A node is ruled out if it is on the path, or if its known failure depends only on nodes of the path.
        """
        if key in self.path:
            return Nogood(frozenset([key]))
        failure = self._nodes.get(key)
        if failure is not None and failure.blocked <= self.path:
            return failure
        for more in self._hopeless:
            if not state & ~more:
                return Nogood(frozenset())
        return None

    def of_choice(self, key: Hashable, choice: Choice) -> Nogood | None:
        """The nogood that rules a choice out at a node while `path` is being solved, or None."""
        choices = self._choices.get(key)
        failure = None if choices is None else choices.get(choice)
        return failure if failure is not None and failure.blocked <= self.path else None

    def add_choice(self, key: Hashable, choice: Choice, failure: Nogood) -> None:
        """Records that a choice failed at a node; the node's own key is removed from the failure."""
        self._choices.setdefault(key, {})[choice] = Nogood(failure.blocked - {key})

    def add_nodes(self, key: Hashable, state: int, visited: Iterable[Hashable], blocked: set[Hashable]) -> Nogood:
        """Records that a search from `key` found no end; returns the nogood, which all visited nodes share."""
        failure = Nogood(frozenset(blocked - {key}))
        if self._less_is_less and not failure.blocked:
            self._hopeless = [less for less in self._hopeless if less & ~state][-tuning.MAX_DEAD_STATES :] + [
                state
            ]
        for node in visited:
            known = self._nodes.get(node)
            if known is None or not known.blocked <= failure.blocked:
                self._nodes[node] = failure
        return failure
