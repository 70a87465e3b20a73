"""PKS declarations: symbols by their number of arguments (`p/1`) or by types (`p(t, u)`, `f(t):u`), constants, types.

Files without types have the single type `object`; unary predicates used like types stay predicates. The value of
an untyped function is a number if the function is used in arithmetic or compared with numbers anywhere, else an
object.
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Literal

from kabo.language.expressions import Expression
from kabo.language.pks.expressions import Broken, place_of, tokens_of, typed_names
from kabo.language.pks.markup import Element, Markup
from kabo.language.types import ANY, NUMBERS, OBJECT, Kind
from kabo.language.vocabulary import Symbol, Vocabulary

_NUMBERS = ("number", "int", "integer", "real", "float", "double")
_COMPUTED = ("number", "+", "-", "*", "/")
_MOST_ARGUMENTS = 20

Declared = Literal["predicate", "function"]
DECLARED: tuple[Declared, ...] = ("predicate", "function")


def read_types(markup: Markup, vocabulary: Vocabulary, elements: Iterable[Element]) -> None:
    """Declares `object` and all types in the elements, such as `<types>a, b : a</types>`, with supertypes."""
    types = vocabulary.types
    types.declare(OBJECT, None)
    pairs: list[tuple[Expression, Expression | None]] = []
    for element in elements:
        tokens = [
            Expression("sign", ":", each.start, each.end) if each.text in ("<", "-") else each
            for each in tokens_of(markup, element.inside, element.end)
        ]
        pairs += _list(markup, tokens, ("name",), grouped=False)
    for token, _ in pairs:
        if token.text not in types.known:
            types.declare(token.text, place_of(markup, token))
    for token, parent in pairs:
        if parent is not None and parent.text not in types.known:
            types.declare(parent.text, place_of(markup, parent))
        if token.text != OBJECT and parent is not None:
            types.parents[types.known[token.text]] = types.known[parent.text]
    root = types.known[OBJECT]
    for name, kind in types.known.items():
        if name == OBJECT:
            continue
        if types.parents[kind] is None:
            types.parents[kind] = root
    for name, kind in types.known.items():
        if root not in types.ancestors(kind):
            place = types.places[name]
            if place is not None:
                markup.findings.add(place, f'the type "{name}" is its own supertype')
            types.parents[kind] = root


def _list(
    markup: Markup, tokens: list[Expression], kinds: tuple[str, ...], *, grouped: bool = True
) -> list[tuple[Expression, Expression | None]]:
    try:
        return typed_names(tokens, kinds, grouped=grouped)
    except Broken as broken:
        place = place_of(markup, broken.token)
        markup.findings.add(place, f'unexpected "{broken.token.text}", expected {broken.expected}')
        return []


def read_constants(markup: Markup, vocabulary: Vocabulary, element: Element) -> None:
    """Declares the objects of `<constants>a, b : t</constants>`."""
    tokens = tokens_of(markup, element.inside, element.end)
    for token, kind in _list(markup, tokens, ("name", "number")):
        name, place = _type(markup, vocabulary, kind), place_of(markup, token)
        earlier = vocabulary.objects.get(token.text)
        if earlier is None:
            own = vocabulary.names.take(token.text)
            vocabulary.objects[token.text] = Symbol("object", own, place, (name,), original=token.text, type=name)
        elif earlier.type != name:
            markup.findings.add(place, f'"{token.text}" is declared twice, with different types')


def _type(markup: Markup, vocabulary: Vocabulary, token: Expression | None) -> str:
    """The type that a token names; a type that is nowhere else declared is declared here."""
    types = vocabulary.types
    if token is None:
        return types.known[OBJECT]
    if token.text not in types.known:
        types.parents[types.declare(token.text, place_of(markup, token))] = types.known[OBJECT]
    return types.known[token.text]


def read_symbols(
    markup: Markup, vocabulary: Vocabulary, element: Element, role: Declared, numeric: frozenset[str]
) -> None:
    """Declares predicates or functions.

    Args:
        markup: the parsed file.
        vocabulary: the vocabulary that receives the symbols.
        element: the element that lists the symbols.
        role: "predicate" or "function".
        numeric: the untyped functions whose values are numbers.
    """
    tokens = tokens_of(markup, element.inside, element.end)
    at = 0
    while tokens[at].kind != "end":
        token = tokens[at]
        if token.text in (",", ";"):
            at += 1
        elif token.kind != "name":
            markup.findings.add(
                place_of(markup, token), f'unexpected "{token.text}", expected the name of a {role}'
            )
            at += 1
        else:
            at = _read_symbol(markup, vocabulary, tokens, at, role, numeric)


def _read_symbol(
    markup: Markup,
    vocabulary: Vocabulary,
    tokens: list[Expression],
    at: int,
    role: Declared,
    numeric: frozenset[str],
) -> int:
    """Declares the symbol at a token; the position behind it."""
    name, after = tokens[at], tokens[at + 1]
    arguments: tuple[Kind, ...] = ()
    at += 1
    if after.text == "/":
        count = tokens[at + 1] if after.kind != "end" else after
        if count.kind != "number" or not count.text.isdigit() or int(count.text) > _MOST_ARGUMENTS:
            message = f'unexpected "{count.text}", expected the number of arguments of "{name.text}"'
            markup.findings.add(place_of(markup, count), message, "write p/1, or p(type, …)")
            return at + 1
        arguments = ((vocabulary.types.known[OBJECT],),) * int(count.text)
        at += 2
    elif after.text == "(":
        found: list[Kind] = []
        at += 1
        while tokens[at].kind == "name" or tokens[at].text == ",":
            if tokens[at].kind == "name":
                found.append((_type(markup, vocabulary, tokens[at]),))
            at += 1
        if tokens[at].text != ")":
            place = place_of(markup, tokens[at])
            markup.findings.add(place, f'unexpected "{tokens[at].text}", expected a type or ")"')
            return at + (tokens[at].kind != "end")
        arguments = tuple(found)
        at += 1
    value = ANY
    if role == "function":
        value, at = _value(markup, vocabulary, tokens, at, name.text in numeric)
    _declare(
        markup, vocabulary, name, Symbol(role, "", place_of(markup, name), value, arguments, original=name.text)
    )
    return at


def _value(
    markup: Markup, vocabulary: Vocabulary, tokens: list[Expression], at: int, numeric: bool
) -> tuple[Kind, int]:
    """What a function's values are, and the position behind it."""
    if tokens[at].text != ":":
        return (NUMBERS if numeric else (vocabulary.types.known[OBJECT],)), at
    kind = tokens[at + 1]
    if kind.kind != "name":
        markup.findings.add(place_of(markup, kind), f'unexpected "{kind.text}", expected the type of a value')
        return NUMBERS, at + 1
    if kind.text in _NUMBERS and kind.text not in vocabulary.types.known:
        return NUMBERS, at + 2
    return (_type(markup, vocabulary, kind),), at + 2


def _declare(markup: Markup, vocabulary: Vocabulary, token: Expression, symbol: Symbol) -> None:
    earlier = vocabulary.symbols.get(token.text)
    if earlier is None:
        vocabulary.symbols[token.text] = replace(symbol, name=vocabulary.names.take(token.text))
    elif earlier.role != symbol.role or earlier.arguments != symbol.arguments:
        message = f'"{token.text}" is already the name of {earlier.description}'
        markup.findings.add(place_of(markup, token), message, vocabulary.declared_at(earlier))


# --------------------------------------------------------------------------------------------- functions of numbers
def numeric_functions(expressions: Iterable[Expression], constants: frozenset[str]) -> frozenset[str]:
    """The names that are used as numbers: in arithmetic, in comparisons by size, or in equations with a number.

    Numbers among `constants` are names of objects.
    """
    numeric: set[str] = set()
    equal: list[tuple[str, str]] = []
    for node in _all_nodes(expressions):
        names = [part.text for part in node.parts if part.kind in ("call", "name")]
        if node.kind in ("+", "-", "*", "/", "<", "<=", ">", ">="):
            numeric.update(names)
        elif node.kind in ("=", "!="):
            if any(part.kind in _COMPUTED and part.text not in constants for part in node.parts):
                numeric.update(names)
            elif len(names) == 2:
                equal.append((names[0], names[1]))
    grown = True
    while grown:
        before = len(numeric)
        for one, other in equal:
            if one in numeric or other in numeric:
                numeric |= {one, other}
        grown = len(numeric) > before
    return frozenset(numeric)


def _all_nodes(expressions: Iterable[Expression]) -> Iterator[Expression]:
    waiting = list(expressions)
    while waiting:
        node = waiting.pop()
        yield node
        waiting.extend(node.parts)
