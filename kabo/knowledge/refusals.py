"""What this planner does not support yet, refused by name and place: nothing is dropped silently."""

from collections.abc import Iterable, Iterator

from kabo.errors import Diagnostic, InputError
from kabo.language.formulas import (
    And,
    Application,
    Arithmetic,
    Change,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    Exists,
    Fact,
    FactAll,
    FactForall,
    Forall,
    ForEach,
    Formula,
    Literal,
    Not,
    Or,
    Place,
    Temporal,
    Term,
    TermFact,
    WorldEffect,
    Xor,
)
from kabo.language.problem import Problem

_Refusal = tuple[str, Place | None]


def refuse_unsupported(problem: Problem) -> None:
    """Raises an InputError with a Diagnostic for everything in the problem that is not supported yet."""
    where = str(problem.domain.path or problem.path)
    found = [_diagnostic(what, place, where) for what, place in _refusals(problem)]
    if found:
        raise InputError(found)


def _diagnostic(what: str, place: Place | None, file: str) -> Diagnostic:
    message = f"{what} not supported yet"
    if place is None:
        return Diagnostic(file, 1, 1, message)
    return Diagnostic(place.file, place.line, place.column, message, length=place.length)


def _refusals(problem: Problem) -> Iterator[_Refusal]:
    for rule in problem.domain.update_rules:
        yield "update rules are", getattr(rule, "place", None)
    for action in problem.domain.actions.values():
        for parameter in action.parameters:
            if parameter.value_of is not None:
                yield (
                    f'the run-time variable "{parameter.name}" (value_of) of action "{action.name}" is',
                    parameter.place,
                )
        yield from _in_formulas(action.preconditions)
        yield from _in_effects(action.effects)
        for sensed in action.sense:
            yield from _in_arguments(sensed.arguments, sensed.place)
    yield from _in_effects(problem.initial)
    yield from _in_formulas(problem.goal)


def _in_formulas(formulas: Iterable[Formula]) -> Iterator[_Refusal]:
    for formula in formulas:
        match formula:
            case Temporal(kind=kind):
                yield f"{kind}(…) in a goal is", formula.place
            case Not(body=body) | Forall(body=body) | Exists(body=body):
                yield from _in_formulas([body])
            case And(parts=parts) | Or(parts=parts):
                yield from _in_formulas(parts)
            case Xor(first=first, second=second):
                yield from _in_formulas([first, second])


def _in_effects(effects: Iterable[Effect]) -> Iterator[_Refusal]:
    for effect in effects:
        match effect:
            case WorldEffect():
                yield "a world effect (when … then …) is", effect.place
            case Conditional():
                yield from _in_formulas([effect.condition])
                yield from _in_effects(effect.updates)
            case ForEach(effects=inner):
                yield from _in_effects(inner)
            case Change(database="Kx" | "LCW"):
                yield f"the database {effect.database} is", effect.place
            case Change():
                for fact in effect.facts:
                    yield from _in_fact(effect, fact)


def _in_fact(change: Change, fact: Fact) -> Iterator[_Refusal]:
    match fact:
        case Literal(atom=atom):
            yield from _in_arguments(atom.arguments, fact.place)
        case TermFact(term=term):
            yield from _in_arguments(term.arguments, fact.place)
        case Comparison():
            yield from _in_comparison(fact)
        case ExactlyOne():
            yield f"exactly_one in {change.database} is", fact.place
        case FactAll() | FactForall() if (change.operation, change.database) != ("add", "Kf"):
            kind = "conjunction" if isinstance(fact, FactAll) else "forall"
            yield f"a {kind} as one fact of {change.operation}({change.database}, …) is", fact.place
        case FactAll(parts=parts):
            for part in parts:
                yield from _in_fact(change, part)
        case FactForall(body=body):
            yield from _in_fact(change, body)


def _in_comparison(fact: Comparison) -> Iterator[_Refusal]:
    sides = fact.left, fact.right
    named = next((side for side in sides if isinstance(side, Application)), None)
    if named is None:
        yield "a fact that compares no function term is", fact.place
    elif fact.operator not in ("=", "!="):
        yield f'the comparison "{fact.operator}" as a fact is', fact.place
    elif fact.operator == "!=" and any(
        isinstance(side, Application | Arithmetic) for side in sides if side != named
    ):
        yield '"!=" between two terms as a fact is', fact.place
    else:
        yield from _in_arguments(named.arguments, fact.place)


def _in_arguments(arguments: Iterable[Term], place: Place | None) -> Iterator[_Refusal]:
    if any(isinstance(argument, Application | Arithmetic) for argument in arguments):
        yield "a function term as an argument of a fact is", place
