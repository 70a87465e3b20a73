"""Formulas as they are written: trees of words with their places in the file, in which no name is resolved yet.

Every syntax makes the same trees of terms, atoms and comparisons; what stands around them is its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

COMPARISONS = ("=", "!=", "<", "<=", ">", ">=")
ARITHMETIC = frozenset("+-*/")


class Span(Protocol):
    """A piece of a file: the offsets of its first character, and of the one behind its last."""

    @property
    def start(self) -> int:
        """The offset of the first character."""

    @property
    def end(self) -> int:
        """The offset behind the last character."""


@dataclass(eq=False, slots=True)
class Expression:
    """A piece of a formula.

    Attributes:
        kind: `name`, `variable`, `number`, `call` (of a predicate, function or procedure), an operator (of one part, or
            of more), `!` for a negation; or another word by which a syntax knows its own.
        text: the name or number; the operator.
        start: the offset of its first character in the file.
        end: the offset behind its last one.
        parts: the arguments of a call, the operands of an operator.
        variables: those that a quantifier binds, with their types.
        name_at: the offset of the name if that differs from the offset of the piece.
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
        """The name alone, without arguments."""
        start = self.start if self.name_at is None else self.name_at
        return Expression("name", self.text, start, start + len(self.text))
