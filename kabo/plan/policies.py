"""A plan as a policy: a function from the history of observations to the next actions.

Between two observations a plan is deterministic. So the history of observations determines the current node, the
actions up to the next observation, and the possible outcomes of this observation.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from kabo.given import require_given
from kabo.plan.plan import Node, Plan


@dataclass(frozen=True)
class Observation:
    """An observation at run time: a fact on which the plan branches, and its outcome, spelled as in the plan."""

    fact: str
    outcome: str


History = tuple[Observation, ...]


@dataclass(frozen=True)
class Decision:
    """The next action and sense nodes in order, and the fact to `observe` after them, with its `outcomes`.

    If `observe` is None, the goal is reached after the actions.
    """

    actions: tuple[Node, ...]
    observe: str | None = None
    outcomes: tuple[str, ...] = ()

    @property
    def is_last(self) -> bool:
        """Whether the goal is reached after the actions."""
        return self.observe is None


class Policy:
    """The policy of one plan: calling it with a history of observations returns the decision after them.

    If `place` is equal for two histories, all later decisions are equal, too.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan

    def __call__(self, history: Sequence[Observation] = ()) -> Decision:
        """The decision after these observations, given in the order in which they were made.

        Raises:
            ValueError: the plan cannot lead to these observations; the text says which one is wrong.
        """
        return self._from(self.place(history))

    def place(self, history: Sequence[Observation] = ()) -> str:
        """The id of the node at which the plan continues after the observations.

        Raises:
            ValueError: the plan cannot lead to these observations.
        """
        name = self.plan.root
        for number, seen in enumerate(history, start=1):
            node = self._branching(name)
            if node is None:
                raise ValueError(f"observation {number}: the goal is reached, nothing is left to observe")
            if seen.fact != node.on:
                raise ValueError(f"observation {number}: the plan observes {node.on} here, not {seen.fact}")
            if seen.outcome not in node.branches:
                expected = ", ".join(node.branches)
                raise ValueError(f"observation {number}: {seen.fact} is {seen.outcome}, expected was {expected}")
            name = node.branches[seen.outcome]
        return name

    def rules(self) -> Iterator[tuple[History, Decision]]:
        """Every history with its decision, generated lazily, since a plan may have very many branches."""
        waiting: list[tuple[History, str]] = [((), self.plan.root)]
        while waiting:
            history, name = waiting.pop()
            decision = self._from(name)
            yield history, decision
            node = self._branching(name)
            if node is not None:
                following = [
                    (Observation(str(node.on), outcome), after) for outcome, after in node.branches.items()
                ]
                waiting += [((*history, seen), after) for seen, after in reversed(following)]

    def _from(self, name: str) -> Decision:
        actions = tuple(node for node in self._until_it_branches(name) if node.action is not None)
        node = self._branching(name)
        return Decision(actions) if node is None else Decision(actions, node.on, tuple(node.branches))

    def _branching(self, name: str) -> Node | None:
        """The next node that branches; None if there is none before the goal."""
        *_, last = self._until_it_branches(name)
        return last if last.branches else None

    def _until_it_branches(self, name: str) -> Iterator[Node]:
        while True:
            node = self.plan.nodes[name]
            yield node
            if node.branches or node.next is None:
                return
            name = node.next


def policy(plan: Plan) -> Policy:
    """The plan as a function from the history of observations to the next decision.

    Args:
        plan: a plan without cycles.

    Example:
        >>> plan = kabo.solve(kabo.load_problem("domains/grid/n3.yaml")).plan
        >>> decision = kabo.policy(plan)()
        >>> [node.action for node in decision.actions], decision.observe
        (['move', 'pick_up', 'move', 'look_at_lock'], 'lock(c2_3, diamond)')

    Raises:
        ArgumentError: `plan` is none.
    """
    require_given("plan", plan, Plan)
    return Policy(plan)
