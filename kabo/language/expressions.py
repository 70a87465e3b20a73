"""Formulas as they are written: trees of words with their places in the file, in which no name is resolved yet.

All syntaxes (YAML, PDDL, PKS) share the trees of terms, atoms and comparisons; connectives differ between them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
ARITHMETIC = frozenset("+-*/")


class Span(Protocol):
    """A piece of a file, given by the offset of its first character and the offset behind its last character."""

    @property
    def start(self) -> int:
        """The offset of the first character."""

    @property
    def end(self) -> int:
        """The offset behind the last character."""


@dataclass(eq=False, slots=True)
class Expression:
    """A node of the syntax tree of a formula.

    Attributes:
        kind: `name`, `variable`, `number`, `call` (of a predicate, function or procedure), an operator, `!` for a
            negation; or a word that has a meaning in one syntax only.
        text: the text of the name, number or operator.
        start: the offset of the node's first character in the file.
        end: the offset behind the node's last character.
        parts: the arguments of a call, or the operands of an operator.
        variables: the variables that a quantifier binds, with their types.
        name_at: the offset of the name in the node; None if the name is at `start`.
    """

    kind: str
    text: str
    start: int
    end: int
    parts: Sequence["Expression"] = ()
    variables: Sequence[tuple["Expression", "Expression | None"]] = ()
    name_at: int | None = None

    @property
    def name(self) -> "Expression":
        """The name in this node as a node of its own, without arguments."""
        start = self.start if self.name_at is None else self.name_at
        return Expression("name", self.text, start, start + len(self.text))
