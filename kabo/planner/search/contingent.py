"""Contingent search: a plan in which every leaf fulfils the goal [K 3.3, ch. 6].

A node is solved as follows. If an earlier continuation covers it, that one is reused. Otherwise a weak plan is
found, its first step is taken, and the node behind *every* outcome of this step is solved. Regression then
computes which facts the continuation needs; the continuation solves every node that has these facts. If some
outcome cannot be solved, the step is banned at this node, and the next weak plan must begin with another step.

Plans are acyclic, so that a node is never solved through one of its own ancestors. A failure is therefore
relative: it names the ancestors that would have to be visited again (`nogoods.py`). Only a failure that names none
is a proof.
"""

from collections.abc import Callable, Generator, Hashable

from kabo import tuning
from kabo.errors import CutOff
from kabo.knowledge import GroundedTask, unreachable_goals
from kabo.options import Options, Search
from kabo.planner.search.algorithms import ALGORITHMS
from kabo.planner.search.algorithms.best import newest_first
from kabo.planner.search.algorithms.graph import Algorithm
from kabo.planner.search.fixpoint import Fixpoint
from kabo.planner.search.heuristics import DEFAULT_HEURISTIC
from kabo.planner.search.late_sensing import delay_sensing
from kabo.planner.search.nodes import Assume, Node, SearchSpace, Step
from kabo.planner.search.nogoods import Nogood, Nogoods
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.regression import Regression
from kabo.planner.search.skeleton import (
    Exhausted,
    FoundSkeleton,
    Geometry,
    SearchLimits,
    SearchResult,
    Skeleton,
    SkeletonBuilder,
    Unreachable,
)
from kabo.planner.search.solved import Memo, Solved
from kabo.planner.search.weak_plans import BudgetSpent, Counter, Move, OnProgress, WeakGraph, choice_of, steps_of

Outcome = Solved | Nogood
Solving = Generator["Solving", Outcome, Outcome]  # asks for other nodes to be solved, returns its own outcome


def find_skeleton(
    task: GroundedTask,
    *,
    search: Search | None = None,
    geometry: Geometry | None = None,
    limits: SearchLimits | None = None,
    on_progress: OnProgress | None = None,
    packed: PackedTask | None = None,
    heuristic: str = DEFAULT_HEURISTIC,
) -> SearchResult:
    """A contingent plan for the task, the proof that there is none, or the budget that was spent.

    Args:
        task: the grounded problem.
        search: the algorithm for weak plans, a value of `Search`; None for the default of `Options`.
        geometry: which calls are refused and which attempts remain; None for purely symbolic planning.
        limits: the budget; None is unlimited.
        on_progress: called periodically with the statistics so far.
        packed: the same task prepared for packed searches by an earlier call; None prepares it when it is needed.
        heuristic: the heuristic for states of knowledge, a key of `HEURISTICS`.

    Raises:
        KeyError: `search` or `heuristic` is not a known name.
    """
    limits, search = limits or SearchLimits(), search or Options.search
    if search in ("best", "astar", "breadth-first") and not task.branchings:
        found = (packed or PackedTask(task)).skeleton(search, geometry, limits)
        if found is not None:
            return found
    if search == "best" and task.branchings and packed is not None:
        linear = packed.linear(geometry, limits)
        if linear is not None:
            return linear
    counter = Counter(limits, on_progress)
    try:
        for may_wait in (False, True) if task.may_wait else (False,):
            outcome = _attempts(task, geometry, may_wait, search, counter, heuristic)
            if isinstance(outcome, Solved):
                return FoundSkeleton(Skeleton(outcome.node), counter.statistics)
    except BudgetSpent as spent:
        return Exhausted(counter.statistics, spent.budget)
    except CutOff:  # geometry was asked on the way
        return Exhausted(counter.statistics, "time")
    return Unreachable(counter.statistics, tuple(unreachable_goals(task)))


def _attempts(
    task: GroundedTask, geometry: Geometry | None, may_wait: bool, search: Search, counter: Counter, heuristic: str
) -> Outcome:
    """Searches; where dead ends accumulate, `best` restarts assuming other sensing outcomes.

    Where they still accumulate, the fixpoint over all nodes takes turns with the search: it ends if there are
    finitely many nodes.
    """
    for assume_last in (True, False) if search == "best" else ():
        space = SearchSpace(task, geometry, may_wait, assume_last, heuristic)
        try:
            outcome = _run(
                _Contingent(space, ALGORITHMS[search], counter, tuning.MAX_FAILED_CHOICES).solve(space.start, [])
            )
        except _TooManyDeadEnds:
            continue
        return outcome if isinstance(outcome, Nogood) else _smaller(outcome, space, counter)
    space = SearchSpace(task, geometry, may_wait, heuristic=heuristic)
    looking = _ExhaustiveCheck(task, may_wait, counter, takes_plans=geometry is None)
    try:
        patience = tuning.FAILED_CHOICES_BEFORE_FIXPOINT
        return _run(_Contingent(space, ALGORITHMS[search], counter, patience, looking).solve(space.start, []))
    except _OutcomeKnown as decided:
        return decided.outcome


def _smaller(found: Solved, space: SearchSpace, counter: Counter) -> Solved:
    """The plan, or a smaller one from a second search that breaks ties the other way; small symbolic problems only.

    With geometry a skeleton is only a proposal, and the smaller one would be refused as often.
    """
    spent = counter.expanded
    if spent > tuning.SECOND_SEARCH_EXPANSIONS or space.geometry is not None:
        return found
    left = 2 * spent if counter.limits.expansions is None else min(2 * spent, counter.limits.expansions - spent)
    second = Counter(SearchLimits(left))  # so few that no clock need end it
    try:
        other = _run(_Contingent(space, newest_first, second, tuning.MAX_FAILED_CHOICES).solve(space.start, []))
    except (BudgetSpent, _TooManyDeadEnds):
        other = found
    counter.add(second)
    return other if isinstance(other, Solved) and _nodes(other) < _nodes(found) else found


def _nodes(solved: Solved) -> int:
    return sum(1 for _ in Skeleton(solved.node).nodes())


class _TooManyDeadEnds(Exception):
    """Too many choices failed in this attempt; caught in this module."""


class _OutcomeKnown(Exception):
    """The fixpoint has found the outcome of the attempt; caught in this module."""

    def __init__(self, outcome: Outcome) -> None:
        self.outcome = outcome
        super().__init__()


class _ExhaustiveCheck:
    """The fixpoint over all nodes, in turns with a search that fails often; with geometry it only proves failures."""

    def __init__(self, task: GroundedTask, may_wait: bool, counter: Counter, *, takes_plans: bool) -> None:
        self._task, self._may_wait, self._counter, self._takes_plans = task, may_wait, counter, takes_plans
        self._patience = tuning.FAILED_CHOICES_BEFORE_FIXPOINT
        self._nodes: Fixpoint | None = None  # made when it is first needed

    def __call__(self) -> int | None:
        """Runs the fixpoint for one turn; how many more choices may fail before the next turn, None for any number.

        Raises:
            _Decided: it has.
        """
        self._nodes = self._nodes or Fixpoint(SearchSpace(self._task, None, self._may_wait), self._counter)
        found = self._nodes.solve(max(tuning.MIN_FIXPOINT_NODES, self._counter.expanded))
        if found is False:
            raise _OutcomeKnown(Nogood(frozenset()))
        if isinstance(found, Solved):
            if self._takes_plans:
                raise _OutcomeKnown(found)
            return None
        self._patience *= tuning.FAILED_CHOICES_GROWTH
        return self._patience


def _give_up() -> int | None:
    raise _TooManyDeadEnds


class _Contingent:
    """One contingent search: its memo of solved continuations, its nogoods, and the nodes being solved."""

    def __init__(
        self,
        space: SearchSpace,
        search: Algorithm[Node, Move],
        counter: Counter,
        dead_ends: int,
        when_spent: Callable[[], int | None] = _give_up,
    ) -> None:
        self.dead_ends: int | None = dead_ends  # how many choices may fail; None: any number
        self.when_spent = when_spent  # says how many more, or ends the search
        self.space = space
        self.search = search
        self.counter = counter
        self.regression = Regression(space)
        self.memo = Memo(space.task.functional)
        self.nogoods = Nogoods(less_is_less=space.geometry is None and space.task.less_is_less)
        self.builder = SkeletonBuilder()
        self.first: dict[Hashable, list[int]] = {}  # node -> conjuncts of the goal to plan for first

    def solve(self, node: Node, plan: list[Step]) -> Solving:
        """Solves a node; `plan` is a weak plan from it that is followed first, or empty."""
        key = self.space.key(node)
        outcome: Outcome | None = self.known(node) or self.nogoods.of_node(key, node[0])
        if outcome is not None:
            return outcome
        self.nogoods.path.add(key)
        while True:
            weak = plan or self.weak_plan(node)
            if isinstance(weak, Nogood):
                outcome = weak
                break
            outcome = yield self.follow(node, weak)
            if isinstance(outcome, Solved):
                self.remember(node, outcome)
                break
            self.nogoods.add_choice(key, choice_of(weak[0]), outcome)
            if self.is_doomed(node):
                outcome = self.nogoods.add_nodes(key, node[0], [key], set())
                break
            if self.dead_ends is not None:
                self.dead_ends -= 1
                if self.dead_ends < 0:
                    self.dead_ends = self.when_spent()
            plan = []
        self.nogoods.path.discard(key)
        return outcome

    def follow(self, node: Node, plan: list[Step]) -> Solving:
        """Takes the first step of a weak plan and solves every node that it may lead to."""
        step, rest = plan[0], plan[1:]
        if isinstance(step, Assume):
            return (yield self.branch(node, step, rest))
        after = self.space.after(node, step)
        if self.space.confirmed_key(after) is None:
            return Nogood(frozenset())
        outcome = yield self.solve(after, rest)
        if isinstance(outcome, Nogood) or (step.action.call is None and self.also_solves(node, after, outcome)):
            return outcome
        needed = self.regression.before_action(node, step, after, outcome.needed)
        delivered = self.space.delivered(node, step, after)
        made = self.builder.act(step.action, step.attempt, delivered, outcome.node)
        return Solved(needed, made, outcome.length + 1)

    def branch(self, node: Node, step: Assume, rest: list[Step]) -> Solving:
        """Solves every outcome of a branching, the assumed one first: its continuation may solve the others as well."""
        branching, needed = step.branching, 0
        outcomes = self.space.outcomes(node, branching)
        children: dict[str, Solved] = {}
        assumed = dict(outcomes)[step.outcome]
        for outcome, child in sorted(outcomes, key=lambda pair: pair[0] != step.outcome):
            if child is not assumed:
                self.first[self.space.key(child)] = self.lost(assumed, child)
            solved = yield self.solve(child, rest if outcome == step.outcome else [])
            if isinstance(solved, Nogood):
                return solved
            needless = not children and self.regression.ignores(branching, child, solved.needed)
            if needless and self.also_solves(node, child, solved):
                return solved  # whatever is sensed: no branch at all
            needed |= self.regression.before_branching(node, branching, outcome, child, solved.needed)
            children[outcome] = solved
        if not children:
            return Nogood(frozenset())
        branches = tuple((outcome, children[outcome].node) for outcome, _ in outcomes)
        length = min(child.length for child in children.values())
        needed |= branching.entry | branching.excluded(node[0])
        return Solved(needed, self.builder.branch(branching.fact, branches), length)

    def weak_plan(self, node: Node) -> list[Step] | Nogood:
        """A weak plan from a node to the goal or to a solved node, sensing as late as possible; or why there is none."""
        first = self.first.pop(self.space.key(node), [])
        graph = WeakGraph(
            self.space,
            self.nogoods,
            self.counter,
            lambda end: self.known(end) is not None,
            first,
            only_goals_end=self.memo.is_empty,
        )
        if self.counter.weak_searches % 16 == 0:
            self.counter.look_at_the_clock()  # many short searches expand nothing
        found = self.search(node, graph)
        self.counter.weak_searches += 1
        if found.path is None:
            return self.nogoods.add_nodes(self.space.key(node), node[0], found.visited, graph.blocked)
        steps = steps_of(found.path)
        delayed = delay_sensing(self.space, node, steps)
        return delayed if delayed != steps and self.may_follow(node, delayed) else steps

    def is_doomed(self, node: Node) -> bool:
        """Whether some single sensing outcome makes the goal unreachable even under delete relaxation.

        Decided only for tasks without inference: there every single outcome is a possible world.
        """
        task, state = self.space.task, node[0]
        if not task.closure.is_empty or self.search not in (ALGORITHMS["best"], newest_first):
            return False
        parts = range(len(task.goal))
        return any(
            self.space.heuristic.estimate(after, parts).value is None
            for branching in task.branchings.values()
            for _, after in branching.outcomes(state)
            if after != state and not self.space.task.is_goal(after)
        )

    def lost(self, assumed: Node, node: Node) -> list[int]:
        """The conjuncts of the goal that hold at the assumed node but not at this one; they are planned for first."""
        held_conjuncts = set(self.space.held_conjuncts(node))
        return [number for number in self.space.held_conjuncts(assumed) if number not in held_conjuncts]

    def also_solves(self, node: Node, after: Node, solved: Solved) -> bool:
        """Whether the continuation of `after` also solves `node`, so that the step between them is not needed."""
        different = self.regression.extended(node[0]) ^ self.regression.extended(after[0])
        return not different & solved.needed

    def may_follow(self, node: Node, steps: list[Step]) -> bool:
        """Whether no step of a reordered weak plan is known to fail."""
        for step in steps:
            if self.nogoods.of_choice(self.space.key(node), choice_of(step)) is not None:
                return False
            node = self.space.after(node, step)
            if self.nogoods.of_node(self.space.key(node), node[0]) is not None:
                return False
        return True

    def known(self, node: Node) -> Solved | None:
        """A continuation that is known to solve a node: it fulfils the goal, or an earlier continuation covers it."""
        if self.space.is_goal(node):
            return Solved(self.regression.goal(node), self.builder.goal, 0)
        if self.memo.is_empty or self.space.task.open_branching(node[0]) is not None:
            return None  # open sensing results are branched on first
        return self.memo.find(self.regression.extended(node[0]), self.space.geometry_key(node))

    def remember(self, node: Node, solved: Solved) -> None:
        """Stores a continuation, for every node that has the facts it needs."""
        self.counter.solved += 1
        if self.space.task.open_branching(node[0]) is None:
            self.memo.add(self.regression.extended(node[0]), self.space.geometry_key(node), solved)


def _run(solving: Solving) -> Outcome:
    """Runs recursive generators on an explicit stack: plans may be longer than Python's stack is deep."""
    stack: list[Solving] = [solving]
    outcome: Outcome | None = None
    while stack:
        try:
            stack.append(stack[-1].send(outcome))  # type: ignore[arg-type]
            outcome = None
        except StopIteration as finished:
            stack.pop()
            outcome = finished.value
    assert outcome is not None
    return outcome
