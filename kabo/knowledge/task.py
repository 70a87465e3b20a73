"""A grounded problem: initial knowledge, actions, branchings and goal, all as bits of one integer."""

from collections.abc import Mapping
from dataclasses import dataclass

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.facts import Group, open_entries
from kabo.knowledge.queries import GeometricOracle, Query, bits_of, optimistic
from kabo.knowledge.relevance import Relevance


@dataclass(frozen=True)
class GoalPart:
    """One conjunct of the goal, with its text for explanations."""

    text: str
    query: Query


@dataclass(frozen=True)
class Task:
    """A grounded problem.

    `entries` maps every Kw and Kv bit to its fact, `whether` are all of them; `branchings` maps those that can be
    branched on to how they split, `pending` are all of these.
    """

    initial: int
    actions: tuple[GroundAction, ...]
    goal: tuple[GoalPart, ...]
    entries: Mapping[int, str]
    whether: int
    branchings: Mapping[int, Branching]
    pending: int
    goal_query: Query
    relevance: Relevance
    closure: Closure
    may_wait: bool  # whether more knowledge may be less: then it may be wise not to branch on what was sensed
    groups: tuple[Group, ...]  # the bits of all atoms and terms that can change
    functional: int  # the bits of known values of terms: of each term at most one is set
    width: int  # how many bits a state has

    def is_goal(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the goal holds."""
        return self.goal_query.holds(state, test)

    def open_branchings(self, state: int) -> list[Branching]:
        """Every entry of the state that could be branched on."""
        return [self.branchings[bit] for bit in bits_of(open_entries(state, self.pending))]

    def open_branching(self, state: int) -> Branching | None:
        """The first entry of the state to branch on, or None if nothing that was sensed is open."""
        pending = open_entries(state, self.pending)
        return self.branchings[pending & -pending] if pending else None
