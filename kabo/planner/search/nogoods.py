"""What could not be solved, and on which ancestors that depends.

A plan is acyclic, so while a node is being solved its descendants must not come back to it. A failure found on the
way says "no plan that avoids the nodes `blocked`"; it holds wherever all of these are ancestors, and everywhere if
there are none. A node's own key is dropped from its failure: a plan for the node never comes back to it anyway.
"""

from collections.abc import Hashable, Iterable
from dataclasses import dataclass

from kabo import tuning

Choice = Hashable  # what is tried at a node: (index of the action, attempt), or the entry that is branched on


@dataclass(frozen=True)
class Failure:
    """No plan that avoids these nodes."""

    blocked: frozenset[Hashable]


class Failures:
    """Failures of nodes and of single choices at a node, and the `path` of nodes that are being solved.

    Where `less_is_less` (knowledge that is part of other knowledge never leads to more), what fails everywhere fails
    for all that know a part of it, as what is solved is solved for all that know more.
    """

    def __init__(self, *, less_is_less: bool = False) -> None:
        self._less_is_less = less_is_less
        self._hopeless: list[int] = []  # states without a plan, none of them a part of another one
        self.path: set[Hashable] = set()
        self._nodes: dict[Hashable, Failure] = {}
        self._choices: dict[Hashable, dict[Choice, Failure]] = {}

    def of_node(self, key: Hashable, state: int) -> Failure | None:
        """Why a node is not to be solved here: it is being solved already, or failed for the same reasons."""
        if key in self.path:
            return Failure(frozenset([key]))
        failure = self._nodes.get(key)
        if failure is not None and failure.blocked <= self.path:
            return failure
        for more in self._hopeless:
            if not state & ~more:
                return Failure(frozenset())
        return None

    def of_choice(self, key: Hashable, choice: Choice) -> Failure | None:
        """Why a choice is banned at a node."""
        choices = self._choices.get(key)
        failure = None if choices is None else choices.get(choice)
        return failure if failure is not None and failure.blocked <= self.path else None

    def add_choice(self, key: Hashable, choice: Choice, failure: Failure) -> None:
        """An outcome of the choice failed; the node itself does not count as an obstacle."""
        self._choices.setdefault(key, {})[choice] = Failure(failure.blocked - {key})

    def add_nodes(self, key: Hashable, state: int, visited: Iterable[Hashable], blocked: set[Hashable]) -> Failure:
        """All of a search from `key` that reached no end failed for the same reasons; returns that failure."""
        failure = Failure(frozenset(blocked - {key}))
        if self._less_is_less and not failure.blocked:
            self._hopeless = [less for less in self._hopeless if less & ~state][-tuning.MAX_DEAD_STATES :] + [
                state
            ]
        for node in visited:
            known = self._nodes.get(node)
            if known is None or not known.blocked <= failure.blocked:
                self._nodes[node] = failure
        return failure
