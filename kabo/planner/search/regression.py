"""Regression: computes the bits of a state that a continuation needs; it solves every node with these bits.

Besides the bits of the knowledge state, there is one derived bit for each compound conjunct of the goal. "The
conjunct for bottle 3 holds" thus remains one condition, whatever makes it true: an empty bottle in the dishwasher,
or a bottle that is not empty. A derived bit is replaced by plain bits only where a step changes something that the
conjunct reads.
"""

from dataclasses import dataclass

from kabo.knowledge import Branching, Query
from kabo.knowledge.queries import AllOf, bits_of, union
from kabo.planner.search.nodes import Act, Node, SearchSpace


@dataclass(frozen=True)
class _Derived:
    """The derived bit of a compound goal conjunct, with a cache of its truth by the bits that it reads."""

    bit: int
    query: Query
    known: dict[int, bool]

    def holds(self, state: int) -> bool:
        """Whether the conjunct holds in a state; cached, because every node asks."""
        read = state & self.query.reads
        answer = self.known.get(read)
        if answer is None:
            answer = self.known[read] = self.query.holds(state)
        return answer


class Regression:
    """Computes, step by step backwards through a plan, the bits that it needs; for one task."""

    def __init__(self, space: SearchSpace) -> None:
        self._space = space
        self._width = space.task.width
        self._plain = (1 << self._width) - 1
        self._inferred = space.task.closure.makes | space.task.closure.clears
        parts = [part.query for part in space.task.goal]
        self._tested = [query for query in parts if query.has_tests]
        compound = [query for query in parts if not query.has_tests and not isinstance(query, AllOf)]
        self._derived = [_Derived(1 << (self._width + number), query, {}) for number, query in enumerate(compound)]
        self._goal = union(query.mask for query in parts if isinstance(query, AllOf)) | union(
            derived.bit for derived in self._derived
        )

    def extended(self, state: int) -> int:
        """The state extended by the derived bits that hold in it."""
        for derived in self._derived:
            if derived.holds(state):
                state |= derived.bit
        return state

    def goal(self, node: Node) -> int:
        """The bits of a node's state because of which the goal holds."""
        oracle = self._space.oracle(node[1])
        return self._goal | union(query.support(node[0], oracle) for query in self._tested)

    def before_action(self, node: Node, step: Act, after: Node, needed: int) -> int:
        """The bits that `node` needs so that the step is applicable and the bits `needed` after it hold."""
        action = step.action
        needed = self._unfolded(after[0], needed, action.effects.writes | self._inferred)
        plain = action.needs(node[0], needed & self._plain, self._space.oracle(node[1]))
        return plain | needed & ~self._plain

    def before_branching(self, node: Node, branching: Branching, outcome: str, after: Node, needed: int) -> int:
        """The bits needed before a branching so that the bits `needed` hold after one outcome.

        The entry that is branched on is needed as well; it is not included.
        """
        needed = self._unfolded(after[0], needed, branching.mask | self._inferred)
        return branching.needs(node[0], outcome, needed & self._plain) | needed & ~self._plain

    def ignores(self, branching: Branching, after: Node, needed: int) -> bool:
        """Whether the continuation needs nothing that depends on the sensed outcome."""
        needed = self._unfolded(after[0], needed, branching.mask | self._inferred)
        return not needed & branching.mask & ~branching.entry

    def _unfolded(self, state: int, needed: int, written: int) -> int:
        """Replaces each derived bit whose conjunct a step may change by the bits that make the conjunct hold now."""
        for bit in bits_of(needed & ~self._plain):
            query = self._derived[bit.bit_length() - 1 - self._width].query
            if query.reads & written:
                needed = needed & ~bit | query.support(state)
        return needed
