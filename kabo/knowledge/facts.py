"""Bits of a knowledge state: those of K(p), K(not p), Kw(p), K(f = v), K(f != v), Kv(f), and of known numbers.

States are Python integers, so a bit is the mask `1 << k`. A *group* is all bits of one ground atom or term. States
are kept closed: a known atom has Kw, too, and a known value excludes all others. Hence equal knowledge is an equal
integer, more knowledge is more bits, and every primitive query tests one bit.

The bit two positions below `whether` (and, for atoms, also the bit one position below) says that the group is
known, so that all groups whose truth or value is still open are found by two shifts (`open_entries`).
"""

import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

Key = tuple[str, tuple[str, ...]]  # symbol and the names of its arguments

NUMBER_BITS = 64  # of an IEEE 754 double


@dataclass(frozen=True)
class Claim:
    """A literal about one group: `p`, `not p`, `f = v` or `f != v`."""

    holds: int  # the bit that says that it is known
    fails: int  # the bit that says that its complement is known
    makes: int  # all bits that follow from it within the group
    group: "Group"

    def __hash__(self) -> int:
        return hash(self.holds)

    @cached_property
    def denied(self) -> "Claim":
        """The complementary claim."""
        group = self.group
        if isinstance(group, AtomBits):
            return group.claim(self.holds == group.false)
        assert isinstance(group, TermBits)
        value = next(v for v in group.equal if self.holds in (group.equal[v], group.unequal[v]))
        return group.claim(value, self.holds != group.equal[value])


@dataclass(frozen=True)
class AtomBits:
    """The bits of one ground atom: K(p), K(not p) and Kw(p)."""

    text: str
    true: int
    false: int
    whether: int

    @property
    def mask(self) -> int:
        """The mask of all bits of the atom."""
        return self.true | self.false | self.whether

    @property
    def known(self) -> int:
        """The bits that make the atom known."""
        return self.true | self.false

    def claim(self, positive: bool) -> Claim:
        """The claim `p` or `not p`."""
        if positive:
            return Claim(self.true, self.false, self.true | self.whether, self)
        return Claim(self.false, self.true, self.false | self.whether, self)


@dataclass(frozen=True)
class TermBits:
    """The bits of one ground term f with a finite range.

    They are K(f = v) and K(f != v) for every value v, a bit that says that f is known, and Kv(f).
    """

    text: str
    equal: dict[str, int]
    unequal: dict[str, int]  # empty if no `f != v` can be known while f is not
    settled: int
    whether: int
    known: int  # all bits of `equal`
    excluded: int  # all bits of `unequal`

    @property
    def mask(self) -> int:
        """The mask of all bits of the term."""
        return self.known | self.excluded | self.settled | self.whether

    def __hash__(self) -> int:
        return hash(self.text)

    def learned(self, value: str) -> int:
        """All bits that are set when this value is known."""
        others = self.excluded & ~self.unequal.get(value, 0)
        return self.equal[value] | others | self.settled | self.whether

    def claim(self, value: str, positive: bool) -> Claim:
        """The claim `f = value` or `f != value`; the term must have bits for `f != v`."""
        equal, unequal = self.equal[value], self.unequal[value]
        if positive:
            return Claim(equal, unequal, self.learned(value), self)
        return Claim(unequal, equal, unequal, self)


@dataclass(frozen=True)
class NumberBits:
    """The bits of a ground term whose value is a number: a flag, its IEEE 754 pattern, and the bit of Kv."""

    text: str
    known: int
    shift: int
    whether: int

    @property
    def field(self) -> int:
        """The bits of the flag and of the pattern."""
        return self.known | ((1 << NUMBER_BITS) - 1) << self.shift

    @property
    def mask(self) -> int:
        """The mask of all bits of the term."""
        return self.field | self.whether

    def encode(self, value: float) -> int:
        """The bits of a known value, which is not NaN; -0.0 becomes 0.0, so that equal numbers have equal bits."""
        pattern = struct.unpack("<Q", struct.pack("<d", value + 0.0))[0]
        return self.known | self.whether | int(pattern) << self.shift

    def decode(self, state: int) -> float | None:
        """The value that is known in the state; None if it is unknown."""
        if not state & self.known:
            return None
        pattern = state >> self.shift & (1 << NUMBER_BITS) - 1
        return float(struct.unpack("<d", struct.pack("<Q", pattern))[0])


@dataclass(frozen=True)
class ConjunctionBits:
    """The Kw bit of a conjunction whose truth will be known at run time.

    A conjunction that is known to be true has no bit of its own: its literals are known.
    """

    text: str
    whether: int
    parts: tuple[Claim, ...]

    known = 0

    @property
    def mask(self) -> int:
        """The only bit of the conjunction."""
        return self.whether

    @property
    def about(self) -> int:
        """The bits of all groups that occur in the conjunction's literals."""
        result = 0
        for part in self.parts:
            result |= part.group.mask
        return result


Group = AtomBits | TermBits | NumberBits | ConjunctionBits


class BitTable:
    """Allocates bits for ground atoms, terms and entries when they are first mentioned.

    The order of first mention is that of the files, so that equal input gives equal bits.
    """

    def __init__(self) -> None:
        self._groups: dict[Key, Group] = {}
        self._keys: dict[str, Key] = {}
        self._next = 0
        self.whether = 0  # all Kw and Kv bits

    def atom(self, name: str, arguments: tuple[str, ...]) -> AtomBits:
        """The bits of a ground atom."""
        group = self._groups.get((name, arguments))
        if group is None:
            group = AtomBits(fact_text(name, arguments), self.bit(), self.bit(), self._entry())
            self._remember(name, arguments, group)
        assert isinstance(group, AtomBits)
        return group

    def term(self, name: str, arguments: tuple[str, ...], values: tuple[str, ...], exclusions: bool) -> TermBits:
        """The bits of a ground term with a finite range; `exclusions` says whether `f != v` can be known."""
        group = self._groups.get((name, arguments))
        if group is None:
            equal = {value: self.bit() for value in values}
            unequal = {value: self.bit() for value in values} if exclusions else {}
            text, known, excluded = fact_text(name, arguments), sum(equal.values()), sum(unequal.values())
            settled, _gap = self.bit(), self.bit()
            group = TermBits(text, equal, unequal, settled, self._entry(), known, excluded)
            self._remember(name, arguments, group)
        assert isinstance(group, TermBits)
        return group

    def number(self, name: str, arguments: tuple[str, ...]) -> NumberBits:
        """The bits of a ground term whose value is a number."""
        group = self._groups.get((name, arguments))
        if group is None:
            shift, self._next = self._next, self._next + NUMBER_BITS
            known, _gap = self.bit(), self.bit()
            group = NumberBits(fact_text(name, arguments), known, shift, self._entry())
            self._remember(name, arguments, group)
        assert isinstance(group, NumberBits)
        return group

    def conjunction(self, text: str, parts: tuple[Claim, ...]) -> ConjunctionBits:
        """The bit of the Kw entry of a conjunction."""
        group = self._groups.get((text, ()))
        if group is None:
            _gap, _gap = self.bit(), self.bit()
            group = ConjunctionBits(text, self._entry(), parts)
            self._remember(text, (), group)
        assert isinstance(group, ConjunctionBits)
        return group

    @property
    def width(self) -> int:
        """The number of bits allocated so far."""
        return self._next

    def __iter__(self) -> Iterator[Group]:
        return iter(self._groups.values())

    def named(self, prefix: str) -> Iterator[tuple[str, tuple[str, ...], Group]]:
        """The name, arguments and bits of each group whose symbol begins with `prefix`."""
        for (name, arguments), group in self._groups.items():
            if name.startswith(prefix):
                yield name, arguments, group

    def key_of(self, group: Group) -> Key:
        """The symbol and arguments of a group."""
        return self._keys[group.text]

    def __contains__(self, group: Group) -> bool:
        return group.text in self._keys

    def bit(self) -> int:
        """Allocates a new bit and returns its mask."""
        self._next += 1
        return 1 << (self._next - 1)

    def _entry(self) -> int:
        bit = self.bit()
        self.whether |= bit
        return bit

    def _remember(self, name: str, arguments: tuple[str, ...], group: Group) -> None:
        self._groups[name, arguments] = group
        self._keys[group.text] = name, arguments


def open_entries(state: int, whether: int) -> int:
    """The Kw and Kv bits of the state (among `whether`) whose groups are not known yet."""
    return state & whether & ~(state << 1 | state << 2)


def fact_text(name: str, arguments: tuple[str, ...]) -> str:
    """A ground atom or term as the language writes it: `f(a, b)`, or `f` without arguments."""
    return f"{name}({', '.join(arguments)})" if arguments else name


def finite(value: float) -> float | None:
    """The value; None if it is infinite or NaN, so that the number counts as unknown."""
    return value if math.isfinite(value) else None
