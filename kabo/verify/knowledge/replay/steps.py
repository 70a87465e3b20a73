"""One node of a plan in one knowledge state: its faults, and the states after it."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from kabo.plan import Node
from kabo.verify.knowledge.facts import will_be_known
from kabo.verify.knowledge.ground import NotVerifiableError, Observable, Value, because, outcome_text
from kabo.verify.knowledge.replay.interpreter import GroundAction, Interpreter
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError
from kabo.verify.knowledge.replay.states import Knowledge


@dataclass(frozen=True)
class Way:
    """An edge of the plan: outcome (None without branching), successor, and the knowledge that reaches it."""

    value: Value | None
    successor: str
    state: Knowledge


@dataclass
class Step:
    """The result of a node in one state; `after` is the state after its action, None if the action fails."""

    messages: list[str] = field(default_factory=list)
    ways: list[Way] = field(default_factory=list)
    after: Knowledge | None = None


def step(interpreter: Interpreter, node: Node, state: Knowledge, *, every: bool = True) -> Step:
    """Executes a node in one knowledge state; the node's call must have passed `check_call`.

    `every`: whether each possible outcome must have a branch.
    """
    result = Step()
    try:
        if node.kind == "goal":
            for number, part in enumerate(interpreter.goals):
                if not state.settled >> number & 1 and not part.holds(state):
                    result.messages.append("the goal does not hold at this leaf" + because(part.formula))
            return result
        after: Knowledge | None = state
        if node.action is not None:
            after = _act(interpreter, node, state, result)
        result.after = after
        if after is None:
            return result
        if node.on is not None:
            result.ways.extend(_branch(interpreter, node, after, result, every))
        elif node.next is not None:
            result.ways.append(Way(None, node.next, after))
    except NotVerifiableError as error:
        result.messages.append(str(error))
    return result


def unmet_early(interpreter: Interpreter, node: Node, state: Knowledge) -> list[str]:
    """Messages about a node's preconditions that do not hold in `state`, in which its motion already begins."""
    action = interpreter.action(str(node.action), node.arguments)
    try:
        return [f"begins early, but then {message}" for message in _unmet(action, state)]
    except NotVerifiableError as error:
        return [str(error)]


def _act(interpreter: Interpreter, node: Node, state: Knowledge, result: Step) -> Knowledge | None:
    action = interpreter.action(str(node.action), node.arguments)
    result.messages.extend(_unmet(action, state))
    try:
        after, updates = interpreter.act(state, action)
    except ContradictionError as error:
        result.messages.append(f'"{node.action}" is not applicable: it would mean {error}')
        return None
    delivered: set[Observable] = {*updates.run_time, *updates.whole, *(after.whether - state.whether)}
    for text in (*([] if node.on is None else [node.on]), *node.delivers):
        if interpreter.read(text) not in delivered:
            result.messages.append(f'"{node.action}" does not sense {text}')
    return after


def _unmet(action: GroundAction, state: Knowledge) -> Iterator[str]:
    for text, symbol in action.values:
        if symbol is None or not will_be_known(symbol, state):
            yield f"the value of {text} is not known at run time here"
    schema = action.action
    for number, (formula, holds) in enumerate(zip(schema.preconditions, action.preconditions, strict=True), 1):
        if not holds(state):
            yield f'precondition {number} of "{schema.name}" does not hold' + because(formula)
    if action.refused and schema.geometry is not None:
        yield f'the procedure "{schema.geometry.procedure}" of "{schema.name}" fails here'


def _branch(interpreter: Interpreter, node: Node, state: Knowledge, result: Step, every: bool) -> Iterator[Way]:
    thing = interpreter.read(str(node.on))
    if thing is None or not interpreter.can_branch(state, thing):
        result.messages.append(f"branches on {node.on}, which is not known at run time here")
        return
    values = interpreter.outcomes_of(thing, state)
    if values is None:
        result.messages.append(f"branches on {node.on}, whose values cannot be listed")
        return
    names = [outcome_text(value) for value in values]
    result.messages.extend(
        f'"{outcome}" is no value of {node.on}' for outcome in node.branches if outcome not in names
    )
    possible = 0
    for value, outcome in zip(values, names, strict=True):
        after = interpreter.learned(state, thing, value)
        if after is None:
            continue
        possible += 1
        if outcome in node.branches:
            yield Way(value, node.branches[outcome], after)
        elif every:
            result.messages.append(f"no branch for {node.on} = {outcome}, which is possible")
    if not possible:
        result.messages.append(f"no outcome of {node.on} is possible: what is known here contradicts itself")
