"""Worlds: the true values of atoms and terms. A value that nothing has read yet is open: it can be any value."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import Excluded, Facts
from kabo.verify.knowledge.ground import Symbol, Value, claim_text, range_of, text_of

MAX_VALUES = 3_000_000  # values of atoms and terms over all worlds that are made, which bounds memory and time

Key = tuple[object, ...]


class CannotJudgeError(Exception):
    """The plan cannot be judged in possible worlds; the text says why not."""


class OpenError(Exception):
    """An open value is read; the world must first be split into one world for each possible value."""

    def __init__(self, symbol: Symbol) -> None:
        super().__init__(symbol)
        self.symbol = symbol


@dataclass(frozen=True)
class Group:
    """Unknown atoms and terms that entries of Kx and Kor link, and every combination of values that they allow."""

    symbols: tuple[Symbol, ...]
    choices: tuple[tuple[Value, ...], ...]


@dataclass(frozen=True)
class _StartValues:
    """The values at the start, as a state in which queries about the start are evaluated."""

    known: Mapping[Symbol, Value]
    excluded: Excluded = field(default_factory=dict)
    whether: frozenset[Symbol] = frozenset()

    @property
    def agent_knowledge(self) -> Facts:
        """This state, by which conditions on knowledge are evaluated."""
        return self


@dataclass
class World:
    """A world: the true values of atoms and terms, with the interface of a state in which they are known.

    Attributes:
        known: the values.
        excluded: the values that an open atom or term cannot have.
        groups: the numbers of those groups of linked unknowns of which no combination is chosen yet.
        first: the values at the start of what `initially` mentions.
        share: the share of all worlds at the start that this one stands for.
        origin: the unknowns of the start that were read, with their values, for messages.
        chosen: the atoms and terms that actions left open, with the values that they took.
        agent_knowledge: the knowledge of the agent, by which conditions on knowledge are evaluated.
    """

    known: dict[Symbol, Value]
    excluded: dict[Symbol, frozenset[Value]] = field(default_factory=dict)
    groups: frozenset[int] = frozenset()
    first: Facts = field(default_factory=lambda: _StartValues({}))
    share: float = 1.0
    origin: tuple[tuple[Symbol, Value], ...] = ()
    chosen: tuple[tuple[Symbol, Value], ...] = ()
    agent_knowledge: Facts = field(default_factory=lambda: _StartValues({}))
    whether: frozenset[Symbol] = frozenset()

    def key(self) -> Key:
        """A value that is equal for worlds that behave alike from here on."""
        known = frozenset(self.known.items())
        return known, frozenset(self.excluded.items()), self.groups, frozenset(self.first.known.items())

    def copy(self) -> "World":
        """A copy of the world that can be changed independently."""
        return replace(self, known=dict(self.known), excluded=dict(self.excluded))

    def remember(self, symbols: frozenset[Symbol]) -> None:
        """Records the present values of the given symbols as their values at the start."""
        self.first = _StartValues({symbol: self.known[symbol] for symbol in symbols if symbol in self.known})

    def value(self, symbol: Symbol) -> Value:
        """The value of the symbol.

        Raises:
            OpenError: the value is open.
        """
        if symbol not in self.known:
            raise OpenError(symbol)
        return self.known[symbol]

    def put(self, symbol: Symbol, value: Value) -> None:
        """Sets the value of the symbol."""
        self.known[symbol] = value
        self.excluded.pop(symbol, None)

    def leave_open(self, symbol: Symbol, without: frozenset[Value] = frozenset()) -> None:
        """Makes the value of the symbol open: any value except those in `without` is possible."""
        self.known.pop(symbol, None)
        self.excluded[symbol] = without

    def kept(
        self, keeps: Callable[[Symbol], bool], symbols: frozenset[Symbol] | None, groups: frozenset[int]
    ) -> "World":
        """The world reduced to what later nodes read; `symbols` lists it, or is None if it cannot be listed."""
        if symbols is not None and len(symbols) < len(self.known):
            known = {symbol: self.known[symbol] for symbol in symbols if symbol in self.known}
        else:
            known = {symbol: value for symbol, value in self.known.items() if keeps(symbol)}
        excluded = {symbol: values for symbol, values in self.excluded.items() if keeps(symbol)}
        return replace(self, known=known, excluded=excluded, groups=self.groups & groups)


@dataclass
class Unknowns:
    """The unknowns of the start, the number of values of each that was read, and the remaining limit of values."""

    problem: Problem
    groups: tuple[Group, ...] = ()
    looked_at: dict[object, int] = field(default_factory=dict)
    values_left: int = MAX_VALUES

    def __post_init__(self) -> None:
        self._group_of = {symbol: number for number, group in enumerate(self.groups) for symbol in group.symbols}

    @property
    def count(self) -> int:
        """The number of worlds at the start that differ in an unknown that was read."""
        result = 1
        for number in self.looked_at.values():
            result *= number
        return result

    def spend(self, world: World, ways: int = 1) -> None:
        """Subtracts the values of `ways` copies of a world from the remaining limit of values.

        Raises:
            CannotJudgeError: there are too many worlds.
        """
        self.values_left -= ways * (1 + len(world.known))
        if self.values_left < 0:
            raise CannotJudgeError("too many worlds arise along it")

    def group_of(self, symbol: Symbol, world: World) -> int | None:
        """The number of the symbol's group of unknowns; None without a group with open values in this world."""
        number = self._group_of.get(symbol)
        return number if number in world.groups else None

    def values(self, symbol: Symbol, world: World) -> tuple[Value, ...] | None:
        """The values that a symbol can have in a world; None for an unknown number."""
        if symbol in world.known:
            return (world.known[symbol],)
        values = range_of(self.problem, symbol)
        without = world.excluded.get(symbol, frozenset())
        return None if values is None else tuple(value for value in values if value not in without)

    def split(self, world: World, symbol: Symbol) -> Iterator[World]:
        """One world for each value that the open symbol can have.

        Raises:
            CannotJudgeError: the symbol is an unknown number.
        """
        number = self.group_of(symbol, world)
        if number is not None:
            group = self.groups[number]
            self.looked_at[number] = len(group.choices)
            self.spend(world, len(group.choices))
            for choice in group.choices:
                yield self._with(world, dict(zip(group.symbols, choice, strict=True)), len(group.choices), number)
            return
        values = self.values(symbol, world)
        if values is None:
            raise CannotJudgeError(f"{text_of(symbol)} is a number that is not known, and an effect depends on it")
        self.spend(world, len(values))
        if symbol not in world.excluded:
            self.looked_at[symbol] = len(values)
            for value in values:
                yield self._with(world, {symbol: value}, len(values), None)
            return
        for value in values:
            other = world.copy()
            other.put(symbol, value)
            other.share /= len(values)
            other.chosen = (*world.chosen, (symbol, value))
            yield other

    def _with(self, world: World, values: Mapping[Symbol, Value], ways: int, number: int | None) -> World:
        other = world.copy()
        for symbol, value in values.items():
            other.put(symbol, value)
        other.groups = world.groups - {number}
        other.share /= ways
        other.origin = (*world.origin, *values.items())
        return other

    def detach(self, world: World, symbol: Symbol) -> None:
        """Takes a symbol that is about to change out of its group.

        Raises:
            OpenError: the group has other members, whose values depend on its present value.
        """
        number = self.group_of(symbol, world)
        if number is None:
            return
        if len(self.groups[number].symbols) > 1:
            raise OpenError(symbol)
        world.groups -= {number}


def every(unknowns: Unknowns, world: World, symbols: frozenset[Symbol]) -> Iterator[World]:
    """One world for each combination of values of the given symbols; unknown numbers stay open."""
    waiting = [world]
    while waiting:
        one = waiting.pop()
        symbol = next(
            (s for s in sorted(symbols, key=repr) if unknowns.values(s, one) is not None and s not in one.known),
            None,
        )
        if symbol is None:
            yield one
        else:
            waiting.extend(reversed(list(unknowns.split(one, symbol))))


def holds(claim: tuple[Symbol, Value, bool], world: World) -> bool:
    """Whether a claim is true in a world.

    Raises:
        OpenError: the value of the claim's symbol is open.
    """
    symbol, value, positive = claim
    if symbol not in world.known and value in world.excluded.get(symbol, ()):
        return not positive
    return (world.value(symbol) == value) is positive


def in_words(world: World, most: int = 12) -> str:
    """A world as text: at most `most` values unknown at the start, and as many that actions left open."""
    parts = []
    for title, pairs in (("world", world.origin), ("left open by actions", world.chosen)):
        texts = [
            claim_text((symbol, value, True)) for symbol, value in sorted(pairs, key=lambda pair: pair[1] is False)
        ]
        shown = ", ".join(texts[:most]) + (f", and {len(texts) - most} more" if len(texts) > most else "")
        if texts or title == "world":
            parts.append(f" [{title}: {shown or 'the only one'}]")
    return "".join(parts)
