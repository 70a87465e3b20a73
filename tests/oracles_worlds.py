"""An exhaustive planner for tiny problems: is there a strong acyclic plan, on the verifier's own knowledge states?

It tries everything that a plan may do: any applicable action, and branching on anything that will be known at run
time, at once or later. So "no" is a proof, if it was not cut short.
"""

from collections.abc import Iterator
from itertools import product

from kabo.language.problem import Problem
from kabo.plan import ValueOf
from kabo.verify.draft import ContradictionError
from kabo.verify.ground import NotVerifiableError, range_of, text_of
from kabo.verify.interpreter import GroundAction, Interpreter, Thing
from kabo.verify.knowledge import Knowledge
from kabo.verify.questions import symbol_of


def ground_actions(interpreter: Interpreter) -> list[GroundAction]:
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
            result.append(interpreter.action(schema.name, arguments))
    return result


def branchable(interpreter: Interpreter, state: Knowledge) -> list[Thing]:
    """What a plan could branch on here."""
    finite = [symbol for symbol in state.whether if range_of(interpreter.problem, symbol) is not None]
    return [*sorted(finite, key=repr), *sorted(state.conjunctions, key=repr)]


def applicable(interpreter: Interpreter, state: Knowledge, action: GroundAction) -> bool:
    """Whether the preconditions hold, and the values of run-time variables will be known."""
    values = all(symbol is not None and interpreter.can_branch(state, symbol) for _, symbol in action.values)
    return values and all(holds(state) for holds in action.preconditions)


def choices(interpreter: Interpreter, actions: list[GroundAction], state: Knowledge) -> Iterator[list[Knowledge]]:
    """Each thing that a plan could do next, as the states that may follow."""
    for thing in branchable(interpreter, state):
        values = interpreter.outcomes_of(thing, state)
        outcomes = [after for value in values if (after := interpreter.learned(state, thing, value)) is not None]
        if outcomes:
            yield outcomes
    for action in actions:
        if applicable(interpreter, state, action):
            try:
                yield [interpreter.act(state, action)[0]]
            except ContradictionError:
                continue


def is_goal(interpreter: Interpreter, state: Knowledge) -> bool:
    """Whether every part of the goal holds."""
    return all(holds(state) for holds in interpreter.goal)


def solvable(problem: Problem, limit: int = 3000) -> bool | None:
    """Whether there is a strong acyclic plan; None if more than `limit` states were met before it was decided.

    Raises:
        ContradictionError: the initial knowledge contradicts itself.
        NotVerifiableError: something of the problem is not judged.
    """
    interpreter = Interpreter(problem)
    actions = ground_actions(interpreter)
    states = [interpreter.initial()]
    number = {states[0].frozen(): 0}
    solved: set[int] = set()
    parents: dict[int, list[tuple[int, frozenset[int]]]] = {}
    for here, state in enumerate(states):  # grows while it is walked: breadth first
        if is_goal(interpreter, state):
            _propagate(here, solved, parents)
            if 0 in solved:
                return True
            continue
        for outcomes in choices(interpreter, actions, state):
            children = set()
            for after in outcomes:
                key = after.frozen()
                if key not in number:
                    number[key] = len(states)
                    states.append(after)
                children.add(number[key])
            choice = here, frozenset(children)
            for child in children:
                parents.setdefault(child, []).append(choice)
            if choice[1] <= solved:
                _propagate(here, solved, parents)
        if 0 in solved:
            return True
        if len(states) > limit:
            return None
    return False


def _propagate(node: int, solved: set[int], parents: dict[int, list[tuple[int, frozenset[int]]]]) -> None:
    """Marks a solved state, and all that are solved with it."""
    waiting = [node]
    while waiting:
        here = waiting.pop()
        if here in solved:
            continue
        solved.add(here)
        waiting.extend(above for above, children in parents.get(here, ()) if children <= solved)


def verdict(problem: Problem, limit: int = 3000) -> str:
    """`solvable`, `unsolvable`, `too large`, `contradiction` or `not judged`: for tables."""
    try:
        answer = solvable(problem, limit)
    except ContradictionError:
        return "contradiction"
    except NotVerifiableError:
        return "not judged"
    return {True: "solvable", False: "unsolvable", None: "too large"}[answer]
