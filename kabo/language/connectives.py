"""Conjunction, disjunction and negation of formulas, each simplified."""

from collections.abc import Iterable

from kabo.language import formulas as f

OPPOSITE = {"=": "!=", "!=": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}


def conjunction(parts: Iterable[f.Formula], place: f.Place | None = None) -> f.Formula:
    """The conjunction of the parts, flattened, without those that are `true`."""
    flat: list[f.Formula] = []
    for part in parts:
        flat.extend(part.parts if isinstance(part, f.And) else [part])
    flat = [part for part in flat if part != f.Truth(True)]
    if f.Truth(False) in flat:
        return f.Truth(False, place)
    if len(flat) < 2:
        return flat[0] if flat else f.Truth(True, place)
    return f.And(tuple(flat), place)


def disjunction(parts: Iterable[f.Formula], place: f.Place | None = None) -> f.Formula:
    """The disjunction of the parts, flattened, without those that are `false`."""
    flat: list[f.Formula] = []
    for part in parts:
        flat.extend(part.parts if isinstance(part, f.Or) else [part])
    flat = [part for part in flat if part != f.Truth(False)]
    if f.Truth(True) in flat:
        return f.Truth(True, place)
    if len(flat) < 2:
        return flat[0] if flat else f.Truth(False, place)
    return f.Or(tuple(flat), place)


def denied(claim: f.Claim) -> f.Claim:
    """The negation of a claim: the claim that holds exactly where the given claim does not."""
    if isinstance(claim, f.Literal):
        return f.Literal(claim.atom, not claim.positive, claim.place)
    return f.Comparison(OPPOSITE[claim.operator], claim.left, claim.right, claim.place)  # type: ignore[arg-type]


def negated(formula: f.Formula) -> f.Formula:
    """The negation of a condition, pushed inwards to its claims; correct only if every atom in it is known."""
    match formula:
        case f.Know(claim=claim):
            return f.Know(denied(claim), formula.place)
        case f.Truth(value=value):
            return f.Truth(not value, formula.place)
        case f.And(parts=parts):
            return disjunction(map(negated, parts), formula.place)
        case f.Or(parts=parts):
            return conjunction(map(negated, parts), formula.place)
        case f.Forall(variables=variables, body=body):
            return f.Exists(variables, negated(body), formula.place)
        case f.Exists(variables=variables, body=body):
            return f.Forall(variables, negated(body), formula.place)
    raise TypeError(f"no condition of PDDL: {formula!r}")
