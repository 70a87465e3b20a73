"""Refuses problems with unsupported parts and names each with its place, so that nothing is ignored silently."""

from collections.abc import Iterable, Iterator
from functools import cache

from kabo.errors import Diagnostic, InputError
from kabo.language.formulas import (
    Application,
    Arithmetic,
    Change,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    External,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Literal,
    Place,
    Term,
    TermFact,
    Test,
    Variable,
    WorldEffect,
)
from kabo.language.problem import Problem

_NAME_EACH = "name each value that it may have: `forall(type x) when f(…) = x then p(x)` for its term f(…)"

_Refusal = tuple[str, Place | None]


def refuse_unsupported(problem: Problem) -> None:
    """Raises an InputError with a diagnostic for each thing in the problem that is not supported."""
    where = str(problem.domain.path or problem.path)
    found = [_diagnostic(f"{what} not supported", place, where) for what, place in _refusals(problem)]
    found += [_diagnostic(what, place, where) for what, place in _unanswered(problem)]
    if found:
        raise InputError(found)


def _diagnostic(what: str, place: Place | None, file: str) -> Diagnostic:
    hint = _NAME_EACH if what.startswith("the run-time variable") else None
    if place is None:
        return Diagnostic(file, 1, 1, what, hint)
    return Diagnostic(place.file, place.line, place.column, what, hint, place.length)


def _unanswered(problem: Problem) -> Iterator[_Refusal]:
    """Refuses values of procedures without a function, each at the procedure's declaration."""
    given = frozenset() if problem.answers is None else problem.answers.given
    domain = problem.domain
    if not domain.procedures:
        return
    used = _externals((*domain.actions.values(), *problem.initial, *problem.goal))
    for name in sorted({external.procedure for external in used} - given):
        if not domain.procedures[name].is_test:
            remedy = f'kabo.solve(…, procedures={{"{name}": …}})'
            yield (
                f'nobody answers for the procedure "{name}": give a function, {remedy}',
                domain.procedures[name].place,
            )


def _refusals(problem: Problem) -> Iterator[_Refusal]:
    for rule in problem.domain.update_rules:
        yield from _in_effects([rule])
        yield from _in_rule(rule, problem)
    for action in problem.domain.actions.values():
        run_time = frozenset(p.name for p in action.parameters if p.value_of is not None)
        yield from _in_effects(action.effects, run_time)
        for sensed in action.sense:
            yield from _in_arguments(sensed.arguments, sensed.place, run_time)
    yield from _in_effects(problem.initial)


def _in_rule(rule: Effect, problem: Problem) -> Iterator[_Refusal]:
    """Refuses numbers and external procedures in update rules, which only infer."""
    match rule:
        case Change(facts=facts):
            for external in _externals(facts):
                yield f'the procedure "{external.procedure}" in an update rule is', external.place
            for fact in facts:
                if _is_about_a_number(fact, problem):
                    yield "assigning a number in an update rule is", fact.place
        case Conditional(condition=condition, updates=inner):
            for external in _externals(condition):
                yield f'the procedure "{external.procedure}" in an update rule is', external.place
            for test in _tests(condition):
                if not isinstance(test.call, External):
                    yield "a geometric test in an update rule is", test.place
            for update in inner:
                yield from _in_rule(update, problem)
        case ForEach(effects=inner):
            for update in inner:
                yield from _in_rule(update, problem)


def _is_about_a_number(fact: Fact, problem: Problem) -> bool:
    if not isinstance(fact, Comparison) or not isinstance(fact.left, Application):
        return False
    return problem.values_of(fact.left.function) is None


def _tests(tree: object) -> Iterator[Test]:
    return (part for part in _parts(tree) if isinstance(part, Test))


def _externals(tree: object) -> Iterator[External]:
    return (part for part in _parts(tree) if isinstance(part, External))


def _parts(tree: object) -> Iterator[object]:
    """The tree and every part inside it."""
    waiting = [tree]
    while waiting:
        part = waiting.pop()
        if isinstance(part, tuple):
            waiting += part[::-1]
            continue
        names = _parts_of(type(part))  # type: ignore[arg-type]  # mypy takes types for unhashable
        if names is not None:
            yield part
            waiting += [getattr(part, name) for name in names]


@cache
def _parts_of(kind: type) -> tuple[str, ...] | None:
    """The fields of a class of formulas, the last first; None if it is no such class."""
    fields = getattr(kind, "__dataclass_fields__", None)
    return None if fields is None else tuple(name for name in fields if name != "place")[::-1]


def _in_effects(effects: Iterable[Effect], run_time: frozenset[str] = frozenset()) -> Iterator[_Refusal]:
    for effect in effects:
        match effect:
            case Conditional(updates=inner) | ForEach(effects=inner):
                yield from _in_effects(inner, run_time)
            case Change():
                for fact in effect.facts:
                    yield from _in_fact(fact, run_time)
                for external in _externals(effect.facts) if effect.database != "Kf" else ():
                    yield f'the procedure "{external.procedure}" in a fact of {effect.database} is', external.place
            case WorldEffect():
                for claim in (*effect.conditions, *effect.outcomes):
                    yield from _in_fact(claim, run_time)
                    for external in _externals(claim):
                        yield f'the procedure "{external.procedure}" inside `when` is', external.place


def _in_fact(fact: Fact, run_time: frozenset[str]) -> Iterator[_Refusal]:
    match fact:
        case Literal(atom=atom):
            yield from _in_arguments(atom.arguments, fact.place, run_time)
        case TermFact(term=term):
            yield from _in_arguments(term.arguments, fact.place, run_time)
        case Comparison():
            yield from _in_comparison(fact, run_time)
        case FactAll(parts=parts):
            for part in parts:
                yield from _in_fact(part, run_time)
        case FactForall(body=body) | ExactlyOne(body=body):
            yield from _in_fact(body, run_time)


def _in_comparison(fact: Comparison, run_time: frozenset[str]) -> Iterator[_Refusal]:
    sides = fact.left, fact.right
    named = next((side for side in sides if isinstance(side, Application)), None)
    if named is None:
        yield "a fact that compares no function term is", fact.place
    elif fact.operator not in ("=", "!="):
        yield f'the comparison "{fact.operator}" as a fact is', fact.place
    elif fact.operator == "!=" and any(
        isinstance(side, Application | Arithmetic | External) for side in sides if side != named
    ):
        yield '"!=" between two terms as a fact is', fact.place
    else:
        yield from _in_arguments(named.arguments, fact.place, run_time)


def _in_arguments(
    arguments: Iterable[Term], place: Place | None, run_time: frozenset[str] = frozenset()
) -> Iterator[_Refusal]:
    for argument in arguments:
        if isinstance(argument, Application | Arithmetic | External):
            yield "a function term as an argument of a fact is", place
        elif isinstance(argument, Variable) and argument.name in run_time:
            yield f'the run-time variable "{argument.name}" as an argument of a fact is', place
