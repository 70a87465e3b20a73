"""The worlds that the initial knowledge allows: every one of them, or a stated number drawn at random.

A world gives a value to every atom and term that matters. It must agree with Kf, with every entry of Kx and Kor, and
with the update rules: what they conclude when all of the world is known must be true in it.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod

from kabo.language.problem import Problem
from kabo.verify.draft import ContradictionError, Draft
from kabo.verify.ground import Entry, NotVerifiableError, Symbol, Value, claim_text, range_of
from kabo.verify.knowledge import Knowledge, truth
from kabo.verify.transition import settle
from kabo.verify.true_world import World
from kabo.verify.update_rules import UpdateRules
from kabo.verify.updates import fired

ATTEMPTS = 20  # draws that are given up before a world is searched for step by step
STEPS = 20_000  # decisions of the exhaustive search, before worlds are sampled instead

_MASK = (1 << 64) - 1


class Stream:
    """Random numbers from a counter (SplitMix64): equal seeds give equal numbers everywhere."""

    def __init__(self, seed: int, index: int) -> None:
        self._state = (seed * 0x9E3779B97F4A7C15 + index * 0xD1B54A32D192ED03) & _MASK

    def below(self, bound: int) -> int:
        """A whole number from 0 to `bound` - 1."""
        self._state = (self._state + 0x9E3779B97F4A7C15) & _MASK
        mixed = self._state
        mixed = ((mixed ^ (mixed >> 30)) * 0xBF58476D1CE4E5B9) & _MASK
        mixed = ((mixed ^ (mixed >> 27)) * 0x94D049BB133111EB) & _MASK
        return (mixed ^ (mixed >> 31)) % bound

    def shuffled(self, things: Iterable[Symbol]) -> list[Symbol]:
        """The things in another order."""
        result = list(things)
        for last in range(len(result) - 1, 0, -1):
            other = self.below(last + 1)
            result[last], result[other] = result[other], result[last]
        return result


@dataclass(frozen=True)
class PossibleWorlds:
    """Worlds, each as the values of what was unknown; `exhaustive` if these are all."""

    unknown: tuple[Symbol, ...]
    worlds: tuple[Mapping[Symbol, Value], ...]
    exhaustive: bool


class Constraints:
    """What a world must agree with: the initial knowledge, and the rules that speak of what matters."""

    def __init__(self, problem: Problem, state: Knowledge, rules: UpdateRules, matters: Iterable[Symbol]) -> None:
        self.problem, self.state, self.rules = problem, state, rules
        wanted = self._tied(set(matters))
        self.unknown = tuple(sorted((s for s in wanted if s not in state.known and self._values(s)), key=repr))
        inside = set(self.unknown)
        self.exclusive = [e for e in state.exclusive if all(claim[0] in inside for claim in e)]
        self.some = [e for e in state.some if all(claim[0] in inside for claim in e)]
        self.numbers = [n for n, group in enumerate(rules.mentioned) if group & inside or _names(group)]
        related = {claim[0] for entry in (*self.exclusive, *self.some) for claim in entry}
        related.update(s for number in self.numbers for s in rules.mentioned[number] if not isinstance(s, str))
        named = {thing for number in self.numbers for thing in rules.mentioned[number] if isinstance(thing, str)}
        self.core = tuple(symbol for symbol in self.unknown if symbol in related or symbol[0] in named)
        self.free = tuple(symbol for symbol in self.unknown if symbol not in set(self.core))

    def _tied(self, wanted: set[Symbol]) -> set[Symbol]:
        """With everything that entries and rules relate to it."""
        groups = [{claim[0] for claim in entry} for entry in (*self.state.exclusive, *self.state.some)]
        groups += [{s for s in group if not isinstance(s, str)} for group in self.rules.mentioned]
        while True:
            more = wanted.union(*(group for group in groups if group & wanted))
            if len(more) == len(wanted):
                return wanted
            wanted = more

    def _values(self, symbol: Symbol) -> list[Value]:
        without = self.state.excluded.get(symbol, ())
        return [value for value in range_of(self.problem, symbol) or () if value not in without]

    def agree(self, values: Mapping[Symbol, Value]) -> bool:
        """Whether a world is possible."""
        world = World({**self.state.known, **values})
        if any(sum(world.holds(claim) for claim in entry) != 1 for entry in self.exclusive):
            return False
        if not all(any(world.holds(claim) for claim in entry) for entry in self.some):
            return False
        return self._obeys_rules(world)

    def _obeys_rules(self, world: World) -> bool:
        try:
            updates = fired([self.rules.rules[number] for number in self.numbers], world.as_known())
        except NotVerifiableError:
            return True
        if any(not _true(entry, database, world) for database, entry in updates.entries):
            return False
        return not any(
            add.value is not None and truth((add.symbol, add.value, add.positive), world) is False
            for add in updates.adds
        )

    # -------------------------------------------------------------------------------------------- enumeration
    def enumerate(self, limit: int) -> list[dict[Symbol, Value]] | None:
        """All possible worlds; None if there are more than `limit`, or the search for them takes too long."""
        ways = prod(len(self._values(symbol)) for symbol in self.free)
        if ways > limit:
            return None
        core = self._all_of_core(limit // ways)
        if core is None:
            return None
        choices = [self._values(symbol) for symbol in self.free]
        return [
            {**values, **dict(zip(self.free, chosen, strict=True))}
            for values in core
            for chosen in product(*choices)
        ]

    def _all_of_core(self, limit: int) -> list[dict[Symbol, Value]] | None:
        found: list[dict[Symbol, Value]] = []
        stack = [self.state]
        for _ in range(STEPS):
            if not stack:
                return found
            state = stack.pop()
            symbol = next((symbol for symbol in self.core if symbol not in state.known), None)
            if symbol is not None:
                stack.extend(reversed(list(self._decisions(state, symbol))))
                continue
            values = {symbol: state.known[symbol] for symbol in self.core}
            if self.agree(values):
                found.append(values)
            if len(found) > limit:
                return None
        return None

    def _decisions(self, state: Knowledge, symbol: Symbol) -> Iterator[Knowledge]:
        """The state with each value that the symbol can have, and what follows."""
        for value in self._values(symbol):
            draft = Draft(self.problem, state)
            try:
                draft.learn((symbol, value, True))
                settle(draft, self.rules)
            except ContradictionError:
                continue
            yield draft.finished()

    # ------------------------------------------------------------------------------------------------ sampling
    def sample(self, stream: Stream) -> dict[Symbol, Value] | None:
        """A random possible world; None if none was found."""
        core = self._core_at_random(stream)
        if core is None:
            return None
        for symbol in self.free:
            values = self._values(symbol)
            core[symbol] = values[stream.below(len(values))]
        return core

    def _core_at_random(self, stream: Stream) -> dict[Symbol, Value] | None:
        for _ in range(ATTEMPTS):
            draft = Draft(self.problem, self.state)
            try:
                for symbol in stream.shuffled(self.core):
                    if symbol not in draft.known:
                        without = draft.excluded.get(symbol, ())
                        values = [value for value in self._values(symbol) if value not in without]
                        draft.learn((symbol, values[stream.below(len(values))], True))
                        settle(draft, self.rules)
            except ContradictionError:
                continue
            chosen = {symbol: draft.known[symbol] for symbol in self.core}
            if self.agree(chosen):
                return chosen
        return self._search(stream)

    def _search(self, stream: Stream) -> dict[Symbol, Value] | None:
        """Backtracking, with a copy of the state at every decision."""
        stack = [self.state]
        order = stream.shuffled(self.core)
        for _ in range(STEPS // 10):
            if not stack:
                return None
            state = stack.pop()
            symbol = next((symbol for symbol in order if symbol not in state.known), None)
            if symbol is not None:
                children = list(self._decisions(state, symbol))
                stack.extend(children[::-1] if stream.below(2) else children)
                continue
            values = {symbol: state.known[symbol] for symbol in self.core}
            if self.agree(values):
                return values
        return None


def possible_worlds(constraints: Constraints, limit: int, samples: int, seed: int) -> PossibleWorlds:
    """All worlds if there are at most `limit`, else about `samples` different ones, drawn at random."""
    everything = constraints.enumerate(limit)
    if everything is not None:
        return PossibleWorlds(constraints.unknown, tuple(everything), True)
    found: dict[tuple[Value, ...], dict[Symbol, Value]] = {}
    for index in range(2 * samples):
        values = constraints.sample(Stream(seed, index))
        if values is not None:
            found.setdefault(tuple(values[symbol] for symbol in constraints.unknown), values)
        if len(found) == samples:
            break
    return PossibleWorlds(constraints.unknown, tuple(found.values()), False)


def _names(group: Iterable[Symbol | str]) -> bool:
    return any(isinstance(thing, str) for thing in group)


def _true(entry: Entry, database: str, world: World) -> bool:
    holding = sum(truth(claim, world) is not False for claim in entry)
    return (
        holding >= 1 if database == "Kor" else sum(truth(claim, world) is True for claim in entry) <= 1 <= holding
    )


def in_words(values: Iterator[tuple[Symbol, Value]] | Sequence[tuple[Symbol, Value]], most: int = 12) -> str:
    """A world as literals: `not p(a), q, f = v`; of many only the first."""
    texts = [claim_text((symbol, value, True)) for symbol, value in values]
    shown = ", ".join(texts[:most])
    return shown + (f", and {len(texts) - most} more" if len(texts) > most else "")
