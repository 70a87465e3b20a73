"""Contingent search: a plan in which every leaf fulfils the goal [K 3.3, ch. 6].

Solve a node: if an earlier continuation covers it, take that; else find a weak plan, take its first step, and
solve the node behind *every* outcome. What the continuation needs is then known by regression, and it serves every
node that has it. If some outcome cannot be solved, the step is banned at this node, and the next weak plan goes
elsewhere.

Plans are acyclic, so a node is not solved through its own ancestors. A failure is therefore relative: it names the
ancestors that stood in the way (see `failures.py`), and only those that need none are proofs.
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
from kabo.planner.search.nogoods import Failure, Failures
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.regression import Explanation
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

Outcome = Solved | Failure
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
    """A contingent plan for the task, the proof that there is none, or what ended the search.

    Args:
        task: the grounded problem.
        search: how weak plans are found, a word of `Search`; None is the best all-round one.
        geometry: what may be refused and which attempts there are; None for purely symbolic planning.
        limits: the budget; None is unlimited.
        on_progress: called now and then with the statistics so far.
        packed: the same task prepared for packed searches by an earlier call; None prepares it where it is needed.
        heuristic: what estimates states of knowledge, a key of `HEURISTICS`.

    Raises:
        KeyError: there is no search of that name.
    """
    limits, search = limits or SearchLimits(), search or Options.search
    if search in ("best", "astar", "breadth-first") and not task.branchings:
        found = (packed or PackedTask(task)).skeleton(search, geometry, limits)
        if found is not None:
            return found
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
    """Searches; `best` starts over with other hopes where one dead end follows the other.

    Where dead ends go on, every node is looked at once. That ends where there are finitely many; so both take turns.
    """
    for assume_last in (True, False) if search == "best" else ():
        space = SearchSpace(task, geometry, may_wait, assume_last, heuristic)
        try:
            outcome = _run(
                _Contingent(space, ALGORITHMS[search], counter, tuning.MAX_FAILED_CHOICES).solve(space.start, [])
            )
        except _TooManyDeadEnds:
            continue
        return outcome if isinstance(outcome, Failure) else _smaller(outcome, space, counter)
    space = SearchSpace(task, geometry, may_wait, heuristic=heuristic)
    looking = _ExhaustiveCheck(task, may_wait, counter, takes_plans=geometry is None)
    try:
        patience = tuning.FAILED_CHOICES_BEFORE_FIXPOINT
        return _run(_Contingent(space, ALGORITHMS[search], counter, patience, looking).solve(space.start, []))
    except _OutcomeKnown as decided:
        return decided.outcome


def _smaller(found: Solved, space: SearchSpace, counter: Counter) -> Solved:
    """The plan, or the smaller one that a second search finds, which breaks ties the other way; for small problems.

    With geometry a plan is only a proposal, and a second one would be asked for in vain.
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
    """Ends an attempt from within; never leaves this module."""


class _OutcomeKnown(Exception):
    """Ends an attempt whose outcome was found by looking at every node; never leaves this module."""

    def __init__(self, outcome: Outcome) -> None:
        self.outcome = outcome
        super().__init__()


class _ExhaustiveCheck:
    """Looks at every node once, where one dead end follows the other; with geometry only for a proof by knowledge alone."""

    def __init__(self, task: GroundedTask, may_wait: bool, counter: Counter, *, takes_plans: bool) -> None:
        self._task, self._may_wait, self._counter, self._takes_plans = task, may_wait, counter, takes_plans
        self._patience = tuning.FAILED_CHOICES_BEFORE_FIXPOINT
        self._nodes: Fixpoint | None = None  # made when it is first needed

    def __call__(self) -> int | None:
        """How many more choices may fail if that has not ended yet; None: any number.

        Raises:
            _Decided: it has.
        """
        self._nodes = self._nodes or Fixpoint(SearchSpace(self._task, None, self._may_wait), self._counter)
        found = self._nodes.solve(max(tuning.MIN_FIXPOINT_NODES, self._counter.expanded))
        if found is False:
            raise _OutcomeKnown(Failure(frozenset()))
        if isinstance(found, Solved):
            if self._takes_plans:
                raise _OutcomeKnown(found)
            return None
        self._patience *= tuning.FAILED_CHOICES_GROWTH
        return self._patience


def _give_up() -> int | None:
    raise _TooManyDeadEnds


class _Contingent:
    """One search: the memo of what is solved, the failures, the path of nodes that are being solved."""

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
        self.explanation = Explanation(space)
        self.memo = Memo(space.task.functional)
        self.failures = Failures(less_is_less=space.geometry is None and space.task.less_is_less)
        self.builder = SkeletonBuilder()
        self.first: dict[Hashable, list[int]] = {}  # conjuncts of the goal to be seen to first, by node

    def solve(self, node: Node, plan: list[Step]) -> Solving:
        """Solves a node; `plan` is a weak plan from it to be followed first, or empty."""
        key = self.space.key(node)
        outcome: Outcome | None = self.known(node) or self.failures.of_node(key, node[0])
        if outcome is not None:
            return outcome
        self.failures.path.add(key)
        while True:
            weak = plan or self.weak_plan(node)
            if isinstance(weak, Failure):
                outcome = weak
                break
            outcome = yield self.follow(node, weak)
            if isinstance(outcome, Solved):
                self.remember(node, outcome)
                break
            self.failures.add_choice(key, choice_of(weak[0]), outcome)
            if self.is_doomed(node):
                outcome = self.failures.add_nodes(key, node[0], [key], set())
                break
            if self.dead_ends is not None:
                self.dead_ends -= 1
                if self.dead_ends < 0:
                    self.dead_ends = self.when_spent()
            plan = []
        self.failures.path.discard(key)
        return outcome

    def follow(self, node: Node, plan: list[Step]) -> Solving:
        """Takes the first step of a weak plan and solves whatever it may lead to."""
        step, rest = plan[0], plan[1:]
        if isinstance(step, Assume):
            return (yield self.branch(node, step, rest))
        after = self.space.after(node, step)
        if self.space.confirmed_key(after) is None:
            return Failure(frozenset())
        outcome = yield self.solve(after, rest)
        if isinstance(outcome, Failure) or (step.action.call is None and self.also_solves(node, after, outcome)):
            return outcome
        needed = self.explanation.before_action(node, step, after, outcome.needed)
        delivered = self.space.delivered(node, step, after)
        made = self.builder.act(step.action, step.attempt, delivered, outcome.node)
        return Solved(needed, made, outcome.length + 1)

    def branch(self, node: Node, step: Assume, rest: list[Step]) -> Solving:
        """Solves every outcome of a branching, the hoped one first: what it finds may serve the others."""
        branching, needed = step.branching, 0
        outcomes = self.space.outcomes(node, branching)
        children: dict[str, Solved] = {}
        assumed = dict(outcomes)[step.outcome]
        for outcome, child in sorted(outcomes, key=lambda pair: pair[0] != step.outcome):
            if child is not assumed:
                self.first[self.space.key(child)] = self.lost(assumed, child)
            solved = yield self.solve(child, rest if outcome == step.outcome else [])
            if isinstance(solved, Failure):
                return solved
            needless = not children and self.explanation.ignores(branching, child, solved.needed)
            if needless and self.also_solves(node, child, solved):
                return solved  # whatever is sensed: no branch at all
            needed |= self.explanation.before_branching(node, branching, outcome, child, solved.needed)
            children[outcome] = solved
        if not children:
            return Failure(frozenset())
        branches = tuple((outcome, children[outcome].node) for outcome, _ in outcomes)
        length = min(child.length for child in children.values())
        needed |= branching.entry | branching.excluded(node[0])
        return Solved(needed, self.builder.branch(branching.fact, branches), length)

    def weak_plan(self, node: Node) -> list[Step] | Failure:
        """A way from a node to the goal or to what is solved, sensing as late as may be; or why there is none."""
        first = self.first.pop(self.space.key(node), [])
        graph = WeakGraph(
            self.space,
            self.failures,
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
            return self.failures.add_nodes(self.space.key(node), node[0], found.visited, graph.blocked)
        steps = steps_of(found.path)
        delayed = delay_sensing(self.space, node, steps)
        return delayed if delayed != steps and self.may_follow(node, delayed) else steps

    def is_doomed(self, node: Node) -> bool:
        """Whether what is unknown may turn out so that the goal is out of reach even relaxed, and that known at once.

        Judged only where nothing is inferred: there every single outcome is a possible world.
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
        """The conjuncts of the goal that hold where it was hoped to go, but not here: they are seen to first."""
        held_conjuncts = set(self.space.held_conjuncts(node))
        return [number for number in self.space.held_conjuncts(assumed) if number not in held_conjuncts]

    def also_solves(self, node: Node, after: Node, solved: Solved) -> bool:
        """Whether what continues from `after` continues from `node` as well: the step between is needless."""
        different = self.explanation.extended(node[0]) ^ self.explanation.extended(after[0])
        return not different & solved.needed

    def may_follow(self, node: Node, steps: list[Step]) -> bool:
        """Whether no step of a reordered weak plan is known to fail."""
        for step in steps:
            if self.failures.of_choice(self.space.key(node), choice_of(step)) is not None:
                return False
            node = self.space.after(node, step)
            if self.failures.of_node(self.space.key(node), node[0]) is not None:
                return False
        return True

    def known(self, node: Node) -> Solved | None:
        """The continuation of a node that fulfils the goal, or that an earlier continuation covers."""
        if self.space.is_goal(node):
            return Solved(self.explanation.goal(node), self.builder.goal, 0)
        if self.memo.is_empty or self.space.task.open_branching(node[0]) is not None:
            return None  # what stands open is branched on first
        return self.memo.find(self.explanation.extended(node[0]), self.space.geometry_key(node))

    def remember(self, node: Node, solved: Solved) -> None:
        """Keeps a continuation for every node that has what it needs."""
        self.counter.solved += 1
        if self.space.task.open_branching(node[0]) is None:
            self.memo.add(self.explanation.extended(node[0]), self.space.geometry_key(node), solved)


def _run(solving: Solving) -> Outcome:
    """Runs a recursion of generators on a stack of its own: plans may be longer than Python's stack is deep."""
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
