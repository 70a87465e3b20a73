"""From lark's parse trees to expressions with places in the file: the grammar's rules become kinds, its words texts."""

from collections.abc import Callable

import lark

from kabo.language.expressions import Expression
from kabo.language.yaml.syntax import Parsed, Token, Tree

_OF_RULES = {"negation": "not", "denial": "!"}


def expression_of(parsed: Parsed, tree: Tree) -> Expression:
    """A parse tree of the start symbols formula, effect, procedure or value; other rules keep their names as kinds."""
    start, end = parsed.span(tree)
    return _READ.get(str(tree.data), _plain)(parsed, tree, start, end)


def _plain(parsed: Parsed, tree: Tree, start: int, end: int) -> Expression:
    """Words of the rule become its text, rules inside its parts; variables are kept apart."""
    words: list[str] = []
    parts: list[Expression] = []
    variables: list[tuple[Expression, Expression | None]] = []
    for child in tree.children:
        if isinstance(child, lark.Token):
            words.append(str(child))
        elif child.data == "variables":
            variables = _variables(parsed, child)
        else:
            parts.append(expression_of(parsed, child))
    rule = str(tree.data)
    return Expression(_OF_RULES.get(rule, rule), " ".join(words), start, end, parts, variables)


def _called(parsed: Parsed, tree: Tree, start: int, end: int) -> Expression:
    name, *arguments = tree.children
    parts = [expression_of(parsed, each) for each in arguments]
    kind = "name" if tree.data == "term" and not parts else "call"
    return Expression(kind, str(name), start, end, parts)


def _infix(parsed: Parsed, tree: Tree, start: int, end: int) -> Expression:
    left, operator, right = tree.children
    return Expression(
        str(operator), str(operator), start, end, [expression_of(parsed, left), expression_of(parsed, right)]
    )


def _signed(parsed: Parsed, tree: Tree, start: int, end: int) -> Expression:
    sign, inner = tree.children
    return Expression(str(sign), str(sign), start, end, [expression_of(parsed, inner)])


def _argument(parsed: Parsed, tree: Tree, start: int, end: int) -> Expression:
    """An argument of a procedure: its text is its name, if it has one; its only part is the value."""
    *name, value = tree.children
    inner = word(parsed, value) if isinstance(value, lark.Token) else expression_of(parsed, value)
    return Expression("argument", str(name[0]) if name else "", start, end, [inner])


def word(parsed: Parsed, token: Token) -> Expression:
    """A single token."""
    start, end = parsed.span(token)
    return Expression("number" if token.type == "NUMBER" else "name", str(token), start, end)


def _variables(parsed: Parsed, tree: Tree) -> list[tuple[Expression, Expression | None]]:
    """The names of `type x, other y` with their types."""
    words = [word(parsed, token) for token in tree.children if isinstance(token, lark.Token)]
    return list(zip(words[1::2], words[::2], strict=True))


_READ: dict[str, Callable[[Parsed, Tree, int, int], Expression]] = {
    "term": _called, "call": _called, "procedure": _called, "compare": _infix, "arithmetic": _infix,
    "signed": _signed, "argument": _argument,
}  # fmt: skip
