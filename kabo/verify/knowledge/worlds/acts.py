"""The effects of actions on the possible worlds, and the outcomes of observing an atom, a term or a conjunction.

Deletions come first, then the outcomes of `when` effects, then additions. A value that an action leaves open may be any
value that was possible before, or any value at all if only one was possible.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from kabo.language.problem import Action, Problem
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import (
    Binding,
    Entry,
    GroundClaim,
    NotVerifiableError,
    Observable,
    Symbol,
    Value,
    claim_text,
    is_symbol,
    range_of,
    text_of,
)
from kabo.verify.knowledge.updates import Assignment, Rule, UnknownComparison, When, fired, rules_of, sensing
from kabo.verify.knowledge.worlds.belief import Belief, ExplicitBelief
from kabo.verify.knowledge.worlds.queries import Query, fires, query
from kabo.verify.knowledge.worlds.world import CannotJudgeError, OpenError, World, holds


class NotApplicableError(Exception):
    """The action's effects contradict each other or what is known."""


@dataclass(frozen=True)
class Act:
    """An action with its arguments."""

    schema: Action
    binding: Binding
    values: tuple[tuple[str, Symbol | None], ...]  # run-time variables: the text and symbol of their terms
    preconditions: tuple[Query, ...]
    effects: tuple[Rule, ...]


def act_of(
    schema: Action, binding: Binding, values: tuple[tuple[str, Symbol | None], ...], problem: Problem
) -> Act:
    """The ground action of a schema under a binding.

    Raises:
        CannotJudgeError: worlds cannot judge the action.
    """
    preconditions = tuple(query(part, problem, binding) for part in schema.preconditions)
    effects = rules_of(schema.effects, problem, binding, _condition)
    return Act(schema, binding, values, preconditions, (*effects, *sensing(schema.sense, problem, binding)))


def _condition(formula, problem: Problem, binding: Binding):  # type: ignore[no-untyped-def]
    asked = query(formula, problem, binding)
    return lambda belief: fires(asked, belief, belief.explicit_belief)


@dataclass
class After:
    """The belief after an action, what it delivered, and how many worlds contradicted an added entry."""

    belief: Belief
    delivered: set[Observable]
    ruled_out: int = 0


@dataclass
class _Change:
    """The effects of an action in one world: claims that cease, outcomes, additions."""

    ceasing: list[GroundClaim]
    outcomes: dict[Symbol, set[Value | None]] = field(default_factory=dict)
    adds: list[Assignment] = field(default_factory=list)

    @property
    def symbols(self) -> set[Symbol]:
        """The atoms and terms that change."""
        return {c[0] for c in self.ceasing} | self.outcomes.keys() | {add.symbol for add in self.adds}


def perform(act: Act, belief: Belief) -> After:
    """Performs an action in all worlds of a belief, and returns the belief afterwards.

    Raises:
        NotApplicableError: the action's effects contradict each other, or what is known.
        CannotJudgeError: the action has an effect that worlds cannot judge.
    """
    try:
        return _Performance(act, belief).after()
    except NotVerifiableError as error:
        raise CannotJudgeError(str(error)) from None


class _Performance:
    """One action performed in one belief."""

    def __init__(self, act: Act, belief: Belief) -> None:
        self.act, self.belief = act, belief
        self.unknowns, self.problem = belief.unknowns, belief.unknowns.problem
        self.updates = fired(act.effects, belief)  # for a reasoner who knows all on which the worlds agree
        if self.updates.no_entries or self.updates.no_complete:
            raise CannotJudgeError("an effect forgets how facts hang together")
        _agree(self.updates.adds)

    def after(self) -> After:
        """The belief after the action."""
        changed = {add.symbol for add in self.updates.adds} | {claim[0] for claim in self.updates.deletions}
        disputed: dict[Symbol, int] = {}
        result: list[World] = []
        number = 0
        for world in self._split(self.belief.worlds):
            number += 1
            change = self._in(world)
            changed |= change.symbols
            for symbol in _disputed(change):
                disputed[symbol] = disputed.get(symbol, 0) + 1
            result.append(self._apply(change, world))
        for symbol, count in disputed.items():
            if count == number:
                raise NotApplicableError(f"two different effects on {text_of(symbol)}")
        result, ruled_out = self._satisfying_entries(result)
        return self._known(result, changed, ruled_out)

    def _split(self, worlds: Iterable[World]) -> Iterator[World]:
        """The worlds, each split by the open values on which the action's effects depend."""
        waiting = list(worlds)[::-1]
        while waiting:
            world = waiting.pop()
            try:
                change = self._in(world)
                probe = world.copy()
                for symbol in sorted(change.symbols, key=repr):
                    self.unknowns.detach(probe, symbol)
            except OpenError as error:
                waiting.extend(list(self.unknowns.split(world, error.symbol))[::-1])
                continue
            yield world

    def _in(self, world: World) -> _Change:
        """The effects of the action in a world.

        Raises:
            OpenError: they depend on a value that is open.
        """
        world.agent_knowledge = self.belief
        updates = fired(self.act.effects, world)
        change = _Change([claim for claim in updates.deletions if truth(claim, world) is not False])
        happening = [
            outcome for effect in updates.worlds if _happens(effect, world) for outcome in effect.outcomes
        ]
        for each in (*happening, *updates.adds):
            if each.value is None and each.source is not None and range_of(self.problem, each.source) is not None:
                raise OpenError(each.source)
        for outcome in happening:
            change.outcomes.setdefault(outcome.symbol, set()).add(outcome.value)
        change.adds = updates.adds
        return change

    def _apply(self, change: _Change, world: World) -> World:
        """The world after these effects."""
        after = world.copy()
        for symbol in change.symbols:
            self.unknowns.detach(after, symbol)
        now: dict[Symbol, set[Value]] = {}
        for claim in change.ceasing:
            self._cease(claim, after, world, now)
        for symbol, values in now.items():
            self._leave(after, symbol, values)
        for symbol, ones in change.outcomes.items():
            known = {value for value in ones if value is not None}
            if None in ones:
                after.leave_open(symbol)
            else:
                self._leave(after, symbol, known)
        for add in change.adds:
            if not add.positive:
                self._deny(add, after)
            elif add.value is None:
                after.leave_open(add.symbol)
            else:
                after.put(add.symbol, add.value)
        return after

    def _cease(self, claim: GroundClaim, after: World, before: World, now: dict[Symbol, set[Value]]) -> None:
        symbol, value, positive = claim
        own = self.unknowns.values(symbol, before)
        if own is None:
            after.leave_open(symbol)
            return
        every = range_of(self.problem, symbol)
        if every is None:  # a number that is known
            after.leave_open(symbol)
            return
        values = now.setdefault(symbol, set(own))
        if positive and value in own:
            values |= self._possible(symbol, every) if self.belief.known.get(symbol) is None else set(every)
        elif not positive and set(own) != {value}:
            values.add(value)

    def _possible(self, symbol: Symbol, every: Iterable[Value]) -> set[Value]:
        return set(every) - self.belief.excluded.get(symbol)

    def _deny(self, add: Assignment, after: World) -> None:
        """Makes the symbol not have the value: if it has it, it may take any other value that was possible before."""
        own, every = self.unknowns.values(add.symbol, after), range_of(self.problem, add.symbol)
        if own is None or every is None or add.value is None:
            after.leave_open(add.symbol)
        elif add.value in own:
            rest = set(own) - {add.value}
            rest = rest or self._possible(add.symbol, every) - {add.value} or set(every) - {add.value}
            if not rest:
                raise NotApplicableError(f"{text_of(add.symbol)} has no value left")
            self._leave(after, add.symbol, rest)

    def _leave(self, world: World, symbol: Symbol, values: set[Value]) -> None:
        """Leaves the symbol open: it may have any of these values from now on."""
        if len(values) == 1:
            world.put(symbol, next(iter(values)))
        else:
            world.leave_open(symbol, frozenset(range_of(self.problem, symbol) or ()) - values)

    # ------------------------------------------------------------------------------------------ entries it adds
    def _satisfying_entries(self, worlds: list[World]) -> tuple[list[World], int]:
        """The worlds in which the entries hold that the action adds, and how many worlds these entries rule out."""
        result, ruled_out = self._where(worlds, self.updates.entries)
        for claims in self.updates.complete:
            known = all(truth(claim, world) for claim in claims for world in result)
            if known and all(truth(claim, ExplicitBelief(self.belief.explicit)) for claim in claims):
                continue
            if known:
                raise CannotJudgeError("a local closed world asks what follows only from several facts together")
            denials = frozenset((s, v, not positive) for s, v, positive in claims)
            result, more = self._where(result, [("Kor", denials)])
            ruled_out += more
        if not result:
            raise NotApplicableError("something of the world that is known not to be so")
        return result, ruled_out

    def _where(self, worlds: list[World], entries: list[tuple[str, Entry]]) -> tuple[list[World], int]:
        if not entries:
            return worlds, 0
        result, waiting, ruled_out = [], worlds[::-1], 0
        while waiting:
            world = waiting.pop()
            try:
                if all(_holds_in(database, entry, world) for database, entry in entries):
                    result.append(world)
                else:
                    ruled_out += 1
            except OpenError as error:
                waiting.extend(list(self.unknowns.split(world, error.symbol))[::-1])
        return result, ruled_out

    # ------------------------------------------------------------------------------------------------ what is known
    def _known(self, worlds: list[World], changed: set[Symbol], ruled_out: int) -> After:
        belief, updates = self.belief, self.updates
        after = Belief(belief.unknowns, worlds, broken=belief.broken, settled=belief.settled)
        kept = belief.whether - changed | {add.symbol for add in updates.adds if add.sensed}
        new = {symbol for symbol in updates.run_time if symbol not in after.known}
        after.whether = (kept - set(updates.no_run_time)) | new
        whole = {claims for claims in belief.whole if not any(claim[0] in changed for claim in claims)}
        after.whole = frozenset((whole - set(updates.no_whole)) | set(updates.whole))
        after.explicit = self._explicit_after()
        delivered: set[Observable] = {*updates.run_time, *updates.whole, *(after.whether - belief.whether)}
        return After(after, delivered, ruled_out)

    def _explicit_after(self) -> dict[Symbol, Value]:
        """The explicit belief after the action: without values that may have changed, with those certainly added."""
        explicit, updates = dict(self.belief.explicit), self.updates
        before = ExplicitBelief(self.belief.explicit)
        maybe = [effect for effect in updates.worlds if not any(_is_false(c, before) for c in effect.conditions)]
        outcomes = [outcome for effect in maybe for outcome in effect.outcomes]
        changing = [claim[0] for claim in updates.deletions] + [each.symbol for each in (*outcomes, *updates.adds)]
        for symbol in changing:
            explicit.pop(symbol, None)
        for effect in maybe:
            if all(_is_true(condition, before) for condition in effect.conditions):
                for outcome in effect.outcomes:
                    if outcome.value is not None and changing.count(outcome.symbol) == 1:
                        explicit[outcome.symbol] = outcome.value
        for add in fired(self.act.effects, ExplicitBelief(self.belief.explicit, about=self.belief)).adds:
            if add.positive and add.value is not None:
                explicit[add.symbol] = add.value
        return explicit


def _agree(adds: Iterable[Assignment]) -> None:
    """Refuses additions that contradict each other."""
    values: dict[Symbol, Assignment] = {}
    for add in adds:
        if add.positive:
            earlier = values.setdefault(add.symbol, add)
            if earlier != add and (earlier.value is None or earlier.value != add.value):
                raise NotApplicableError(f"two different effects on {text_of(add.symbol)}")
    for add in adds:
        given = values.get(add.symbol)
        if not add.positive and given is not None and given.value == add.value:
            raise NotApplicableError(f"contradictory effects on {text_of(add.symbol)}")


def _disputed(change: _Change) -> Iterator[Symbol]:
    """The atoms and terms that get two different values in one world."""
    for symbol, ones in change.outcomes.items():
        added = {add.value for add in change.adds if add.symbol == symbol and add.positive}
        denied = {add.value for add in change.adds if add.symbol == symbol and not add.positive}
        if len(ones | added) > 1 or ones & denied:
            yield symbol


def _happens(effect: When, world: World) -> bool:
    """Whether all conditions of a `when` effect are true."""
    first_open: Symbol | None = None
    for condition in effect.conditions:
        if isinstance(condition, bool):
            if not condition:
                return False
        elif isinstance(condition, UnknownComparison):
            first_open = condition.left if condition.left not in world.known else condition.right
            if first_open is None:
                raise CannotJudgeError("a condition compares numbers that are not known")
        else:
            true = truth(condition, world)
            if true is False:
                return False
            if true is None:
                first_open = condition[0]
    if first_open is not None:
        raise OpenError(first_open)
    return True


def _is_false(condition: object, explicit: ExplicitBelief) -> bool:
    if isinstance(condition, bool):
        return not condition
    return not isinstance(condition, UnknownComparison) and truth(condition, explicit) is False  # type: ignore[arg-type]


def _is_true(condition: object, explicit: ExplicitBelief) -> bool:
    if isinstance(condition, bool):
        return condition
    return not isinstance(condition, UnknownComparison) and truth(condition, explicit) is True  # type: ignore[arg-type]


def _holds_in(database: str, entry: Entry, world: World) -> bool:
    truths = {claim: truth(claim, world) for claim in sorted(entry, key=claim_text)}
    holding = list(truths.values()).count(True)
    if holding > 1 and database == "Kx":
        return False
    for claim, true in truths.items():
        if true is None and (database == "Kx" or not holding):
            raise OpenError(claim[0])
    return holding > 0


def observed(belief: Belief, thing: Observable) -> dict[Value, Belief]:
    """Each possible outcome of the atom, term or conjunction that a plan branches on, with the belief after it."""
    parts: dict[Value, list[World]] = {}
    waiting = belief.worlds[::-1]
    while waiting:
        world = waiting.pop()
        try:
            value = _observed_in(world, thing)
        except OpenError as error:
            waiting.extend(list(belief.unknowns.split(world, error.symbol))[::-1])
            continue
        parts.setdefault(value, []).append(world)
    return {value: _learned(belief, thing, value, worlds) for value, worlds in parts.items()}


def _observed_in(world: World, thing: Observable) -> Value:
    if is_symbol(thing):
        return world.value(thing)  # type: ignore[arg-type]
    claims: tuple[GroundClaim, ...] = thing  # type: ignore[assignment]
    return False not in [holds(claim, world) for claim in claims]


def _learned(belief: Belief, thing: Observable, value: Value, worlds: list[World]) -> Belief:
    explicit = dict(belief.explicit)
    whether, whole = belief.whether, belief.whole
    if is_symbol(thing):
        explicit[thing] = value  # type: ignore[index]
        whether -= {thing}
    else:
        whole -= {thing}
        if value is True:
            explicit.update({claim[0]: claim[1] for claim in thing if claim[2]})  # type: ignore[misc]
    return Belief(belief.unknowns, worlds, whether, whole, explicit, broken=belief.broken, settled=belief.settled)
