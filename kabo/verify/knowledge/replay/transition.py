"""What actions, update rules and sensing do to knowledge: deletions, additions, then rules and closure [P].

An action's fired updates of Kf, and what its `when` effects may do, change the world: entries about what changes
are dropped. Update rules and outcomes of sensing only add to what is known about the same world.
"""

from collections.abc import Iterable

from kabo.verify.knowledge.facts import Facts, truth
from kabo.verify.knowledge.ground import NotVerifiableError, Symbol
from kabo.verify.knowledge.replay.draft import ContradictionError, Draft
from kabo.verify.knowledge.replay.postdiction import WorldEffects, forget_what_may_change, postdict, world_effects
from kabo.verify.knowledge.replay.states import Knowledge, Remembered, exclude
from kabo.verify.knowledge.replay.update_rules import UpdateRules
from kabo.verify.knowledge.updates import Assignment, Updates, denies_each, fired

ROUNDS = 1000  # of update rules; rules that still change something after so many do not settle


def change_world(draft: Draft, before: Knowledge, updates: Updates, remember: Remembered) -> None:
    """Applies the fired updates of an action to the state before it; rules and closure are still to come.

    Args:
        draft: a copy of the state before.
        before: the state before.
        updates: what fired in it.
        remember: atoms and terms, or their names, of which `initially` wants to know.

    Raises:
        ContradictionError: the updates contradict each other.
    """
    effects = world_effects(updates.worlds, before)
    updated = {add.symbol for add in updates.adds} | {claim[0] for claim in updates.deletions}
    changing = updated | effects.symbols
    draft.touch(changing, remember)
    draft.drop_entries(changing)
    draft.changed |= changing
    for claim in updates.deletions:
        draft.may_cease(claim)
    forget_what_may_change(draft, effects)
    agree([*updates.adds, *effects.sure])
    for add in [*_undisputed(draft, effects), *updates.adds]:
        assign(draft, add)
    note(draft, updates)
    postdict(draft, effects, before, updated, changing)


def agree(adds: Iterable[Assignment]) -> None:
    """Refuses additions that contradict each other.

    Raises:
        ContradictionError: one symbol gets two values, or a value that it is said not to have.
    """
    values: dict[object, Assignment] = {}
    for add in adds:
        if add.positive:
            earlier = values.setdefault(add.symbol, add)
            if earlier != add and (earlier.value is None or earlier.value != add.value):
                raise ContradictionError("it has two different effects on the same atom or term")
    for add in adds:
        given = values.get(add.symbol)
        if not add.positive and given is not None and given.value == add.value:
            raise ContradictionError("it has contradictory effects on the same term")


def _undisputed(draft: Draft, effects: WorldEffects) -> list[Assignment]:
    """The certain outcomes; where another one may pull elsewhere, only that the value is one of theirs is known."""
    result = []
    for outcome in effects.sure:
        rivals = {e.value for e, _ in effects.possible if e.symbol == outcome.symbol} - {outcome.value}
        if rivals:
            draft.forget(outcome.symbol)
        else:
            result.append(outcome)
    return result


def assign(draft: Draft, add: Assignment) -> None:
    """The action makes the claim true, whatever held before."""
    symbol, value = add.symbol, add.value
    draft.changed.add(symbol)
    draft.whether.discard(symbol)
    if add.positive:
        draft.known.pop(symbol, None)
        draft.excluded.pop(symbol, None)
        if value is not None:
            draft.known[symbol] = value
        elif add.sensed:
            draft.whether.add(symbol)
        return
    if value is None or draft.known.get(symbol) == value:
        draft.known.pop(symbol, None)
    if value is not None and symbol not in draft.known:
        exclude(draft.excluded, symbol, value)


def note(draft: Draft, updates: Updates) -> None:
    """The databases beside Kf: deletions, then additions."""
    for symbol in updates.no_run_time:
        if symbol in draft.whether:
            draft.whether.discard(symbol)
            draft.changed.add(symbol)
    for whole in updates.no_whole:
        draft.conjunctions.discard(whole)
    for database, entry in updates.no_entries:
        draft.remove_entry(database, entry)
    for claims in updates.no_complete:
        draft.remove_entry("Kor", denies_each(draft.problem, claims))
    for symbol in updates.run_time:
        draft.will_know(symbol)
    for whole in updates.whole:
        truths = [truth(claim, draft) for claim in whole]
        if False not in truths and None in truths:
            draft.conjunctions.add(whole)
    for database, entry in updates.entries:
        draft.add_entry(database, entry)
    for claims in updates.complete:
        if not all(truth(claim, draft) for claim in claims):
            draft.deny_all(claims)


def infer(draft: Draft, updates: Updates) -> None:
    """Applies what update rules say: deletions forget, additions must agree with what is known.

    Raises:
        ContradictionError: they do not.
    """
    added = {(add.symbol, add.value, add.positive) for add in updates.adds}
    for claim in updates.deletions:
        symbol, value, positive = claim
        if claim in added:
            continue
        if positive and draft.known.get(symbol) == value:
            draft.forget(symbol)
        elif not positive and value in draft.excluded.get(symbol, ()):
            draft.may_become(symbol, value)
    for add in updates.adds:
        if add.value is not None:
            draft.learn((add.symbol, add.value, add.positive))
        elif add.sensed:
            draft.will_know(add.symbol)
    note(draft, updates)


def settle(draft: Draft, rules: UpdateRules, *, everything: bool = False) -> None:
    """Closure and update rules in turn, until nothing changes.

    Args:
        draft: the state.
        rules: the domain's update rules.
        everything: whether every rule is to be asked, not only those that the changes so far set off.

    Raises:
        ContradictionError: the state contradicts itself.
        NotVerifiableError: the rules do not settle.
    """
    for number in range(ROUNDS):
        changed = draft.close()
        waiting = rules.rules if everything and number == 0 else rules.set_off_by(changed)
        if not waiting:
            return
        facts: Facts = draft
        infer(draft, fired(waiting, facts))
        if not draft.changed:
            return
    raise NotVerifiableError(f"the update rules still change something after {ROUNDS} rounds")


def look_back(draft: Draft, rules: UpdateRules, remember: Remembered) -> None:
    """What is known of what no action has touched was so at the start, and the other way round, to a fixpoint.

    Raises:
        ContradictionError: it cannot have been so.
        NotVerifiableError: the rules do not settle.
    """
    while draft.past is not None:
        past = Draft(draft.problem, draft.past)
        _tell(draft, past, draft.touched, remember)
        settle(past, rules)
        draft.past = past.finished()
        _tell(past, draft, draft.touched, remember)
        if not draft.changed:
            return
        settle(draft, rules)


def _tell(one: Draft, other: Draft, touched: frozenset[Symbol], remember: Remembered) -> None:
    """The other draft learns what the one knows of what is remembered and untouched."""
    for symbol, value in one.known.items():
        if symbol not in touched and (symbol in remember or symbol[0] in remember):
            other.learn((symbol, value, True))
    for symbol, values in one.excluded.items():
        if symbol not in touched and (symbol in remember or symbol[0] in remember):
            for value in sorted(values, key=repr):
                other.learn((symbol, value, False))
