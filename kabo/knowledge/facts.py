"""Bits of a knowledge state: which bit says K(p), K(not p), Kw(p), K(f = v), K(f != v), Kv(f), and known numbers.

States are Python integers, so a bit is the mask `1 << k`. A *group* has all bits of one ground atom or term. They
are kept without redundancy: what is known has no Kw or Kv entry, and a known value needs no `f != v`. Hence equal
knowledge is an equal integer.
"""

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass

Key = tuple[str, tuple[str, ...]]  # symbol and the names of its arguments

NUMBER_BITS = 64


@dataclass(frozen=True)
class AtomBits:
    """K(p), K(not p) and the Kw entry of one ground atom."""

    text: str
    true: int
    false: int
    entry: int

    @property
    def mask(self) -> int:
        """All bits of the atom."""
        return self.true | self.false | self.entry

    @property
    def known(self) -> int:
        """The bits that make the atom known."""
        return self.true | self.false


@dataclass(frozen=True)
class TermBits:
    """K(f = v) and K(f != v) for every value, and the Kv entry, of one ground term with a finite range."""

    text: str
    equal: dict[str, int]
    unequal: dict[str, int]
    entry: int
    known: int  # all bits of `equal`
    excluded: int  # all bits of `unequal`

    @property
    def mask(self) -> int:
        """All bits of the term."""
        return self.known | self.excluded | self.entry

    def __hash__(self) -> int:
        return hash(self.text)


@dataclass(frozen=True)
class NumberBits:
    """A known number: a flag, its IEEE 754 pattern above it, and the Kv entry."""

    text: str
    known: int
    shift: int
    entry: int

    @property
    def field(self) -> int:
        """The flag and the pattern."""
        return self.known | ((1 << NUMBER_BITS) - 1) << self.shift

    @property
    def mask(self) -> int:
        """All bits of the term."""
        return self.field | self.entry

    def encode(self, value: float) -> int:
        """The bits of a known value (never NaN; -0.0 is 0.0, so that equal numbers are equal bits)."""
        pattern = struct.unpack("<Q", struct.pack("<d", value + 0.0))[0]
        return self.known | int(pattern) << self.shift

    def decode(self, state: int) -> float | None:
        """The value that is known in the state, or None."""
        if not state & self.known:
            return None
        pattern = state >> self.shift & (1 << NUMBER_BITS) - 1
        return float(struct.unpack("<d", struct.pack("<Q", pattern))[0])


Group = AtomBits | TermBits | NumberBits


class Vocabulary:
    """Hands out bits to ground atoms and terms when they are first mentioned.

    The order of mention is the order of the files, so that equal input gives equal bits.
    """

    def __init__(self) -> None:
        self._groups: dict[Key, Group] = {}
        self._texts: set[str] = set()
        self._next = 0

    def atom(self, name: str, arguments: tuple[str, ...]) -> AtomBits:
        """The bits of a ground atom."""
        group = self._groups.get((name, arguments))
        if group is None:
            group = AtomBits(fact_text(name, arguments), self._bit(), self._bit(), self._bit())
            self._remember(name, arguments, group)
        assert isinstance(group, AtomBits)
        return group

    def term(self, name: str, arguments: tuple[str, ...], values: tuple[str, ...], exclusions: bool) -> TermBits:
        """The bits of a ground term with a finite range; `exclusions` says whether `f != v` can be a fact."""
        group = self._groups.get((name, arguments))
        if group is None:
            equal = {value: self._bit() for value in values}
            unequal = {value: self._bit() for value in values} if exclusions else {}
            text, known, excluded = fact_text(name, arguments), sum(equal.values()), sum(unequal.values())
            group = TermBits(text, equal, unequal, self._bit(), known, excluded)
            self._remember(name, arguments, group)
        assert isinstance(group, TermBits)
        return group

    def number(self, name: str, arguments: tuple[str, ...]) -> NumberBits:
        """The bits of a ground term whose value is a number."""
        group = self._groups.get((name, arguments))
        if group is None:
            known = self._bit()
            shift, self._next = self._next, self._next + NUMBER_BITS
            group = NumberBits(fact_text(name, arguments), known, shift, self._bit())
            self._remember(name, arguments, group)
        assert isinstance(group, NumberBits)
        return group

    @property
    def width(self) -> int:
        """How many bits have been handed out."""
        return self._next

    def __iter__(self) -> Iterator[Group]:
        return iter(self._groups.values())

    def __contains__(self, group: Group) -> bool:
        return group.text in self._texts

    def _remember(self, name: str, arguments: tuple[str, ...], group: Group) -> None:
        self._groups[name, arguments] = group
        self._texts.add(group.text)

    def _bit(self) -> int:
        self._next += 1
        return 1 << (self._next - 1)


def fact_text(name: str, arguments: tuple[str, ...]) -> str:
    """A ground atom or term in the language's spelling: `f(a, b)`, or `f` without arguments."""
    return f"{name}({', '.join(arguments)})" if arguments else name


def finite(value: float) -> float | None:
    """The value, or None for what a float cannot hold (overflow): then it is unknown."""
    return value if math.isfinite(value) else None
