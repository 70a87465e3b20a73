"""PDDL and kabo's trees evaluated on complete states, each by its own definition: obvious, slow, not the code tested.

A state is a set of true atoms (name, arguments). PDDL is read here from its text by a reader of three lines.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import product

from kabo.language import formulas as f
from kabo.language.problem import Problem

State = frozenset[tuple[str, tuple[str, ...]]]
Binding = Mapping[str, str]


# -------------------------------------------------------------------------------------------------- PDDL by its text
def parsed(text: str) -> list:
    """Nested lists of words."""
    stack: list[list] = [[]]
    for word in re.findall(r"[()]|[^\s()]+", re.sub(r";.*", "", text).lower()):
        if word == "(":
            stack.append([])
        elif word == ")":
            stack[-2].append(stack.pop())
        else:
            stack[-1].append(word)
    return stack[0]


def true_in(condition: list, state: State, binding: Binding, objects: Iterable[str]) -> bool:
    """Whether a condition of untyped PDDL holds."""
    head, *rest = condition or ["and"]
    if head in ("and", "or"):
        return (all if head == "and" else any)(true_in(part, state, binding, objects) for part in rest)
    if head == "not":
        return not true_in(rest[0], state, binding, objects)
    if head == "imply":
        return not true_in(rest[0], state, binding, objects) or true_in(rest[1], state, binding, objects)
    if head == "=":
        return binding.get(rest[0], rest[0]) == binding.get(rest[1], rest[1])
    if head in ("forall", "exists"):
        inner = bindings(rest[0], binding, objects)
        return (all if head == "forall" else any)(true_in(rest[1], state, each, objects) for each in inner)
    return (head, tuple(binding.get(word, word) for word in rest)) in state


def bindings(variables: list[str], binding: Binding, objects: Iterable[str]) -> Iterator[Binding]:
    """All instances of a list of untyped variables."""
    for values in product(objects, repeat=len(variables)):
        yield {**binding, **dict(zip(variables, values, strict=True))}


def changes(effect: list, state: State, binding: Binding, objects: Iterable[str]) -> Iterator[tuple]:
    """The atoms that an effect makes true or false, read in the state before."""
    head, *rest = effect or ["and"]
    if head == "and":
        for part in rest:
            yield from changes(part, state, binding, objects)
    elif head == "forall":
        for inner in bindings(rest[0], binding, objects):
            yield from changes(rest[1], state, inner, objects)
    elif head == "when":
        if true_in(rest[0], state, binding, objects):
            yield from changes(rest[1], state, binding, objects)
    else:
        atom = rest[0] if head == "not" else effect
        yield (atom[0], tuple(binding.get(word, word) for word in atom[1:])), head != "not"


def after(effect: list, state: State, binding: Binding, objects: Iterable[str]) -> State:
    """The next state by PDDL's rule: what is added stays, whatever is deleted."""
    changed = list(changes(effect, state, binding, objects))
    deleted = {atom for atom, positive in changed if not positive}
    return state - deleted | {atom for atom, positive in changed if positive}


# --------------------------------------------------------------------------------------------------- kabo's by trees
def value(term: f.Term, binding: Binding) -> str:
    """The object that a term without functions means."""
    return binding[term.name] if isinstance(term, f.Variable) else term.name


def claim_holds(claim: f.Claim, state: State, binding: Binding) -> bool:
    """Whether a claim is true."""
    if isinstance(claim, f.Comparison):
        return (value(claim.left, binding) == value(claim.right, binding)) == (claim.operator == "=")
    arguments = tuple(value(each, binding) for each in claim.atom.arguments)
    return ((claim.atom.predicate, arguments) in state) == claim.positive


def holds(formula: f.Formula, state: State, binding: Binding, problem: Problem) -> bool:
    """Whether a formula holds when everything is known."""

    def here(part: f.Formula, more: Binding = binding) -> bool:
        return holds(part, state, more, problem)

    match formula:
        case f.Know(claim=claim):
            return claim_holds(claim, state, binding)
        case f.Truth(value=truth):
            return truth
        case f.Not(body=body):
            return not here(body)
        case f.And(parts=parts):
            return all(map(here, parts))
        case f.Or(parts=parts):
            return any(map(here, parts))
        case f.Forall(variables=variables, body=body):
            return all(here(body, each) for each in instances(variables, binding, problem))
        case f.Exists(variables=variables, body=body):
            return any(here(body, each) for each in instances(variables, binding, problem))
    raise TypeError(formula)


def instances(variables: tuple[f.Variable, ...], binding: Binding, problem: Problem) -> Iterator[Binding]:
    """All bindings of typed variables."""
    for values in product(*(problem.of_type(each.type) for each in variables)):
        yield {**binding, **{each.name: name for each, name in zip(variables, values, strict=True)}}


def outcomes(effect: f.Effect, state: State, binding: Binding, problem: Problem) -> Iterator[f.Claim]:
    """The ground literals that an effect makes true in the world."""
    match effect:
        case f.Change(operation="add", database="Kf", facts=facts):
            yield from (_ground(fact, binding) for fact in facts)
        case f.WorldEffect(conditions=conditions, outcomes=made):
            if all(claim_holds(each, state, binding) for each in conditions):
                yield from (_ground(each, binding) for each in made)
        case f.Conditional(condition=condition, updates=updates):
            if holds(condition, state, binding, problem):
                for update in updates:
                    yield from outcomes(update, state, binding, problem)
        case f.ForEach(variables=variables, effects=inner):
            for each in instances(variables, binding, problem):
                for update in inner:
                    yield from outcomes(update, state, each, problem)
        case _:
            raise TypeError(effect)


def _ground(literal: f.Literal, binding: Binding) -> f.Literal:
    arguments = tuple(f.Constant(value(each, binding)) for each in literal.atom.arguments)
    return f.Literal(f.Atom(literal.atom.predicate, arguments), literal.positive)


def world_after(problem: Problem, action: str, state: State, binding: Binding) -> State:
    """The next state of the world by kabo's effects.

    Raises:
        AssertionError: an atom is made both true and false.
    """
    made: dict[tuple[str, tuple[str, ...]], bool] = {}
    for effect in problem.domain.actions[action].effects:
        for literal in outcomes(effect, state, binding, problem):
            atom = literal.atom.predicate, tuple(each.name for each in literal.atom.arguments)
            assert made.setdefault(atom, literal.positive) == literal.positive, f"{atom} is made true and false"
    return (state | {atom for atom, true in made.items() if true}) - {a for a, true in made.items() if not true}
