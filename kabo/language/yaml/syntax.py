"""The parser of formulas: from text to expressions by the grammar kabo.lark, with exact places and remedies.

The parser reads the text of the scalar in the file (with quotes and block header replaced by blanks), not the
value that YAML makes of it, so that an offset in the formula is an offset in the file.
"""

import re
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import lark

from kabo.compilation import cache_folder
from kabo.language.expressions import Expression
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.yaml.documents import Scalar

MAX_DEPTH = 40
MAX_LENGTH = 20_000

Tree = lark.Tree[Any]
Token = lark.Token

_STARTS = ["formula", "effect", "procedure", "constraint", "value"]
_WORDS = {
    "COMPARE": "a comparison", "RPAR": '")"', "LPAR": '"("', "NAME": "a name", "CHANGE": "add(…) or del(…)",
    "SIGN": '"+" or "-"', "OPERATOR": '"*" or "/"', "COMMA": '","', "NUMBER": "a number", "$END": "the end",
    "DATABASE": "Kf, Kw, Kv, Kx, Kor or LCW", "WHEN": "when … then …", "TEMPORAL": "initially or always",
    "EQUAL": '"="', "DOT": '"."', "LSQB": '"["', "RSQB": '"]"', "DEGREES": '"deg"', "__ANON_0": '"=>"',
}  # fmt: skip


@cache
def _parser() -> lark.Lark:
    grammar = resources.files("kabo.language.yaml").joinpath("kabo.lark").read_text(encoding="utf-8")
    # The tables are pickled by lark into kabo's own cache folder; that saves 0.1 s of every start.
    tables = cache_folder() / f"grammar-{lark.__version__}-{sys.version_info.major}.{sys.version_info.minor}.lark"
    return lark.Lark(
        grammar,
        parser="lalr",
        start=_STARTS,
        propagate_positions=True,
        maybe_placeholders=False,
        cache=str(tables),
    )


@dataclass(frozen=True)
class Parsed:
    """A parse tree and the scalar that holds its text."""

    tree: Tree
    scalar: Scalar

    def span(self, piece: Tree | Token) -> tuple[int, int]:
        """The offsets of a piece of the tree in the file."""
        begin = self.scalar.start
        if isinstance(piece, lark.Token):
            return begin + (piece.start_pos or 0), begin + (piece.end_pos or 0)
        if piece.meta.empty:
            return begin, self.scalar.end
        return begin + piece.meta.start_pos, begin + piece.meta.end_pos

    def place(self, piece: Tree | Token) -> Place:
        """The place of a piece of the tree in the file."""
        return self.scalar.source.place(*self.span(piece))


def parse(scalar: Scalar, start: str, findings: Findings) -> Parsed | None:
    """The parse tree of a scalar from the start symbol `start`; None after reporting why there is none."""
    text = _formula_text(scalar)
    if len(text) > MAX_LENGTH:
        findings.add(scalar.place, f"a formula has at most {MAX_LENGTH} characters, this one {len(text)}")
        return None
    try:
        tree = _parser().parse(text, start=start)
    except lark.exceptions.UnexpectedInput as error:
        _report(scalar, text, start, error, findings)
        return None
    if not isinstance(tree, lark.Tree):  # a single token: only `?value: NAME`-like rules could, and none does
        tree = lark.Tree("term", [tree])
    parsed = Parsed(tree, scalar)
    too_deep = _first_too_deep(tree)
    if too_deep is not None:
        findings.add(parsed.place(too_deep), f"this formula is nested deeper than {MAX_DEPTH} levels")
        return None
    return parsed


def _formula_text(scalar: Scalar) -> str:
    text = scalar.source.text[scalar.start : scalar.end]
    if scalar.style in ("|", ">"):
        header = re.match(r"[^\r\n]*", text)
        length = header.end() if header else 0
        return " " * length + text[length:]
    if scalar.style in ("'", '"'):
        return " " + text[1:-1] + " "
    return text


def _first_too_deep(tree: Tree) -> Tree | None:
    waiting: list[tuple[Tree, int]] = [(tree, 1)]
    while waiting:
        here, depth = waiting.pop()
        if depth > MAX_DEPTH:
            return here
        waiting.extend((child, depth + 1) for child in here.children if isinstance(child, lark.Tree))
    return None


# ----------------------------------------------------------------------------------------------------- expressions
_OF_RULES = {"negation": "not", "denial": "!"}


def expression_of(parsed: Parsed, tree: Tree) -> Expression:
    """The expression of a parse tree; grammar rules without a reader of their own give their name as its kind."""
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
    """The expression of a single token: a number or a name."""
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


# ----------------------------------------------------------------------------------------------- what was meant
def _report(
    scalar: Scalar, text: str, start: str, error: lark.exceptions.UnexpectedInput, findings: Findings
) -> None:
    token = error.token if isinstance(error, lark.exceptions.UnexpectedToken) else None
    ended = token is None if not isinstance(error, lark.exceptions.UnexpectedCharacters) else False
    ended = ended or (token is not None and token.type == "$END")
    at = len(text.rstrip()) if ended else max(0, error.pos_in_stream or 0)
    word = "" if ended else str(token) if token is not None else text[at]
    expected: Iterable[str] = getattr(error, "allowed", None) or ()
    if isinstance(error, lark.exceptions.UnexpectedToken):
        expected = error.accepts or error.expected or ("$END",)
    message = f"unexpected {'end' if ended else _quoted(word)}"
    if expected:
        message += f", expected {_spell_expected(expected)}"
    place = scalar.source.place(scalar.start + at, scalar.start + at + max(1, len(word)))
    findings.add(place, message, _remedy(text[:at], word, text[at:], start, "LPAR" in expected))


def _quoted(word: str) -> str:
    return f"'{word}'" if word == '"' else f'"{word}"'


def _spell_expected(expected: Iterable[str]) -> str:
    words = sorted({_WORDS.get(name, f'"{name.lower()}"') for name in expected})
    if len(words) > 5:
        words = [*words[:5], "…"]
    return " or ".join(words)


_NO_IMPLICATION = "=> stands only in effects: write not … or …"
_CLAIM_OPEN = re.compile(r"\bK\s*\(\s*(not\s+)?[a-z_]\w*\s*(\([^()]*\))?\s*$")
_LAST_NAME = re.compile(r"([A-Za-z_]\w*)\s*$")
_LAST_TERM = re.compile(r"([A-Za-z_]\w*\s*(\([^()]*\))?)\s*$")


def _remedy(before: str, word: str, after: str, start: str, callable_: bool) -> str | None:
    """What was probably meant where the formula broke; the first matching case."""
    if word in ("!", "~", "¬"):
        return "write not"
    if word in ("&", "∧", "|", "∨", "\\"):
        return "a formula has no escapes" if word == "\\" else f"write {'and' if word in '&∧' else 'or'}"
    if word == "=" and before.rstrip().endswith("="):
        return 'write a single "="'
    if word == "-" and after[1:2] == ">":
        return "write condition => add(…)" if start == "effect" else _NO_IMPLICATION
    if word in ("=>", "implies") and start == "formula":
        return _NO_IMPLICATION
    if word in ("K", "Kw", "Kv", "Kx", "Kor") and before.rstrip().endswith(("(", ",", "not", "when", "then")):
        return "a claim about the world stands here, without K"
    if word == "" and start == "effect" and (meant := _effect_remedy(before)):
        return meant
    if word in ("and", "or", "xor") and _CLAIM_OPEN.search(before):
        return f"K takes one literal: write K(a) {word} K(b)"
    name = _LAST_NAME.search(before)
    if word == ")" and before.rstrip().endswith("(") and (called := _LAST_NAME.search(before.rstrip()[:-1])):
        return f"without arguments, write {called[1]}"
    if word in ("or", "xor") and re.search(r"\b(or|xor)\b", before):
        return "or and xor do not mix without parentheses, and xor takes two"
    if start == "formula" and word in ("=", "!=", "<", "<=", ">", ">=") and (term := _LAST_TERM.search(before)):
        return f"write K({term[1].strip()} {word} …)"
    return _remedy_of_place(before, name[1] if name and callable_ else None, word, after, start)


def _remedy_of_place(before: str, name: str | None, word: str, after: str, start: str) -> str | None:
    in_quantifier = re.search(r"\b(forall|exists|exactly_one)\s*(\([^)]*\))?\s*$", before)
    if start == "effect" and "forall" in before and (word in ("add", "del") or "=>" in after):
        return "write forall(type x, other y) add(…) or forall(type x) (condition => add(…))"
    if in_quantifier and in_quantifier[2] is None:
        return f"write {in_quantifier[1]}(type x) …"
    if word == "" and before.count("(") > before.count(")"):
        return "a parenthesis is not closed"
    if name is None:
        return None
    if re.fullmatch(r"[A-Za-z_]\w*", word) and word not in ("and", "or", "xor", "then", "when", "not"):
        return None if re.search(r"[A-Za-z_]\w*\s*\($", before) else f"write {name}({word})"
    opened = before.count("(") > before.count(")")
    if start == "formula" and word in ("and", "or", "xor", ")", "", "=>") and not before.rstrip().endswith(")"):
        return f"write K({name})" if not opened or word in ("and", "or", "xor") else None
    return None


def _effect_remedy(text: str) -> str | None:
    """For an effect that is only an atom: the update that was probably meant."""
    return f"write add(Kf, {text.strip()})" if re.fullmatch(r"\s*(not\s+)?[a-z_]\w*(\(.*\))?\s*", text) else None
