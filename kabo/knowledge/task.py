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
class GroundedTask:
    """A grounded problem.

    `entries` maps every Kw and Kv bit to the text of its fact, and `whether` is the mask of all these bits.
    `branchings` maps every Kw and Kv bit that allows branching to its branching, and `pending` is the mask of
    these bits.
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
    may_wait: bool  # whether knowing more may make something false, so that it may pay not to branch at once
    groups: tuple[Group, ...]  # the bits of all atoms and terms that can change
    functional: int  # the bits of known values of terms, of which each term has at most one set
    width: int  # the number of bits of a state

    @cached_property
    def normal_form(self) -> NormalForm:
        """The normal form of this task's states, by which equivalent states are found."""
        return NormalForm((p for p in self.closure.propagators if isinstance(p, Entry)), self.width)

    @cached_property
    def less_is_less(self) -> bool:
        """Whether a state never has a plan that a state with more knowledge lacks.

        This is so where nothing requires that something is unknown, and no effect depends on what is known.
        """
        asked = [self.goal_query, *(action.precondition for action in self.actions)]
        if self.closure.rules or self.closure.monitors or any(query.has_tests for query in asked):
            return False
        effects = {id(action.effects): action.effects for action in self.actions}.values()
        fixed = all(update.is_certain and not update.assignment for each in effects for update in each.updates)
        return fixed and not union(tested_for_zero(query) for query in asked)

    def is_goal(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the goal holds in the state."""
        return self.goal_query.holds(state, test)

    def open_branchings(self, state: int) -> list[Branching]:
        """The branchings on all Kw and Kv entries of the state that are still open."""
        return [self.branchings[bit] for bit in bits_of(open_entries(state, self.pending))]

    def open_branching(self, state: int) -> Branching | None:
        """The branching on the first open Kw or Kv entry of the state; None if there is none."""
        pending = open_entries(state, self.pending)
        return self.branchings[pending & -pending] if pending else None
