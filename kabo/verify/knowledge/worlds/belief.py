"""Beliefs: sets of the worlds that agree with every observation made before a node is reached."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from kabo.verify.knowledge.facts import Facts
from kabo.verify.knowledge.ground import GroundClaim, Symbol, Value, range_of
from kabo.verify.knowledge.terms import Namer, Question, named
from kabo.verify.knowledge.worlds.world import Key, Unknowns, World, every


class _Agreed(dict[Symbol, Value]):
    """The values on which all worlds agree, each computed on demand."""

    def __init__(self, worlds: Iterable[World]) -> None:
        super().__init__()
        self._worlds = [world.known for world in worlds]
        self._differ: set[Symbol] = set()

    def get(self, symbol: Symbol, default: Value | None = None) -> Value | None:  # type: ignore[override]
        """The value on which all worlds agree, or the default."""
        if not super().__contains__(symbol):
            if symbol in self._differ:
                return default
            first = self._worlds[0].get(symbol)
            if first is None or any(known.get(symbol) != first for known in self._worlds):
                self._differ.add(symbol)
                return default
            self[symbol] = first
        return self[symbol]

    def __contains__(self, symbol: object) -> bool:
        return self.get(symbol) is not None  # type: ignore[arg-type]


class _Excluded(dict[Symbol, frozenset[Value]]):
    """For each symbol the values that it has in no world, computed on demand."""

    def __init__(self, belief: "Belief") -> None:
        super().__init__()
        self._belief = belief

    def get(self, symbol: Symbol, default: object = None) -> frozenset[Value]:
        """The values that the symbol has in no world; the empty set for a number."""
        if symbol not in self:
            unknowns, every = (
                self._belief.unknowns,
                frozenset(range_of(self._belief.unknowns.problem, symbol) or ()),
            )
            for world in self._belief.worlds:
                every -= frozenset(unknowns.values(symbol, world) or ())
            self[symbol] = every
        return self[symbol]


@dataclass
class ExplicitBelief:
    """The facts that were literally given, set or observed; kabo's own inference knows at least these [Levesque 1984]."""

    known: Mapping[Symbol, Value]
    excluded: Mapping[Symbol, frozenset[Value]] = field(default_factory=dict)
    whether: frozenset[Symbol] = frozenset()
    about: "Belief | None" = None

    @property
    def agent_knowledge(self) -> Facts:
        """The belief by which conditions on knowledge are evaluated."""
        return self.about or self

    def knows(self, claim: Question, at_start: bool, compared: frozenset[Symbol]) -> bool:
        """Whether the claim follows from the explicit facts; False for a claim about the state at the start."""
        return not at_start and claim(self)

    def will_know(self, name: Symbol | Namer | None, at_start: bool) -> bool:
        """Whether the symbol's value is an explicit fact; False for the state at the start."""
        symbol = named(name, self)
        return not at_start and symbol is not None and symbol in self.known

    def always_held(self, number: int) -> bool:
        """False: explicit facts do not record how `always` goals held in earlier states."""
        return False


@dataclass
class Belief:
    """The possible worlds at a node of the plan, and what must be remembered of earlier nodes.

    Attributes:
        unknowns: the atoms and terms that are unknown at the start.
        worlds: the worlds; at least one.
        whether: the atoms and terms that were sensed and have not been branched on yet.
        whole: the conjunctions that were sensed and have not been branched on yet.
        explicit: the values that were literally given, set or observed.
        broken: the numbers of the `always` goals that have been false in some state on the way.
        settled: a bit for each part of the goal that holds and that the rest of the plan cannot touch.
    """

    unknowns: Unknowns
    worlds: list[World]
    whether: frozenset[Symbol] = frozenset()
    whole: frozenset[tuple[GroundClaim, ...]] = frozenset()
    explicit: Mapping[Symbol, Value] = field(default_factory=dict)
    broken: frozenset[int] = frozenset()
    settled: int = 0

    def __post_init__(self) -> None:
        self.known = _Agreed(self.worlds)
        self.excluded = _Excluded(self)

    @property
    def agent_knowledge(self) -> "Belief":
        """The belief itself: conditions on knowledge are evaluated in it."""
        return self

    @property
    def explicit_belief(self) -> ExplicitBelief:
        """The belief of a reasoner who infers nothing."""
        return ExplicitBelief(self.explicit)

    @property
    def share(self) -> float:
        """The share of all worlds at the start that the worlds of this belief stand for."""
        return sum(world.share for world in self.worlds)

    def knows(self, claim: Question, at_start: bool, compared: frozenset[Symbol]) -> bool:
        """Whether the claim holds in every world, in the present state or in that at the start."""
        if at_start:
            return all(claim(world.first) for world in self.worlds)
        if len(compared) > 1:
            return all(claim(one) for world in self.worlds for one in every(self.unknowns, world, compared))
        return all(map(claim, self.worlds))

    def will_know(self, name: Symbol | Namer | None, at_start: bool) -> bool:
        """Whether the symbol's value, now or at the start, is equal in all worlds or will be known at run time."""
        worlds = self.worlds
        symbol = named(name, worlds[0])
        if symbol is None or (callable(name) and any(name(world) != symbol for world in worlds)):
            return False
        if not at_start:
            return symbol in self.whether or symbol in self.known
        values = {world.first.known.get(symbol) for world in worlds}
        unchanged = all(world.known.get(symbol) == world.first.known.get(symbol) for world in worlds)
        return (len(values) == 1 and None not in values) or (
            symbol in self.whether and unchanged and None not in values
        )

    def always_held(self, number: int) -> bool:
        """Whether the `always` goal of this number has held in every state so far."""
        return number not in self.broken

    def is_free(self, thing: Symbol | str) -> bool:
        """Whether an atom or term is unknown in every world, and unrelated to all other unknowns.

        Every world must exclude the same values of it, and have no entry of Kx or Kor that links it. False for a
        name alone, which stands for all instances of a symbol.
        """
        if isinstance(thing, str):
            return False
        worlds = self.worlds
        free = all(thing not in w.known and self.unknowns.group_of(thing, w) is None for w in worlds)
        return free and len({w.excluded.get(thing) for w in worlds}) == 1


def collected(worlds: Iterable[World]) -> dict[Key, World]:
    """The worlds by their keys; worlds with equal keys are merged into one with the sum of their shares."""
    result: dict[Key, World] = {}
    for world in worlds:
        key = world.key()
        if key in result:
            result[key].share += world.share
        else:
            result[key] = world
    return result


def without(
    belief: Belief, keeps: Callable[[Symbol], bool], groups: frozenset[int], symbols: frozenset[Symbol] | None
) -> tuple[Belief, dict[Key, World], Key]:
    """The belief reduced to what later nodes read, its worlds by their keys, and a key of the reduced belief.

    Two beliefs with the same key behave alike from here on.

    Args:
        belief: the belief.
        keeps: the function that says whether a later node reads an atom or term.
        groups: the numbers of the groups of unknowns with a member that a later node reads.
        symbols: all atoms and terms that later nodes read; None if they cannot be listed.
    """
    worlds = collected(world.kept(keeps, symbols, groups) for world in belief.worlds)
    whether = frozenset(filter(keeps, belief.whether))
    whole = frozenset(whole for whole in belief.whole if any(keeps(claim[0]) for claim in whole))
    explicit = {symbol: value for symbol, value in belief.explicit.items() if keeps(symbol)}
    less = Belief(belief.unknowns, list(worlds.values()), whether, whole, explicit, belief.broken, belief.settled)
    return (
        less,
        worlds,
        (frozenset(worlds), whether, whole, frozenset(explicit.items()), belief.broken, belief.settled),
    )
