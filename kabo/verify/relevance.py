"""Which facts the rest of a plan can ask for: all else may be forgotten, so that 2^n branches stay a few states.

A node's continuation never sees more of the knowledge than the atoms and terms that its formulas and effects
mention, what update rules relate them to, and entries of the state that a chain of shared members ties to them.
States that agree on these behave alike from there on, and are replayed once.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from itertools import compress
from typing import Any

from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Constant,
    ExactlyOne,
    Exists,
    FactForall,
    Forall,
    ForEach,
    Literal,
    Number,
    TermFact,
    Variable,
)
from kabo.language.problem import Problem
from kabo.plan import Node, Plan, ValueOf
from kabo.verify.ground import Binding, Entry, GroundClaim, Symbol, Value, instances, read_symbol
from kabo.verify.knowledge import Knowledge, symbols_of

Mentions = Callable[[Node], Iterable["Symbol | str"]]


class Relevance:
    """For every node, what it and its continuation mention: a bit for each atom or term, and for each whole name.

    Bits, since a set for each of 25,000 nodes would not fit into memory.
    """

    def __init__(
        self, plan: Plan, order: Sequence[str], mentioned_by: Mentions, ties: Iterable[frozenset[Symbol | str]]
    ) -> None:
        """Collects what matters.

        Args:
            plan: the plan.
            order: the reached nodes, each before its successors.
            mentioned_by: gives what a node mentions itself.
            ties: groups of atoms and terms of which each can tell about the others (update rules).
        """
        self._bits: dict[Symbol | str, int] = {}
        self._masks: dict[str, int] = {}
        for name in reversed(order):
            node = plan.nodes[name]
            mask = self._mask(mentioned_by(node))
            for successor in node.successors:
                mask |= self._masks.get(successor, 0)
            self._masks[name] = mask
        groups = [self._mask(group) for group in ties]
        self._names = [(thing, bit) for thing, bit in self._bits.items() if isinstance(thing, str)]
        self._of_name = {
            name: self._mask([t for t in self._bits if not isinstance(t, str) and t[0] == name])
            for name, _ in self._names
        }
        self._groups = _merged([self._widened(group) for group in groups])
        for name, mask in self._masks.items():
            self._masks[name] = self.tied(self._widened(mask))

    def _mask(self, group: Iterable[Symbol | str]) -> int:
        mask = 0
        for thing in group:
            mask |= self._bits.setdefault(thing, 1 << len(self._bits))
        return mask

    def _widened(self, mask: int) -> int:
        """With all atoms and terms of the names in it, so that groups that share one meet."""
        for name, bit in self._names:
            if bit & mask:
                mask |= self._of_name[name]
        return mask

    @property
    def has_rules(self) -> bool:
        """Whether update rules relate anything."""
        return bool(self._groups)

    def tied(self, mask: int) -> int:
        """With everything that update rules relate to what is in it."""
        for group in self._groups:
            if group & mask:
                mask |= group
        return mask

    @property
    def everything(self) -> Iterable[Symbol | str]:
        """All that the plan and the update rules mention, in the order of first mention from the leaves."""
        return self._bits.keys()

    def kept(self, name: str) -> "Kept":
        """What matters at a node and behind it."""
        return self.kept_by(self._masks[name])

    def kept_by(self, mask: int) -> "Kept":
        """The atoms and terms of a mask."""
        names = frozenset(str(thing) for thing, bit in self._names if bit & mask)
        return Kept(self, mask, frozenset(compress(self._bits, map(int, f"{mask:b}"[::-1]))), names)

    def bits_of(self, symbols: Iterable[Symbol]) -> int:
        """The mask of atoms and terms; those that nobody mentions have no bit."""
        mask = 0
        for symbol in symbols:
            mask |= self._bits.get(symbol, 0)
        return mask


@dataclass(frozen=True)
class Kept:
    """Whether an atom or term matters at a place in the plan; can be called as a function."""

    relevance: Relevance
    mask: int
    symbols: frozenset["Symbol | str"]
    names: frozenset[str]

    def __call__(self, symbol: Symbol) -> bool:  # noqa: D102 (the class says it)
        return symbol in self.symbols or symbol[0] in self.names

    def tied_to(self, symbols: Iterable[Symbol]) -> "Kept":
        """With what update rules relate these to."""
        wide = self.relevance.tied(self.mask | self.relevance.bits_of(symbols))
        return self if wide == self.mask else self.relevance.kept_by(wide)

    def only(self, known: Mapping[Symbol, Value]) -> dict[Symbol, Value]:
        """What matters of the known values."""
        if self.names:
            return {symbol: value for symbol, value in known.items() if self(symbol)}
        symbols = self.symbols
        return {symbol: value for symbol, value in known.items() if symbol in symbols}


def _merged(groups: Iterable[int]) -> list[int]:
    """Groups that share something become one."""
    merged: list[int] = []
    for group in groups:
        apart = [other for other in merged if not other & group]
        for other in merged:
            if other & group:
                group |= other
        merged = [*apart, group]
    return merged


def forget(state: Knowledge, kept: Kept) -> Knowledge:
    """The state without what nobody asks for any more."""
    entries: list[Entry | tuple[GroundClaim, ...]] = [*state.exclusive, *state.some, *state.conjunctions]
    tied, keeps = _tied(entries, kept) if entries else (frozenset[Symbol](), kept)
    return Knowledge(
        keeps.only(state.known),
        {s: values for s, values in state.excluded.items() if s in tied or keeps(s)},
        frozenset(symbol for symbol in state.whether if symbol in tied or keeps(symbol)),
        frozenset(e for e in state.exclusive if not symbols_of(e).isdisjoint(tied)),
        frozenset(e for e in state.some if not symbols_of(e).isdisjoint(tied)),
        frozenset(e for e in state.conjunctions if not symbols_of(e).isdisjoint(tied)),
        state.start,
        state.broken,
    )


def _tied(entries: Sequence[Entry | tuple[GroundClaim, ...]], kept: Kept) -> tuple[frozenset[Symbol], Kept]:
    """The atoms and terms of all entries that a chain of shared members ties to one that matters; and all that does."""
    rest = [symbols_of(entry) for entry in entries]
    tied: frozenset[Symbol] = frozenset()
    while True:
        near: list[frozenset[Symbol]] = []
        far: list[frozenset[Symbol]] = []
        for group in rest:
            wanted = not group.isdisjoint(tied) or not group.isdisjoint(kept.symbols)
            (near if wanted or (kept.names and any(map(kept, group))) else far).append(group)
        if not near:
            return tied, kept
        rest, tied = far, tied.union(*near)
        kept = kept.tied_to(tied) if kept.relevance.has_rules else kept


# ------------------------------------------------------------------------------------------------------ mentions
def mentions(tree: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """Every atom and term that stands anywhere in a formula, effect or term, ground under the binding.

    One whose arguments depend on knowledge is mentioned by its name, which stands for all of that name.
    """
    if isinstance(tree, Forall | Exists | ForEach | FactForall | ExactlyOne):
        bodies: Iterable[Any] = tree.effects if isinstance(tree, ForEach) else (tree.body,)
        for more in instances(problem, tree.variables, binding):
            for body in bodies:
                yield from mentions(body, problem, more)
        return
    if isinstance(tree, Atom | Application):
        yield _ground(tree, binding)
        for argument in tree.arguments:
            yield from mentions(argument, problem, binding)
        return
    if isinstance(tree, Variable):
        value = binding.get(tree.name)
        symbol = read_symbol(value.term, problem) if isinstance(value, ValueOf) else None
        if symbol is not None:
            yield symbol
        return
    parts = tree if isinstance(tree, tuple | list) else ()
    if is_dataclass(tree):
        parts = [getattr(tree, field.name) for field in fields(tree) if field.name != "place"]
    for part in parts:
        yield from mentions(part, problem, binding)


def reads(effect: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """What an effect asks for: conditions, right sides and arguments, but not the facts of Kf that it writes."""
    if isinstance(effect, ForEach):
        for more in instances(problem, effect.variables, binding):
            for inner in effect.effects:
                yield from reads(inner, problem, more)
    elif isinstance(effect, Change) and effect.database == "Kf" and effect.operation == "add":
        for fact in effect.facts:
            yield from _read_by_fact(fact, problem, binding)
    elif hasattr(effect, "updates"):
        yield from mentions(effect.condition, problem, binding)
        for inner in effect.updates:
            yield from reads(inner, problem, binding)
    elif isinstance(effect, Change) and effect.database in ("Kf", "Kv"):
        for fact in effect.facts:
            yield from _read_by_fact(fact, problem, binding)
    else:
        yield from mentions(effect, problem, binding)


def _read_by_fact(fact: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    if isinstance(fact, FactForall):
        for more in instances(problem, fact.variables, binding):
            yield from _read_by_fact(fact.body, problem, more)
    elif isinstance(fact, Literal):
        yield from mentions(fact.atom.arguments, problem, binding)
    elif isinstance(fact, TermFact):
        yield from mentions(fact.term.arguments, problem, binding)
    elif hasattr(fact, "right") and isinstance(fact.left, Application):
        yield from mentions(fact.left.arguments, problem, binding)
        yield from mentions(fact.right, problem, binding)
    else:
        yield from mentions(fact, problem, binding)


def _ground(tree: Atom | Application, binding: Binding) -> Symbol | str:
    name = tree.predicate if isinstance(tree, Atom) else tree.function
    values = []
    for argument in tree.arguments:
        value = binding.get(argument.name) if isinstance(argument, Variable) else None
        if isinstance(argument, Constant):
            values.append(argument.name)
        elif isinstance(argument, Number):
            values.append(argument.value)  # type: ignore[arg-type]
        elif value is not None and not isinstance(value, ValueOf):
            values.append(value)  # type: ignore[arg-type]
        else:
            return name
    return name, tuple(values)
