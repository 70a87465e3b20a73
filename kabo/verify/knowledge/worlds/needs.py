"""The atoms and terms that the rest of a plan reads; worlds that agree on them are treated as one.

A node's continuation reads only what its actions, its branchings and the goal mention. A part of the goal that holds, and
that neither a change nor an observation in the continuation can make false, need not be read again.
"""

from collections.abc import Callable, Iterable, Sequence

from kabo.language.formulas import And, Exists, Forall, Formula, Know, KnowValue, KnowWhether, Or, Truth
from kabo.language.problem import Problem
from kabo.plan import Node, Plan, ValueOf
from kabo.verify.knowledge.ground import Observable, Symbol, is_symbol, read_observable, read_symbol
from kabo.verify.knowledge.mentions import mentions

Named = Iterable[Symbol | str]  # atoms and terms, or names that stand for all of theirs


def never_hurt_by_knowledge(formula: Formula) -> bool:
    """Whether more knowledge never makes the formula false."""
    match formula:
        case And(parts=parts) | Or(parts=parts):
            return all(map(never_hurt_by_knowledge, parts))
        case Forall(body=body) | Exists(body=body):
            return never_hurt_by_knowledge(body)
    return isinstance(formula, Know | KnowWhether | KnowValue | Truth)


class Needs:
    """The atoms, terms and whole symbols that each node and its continuation read and may change, as bit masks."""

    def __init__(
        self, plan: Plan, order: Sequence[str], problem: Problem, goals: Sequence[Named], always: Named
    ) -> None:
        """Collects what the reached nodes read; `order` has each before its successors."""
        self._bits: dict[Symbol | str, int] = {}
        self.goals = [self._mask(goal) for goal in goals]
        throughout = self._mask(always)
        self._asked: dict[str, int] = {}
        self._changed: dict[str, int] = {}
        known: dict[object, tuple[int, int]] = {}
        for name in reversed(order):
            node = plan.nodes[name]
            key = (
                node.action,
                tuple(sorted(node.arguments.items(), key=lambda pair: pair[0])),
                node.on,
                node.delivers,
            )
            if key not in known:
                known[key] = self._of(node, problem)
            asked, changed = known[key]
            for successor in node.successors:
                asked |= self._asked.get(successor, 0)
                changed |= self._changed.get(successor, 0)
            self._asked[name], self._changed[name] = asked | throughout, changed
        self._names = {thing: bit for thing, bit in self._bits.items() if isinstance(thing, str)}
        self.goals = [self._wide(goal) for goal in self.goals]
        self._changed = {name: self._wide(mask) for name, mask in self._changed.items()}
        self._kept: dict[int, tuple[Callable[[Symbol], bool], frozenset[Symbol] | None]] = {}

    def _of(self, node: Node, problem: Problem) -> tuple[int, int]:
        """The masks of what a node reads, and of what it may change."""
        things = [
            read_observable(text, problem) for text in (*([] if node.on is None else [node.on]), *node.delivers)
        ]
        asked = self._mask(symbol for thing in things for symbol in _symbols(thing))
        if node.action is None:
            return asked, 0
        action, binding = problem.domain.actions[node.action], dict(node.arguments)
        terms = (
            read_symbol(value.term, problem) for value in node.arguments.values() if isinstance(value, ValueOf)
        )
        asked |= self._mask(symbol for symbol in terms if symbol is not None)
        asked |= self._mask(mentions((action.preconditions, action.sense, action.effects), problem, binding))
        return asked, self._mask(mentions(action.effects, problem, binding))

    def _mask(self, things: Named) -> int:
        mask = 0
        for thing in things:
            mask |= self._bits.setdefault(thing, 1 << len(self._bits))
        return mask

    def _wide(self, mask: int) -> int:
        """The mask with the symbols of all atoms and terms in it, and with all instances of the symbols in it."""
        for name, bit in self._names.items():
            own = [other for thing, other in self._bits.items() if not isinstance(thing, str) and thing[0] == name]
            if mask & bit or any(mask & other for other in own):
                mask |= bit
                for other in own:
                    mask |= other
        return mask

    def done(self, name: str, number: int) -> bool:
        """Whether neither a node nor its continuation can change what the goal part `number` reads."""
        return not self.goals[number] & self._changed[name]

    def read_later(self, name: str, thing: Symbol | str) -> bool:
        """Whether the node or its continuation reads the atom or term, or its symbol as a whole."""
        mask = self._bits.get(thing, 0)
        if not isinstance(thing, str):
            mask |= self._bits.get(thing[0], 0)
        return bool(self._asked[name] & mask)

    def kept(self, name: str, settled: int) -> tuple[Callable[[Symbol], bool], frozenset[Symbol] | None]:
        """What a node, its continuation and unsettled goal parts read: a membership test, and the set.

        The set is None if a symbol is read as a whole.
        """
        mask = self._asked[name]
        for number, goal in enumerate(self.goals):
            if not settled >> number & 1:
                mask |= goal
        if mask not in self._kept:
            symbols = frozenset(
                thing for thing, bit in self._bits.items() if mask & bit and not isinstance(thing, str)
            )
            names = frozenset(name for name, bit in self._names.items() if mask & bit)

            def keeps(symbol: Symbol) -> bool:
                return symbol in symbols or symbol[0] in names

            if len(self._kept) > 64:
                self._kept.clear()
            self._kept[mask] = keeps, None if names else symbols
        return self._kept[mask]


def _symbols(thing: Observable | None) -> tuple[Symbol, ...]:
    if thing is None:
        return ()
    return (thing,) if is_symbol(thing) else tuple(claim[0] for claim in thing)  # type: ignore
