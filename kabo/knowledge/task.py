"""A grounded problem: initial knowledge, actions, branchings and goal, all as bits of one integer."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from kabo.knowledge.actions import Branching, GroundAction
from kabo.knowledge.closure import Closure
from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import Group, open_entries
from kabo.knowledge.normal_form import NormalForm
from kabo.knowledge.queries import GeometricOracle, Query, bits_of, optimistic, tested_for_zero, union
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

    @cached_property
    def normal_form(self) -> NormalForm:
        """What makes states that say the same equal."""
        return NormalForm((p for p in self.closure.propagators if isinstance(p, Entry)), self.width)

    @cached_property
    def less_is_less(self) -> bool:
        """Whether a state that knows a part of what another one knows never leads to more than that.

        So it is where nothing asks for what is not known, and what actions do does not depend on what is known.
        """
        asked = [self.goal_query, *(action.precondition for action in self.actions)]
        if self.closure.rules or self.closure.monitors or any(query.has_tests for query in asked):
            return False
        effects = {id(action.effects): action.effects for action in self.actions}.values()
        fixed = all(update.is_certain and not update.assignment for each in effects for update in each.updates)
        return fixed and not union(tested_for_zero(query) for query in asked)

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
