"""Expands every reachable node once, then marks solved nodes backwards from the goals until nothing changes.

Following weak plans one after the other finds plans soon but proves failures slowly: each failure holds only below
the ancestors that it names, and in strongly connected spaces there are exponentially many sets of ancestors. In
the fixpoint search, a node is solved if the goal holds in it or if some choice leads only to solved nodes. A
search over finitely many nodes therefore ends after at most one expansion per node.
"""

from collections.abc import Hashable
from dataclasses import dataclass, field

from kabo.planner.search.nodes import Act, Assume, Node, SearchSpace
from kabo.planner.search.skeleton import SkeletonBuilder, SkeletonNode
from kabo.planner.search.solved import Solved
from kabo.planner.search.weak_plans import Counter


@dataclass
class _Choice:
    """A choice at a node, and the nodes that it may lead to; `open` of them are not solved yet."""

    node: int
    step: Act | Assume
    children: tuple[tuple[str, int], ...]
    open: int = 0


@dataclass
class Fixpoint:
    """The nodes of a search space that were generated so far, and which of them are solved."""

    space: SearchSpace
    counter: Counter
    builder: SkeletonBuilder = field(default_factory=SkeletonBuilder)

    def __post_init__(self) -> None:
        self._numbers: dict[Hashable, int] = {}
        self._nodes: list[Node] = []
        self._parents: list[list[_Choice]] = []
        self._solved: dict[int, _Choice | None] = {}
        self._next = 0
        self._number(self.space.start)

    def solve(self, limit: int) -> Solved | bool:
        """A plan from the start; False if there is none; True if nodes remain after `limit` further expansions.

        Raises:
            BudgetSpent: the budget of the counter is spent.
        """
        until = self._next + limit
        while self._next < len(self._nodes):
            if self._next >= until:
                return True
            here, self._next = self._next, self._next + 1
            self._expand(here)
            if 0 in self._solved:
                return Solved(0, self._skeleton(), 0)
        return False

    # ---------------------------------------------------------------------------------------------------- looking
    def _expand(self, here: int) -> None:
        node = self._nodes[here]
        self.counter.expand()
        if self.space.is_goal(node):
            self._solve(here, None)
            return
        choices = list(self._branchings(node))
        if not choices or self.space.may_wait:
            for action, attempt, after in self.space.moves(node):
                choices.append((Act(action, attempt, after[1]), [("", after)]))
        for step, children in choices:
            numbered = tuple((outcome, self._number(child)) for outcome, child in children)
            self.counter.generated += len(numbered)
            choice = _Choice(here, step, numbered)
            for child in {child for _, child in numbered}:
                if child not in self._solved:
                    choice.open += 1
                    self._parents[child].append(choice)
            if numbered and not choice.open and here not in self._solved:
                self._solve(here, choice)

    def _branchings(self, node: Node) -> "list[tuple[Act | Assume, list[tuple[str, Node]]]]":
        """The open branchings, each with its outcomes; only the first where branching may not wait."""
        task, found = self.space.task, []
        for branching in task.open_branchings(node[0]):
            outcomes = self.space.outcomes(node, branching)
            found.append((Assume(branching, ""), outcomes))
            if not self.space.may_wait:
                break
        return found  # type: ignore[return-value]

    def _number(self, node: Node) -> int:
        key = self.space.key(node)
        number = self._numbers.setdefault(key, len(self._nodes))
        if number == len(self._nodes):
            self._nodes.append(node)
            self._parents.append([])
        return number

    def _solve(self, here: int, by: _Choice | None) -> None:
        """Marks a node as solved, and all nodes that are solved by this, in order."""
        self._solved[here] = by
        waiting = [here]
        for number in waiting:
            for choice in self._parents[number]:
                choice.open -= 1
                if not choice.open and choice.node not in self._solved:
                    self._solved[choice.node] = choice
                    waiting.append(choice.node)

    # ----------------------------------------------------------------------------------------------------- the plan
    def _skeleton(self) -> SkeletonNode:
        """The plan from the start, built in the order in which its nodes were solved."""
        made: dict[int, SkeletonNode] = {}
        for number in self._needed():
            choice = self._solved[number]
            if choice is None:
                made[number] = self.builder.goal
                continue
            following = [(outcome, made[child]) for outcome, child in choice.children]
            if isinstance(choice.step, Assume):
                made[number] = self.builder.branch(choice.step.branching.fact, tuple(following))
            else:
                after = self.space.after(self._nodes[number], choice.step)
                delivered = self.space.delivered(self._nodes[number], choice.step, after)
                made[number] = self.builder.act(
                    choice.step.action, choice.step.attempt, delivered, following[0][1]
                )
        return made[0]

    def _needed(self) -> list[int]:
        """The solved nodes that the plan from the start visits, in the order in which they were solved."""
        visited, waiting = {0}, [0]
        for number in waiting:
            choice = self._solved[number]
            for _, child in () if choice is None else choice.children:
                if child not in visited:
                    visited.add(child)
                    waiting.append(child)
        return [number for number in self._solved if number in visited]
