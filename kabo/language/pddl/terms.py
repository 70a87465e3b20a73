"""PDDL terms, atoms and comparisons: every name resolved, every type checked; None after a report."""

import math
import re
from dataclasses import dataclass, field, replace

from kabo.language import formulas as f
from kabo.language.foreign_vocabulary import ANY, NUMBER, Kinds, Scope, Signature, Vocabulary, term_of_object
from kabo.language.pddl.forms import Document, Form, Node, Word
from kabo.language.tree_algebra import nodes

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:e[+-]?[0-9]+)?")
_ARITHMETIC = ("+", "-", "*", "/")
_MOST_OPERANDS = 30
_MOST_OPERATORS = 60


@dataclass(frozen=True)
class Context:
    """What is known around a piece of a formula; `where` completes "unknown predicate "p" …"."""

    document: Document
    vocabulary: Vocabulary
    where: str
    scope: Scope = field(default_factory=dict)

    def report(self, node: Node, message: str, hint: str | None = None, *, warning: bool = False) -> None:
        """Records a finding at a node."""
        self.document.report(node, message, hint, warning=warning)

    def place(self, node: Node) -> f.Place:
        """Where the node stands."""
        return self.document.place(node)

    def inside(self, scope: Scope) -> "Context":
        """This context with more variables in scope."""
        return replace(self, scope={**self.scope, **scope})


def read_term(context: Context, node: Node) -> tuple[f.Term, Kinds] | None:
    """A term, and what its values are."""
    if isinstance(node, Form):
        return _function_term(context, node)
    vocabulary, word = context.vocabulary, node.text
    if word in context.scope:
        bound = context.scope[word]
        return replace(bound.variable, place=context.place(node)), bound.kinds
    if word in vocabulary.objects:
        return term_of_object(vocabulary, word, context.place(node)), vocabulary.kinds_of_object(word)
    if _NUMBER.fullmatch(word):
        return _number(context, node, word)
    if word in vocabulary.functions and not vocabulary.functions[word].arguments:
        return _function_term(context, Form([node], node.start, node.end))
    if word.startswith("?"):
        hint = context.vocabulary.findings.near(word, list(context.scope))
        context.report(node, f'unknown variable "{word}" {context.where}', hint)
    else:
        hint = vocabulary.near(word, [*vocabulary.objects, *context.scope], all_if_few=False)
        context.report(node, f'unknown object "{word}" {context.where}', hint)
    return None


def _number(context: Context, node: Node, word: str) -> tuple[f.Term, Kinds] | None:
    value = float(word)
    if not math.isfinite(value):
        context.report(node, "this number is too large")
        return None
    return f.Number(value + 0.0, context.place(node)), (NUMBER,)


def _function_term(context: Context, form: Form) -> tuple[f.Term, Kinds] | None:
    head, vocabulary = form.head, context.vocabulary
    if head in _ARITHMETIC and head not in vocabulary.functions:
        return _arithmetic(context, form)
    if head in vocabulary.functions:
        signature = vocabulary.functions[head]
        arguments = read_arguments(context, form, signature)
        if arguments is None:
            return None
        return f.Application(signature.name, arguments, context.place(form)), signature.value or (NUMBER,)
    if head in vocabulary.predicates:
        context.report(form, f'"{head}" is a predicate: it is true or false, and no value')
    else:
        hint = vocabulary.near(head, vocabulary.functions) if head else None
        what = f'unknown function "{head}"' if head else f'unexpected "{context.document.text(form)}"'
        context.report(form.items[0] if head else form, f"{what} {context.where}", hint)
    return None


def _arithmetic(context: Context, form: Form) -> tuple[f.Term, Kinds] | None:
    operator, place = form.head, context.place(form)
    operands = [read_number(context, node) for node in form.rest]
    most = _MOST_OPERANDS if operator in "+*" else 2
    if not 1 <= len(operands) <= most or (len(operands) == 1 and operator != "-"):
        count = "one or two" if operator == "-" else f"two{f' to {most}' if most > 2 else ''}"
        context.report(form, f'"{operator}" takes {count} operands here, not {len(operands)}')
        return None
    terms = [operand for operand in operands if operand is not None]
    if len(terms) < len(operands):
        return None
    if len(terms) == 1:
        if isinstance(terms[0], f.Number):
            return f.Number(-terms[0].value + 0.0, place), (NUMBER,)
        terms.insert(0, f.Number(0.0, place))
    whole = terms[0]
    for term in terms[1:]:
        whole = f.Arithmetic(operator, whole, term, place)  # type: ignore[arg-type]
    if sum(isinstance(node, f.Arithmetic) for node in nodes(whole)) > _MOST_OPERATORS:
        context.report(form, f"a term has at most {_MOST_OPERATORS} operators")
        return None
    return whole, (NUMBER,)


def read_number(context: Context, node: Node) -> f.Term | None:
    """A term whose value is a number."""
    found = read_term(context, node)
    if found is None:
        return None
    term, kinds = found
    if kinds not in ((NUMBER,), ANY):
        context.report(node, f'"{context.document.text(node)}" is no number, expected one')
        return None
    return term


def read_arguments(context: Context, form: Form, signature: Signature) -> tuple[f.Term, ...] | None:
    """The arguments of a predicate or function, checked against its declaration."""
    found = [read_term(context, node) for node in form.rest]
    vocabulary, wanted = context.vocabulary, signature.arguments
    if len(found) != len(wanted):
        count = len(wanted)
        message = f"{signature.original} takes {count or 'no'} argument{'' if count == 1 else 's'}"
        context.report(form, f"{message}, not {len(found) or 'none'}", vocabulary.declared_at(signature))
        return None
    for number, (node, each, kinds) in enumerate(zip(form.rest, found, wanted, strict=True), 1):
        if each is not None and not vocabulary.types.fits(each[1], kinds):
            message = f"argument {number} of {signature.original} must be of type {_or(kinds)}"
            message += f', "{context.document.text(node)}" is of type {_or(each[1])}'
            context.report(node, message, vocabulary.declared_at(signature))
            return None
    terms = tuple(each[0] for each in found if each is not None)
    return terms if len(terms) == len(found) else None


def _or(kinds: Kinds) -> str:
    return " or ".join(kinds)


def read_atom(context: Context, node: Node) -> f.Atom | None:
    """A predicate with its arguments."""
    form = Form([node], node.start, node.end) if isinstance(node, Word) else node
    head, vocabulary = form.head, context.vocabulary
    if head in vocabulary.predicates:
        signature = vocabulary.predicates[head]
        arguments = read_arguments(context, form, signature)
        return None if arguments is None else f.Atom(signature.name, arguments, context.place(node))
    if head in vocabulary.functions:
        context.report(node, f'"{head}" is a function, not a predicate', f"compare it: (= ({head} …) …)")
    elif not head:
        what = "()" if not form.items else context.document.text(form)
        context.report(node, f'unexpected "{what}" {context.where}, expected "(predicate …)"')
    else:
        hint = vocabulary.near(head, vocabulary.predicates)
        context.report(form.items[0], f'unknown predicate "{head}" {context.where}', hint)
    return None


def read_comparison(context: Context, form: Form) -> f.Comparison | f.Truth | None:
    """`(= a b)`, `(< a b)` …; what can never be equal is false."""
    operator = form.head
    if len(form.items) != 3:
        context.report(form, f'"{operator}" compares two things, not {len(form.items) - 1}')
        return None
    found = [read_term(context, node) for node in form.rest]
    if found[0] is None or found[1] is None:
        return None
    (left, left_kinds), (right, right_kinds) = found[0], found[1]
    if operator != "=":
        for node, kinds in zip(form.rest, (left_kinds, right_kinds), strict=True):
            if kinds not in ((NUMBER,), ANY):
                context.report(node, f'"{operator}" compares numbers, "{context.document.text(node)}" is none')
                return None
    elif not context.vocabulary.types.comparable(left_kinds, right_kinds):
        return f.Truth(False, context.place(form))
    return f.Comparison(operator, left, right, context.place(form))  # type: ignore[arg-type]
