"""Replays the plan on the knowledge level: preconditions, sensing, complete branches, and the goal at every leaf.

Nodes are taken in topological order with the *set* of knowledge states that can arrive there; states that agree on
all that the continuation asks for are one. So a plan for 2^n outcomes costs about its nodes, not its branches.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from kabo.errors import did_you_mean
from kabo.language.formulas import Application, Atom, Effect, TermFact
from kabo.language.problem import Action, Problem
from kabo.plan import Node, Plan, ValueOf
from kabo.verify.effects import apply, initial_knowledge, learned, with_rules
from kabo.verify.knowledge import (
    Binding,
    Frozen,
    Knowledge,
    NotVerifiableError,
    Symbol,
    Value,
    holds,
    possible_values,
    symbol_of,
    text_of,
)
from kabo.verify.relevance import forget, mentions, reads, relevant
from kabo.verify.report import Finding

_GROUND = re.compile(r"([a-z][a-z0-9_]*)(?:\(([^()]*)\))?")


@dataclass
class Replay:
    """The outcome: findings, and how many knowledge states were looked at."""

    findings: list[Finding] = field(default_factory=list)
    states: int = 0


def replay(plan: Plan, problem: Problem, order: Sequence[str]) -> Replay:
    """Replays all branches of a plan whose nodes are given, each before its successors."""
    result = Replay()
    usable = {name for name in order if not _add(result, check_call(name, plan.nodes[name], problem))}
    if len(usable) < len(order):
        return result
    keep = relevant(plan, problem, order, lambda node: _mentioned(node, problem))
    arriving: dict[str, dict[Frozen, Knowledge]] = {name: {} for name in order}
    try:
        start = initial_knowledge(problem)
    except NotVerifiableError as error:
        result.findings.append(Finding(None, f"the initial knowledge: {error}"))
        return result
    _arrive(arriving[plan.root], start, None if keep is None else keep[plan.root])
    for name in order:
        told: dict[Finding, None] = {}
        for state in arriving[name].values():
            result.states += 1
            for successor, after in _step(name, plan.nodes[name], problem, state, told):
                if successor in arriving:
                    _arrive(arriving[successor], after, None if keep is None else keep[successor])
        result.findings.extend(told)
        arriving[name] = {}
    return result


def _add(result: Replay, findings: Iterator[Finding]) -> bool:
    before = len(result.findings)
    result.findings.extend(findings)
    return len(result.findings) > before


def _arrive(states: dict[Frozen, Knowledge], state: Knowledge, keep) -> None:  # type: ignore[no-untyped-def]
    key, rest = forget(state, keep)
    states.setdefault(key, rest)


# --------------------------------------------------------------------------------------------------- calls
def check_call(name: str, node: Node, problem: Problem) -> Iterator[Finding]:
    """What is wrong with a node before any knowledge is asked: unknown names, wrong arguments, wrong types."""
    if node.action is not None:
        action = problem.domain.actions.get(node.action)
        if action is None:
            hint = did_you_mean(node.action, problem.domain.actions)
            yield Finding(name, f'unknown action "{node.action}"' + (f"; {hint}" if hint else ""))
            return
        yield from _check_arguments(name, node, action, problem)
    for text in (*([] if node.on is None else [node.on]), *node.delivers):
        if read_symbol(text, problem) is None:
            yield Finding(name, f'"{text}" is no ground atom or term of the domain')


def _check_arguments(name: str, node: Node, action: Action, problem: Problem) -> Iterator[Finding]:
    declared = {parameter.name: parameter for parameter in action.parameters}
    for extra in node.arguments.keys() - declared.keys():
        yield Finding(name, f'action "{action.name}" has no parameter "{extra}"')
    for parameter in action.parameters:
        if parameter.name not in node.arguments:
            yield Finding(name, f'argument "{parameter.name}" of action "{action.name}" is missing')
            continue
        value = node.arguments[parameter.name]
        if parameter.value_of is not None:
            expected = _term_text(parameter.value_of, node)
            if not isinstance(value, ValueOf) or value.term != expected:
                yield Finding(name, f'argument "{parameter.name}" must be the value of {expected} at run time')
        elif not isinstance(value, str) or value not in problem.of_type(parameter.type):
            shown = value.term if isinstance(value, ValueOf) else value
            yield Finding(name, f'argument "{parameter.name}": {shown} is no {parameter.type}')


def _term_text(term: Application, node: Node) -> str | None:
    symbol = symbol_of(term.function, term.arguments, Knowledge({}), _binding(node))
    return None if symbol is None else text_of(symbol)


def _binding(node: Node) -> Binding:
    return dict(node.arguments)


def read_symbol(text: str, problem: Problem) -> Symbol | None:
    """The ground atom or term of a text `f(a, b)`; None if it is none of the domain."""
    match = _GROUND.fullmatch(text)
    if match is None:
        return None
    name, inner = match.groups()
    values: list[Value] = [] if inner is None else [_read_value(part.strip()) for part in inner.split(",")]
    domain = problem.domain
    types = domain.predicates.get(name)
    if types is None and name in domain.functions:
        types = domain.functions[name].arguments
    if types is None or len(types) != len(values):
        return None
    return name, tuple(values)


def _read_value(text: str) -> Value:
    try:
        return float(text)
    except ValueError:
        return text


# --------------------------------------------------------------------------------------------------- steps
def _step(
    name: str, node: Node, problem: Problem, state: Knowledge, told: dict[Finding, None]
) -> Iterator[tuple[str, Knowledge]]:
    """The successors that a state can lead to, each with the knowledge there; findings go into `told`."""
    try:
        if node.kind == "goal":
            for part in problem.goal:
                if not holds(part, problem, state, {}):
                    told[Finding(name, "the goal does not hold at this leaf" + _because(part))] = None
            return
        if node.action is not None:
            state = _act(name, node, problem, state, told)
        if node.on is None:
            if node.next is not None:
                yield node.next, state
            return
        yield from _branch(name, node, problem, state, told)
    except NotVerifiableError as error:
        told[Finding(name, str(error))] = None


def _act(name: str, node: Node, problem: Problem, state: Knowledge, told: dict[Finding, None]) -> Knowledge:
    action, binding = problem.domain.actions[str(node.action)], _binding(node)
    for value in node.arguments.values():
        if isinstance(value, ValueOf):
            symbol = read_symbol(value.term, problem)
            if symbol is None or not state.will_be_known(symbol):
                told[Finding(name, f"the value of {value.term} is not known at run time here")] = None
    for i, condition in enumerate(action.preconditions, 1):
        if not holds(condition, problem, state, binding):
            text = f'precondition {i} of "{action.name}" does not hold'
            told[Finding(name, text + _because(condition))] = None
    after = apply(action.effects, problem, state, binding)
    sensed = [symbol for symbol in sensed_by(action, problem, state, binding) if symbol not in after.known]
    after = with_rules(problem, Knowledge(after.known, after.excluded, after.whether | frozenset(sensed)))
    delivered = set(sensed_by(action, problem, state, binding)) | (after.whether - state.whether)
    for text in (*([] if node.on is None else [node.on]), *node.delivers):
        symbol = read_symbol(text, problem)
        if symbol not in delivered:
            told[Finding(name, f'"{action.name}" does not sense {text}')] = None
    return after


def sensed_by(action: Action, problem: Problem, state: Knowledge, binding: Binding) -> list[Symbol]:
    """The atoms and terms that an action's run-time component delivers, ground."""
    result = []
    for thing in (*action.sense, *_sensing_effects(action.effects)):
        sensed_name = thing.predicate if isinstance(thing, Atom) else thing.function
        symbol = symbol_of(sensed_name, thing.arguments, state, binding)
        if symbol is None:
            raise NotVerifiableError(f"{sensed_name} is sensed of something whose value is not known")
        result.append(symbol)
    return result


def _sensing_effects(effects: Sequence[Effect]) -> Iterator[Atom | Application]:
    """What `add(Kw, …)` and `add(Kv, …)` without conditions name: the other spelling of `sense`."""
    for effect in effects:
        if getattr(effect, "operation", None) == "add" and getattr(effect, "database", None) in ("Kw", "Kv"):
            for fact in effect.facts:  # type: ignore[union-attr]
                if isinstance(fact, TermFact):
                    yield fact.term
                elif hasattr(fact, "atom"):
                    yield fact.atom


def _branch(
    name: str, node: Node, problem: Problem, state: Knowledge, told: dict[Finding, None]
) -> Iterator[tuple[str, Knowledge]]:
    symbol = read_symbol(str(node.on), problem)
    if symbol is None or not state.will_be_known(symbol):
        told[Finding(name, f"branches on {node.on}, which is not known at run time here")] = None
        return
    values = possible_values(problem, symbol, state)
    if values is None:
        told[Finding(name, f"branches on {node.on}, whose values cannot be listed")] = None
        return
    domain_values = possible_values(problem, symbol, Knowledge({})) or values
    allowed = {_outcome(value) for value in domain_values}
    for outcome in node.branches:
        if outcome not in allowed:
            told[Finding(name, f'"{outcome}" is no value of {node.on}')] = None
    for value in values:
        successor = node.branches.get(_outcome(value))
        if successor is None:
            told[Finding(name, f"no branch for {node.on} = {_outcome(value)}, which is possible")] = None
        else:
            yield successor, learned(problem, state, symbol, value)


def _outcome(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _because(formula: object) -> str:
    place = getattr(formula, "place", None)
    return "" if place is None else f" ({place.file}:{place.line}:{place.column})"


def _mentioned(node: Node, problem: Problem) -> Iterator[Symbol | str]:
    if node.kind == "goal":
        yield from mentions(problem.goal, problem, {})
    for text in (*([] if node.on is None else [node.on]), *node.delivers):
        symbol = read_symbol(text, problem)
        if symbol is not None:
            yield symbol
    if node.action is None:
        return
    action, binding = problem.domain.actions[node.action], _binding(node)
    yield from mentions((action.preconditions, action.sense), problem, binding)
    for effect in action.effects:
        yield from reads(effect, problem, binding)
    yield from mentions(tuple(_sensing_effects(action.effects)), problem, binding)
    for value in node.arguments.values():
        symbol = read_symbol(value.term, problem) if isinstance(value, ValueOf) else None
        if symbol is not None:
            yield symbol
