"""PKS terms, atoms and claims: every name resolved, every type checked; None after a report."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from kabo.language import formulas as f
from kabo.language.foreign_vocabulary import (
    ANY,
    NUMBER,
    OBJECT,
    Bound,
    Kinds,
    Scope,
    Signature,
    Vocabulary,
    term_of_object,
)
from kabo.language.pks.expressions import Expression, Token, place_of
from kabo.language.pks.markup import Markup

COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
_ARITHMETIC = ("+", "-", "*", "/")


@dataclass(frozen=True)
class Context:
    """What is known around an expression; `where` completes "unknown predicate "p" …".

    `free`: variables that nobody binds are collected here (LCW, update rules); without it they are errors.
    """

    markup: Markup
    vocabulary: Vocabulary
    where: str
    scope: Scope = field(default_factory=dict)
    free: dict[str, Bound] | None = None

    def report(self, piece: Expression | Token, message: str, hint: str | None = None) -> None:
        """Records a finding at a piece of the text."""
        self.markup.findings.add(place_of(self.markup, piece), message, hint)

    def place(self, piece: Expression | Token) -> f.Place:
        """Where the piece stands."""
        return place_of(self.markup, piece)

    def text(self, piece: Expression) -> str:
        """The piece as it is written, on one line, shortened if it is long."""
        written = " ".join(self.markup.text[piece.start : piece.end].split())
        return written if len(written) <= 60 else f"{written[:57]}…"

    def inside(self, scope: Mapping[str, Bound]) -> "Context":
        """This context with more variables in scope."""
        return replace(self, scope={**self.scope, **scope})


def bind(context: Context, variables: list[tuple[Token, Token | None]]) -> dict[str, Bound]:
    """The variables of a parameter list or quantifier, by their names in the file."""
    vocabulary, found = context.vocabulary, dict[str, Bound]()
    for token, kind in variables:
        if token.text in found:
            context.report(token, f'the variable "{token.text}" stands twice in this list')
            continue
        kinds = kinds_of(context, kind)
        taken = [bound.variable.name for bound in (*context.scope.values(), *found.values())]
        name = vocabulary.names.free(token.text.lstrip("?"), taken)
        found[token.text] = Bound(f.Variable(name, vocabulary.types.common(kinds), context.place(token)), kinds)
    return found


def kinds_of(context: Context, token: Token | None) -> Kinds:
    """The type that a token names; `object` if there is none, ANY after a report."""
    types = context.vocabulary.types
    if token is None or token.text in types.known:
        return (types.known[OBJECT if token is None else token.text],)
    hint = context.vocabulary.findings.near(token.text, list(types.known))
    context.report(token, f'unknown type "{token.text}" {context.where}', hint)
    return ANY


# --------------------------------------------------------------------------------------------------------- terms
def read_term(context: Context, node: Expression, wanted: Kinds | None = None) -> tuple[f.Term, Kinds] | None:
    """A term, and what its values are; `wanted` is what a variable bound by nobody would have to be."""
    vocabulary, place = context.vocabulary, context.place(node)
    if node.kind in _ARITHMETIC or node.kind == "minus":
        return _arithmetic(context, node)
    if node.text in context.scope and node.kind in ("variable", "name"):
        bound = context.scope[node.text]
        return replace(bound.variable, place=place), bound.kinds
    if node.kind == "variable":
        return _free_variable(context, node, wanted)
    if node.kind in ("name", "number") and node.text in vocabulary.objects and wanted != (NUMBER,):
        return term_of_object(vocabulary, node.text, place), vocabulary.kinds_of_object(node.text)
    if node.kind == "number":
        value = float(node.text)
        if not math.isfinite(value):
            context.report(node, "this number is too large")
            return None
        return f.Number(value, place), (NUMBER,)
    if node.kind in ("name", "call") and node.text in vocabulary.functions:
        signature = vocabulary.functions[node.text]
        arguments = read_arguments(context, node, signature)
        if arguments is None:
            return None
        return f.Application(signature.name, arguments, place), signature.value or (NUMBER,)
    _report_unknown(context, node)
    return None


def _free_variable(context: Context, node: Expression, wanted: Kinds | None) -> tuple[f.Term, Kinds] | None:
    if context.free is None:
        hint = context.vocabulary.findings.near(node.text, list(context.scope))
        context.report(node, f'unknown variable "{node.text}" {context.where}', hint)
        return None
    if node.text not in context.free:
        types = context.vocabulary.types
        kind = types.known[OBJECT] if wanted is None or wanted == (NUMBER,) else types.common(wanted)
        taken = [bound.variable.name for bound in (*context.scope.values(), *context.free.values())]
        name = context.vocabulary.names.free(node.text.lstrip("?"), taken)
        context.free[node.text] = Bound(f.Variable(name, kind, context.place(node)), (kind,))
    bound = context.free[node.text]
    return replace(bound.variable, place=context.place(node)), bound.kinds


def _report_unknown(context: Context, node: Expression) -> None:
    vocabulary = context.vocabulary
    if node.kind == "call" and node.text not in vocabulary.predicates:
        hint = vocabulary.near(node.text, vocabulary.functions)
        message = f'unknown function "{node.text}" {context.where}'
        context.report(node, f"{message}; external procedures are not supported in imported files", hint)
    elif node.kind == "name" and node.text not in vocabulary.predicates:
        hint = vocabulary.near(node.text, [*vocabulary.objects, *vocabulary.functions], all_if_few=False)
        context.report(node, f'unknown constant "{node.text}" {context.where}', hint)
    elif node.kind in ("name", "call"):
        context.report(node, f'"{node.text}" is a predicate: it is true or false, and no value')
    else:
        context.report(node, f'unexpected "{context.text(node)}" {context.where}, expected a term')


def _arithmetic(context: Context, node: Expression) -> tuple[f.Term, Kinds] | None:
    operands = [read_number(context, part) for part in node.parts]
    place = context.place(node)
    if operands[0] is None or operands[-1] is None:
        return None
    if node.kind == "minus":
        if isinstance(operands[0], f.Number):
            return f.Number(-operands[0].value + 0.0, place), (NUMBER,)
        return f.Arithmetic("-", f.Number(0.0, place), operands[0], place), (NUMBER,)
    return f.Arithmetic(node.kind, operands[0], operands[1], place), (NUMBER,)  # type: ignore[arg-type]


def read_number(context: Context, node: Expression) -> f.Term | None:
    """A term whose value is a number."""
    found = read_term(context, node, (NUMBER,))
    if found is not None and found[1] not in ((NUMBER,), ANY):
        context.report(node, f'"{context.text(node)}" is no number, expected one')
        return None
    return None if found is None else found[0]


def read_arguments(context: Context, node: Expression, signature: Signature) -> tuple[f.Term, ...] | None:
    """The arguments of a predicate or function, checked against its declaration."""
    wanted, vocabulary = signature.arguments, context.vocabulary
    if len(node.parts) != len(wanted):
        count = len(wanted)
        message = f"{signature.original} takes {count or 'no'} argument{'' if count == 1 else 's'}"
        hint = vocabulary.declared_at(signature)
        context.report(node, f"{message}, not {len(node.parts) or 'none'}", hint)
        return None
    found = [read_term(context, part, kinds) for part, kinds in zip(node.parts, wanted, strict=True)]
    for number, (part, each, kinds) in enumerate(zip(node.parts, found, wanted, strict=True), 1):
        if each is not None and not vocabulary.types.fits(each[1], kinds):
            message = f"argument {number} of {signature.original} must be of type {' or '.join(kinds)}"
            message += f', "{context.text(part)}" is of type {" or ".join(each[1])}'
            context.report(part, message, vocabulary.declared_at(signature))
            return None
    terms = tuple(each[0] for each in found if each is not None)
    return terms if len(terms) == len(found) else None


# -------------------------------------------------------------------------------------------------------- claims
def read_atom(context: Context, node: Expression) -> f.Atom | None:
    """A predicate with its arguments."""
    vocabulary = context.vocabulary
    if node.kind in ("name", "call") and node.text in vocabulary.predicates:
        signature = vocabulary.predicates[node.text]
        arguments = read_arguments(context, node, signature)
        return None if arguments is None else f.Atom(signature.name, arguments, context.place(node))
    if node.kind in ("name", "call") and node.text in vocabulary.functions:
        remedy = f"compare it: {context.text(node)} = value"
        context.report(node, f'"{node.text}" is a function, not a predicate', remedy)
    elif node.kind in ("name", "call"):
        hint = vocabulary.near(node.text, vocabulary.predicates)
        context.report(node, f'unknown predicate "{node.text}" {context.where}', hint)
    else:
        context.report(node, f'unexpected "{context.text(node)}" {context.where}, expected an atom')
    return None


def read_claim(context: Context, node: Expression) -> f.Claim | f.Truth | None:
    """A literal or a comparison; what can never be equal is false, or with `!=` true."""
    if node.kind in COMPARISONS:
        return _comparison(context, node)
    inner = node.parts[0] if node.kind == "!" else node
    if node.kind == "!" and inner.kind in ("=", "!="):
        claim = read_claim(context, inner)
        if isinstance(claim, f.Comparison):
            return replace(claim, operator="!=" if claim.operator == "=" else "=")
        return f.Truth(not claim.value, claim.place) if isinstance(claim, f.Truth) else None
    atom = read_atom(context, inner)
    return None if atom is None else f.Literal(atom, node.kind != "!", context.place(node))


def _comparison(context: Context, node: Expression) -> f.Comparison | f.Truth | None:
    left = read_term(context, node.parts[0])
    right = read_term(context, node.parts[1], None if left is None else left[1])
    if left is None or right is None:
        return None
    if node.kind not in ("=", "!="):
        for part, (_, kinds) in zip(node.parts, (left, right), strict=True):
            if kinds not in ((NUMBER,), ANY):
                context.report(part, f'"{node.kind}" compares numbers, "{context.text(part)}" is none')
                return None
    elif not context.vocabulary.types.comparable(left[1], right[1]):
        return f.Truth(node.kind == "!=", context.place(node))
    return f.Comparison(node.kind, left[0], right[0], context.place(node))  # type: ignore[arg-type]
