"""Nogoods: nodes and choices that fail, and on which ancestors each failure depends.

A plan is acyclic, so while a node is being solved its descendants must not lead back to it. A failure found then
says "there is no plan that avoids the nodes `blocked`"; it holds wherever all of these are ancestors, and everywhere
if there are none. A node's own key is dropped from its failure: a plan for a node never returns to it anyway.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass

from kabo import tuning

Choice = Hashable  # what is tried at a node: (index of the action, attempt), or the entry that is branched on


@dataclass(frozen=True)
class Nogood:
    """There is no plan that avoids these nodes."""

    blocked: frozenset[Hashable]


class Nogoods:
    """Nogoods of nodes and of single choices at a node; `path` holds the nodes that are being solved.

    With `less_is_less` (a state that knows less can never do more), a state without a plan rules out all states that
    know only a part of what it knows.
    """

    def __init__(self, *, less_is_less: bool = False) -> None:
        self._less_is_less = less_is_less
        self._hopeless: list[int] = []  # states without a plan, none of them a part of another one
        self.path: set[Hashable] = set()
        self._nodes: dict[Hashable, Nogood] = {}
        self._choices: dict[Hashable, dict[Choice, Nogood]] = {}

    def of_node(self, key: Hashable, state: int) -> Nogood | None:
        """The nogood that rules a node out below `path`: it is on the path, or failed for ancestors that are; or None."""
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
        """The nogood that rules a choice out at a node, below `path`; or None."""
        choices = self._choices.get(key)
        failure = None if choices is None else choices.get(choice)
        return failure if failure is not None and failure.blocked <= self.path else None

    def add_choice(self, key: Hashable, choice: Choice, failure: Nogood) -> None:
        """Records that an outcome of a choice failed; the node itself is dropped from the failure."""
        self._choices.setdefault(key, {})[choice] = Nogood(failure.blocked - {key})

    def add_nodes(self, key: Hashable, state: int, visited: Iterable[Hashable], blocked: set[Hashable]) -> Nogood:
        """Records that a search from `key` reached no end: all visited nodes share its nogood, which is returned."""
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
