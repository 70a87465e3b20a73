"""Reads PDDL's terms and atoms as expressions; defines PDDL's rules for names and types and its error messages."""

import re

from kabo.language import formulas as f
from kabo.language.expressions import ARITHMETIC, Expression
from kabo.language.pddl.forms import Document, Form, Node, Token
from kabo.language.resolver import Dialect, NameResolver, Typed
from kabo.language.tree_algebra import nodes
from kabo.language.vocabulary import Symbol, Vocabulary

_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:e[+-]?[0-9]+)?")
_KINDS = {"?": "variable", **dict.fromkeys("+-.0123456789", "number")}  # by what a word begins with
_MOST_OPERANDS = 30
_MOST_OPERATORS = 60


class PddlDialect(Dialect):
    """The dialect of PDDL: objects, variables and predicates have namespaces of their own."""

    def unknown_term(self, here: NameResolver, node: Expression) -> None:
        """Reports an unknown variable, object or function."""
        vocabulary, word = here.vocabulary, node.text
        if node.kind != "call":
            if word.startswith("?"):
                what, hint = "variable", here.findings.near(word, list(here.scope))
            else:
                what, hint = "object", vocabulary.near(word, [*vocabulary.objects, *here.scope], all_if_few=False)
            here.report(node, f'unknown {what} "{word}" {here.where}', hint)
        elif word:
            hint = vocabulary.near(word, vocabulary.written("function"))
            here.report(node.name, f'unknown function "{word}" {here.where}', hint)
        else:
            here.report(node, f'unexpected "{here.quote(node)}" {here.where}')

    def no_value(self, here: NameResolver, node: Expression, symbol: Symbol) -> None:
        """Reports a predicate in the place of a term; a mere name is reported as an unknown object."""
        if node.kind != "call":
            self.unknown_term(here, node)
        else:
            super().no_value(here, node, symbol)

    def no_atom(self, here: NameResolver, node: Expression, symbol: Symbol | None) -> None:
        """Reports a function, an unknown predicate or anything but a word in the place of an atom."""
        if symbol is not None:
            message = f'"{node.text}" is a function, not a predicate'
            here.report(node, message, f"compare it: (= ({node.text} …) …)")
        elif node.text:
            hint = here.vocabulary.near(node.text, here.vocabulary.written("predicate"))
            here.report(node.name, f'unknown predicate "{node.text}" {here.where}', hint)
        else:
            what = "()" if node.name_at is None else here.quote(node)
            here.report(node, f'unexpected "{what}" {here.where}, expected "(predicate …)"')

    def wrong_count(self, here: NameResolver, node: Expression, symbol: Symbol) -> None:
        """Reports a wrong number of arguments; checks each of them as well."""
        if node.kind != "call":
            self.unknown_term(here, node)
            return
        for part in node.parts:
            here.term(part)
        super().wrong_count(here, node, symbol)

    def operand_fault(self, operator: str, count: int) -> str | None:
        """The message for a wrong number of operands; None if `operator` may have `count` operands."""
        most = _MOST_OPERANDS if operator in "+*" else 2
        if 1 <= count <= most and (count > 1 or operator == "-"):
            return None
        permitted = "one or two" if operator == "-" else f"two{f' to {most}' if most > 2 else ''}"
        return f'"{operator}" takes {permitted} operands here, not {count}'

    def size_fault(self, term: f.Term) -> str | None:
        """The message for a term with too many operators; None if it has an acceptable number of them."""
        if sum(isinstance(node, f.Arithmetic) for node in nodes(term)) > _MOST_OPERATORS:
            return f"a term has at most {_MOST_OPERATORS} operators"
        return None


PDDL = PddlDialect()


def resolver_of(document: Document, vocabulary: Vocabulary, where: str) -> NameResolver:
    """A resolver for the names in one part of a file, with no variables in scope."""
    return NameResolver(document.source, document.source.text, vocabulary, where, PDDL)


def expression_of(vocabulary: Vocabulary, node: Node) -> Expression:
    """A word or form as a term; an operator is read as a function if a function of that name is declared."""
    if isinstance(node, Token):
        text, start = node.text, node.start
        kind = _KINDS.get(text[0], "name")
        if kind == "number" and _NUMBER.fullmatch(text) is None:
            kind = "name"
        return Expression(kind, text, start, start + len(text))
    called = _called(vocabulary, node)
    if called.text in ARITHMETIC and vocabulary.function(called.text) is None:
        called.kind = called.text
    return called


def _called(vocabulary: Vocabulary, node: Node) -> Expression:
    """A word or form as an atom, or a function with its arguments."""
    if isinstance(node, Token):
        return Expression("call", node.text, node.start, node.end)
    parts = [expression_of(vocabulary, each) for each in node.rest]
    name_at = node.items[0].start if node.items else None
    return Expression("call", node.head, node.start, node.end, parts, (), name_at)


def read_term(here: NameResolver, node: Node) -> Typed | None:
    """A term and the kind of its values."""
    return here.term(expression_of(here.vocabulary, node))


def read_number(here: NameResolver, node: Node) -> f.Term | None:
    """A term whose value is a number."""
    return here.number(expression_of(here.vocabulary, node))


def read_atom(here: NameResolver, node: Node) -> f.Atom | None:
    """A predicate with its arguments."""
    return here.atom(_called(here.vocabulary, node))


def read_comparison(here: NameResolver, form: Form) -> f.Comparison | f.Truth | None:
    """A comparison such as `(= a b)` or `(< a b)`; an equality that can never hold becomes `false`."""
    if len(form.items) != 3:
        here.report(form, f'"{form.head}" compares two things, not {len(form.items) - 1}')
        return None
    sides = [expression_of(here.vocabulary, node) for node in form.rest]
    return here.comparison(Expression(form.head, form.head, form.start, form.end, sides))
