"""Explains why static facts make a formula false in every state: which part is false, and why."""

from collections.abc import Iterable, Iterator

from kabo.knowledge.binding import Binding
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.queries import FALSE
from kabo.language import spell_bound
from kabo.language.formulas import (
    And,
    Application,
    Comparison,
    Exists,
    Forall,
    Formula,
    Know,
    KnowValue,
    KnowWhether,
    Literal,
    Not,
    Or,
    Term,
)

SHOWN_ALTERNATIVES = 3  # alternatives of which each gets a sentence of its own


def why_false(compiler: Compiler, formula: Formula, binding: Binding) -> Iterator[str]:
    """Sentences that say why a formula is false in every state; none if static facts do not make it false."""
    if compiler.query(formula, binding) != FALSE:
        return
    match formula:
        case And(parts=parts):
            sentences = [s for part in parts for s in why_false(compiler, part, binding)]
            yield from sentences or [f"The parts of {spell_bound(formula, binding)} contradict each other."]
        case Forall():
            inner = compiler.instances(formula.variables, binding)
            sentences = [s for instance in inner for s in why_false(compiler, formula.body, instance)]
            yield from _some(
                sentences or [f"The instances of {spell_bound(formula, binding)} contradict each other."]
            )
        case Or(parts=parts):
            yield from _some([s for part in parts for s in why_false(compiler, part, binding)])
        case Exists():
            inner = compiler.instances(formula.variables, binding)
            sentences = [s for instance in inner for s in why_false(compiler, formula.body, instance)]
            yield from _some(sentences or [f"There is no object for {spell_bound(formula, binding)}."])
        case _:
            yield _leaf(compiler, formula, binding)


def _some(sentences: Iterable[str]) -> list[str]:
    every = list(dict.fromkeys(sentences))
    more = len(every) - SHOWN_ALTERNATIVES
    return every if more <= 1 else [*every[:SHOWN_ALTERNATIVES], f"The same holds of {more} others."]


def _leaf(compiler: Compiler, formula: Formula, binding: Binding) -> str:
    text = spell_bound(formula, binding)
    match formula:
        case Know(claim=Literal() as literal):
            opposite = Know(Literal(literal.atom, not literal.positive))
            return _claim(compiler, opposite, text, binding)
        case Know(claim=Comparison() as claim) if claim.operator in ("=", "!="):
            opposite = Know(Comparison("!=" if claim.operator == "=" else "=", claim.left, claim.right))
            return _claim(compiler, opposite, text, binding, _out_of_range(compiler, claim, binding))
        case KnowWhether() | KnowValue():
            about = text.split("(", 1)[1][:-1]
            asked = "known whether" if isinstance(formula, KnowWhether) else "known"
            return f"{about} can never be {asked}: it is not known at the start, and no action adds or senses it."
        case Not(body=body):
            return f"{spell_bound(body, binding)} holds from the start, and nothing ever changes that."
    return f"{text} never holds."


def _claim(compiler: Compiler, opposite: Know, text: str, binding: Binding, more: str = "") -> str:
    if more:
        return f"{text} never holds: {more}."
    if compiler.query(opposite, binding) != FALSE:
        said = spell_bound(opposite.claim, binding)
        return f"{text} never holds: {said} is known from the start, and nothing ever changes that."
    return f"{text} never holds: it is not known at the start, and no action or update rule adds or senses it."


def _out_of_range(compiler: Compiler, claim: Comparison, binding: Binding) -> str:
    """The sentence that a value is not in the range of its function; empty if it is."""
    sides: list[tuple[Term, Term]] = [(claim.left, claim.right), (claim.right, claim.left)]
    for term, value in sides:
        if claim.operator == "=" and isinstance(term, Application) and not isinstance(value, Application):
            values = compiler.problem.values_of(term.function)
            if values is not None and spell_bound(value, binding) not in values:
                return f"{spell_bound(value, binding)} is no value of {term.function}"
    return ""
