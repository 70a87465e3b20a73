"""The worlds that the initial knowledge allows, found with the inference of the replay: beside `worlds/initial.py`.

Groups that nothing links are independent: a world is one choice for each, so each is searched on its own.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import Entry, GroundClaim, NotVerifiableError, Symbol, Value, range_of
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError, MutableKnowledge
from kabo.verify.knowledge.replay.states import Knowledge
from kabo.verify.knowledge.replay.transition import settle
from kabo.verify.knowledge.replay.update_rules import UpdateRules
from kabo.verify.knowledge.updates import Rule, fired

STEPS = 20_000  # decisions of one search

Values = dict[Symbol, Value]


@dataclass
class Linked:
    """One group, and what is known that matters to it."""

    problem: Problem
    rules: UpdateRules
    symbols: tuple[Symbol, ...]
    state: Knowledge
    own_rules: tuple[Rule, ...]
    _listed: "dict[int, list[Values] | None]" = field(default_factory=dict)

    @cached_property
    def _claims(self) -> list[GroundClaim]:
        """The members of all entries, each once."""
        return list(dict.fromkeys(claim for entry in (*self.state.exclusive, *self.state.some) for claim in entry))

    def values_of(self, symbol: Symbol) -> list[Value]:
        """The values that are not excluded."""
        without = self.state.excluded.get(symbol, ())
        return [value for value in range_of(self.problem, symbol) or () if value not in without]

    def all(self, limit: int) -> list[Values] | None:
        """Every combination of values; None if there are more than `limit`, or the search takes too long."""
        if limit not in self._listed:
            self._listed[limit] = self._all(limit)
        return self._listed[limit]

    def _all(self, limit: int) -> list[Values] | None:
        if len(self.symbols) == 1 and not self.own_rules and not self.state.exclusive and not self.state.some:
            values = self.values_of(self.symbols[0])
            return [{self.symbols[0]: value} for value in values] if len(values) <= limit else None
        found: list[Values] = []
        stack = [self.state]
        for _ in range(STEPS):
            if not stack:
                return found
            state = stack.pop()
            symbol = next((symbol for symbol in self.symbols if symbol not in state.known), None)
            if symbol is not None:
                stack.extend(reversed(list(self._decisions(state, symbol))))
                continue
            values_found = {symbol: state.known[symbol] for symbol in self.symbols}
            if self.agree(values_found):
                found.append(values_found)
            if len(found) > limit:
                return None
        return None

    def _decisions(self, state: Knowledge, symbol: Symbol) -> Iterator[Knowledge]:
        """The state with each value that the symbol can have, and what follows."""
        for value in self.values_of(symbol):
            draft = MutableKnowledge(self.problem, state)
            try:
                draft.learn((symbol, value, True))
                settle(draft, self.rules)
            except ContradictionError:
                continue
            yield draft.finished()

    def agree(self, values: Mapping[Symbol, Value]) -> bool:
        """Whether these values can be together: entries hold, and rules conclude nothing else."""
        world = Knowledge({**self.state.known, **values})
        holding = {claim for claim in self._claims if truth(claim, world)}
        if any(len(entry & holding) != 1 for entry in self.state.exclusive):
            return False
        if any(entry.isdisjoint(holding) for entry in self.state.some):
            return False
        try:
            updates = fired(self.own_rules, world)
        except NotVerifiableError:
            return True
        if any(not _may_hold(entry, database, world) for database, entry in updates.entries):
            return False
        return not any(
            add.value is not None and truth((add.symbol, add.value, add.positive), world) is False
            for add in updates.adds
        )


def _may_hold(entry: Entry, database: str, world: Knowledge) -> bool:
    truths = [truth(claim, world) for claim in entry]
    at_most_one = database == "Kor" or truths.count(True) <= 1
    return at_most_one and len(truths) > truths.count(False)


def linked_groups(
    problem: Problem, state: Knowledge, rules: UpdateRules, matters: Iterable[Symbol]
) -> list[Linked]:
    """The groups of unknown atoms and terms that matter, or are linked to one that does, in a fixed order."""
    matters = frozenset(matters)
    related = [frozenset(claim[0] for claim in entry) for entry in (*state.exclusive, *state.some)]
    wanted = matters.union(*related)
    names = [{thing for thing in group if isinstance(thing, str)} for group in rules.mentioned]
    by_rule = [
        frozenset(s for s in group if not isinstance(s, str)) | frozenset(s for s in wanted if s[0] in named)
        for group, named in zip(rules.mentioned, names, strict=True)
    ]
    wanted = wanted.union(*by_rule)
    unknown = {s for s in wanted if s not in state.known and range_of(problem, s) is not None}
    parent = {symbol: symbol for symbol in unknown}

    def root(symbol: Symbol) -> Symbol:
        while parent[symbol] != symbol:
            parent[symbol] = parent[parent[symbol]]
            symbol = parent[symbol]
        return symbol

    for group in (*related, *by_rule):
        inside = sorted(group & unknown, key=repr)
        for symbol in inside[1:]:
            parent[root(symbol)] = root(inside[0])
    members: dict[Symbol, list[Symbol]] = {}
    for symbol in sorted(unknown, key=repr):
        members.setdefault(root(symbol), []).append(symbol)
    return _built(problem, state, rules, [group for group in members.values() if matters & set(group)], by_rule)


def _built(
    problem: Problem,
    state: Knowledge,
    rules: UpdateRules,
    groups: list[list[Symbol]],
    by_rule: list[frozenset[Symbol]],
) -> list[Linked]:
    number = {symbol: index for index, group in enumerate(groups) for symbol in group}
    own: list[list[int]] = [[] for _ in groups]
    for rule, symbols in enumerate(by_rule):
        for index in sorted({number[symbol] for symbol in symbols if symbol in number}):
            own[index].append(rule)
    entries: list[tuple[list[Entry], list[Entry]]] = [([], []) for _ in groups]
    for database, all_entries in enumerate((state.exclusive, state.some)):
        for entry in all_entries:
            symbol = next(iter(entry))[0]
            if symbol in number:
                entries[number[symbol]][database].append(entry)
    result = []
    for index, group in enumerate(groups):
        near = set(group).union(*(by_rule[rule] for rule in own[index]))
        known = {symbol: state.known[symbol] for symbol in sorted(near, key=repr) if symbol in state.known}
        excluded = {symbol: state.excluded[symbol] for symbol in group if symbol in state.excluded}
        inner = Knowledge(
            known, excluded, exclusive=frozenset(entries[index][0]), some=frozenset(entries[index][1])
        )
        chosen = tuple(rules.rules[rule] for rule in own[index])
        result.append(Linked(problem, rules, tuple(group), inner, chosen))
    return result


def all_worlds(groups: Sequence[Linked], limit: int) -> list[Values] | None:
    """Every world; None if there are more than `limit`, or they are not found in time."""
    choices: list[list[Values]] = []
    count = 1
    for group in groups:
        choice = group.all(limit)
        if choice is None or (count := count * len(choice)) > limit:
            return None
        choices.append(choice)
    return [{symbol: value for part in parts for symbol, value in part.items()} for parts in product(*choices)]
