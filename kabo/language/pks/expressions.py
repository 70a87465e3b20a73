"""The parser of PKS expressions: one grammar for queries, effects and facts.

Operators from lowest to highest precedence: `=>` (right-associative), `|` and xor, `^` and `&`, `!`, comparisons,
`+ -`, `* /`. The body of a quantifier extends as far as possible. A statement ends with `;` or where the next one
begins.
"""

import re
from collections.abc import Iterator

from kabo.language.expressions import Expression, Span
from kabo.language.formulas import Place
from kabo.language.pks.markup import Markup

MAX_DEPTH = 60

_TOKEN = re.compile(
    r"(?P<variable>\?[A-Za-z_][\w']*)|(?P<number>[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>K\*(?=\s*\()|[A-Za-z_][\w']*)|(?P<sign>=>|->|!=|<=|>=|==|&&|\|\||[-+*/()<>=!~&^|,;:⊕])|(?P<other>\S)"
)
_SIGNS = {"->": "=>", "==": "=", "&&": "and", "||": "or", "&": "and", "^": "and", "|": "or", "~": "!", "⊕": "xor"}
_WORDS = {"and": "and", "or": "or", "xor": "xor", "not": "!"}
_QUANTIFIERS = {"forallK": "forall", "existsK": "exists", "forall": "forall", "exists": "exists"}
_LEVELS = (("=>",), ("or", "xor"), ("and",), ("=", "!=", "<", "<=", ">", ">="), ("+", "-"), ("*", "/"))
_LEVEL_OF = {sign: level for level, signs in enumerate(_LEVELS) for sign in signs}


class Broken(Exception):
    """A syntax error: the text is not an expression; carries the unexpected token and what was expected."""

    def __init__(self, token: Expression, expected: str) -> None:
        super().__init__(expected)
        self.token, self.expected = token, expected


def tokens_of(markup: Markup, start: int, end: int) -> list[Expression]:
    """The tokens between two offsets, followed by a token of kind `end`; unknown characters are reported.

    The other kinds are `variable`, `number`, `name` and `sign`; signs with several spellings are unified.
    """
    found: list[Expression] = []
    for match in _TOKEN.finditer(markup.text, start, end):
        kind, text = match.lastgroup or "", match[0]
        if kind == "other":
            shown = text if text.isprintable() else f"U+{ord(text):04X}"
            markup.findings.add(markup.source.place(match.start()), f'unexpected character "{shown}"')
            continue
        if kind == "sign":
            text = _SIGNS.get(text, text)
        elif text in _WORDS:
            kind, text = "sign", _WORDS[text]
        found.append(Expression(kind, text, match.start(), match.end()))
    return [*found, Expression("end", "the end", end, end)]


def place_of(markup: Markup, piece: Span) -> Place:
    """The place of a piece of the text in the file."""
    return markup.source.place(piece.start, piece.end)


def statements(markup: Markup, start: int, end: int) -> Iterator[Expression]:
    """The statements between two offsets; after a syntax error, the text up to the next `;` is skipped."""
    parser = _ExpressionParser(tokens_of(markup, start, end))
    while parser.skip_separators().kind != "end":
        try:
            expression = parser.expression(0)
        except Broken as broken:
            here = f'unexpected "{broken.token.text}"' if broken.token.kind != "end" else "the text ends"
            markup.findings.add(place_of(markup, broken.token), f"{here}, expected {broken.expected}")
            parser.recover()
            continue
        yield expression


class _ExpressionParser:
    def __init__(self, tokens: list[Expression]) -> None:
        self._tokens, self._at, self._depth = tokens, 0, 0

    @property
    def _next(self) -> Expression:
        return self._tokens[self._at]

    def _take(self) -> Expression:
        token = self._tokens[self._at]
        self._at += token.kind != "end"
        return token

    def _accept(self, text: str) -> Expression | None:
        token = self._tokens[self._at]
        if token.text != text or token.kind != "sign":
            return None
        self._at += 1
        return token

    def _expect(self, text: str) -> Expression:
        token = self._accept(text)
        if token is None:
            raise Broken(self._next, f'"{text}"')
        return token

    def skip_separators(self) -> Expression:
        """The next token that begins a statement."""
        while self._accept(";") or self._accept(","):
            pass
        return self._next

    def recover(self) -> None:
        """Goes on behind the next `;`."""
        self._depth = 0
        while self._next.kind != "end" and self._take().text != ";":
            pass

    # ------------------------------------------------------------------------------------------------- operators
    def expression(self, level: int) -> Expression:
        """An expression whose operators bind at least as tightly as a level."""
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise Broken(self._next, f"at most {MAX_DEPTH} levels of nesting")
        left = self._unary()
        length = 0
        while (own := self._level_of_next()) is not None and own >= level:
            operator = self._take().text
            length += operator not in ("and", "or")
            if length > MAX_DEPTH:
                raise Broken(self._next, f"at most {MAX_DEPTH} signs in one chain")
            right = self.expression(own if operator == "=>" else own + 1)
            if left.kind == operator and operator in ("and", "or") and isinstance(left.parts, list):
                left.parts.append(right)
                left.end = right.end
            else:
                left = Expression(operator, operator, left.start, right.end, [left, right])
        self._depth -= 1
        return left

    def _level_of_next(self) -> int | None:
        return _LEVEL_OF.get(self._next.text) if self._next.kind == "sign" else None

    def _unary(self) -> Expression:
        token = self._next
        if self._accept("!"):
            inner = self.expression(3)
            return Expression("!", "!", token.start, inner.end, [inner])
        if self._accept("-"):
            inner = self.expression(len(_LEVELS))
            return Expression("-", "-", token.start, inner.end, [inner])
        if self._accept("("):
            return self._group(token)
        if token.kind not in ("variable", "number", "name"):
            raise Broken(token, "a name, a variable, a number or a parenthesis")
        self._take()
        if token.kind == "name" and self._next.text == "(":
            return self._quantified(token) if token.text in _QUANTIFIERS else self._call(token)
        return token

    def _group(self, opening: Expression) -> Expression:
        parts = []
        while self.skip_separators().text != ")" or self._next.kind != "sign":
            parts.append(self.expression(0))
        closing = self._expect(")")
        if len(parts) == 1:
            return parts[0]
        return Expression("group", "", opening.start, closing.end, parts)

    def _call(self, name: Expression) -> Expression:
        self._expect("(")
        parts: list[Expression] = []
        while self._accept(",") or self._next.text != ")" or self._next.kind != "sign":
            if self._next.text == ")":
                break
            parts.append(self.expression(0))
            if self._next.text not in (",", ")"):
                raise Broken(self._next, '"," or ")"')
        closing = self._expect(")")
        return Expression("call", name.text, name.start, closing.end, parts)

    def _quantified(self, name: Expression) -> Expression:
        self._expect("(")
        variables = typed_names(self._until_closed(), ("variable", "name"))
        self._expect(")")
        body = self.expression(0)
        kind = _QUANTIFIERS[name.text]
        return Expression(kind, name.text, name.start, body.end, [body], variables)

    def _until_closed(self) -> list[Expression]:
        found = []
        while self._next.text not in (")", "(") and self._next.kind != "end":
            found.append(self._take())
        return [*found, self._next]


def typed_names(
    tokens: list[Expression], kinds: tuple[str, ...], *, grouped: bool = True
) -> list[tuple[Expression, Expression | None]]:
    """The names of `a : t, b, c : u` with their types; if `grouped`, a name without a type has that of the next.

    Raises:
        Broken: the tokens are not a list of names with types.
    """
    found: list[tuple[Expression, Expression | None]] = []
    waiting: list[Expression] = []
    at = 0
    while tokens[at].kind != "end" and tokens[at].text not in (")", "("):
        token = tokens[at]
        at += 1
        if token.kind in kinds:
            waiting.append(token)
        elif token.text == ":" and waiting:
            kind = tokens[at]
            if kind.kind != "name":
                raise Broken(kind, "the name of a type")
            at += 1
            found += [(each, kind if grouped or each is waiting[-1] else None) for each in waiting]
            waiting = []
        elif token.text == ";":
            found += [(each, None) for each in waiting]
            waiting = []
        elif token.text != ",":
            raise Broken(token, "a name or a variable")
    return found + [(each, None) for each in waiting]
