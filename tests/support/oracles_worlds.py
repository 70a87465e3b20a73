"""An exhaustive planner for tiny problems: is there a strong acyclic plan, on the verifier's own knowledge states?

It tries everything that a plan may do: any applicable action, and branching on anything that will be known at run
time, at once or later. So "no" is a proof, if it was not cut short. With `at_once` it must branch before it acts,
which a search may well do; that costs solutions where an action is applicable only as long as one does not know.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

from kabo.language.problem import Problem
from kabo.plan import Node, Plan, PlanBuilder, ValueOf
from kabo.verify.knowledge.ground import (
    NotVerifiableError,
    Observable,
    observable_text,
    outcome_text,
    range_of,
    text_of,
)
from kabo.verify.knowledge.replay.interpreter import GroundAction, Interpreter
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError
from kabo.verify.knowledge.replay.states import Knowledge
from kabo.verify.knowledge.terms import symbol_of
from tests.support.linked_worlds import all_worlds, linked_groups

Grounded = tuple[GroundAction, dict[str, "str | ValueOf"]]


def ground_actions(interpreter: Interpreter) -> list[Grounded]:
    """Every action with every argument; run-time variables are the values of their terms."""
    problem, result = interpreter.problem, []
    for schema in problem.domain.actions.values():
        free = [parameter for parameter in schema.parameters if parameter.value_of is None]
        for values in product(*(problem.of_type(parameter.type) for parameter in free)):
            arguments = dict(zip((parameter.name for parameter in free), values, strict=True))
            for parameter in schema.parameters:
                if parameter.value_of is not None:
                    symbol = symbol_of(parameter.value_of, problem, arguments)
                    arguments[parameter.name] = ValueOf(text_of(symbol))
            result.append((interpreter.action(schema.name, arguments), arguments))
    return result


def branchable(interpreter: Interpreter, state: Knowledge) -> list[Observable]:
    """What a plan could branch on here."""
    finite = [symbol for symbol in state.whether if range_of(interpreter.problem, symbol) is not None]
    return [*sorted(finite, key=repr), *sorted(state.conjunctions, key=repr)]


def applicable(interpreter: Interpreter, state: Knowledge, action: GroundAction) -> bool:
    """Whether the preconditions hold, and the values of run-time variables will be known."""
    values = all(symbol is not None and interpreter.can_branch(state, symbol) for _, symbol in action.values)
    return values and all(holds(state) for holds in action.preconditions)


@dataclass(frozen=True)
class Choice:
    """Something that a plan could do next: an action with what it delivers, or branching; and the states after."""

    action: GroundAction | None
    arguments: dict[str, str | ValueOf]
    delivers: tuple[str, ...]
    on: Observable | None
    outcomes: tuple[tuple[str | None, Knowledge], ...]


def choices(
    interpreter: Interpreter, actions: list[Grounded], state: Knowledge, at_once: bool
) -> Iterator[Choice]:
    """Each thing that a plan could do next: branching first."""
    branched = False
    for thing in branchable(interpreter, state):
        values = interpreter.outcomes_of(thing, state)
        after = [(outcome_text(value), interpreter.learned(state, thing, value)) for value in values]
        possible = tuple((value, one) for value, one in after if one is not None)
        if possible:
            branched = True
            yield Choice(None, {}, (), thing, possible)
    for action, arguments in () if branched and at_once else actions:
        if applicable(interpreter, state, action):
            try:
                after, updates = interpreter.act(state, action)
            except ContradictionError:
                continue
            delivered = dict.fromkeys(map(observable_text, (*updates.run_time, *updates.whole)))
            yield Choice(action, arguments, tuple(delivered), None, ((None, after),))


class Exploration:
    """All knowledge states that can be reached, and which of them a strong acyclic plan leads from to the goal."""

    def __init__(self, problem: Problem, limit: int, *, at_once: bool = False) -> None:
        self.at_once = at_once
        self.problem, self.interpreter = problem, Interpreter(problem)
        self.states = [self.interpreter.initial()]
        self.number = {self.states[0].frozen(): 0}
        self.solved: dict[int, Choice | None] = {}
        self._parents: dict[int, list[tuple[int, frozenset[int], Choice]]] = {}
        self.complete = self._explore(limit)

    def _explore(self, limit: int) -> bool:
        actions = ground_actions(self.interpreter)
        for here, state in enumerate(self.states):  # grows while it is walked: breadth first
            if self.interpreter.reaches_goal(state):
                self._solve(here, None)
            elif here not in self.solved:
                for choice in choices(self.interpreter, actions, state, self.at_once):
                    children = frozenset(self._number(after) for _, after in choice.outcomes)
                    for child in children:
                        self._parents.setdefault(child, []).append((here, children, choice))
                    if children <= self.solved.keys():
                        self._solve(here, choice)
            if 0 in self.solved:
                return True
            if len(self.states) > limit:
                return False
        return True

    def _number(self, state: Knowledge) -> int:
        key = state.frozen()
        if key not in self.number:
            self.number[key] = len(self.states)
            self.states.append(state)
        return self.number[key]

    def _solve(self, node: int, by: Choice | None) -> None:
        """Marks a solved state, and all that are solved with it."""
        waiting = [(node, by)]
        while waiting:
            here, choice = waiting.pop(0)
            if here in self.solved:
                continue
            self.solved[here] = choice
            for above, children, way in self._parents.get(here, ()):
                if children <= self.solved.keys():
                    waiting.append((above, way))

    def plan(self) -> Plan:
        """The plan that was found; equal continuations are shared."""
        builder, handles = PlanBuilder(), {}

        def add(number: int) -> str:
            if number not in handles:
                choice = self.solved[number]
                handles[number] = builder.goal() if choice is None else builder.add(self._node(choice, add))
            return handles[number]

        options = {"search": "oracle", "seed": 0, "epsilon": None, "geometry": "none"}
        return builder.build(add(0), problem=self.problem.name, files=self.problem.files, options=options)

    def _node(self, choice: Choice, add: Callable[[int], str]) -> Node:
        after = {outcome: add(self.number[state.frozen()]) for outcome, state in choice.outcomes}
        if choice.action is None:
            return Node("branch", on=observable_text(choice.on), branches=after)
        kind = "sense" if choice.delivers else "action"
        return Node(kind, choice.action.action.name, choice.arguments, next=after[None], delivers=choice.delivers)


def solvable(problem: Problem, limit: int = 3000, *, at_once: bool = False) -> bool | None:
    """Whether there is a strong acyclic plan; None if more than `limit` states were met before it was decided.

    Raises:
        ContradictionError: the initial knowledge contradicts itself.
        NotVerifiableError: something of the problem is not judged.
    """
    explored = Exploration(problem, limit, at_once=at_once)
    return 0 in explored.solved if explored.complete else None


def find_plan(problem: Problem, limit: int = 3000) -> Plan | None:
    """A plan; None if there is none, or it was not found within the limit."""
    explored = Exploration(problem, limit)
    return explored.plan() if 0 in explored.solved else None


def has_world(problem: Problem) -> bool:
    """Whether any world agrees with the initial knowledge: inference, being incomplete, may not have noticed.

    Raises:
        ContradictionError: it has noticed.
    """
    interpreter = Interpreter(problem)
    predicates, functions = problem.domain.predicates, problem.domain.functions
    kinds = {**predicates, **{name: function.arguments for name, function in functions.items()}}
    everything = [(name, args) for name, ks in kinds.items() for args in product(*map(problem.of_type, ks))]
    return all_worlds(linked_groups(problem, interpreter.initial(), interpreter.rules, everything), 100_000) != []


def verdict(problem: Problem, limit: int = 3000, *, at_once: bool = False) -> str:
    """`solvable`, `unsolvable`, `too large`, `contradiction` or `not judged`: for tables."""
    try:
        if not has_world(problem):
            return "contradiction"
        answer = solvable(problem, limit, at_once=at_once)
    except ContradictionError:
        return "contradiction"
    except NotVerifiableError:
        return "not judged"
    return {True: "solvable", False: "unsolvable", None: "too large"}[answer]
