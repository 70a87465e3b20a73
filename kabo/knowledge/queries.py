"""Queries on knowledge states: formulas in negation normal form over bits [K 3.3.1; PKS primitive queries].

A knowledge state is one Python integer; a query is a small tree whose leaves are masks. Every query answers three
questions: whether it holds, which bits are the reason (this explanation generalises solved states), and whether it could
ever hold in the delete relaxation. "Not" exists only while compiling: `negation` pushes it into the leaves.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

from kabo.language.formulas import GroundCall

# Answers a geometric test inside a formula; it should say True where the answer is unknown.
GeometricOracle = Callable[[GroundCall], bool]


def optimistic(_call: GroundCall) -> bool:
    """The oracle of purely symbolic planning: every geometric test may succeed."""
    return True


class Query(ABC):
    """A compiled formula; `has_tests` says whether it has a geometric test."""

    has_tests: bool = False

    @property
    @abstractmethod
    def reads(self) -> int:
        """All bits on which the query's value may depend."""

    @abstractmethod
    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the query holds in the state; parts are evaluated in order, and only until the answer is clear."""

    @abstractmethod
    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """Bits that decide the answer: it is the same in any state with the same values of these bits."""

    @abstractmethod
    def possible(self, ones: int, zeros: int) -> bool:
        """Whether the query can hold if the bits `ones` can be 1 and `zeros` can be 0; only False is certain."""


@dataclass(frozen=True)
class AllOf(Query):
    """The query whether the bits of `mask` are exactly `value`."""

    mask: int
    value: int

    @property
    def reads(self) -> int:
        """The mask of all bits that the query tests."""
        return self.mask

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the tested bits of the state have the required values."""
        return state & self.mask == self.value

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """All tested bits if the query holds, else the lowest one whose value differs."""
        wrong = (state & self.mask) ^ self.value
        return wrong & -wrong if wrong else self.mask

    def possible(self, ones: int, zeros: int) -> bool:
        """Whether every tested bit can have its required value."""
        return not (self.value & ~ones or self.mask & ~self.value & ~zeros)


@dataclass(frozen=True)
class AnyOf(Query):
    """The query whether some bit of `mask` is 1."""

    mask: int

    @property
    def reads(self) -> int:
        """The mask of all bits that the query tests."""
        return self.mask

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether some tested bit is 1 in the state."""
        return state & self.mask != 0

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The lowest tested bit that is 1; all tested bits if none is 1."""
        held = state & self.mask
        return held & -held if held else self.mask

    def possible(self, ones: int, zeros: int) -> bool:
        """Whether some tested bit can be 1."""
        return self.mask & ones != 0


TRUE: Final = AllOf(0, 0)
FALSE: Final = AnyOf(0)


class Signed(Query):
    """A leaf of a query that is negated as a whole: `positive` False means "not known to hold"."""

    positive: bool


@dataclass(frozen=True)
class GeometricTest(Signed):
    """A geometric test, which depends on no bit, only on the geometric state that the oracle knows."""

    call: GroundCall
    positive: bool = True

    has_tests = True

    @property
    def reads(self) -> int:
        """The empty mask: the test depends on no bit."""
        return 0

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether the oracle's answer equals `positive`."""
        return test(self.call) == self.positive

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The empty mask: the answer depends on the geometric state alone."""
        return 0

    def possible(self, ones: int, zeros: int) -> bool:
        """True: in the relaxation a test may have any answer."""
        return True


class _Junction(Query):
    """A query made of parts: what conjunction and disjunction share."""

    parts: tuple[Query, ...]

    def __init__(self, parts: tuple[Query, ...]) -> None:
        self.parts = parts
        self._reads = union(part.reads for part in parts)
        self.has_tests = any(part.has_tests for part in parts)

    @property
    def reads(self) -> int:
        """The bits of all parts."""
        return self._reads

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self.parts == other.parts

    def __hash__(self) -> int:
        return hash((type(self), self.parts))

    def __repr__(self) -> str:
        return f"{type(self).__name__}{self.parts!r}"


class All(_Junction):
    """A conjunction, evaluated in order until a part fails."""

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether all parts hold."""
        return all(part.holds(state, test) for part in self.parts)

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The bits because of which all parts hold, or because of which the first failing part fails."""
        for part in self.parts:
            if not part.holds(state, test):
                return part.support(state, test)
        return union(part.support(state, test) for part in self.parts)

    def possible(self, ones: int, zeros: int) -> bool:
        """Whether every part is possible on its own."""
        return all(part.possible(ones, zeros) for part in self.parts)


class Some(_Junction):
    """A disjunction, evaluated in order until a part holds."""

    def holds(self, state: int, test: GeometricOracle = optimistic) -> bool:
        """Whether some part holds."""
        return any(part.holds(state, test) for part in self.parts)

    def support(self, state: int, test: GeometricOracle = optimistic) -> int:
        """The bits because of which the first holding part holds, or because of which all parts fail."""
        for part in self.parts:
            if part.holds(state, test):
                return part.support(state, test)
        return union(part.support(state, test) for part in self.parts)

    def possible(self, ones: int, zeros: int) -> bool:
        """Whether some part is possible."""
        return any(part.possible(ones, zeros) for part in self.parts)


def union(masks: Iterable[int]) -> int:
    """The bitwise or of all masks."""
    result = 0
    for mask in masks:
        result |= mask
    return result


def truth(value: bool) -> Query:
    """The query TRUE or FALSE."""
    return TRUE if value else FALSE


def conjunction(parts: Iterable[Query]) -> Query:
    """The conjunction of the parts: comparisons of bits become one first test, geometric tests keep order."""
    mask = value = 0
    rest: list[Query] = []
    for part in _flat(parts, All):
        if isinstance(part, AllOf):
            if (part.value ^ value) & part.mask & mask:
                return FALSE
            mask, value = mask | part.mask, value | part.value
        elif part == FALSE:
            return FALSE
        elif part not in rest:
            rest.append(part)
    rest.sort(key=lambda part: part.has_tests)
    if mask:
        rest.insert(0, AllOf(mask, value))
    return _only(rest, All, TRUE)


def disjunction(parts: Iterable[Query]) -> Query:
    """The disjunction of the parts: single bits become one test that comes first."""
    mask = 0
    rest: list[Query] = []
    for part in _flat(parts, Some):
        if part == TRUE:
            return TRUE
        if isinstance(part, AnyOf) or _is_one_bit(part):
            mask |= part.reads
        elif part not in rest:
            rest.append(part)
    rest.sort(key=lambda part: part.has_tests)
    if mask:
        rest.insert(0, known_one(mask))
    return _only(rest, Some, FALSE)


def known_one(mask: int) -> Query:
    """The query whether some bit of the mask is 1; if the mask is a single bit, an `AllOf`."""
    return AllOf(mask, mask) if mask and mask & (mask - 1) == 0 else AnyOf(mask)


def negation(query: Query) -> Query:
    """The negated query, in negation normal form."""
    match query:
        case AllOf(mask, value):
            return disjunction(AllOf(bit, bit & ~value) for bit in bits_of(mask))
        case AnyOf(mask):
            return AllOf(mask, 0)
        case Signed():
            return replace(query, positive=not query.positive)  # type: ignore[type-var]
        case All():
            return disjunction(negation(part) for part in query.parts)
        case Some():
            return conjunction(negation(part) for part in query.parts)
    raise TypeError(f"not a compiled query: {query!r}")


def bits_of(mask: int) -> Iterator[int]:
    """The single bits of a mask, lowest first."""
    while mask:
        bit = mask & -mask
        yield bit
        mask ^= bit


def _is_one_bit(query: Query) -> bool:
    """Whether the query is that a single bit is 1."""
    return isinstance(query, AllOf) and query.mask == query.value and query.mask & (query.mask - 1) == 0


def _flat(parts: Iterable[Query], kind: type[_Junction]) -> Iterator[Query]:
    for part in parts:
        if isinstance(part, kind):
            yield from part.parts
        else:
            yield part


def _only(parts: list[Query], kind: type[_Junction], empty: Query) -> Query:
    if not parts:
        return empty
    return parts[0] if len(parts) == 1 else kind(tuple(parts))


def tested_for_zero(query: Query) -> int:
    """The bits that the query may require to be 0, so that knowing more may make it false."""
    match query:
        case AllOf(mask, value):
            return mask & ~value
        case Signed(positive=False):
            return query.reads
        case All() | Some():
            return union(tested_for_zero(part) for part in query.parts)
    return 0


def split(query: Query) -> tuple[int, int, Query | None]:
    """The mask and value of a conjunction's first test of bits, and the rest as a query or None.

    The mask is 0 if the first part does not test bits.
    """
    parts = query.parts if isinstance(query, All) else (query,)
    if not isinstance(parts[0], AllOf):
        return 0, 0, query
    rest = parts[1:]
    return parts[0].mask, parts[0].value, conjunction(rest) if rest else None
