"""Explains why a goal that the delete relaxation reaches has no plan: dead ends, or outcomes without a plan."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from kabo.knowledge import GroundedTask, relaxed_reach
from kabo.planner.proofs.wording import listed
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.nodes import Assume, Node, SearchSpace, Step
from kabo.planner.search.nogoods import Nogoods
from kabo.planner.search.skeleton import SearchLimits, Unreachable
from kabo.planner.search.weak_plans import BudgetSpent, Counter, WeakGraph, steps_of

MAX_EXPANSIONS = 5_000  # node expansions of all the searches below together
MAX_PARTS = 20  # conjuncts of the goal that are searched for one by one
SHOWN_STEPS = 6  # actions, or conjuncts, that a sentence lists


def dead_ends(task: GroundedTask, deadline: Callable[[], bool] | None = None) -> list[str]:
    """Sentences that say why a task has no plan; an empty list if no reason is found within the limits.

    Args:
        task: a task that is proven to have no plan.
        deadline: called periodically; True ends the searches.
    """
    ends = _DeadEnds(SearchSpace(task, None), Counter(SearchLimits(MAX_EXPANSIONS, deadline)))
    try:
        steps = ends.lucky(ends.space.is_goal)
        return list(ends.bad_luck(steps)) if steps else list(ends.apart())
    except BudgetSpent:
        return []


@dataclass
class _DeadEnds:
    space: SearchSpace
    counter: Counter

    def lucky(self, is_end: Callable[[Node], bool]) -> list[Step]:
        """A weak plan to an end, with the outcomes of sensing assumed; empty if there is none."""
        graph = WeakGraph(self.space, Nogoods(), self.counter, is_end)
        found = ALGORITHMS["best"](self.space.start, graph)
        return [] if found.path is None else steps_of(found.path)

    def bad_luck(self, steps: list[Step]) -> Iterator[str]:
        """Sentences about outcomes other than the assumed ones, from which the goal is out of reach."""
        way = listed((str(step.action) for step in steps if not isinstance(step, Assume)), "and", SHOWN_STEPS)
        lucky = f"With luck {way} would reach the goal" if way else "With luck the goal would hold already"
        node, explained = self.space.start, False
        for step in steps:
            others = self.space.outcomes(node, step.branching) if isinstance(step, Assume) else []
            for outcome, child in others:
                if isinstance(step, Assume) and outcome != step.outcome and (why := self.lost(child[0])):
                    explained = True
                    yield f"{lucky}; but once {step.branching.fact} turns out to be {outcome}, {why}."
            node = self.space.after(node, step)
        if not explained:
            facts = listed((step.branching.fact for step in steps if isinstance(step, Assume)), "and")
            yield f"{lucky}, but no plan does whatever {facts} turns out to be."

    def lost(self, state: int) -> str:
        """What is out of reach from a state, as text; empty if nothing is, or if the budget is spent."""
        task, spent = self.space.task, self.counter.expanded
        reach = relaxed_reach(state, task.actions, task.branchings, task.closure)
        lost = [part.text for part in task.goal if not part.query.possible(reach.ones, reach.zeros)]
        if lost:
            return f"{listed(lost, 'and')} can never hold any more"
        found = find_skeleton(
            replace(task, initial=state), limits=SearchLimits(MAX_EXPANSIONS - spent, self.counter.limits.deadline)
        )
        self.counter.expanded += found.statistics.expanded
        return "no plan reaches the goal any more" if isinstance(found, Unreachable) else ""

    def apart(self) -> Iterator[str]:
        """Sentences about conjuncts of the goal that cannot be reached alone, where there is no weak plan."""
        parts = self.space.task.goal
        if len(parts) == 1 or len(parts) > MAX_PARTS:
            yield "Not even with luck in all that is sensed is there a way: what it needs never holds all at once."
            return
        alone: list[str] = []
        for number, part in enumerate(parts):
            steps = [] if self.space.holds((number,), self.space.start) else self.lucky(self.holds(number))
            if steps == [] and not self.space.holds((number,), self.space.start):
                alone.append(part.text)
        if alone:
            yield f"Not even alone, and with luck in all that is sensed, can {listed(alone, 'or')} be reached."
        else:
            texts = listed((part.text for part in parts), "and", SHOWN_STEPS)
            yield f"Each part of the goal can be reached alone, but not {texts} together, not even with luck."

    def holds(self, number: int) -> Callable[[Node], bool]:
        return lambda node: self.space.holds((number,), node)
