"""The effects of actions, update rules and sensing on knowledge: deletions, additions, then rules and closure [P].

An action's updates of Kf that fire, and its `when` effects, change the world: entries about what changes are removed.
Update rules and outcomes of sensing only add knowledge about the same world.
"""

from collections.abc import Iterable

from kabo.verify.knowledge.facts import Facts, truth
from kabo.verify.knowledge.ground import NotVerifiableError, Symbol
from kabo.verify.knowledge.replay.mutable_knowledge import ContradictionError, MutableKnowledge
from kabo.verify.knowledge.replay.postdiction import WorldEffects, forget_what_may_change, postdict, world_effects
from kabo.verify.knowledge.replay.states import Knowledge, Remembered, exclude
from kabo.verify.knowledge.replay.update_rules import UpdateRules
from kabo.verify.knowledge.updates import Assignment, Updates, denies_each, fired

MAX_RULE_ROUNDS = 1000  # rounds of update rules; rules that still change something then are refused


def change_world(draft: MutableKnowledge, before: Knowledge, updates: Updates, remember: Remembered) -> None:
    """Applies the updates of an action that fire in the state before it; rules and closure follow later.

    Args:
        draft: a copy of the state before.
        before: the state before.
        updates: the updates that fire in it.
        remember: the atoms, terms and names of symbols that `initially` goals mention.

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
        ContradictionError: one symbol gets two values, or a value that another addition denies.
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


def _undisputed(draft: MutableKnowledge, effects: WorldEffects) -> list[Assignment]:
    """The certain outcomes that no other outcome may contradict; of others only the possible values become known."""
    result = []
    for outcome in effects.sure:
        rivals = {e.value for e, _ in effects.possible if e.symbol == outcome.symbol} - {outcome.value}
        if rivals:
            draft.forget(outcome.symbol)
        else:
            result.append(outcome)
    return result


def assign(draft: MutableKnowledge, add: Assignment) -> None:
    """Applies an assignment to the state, regardless of what was known of its symbol before."""
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


def note(draft: MutableKnowledge, updates: Updates) -> None:
    """Applies the updates of all knowledge databases except Kf: deletions, then additions."""
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


def infer(draft: MutableKnowledge, updates: Updates) -> None:
    """Applies the conclusions of update rules: deletions forget, additions must agree with what is known.

    Raises:
        ContradictionError: an addition contradicts what is known.
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


def settle(draft: MutableKnowledge, rules: UpdateRules, *, everything: bool = False) -> None:
    """Alternates closure and update rules until nothing changes.

    Args:
        draft: the state.
        rules: the domain's update rules.
        everything: whether to try every rule, not only those that the changes so far may trigger.

    Raises:
        ContradictionError: the state contradicts itself.
        NotVerifiableError: the rules do not settle.
    """
    for number in range(MAX_RULE_ROUNDS):
        changed = draft.close()
        waiting = rules.rules if everything and number == 0 else rules.set_off_by(changed)
        if not waiting:
            return
        facts: Facts = draft
        infer(draft, fired(waiting, facts))
        if not draft.changed:
            return
    raise NotVerifiableError(f"the update rules still change something after {MAX_RULE_ROUNDS} rounds")


def look_back(draft: MutableKnowledge, rules: UpdateRules, remember: Remembered) -> None:
    """Copies knowledge of unchanged symbols between the present and the initial state, until a fixpoint.

    Raises:
        ContradictionError: the knowledge of the two states is contradictory.
        NotVerifiableError: the update rules still change something after `MAX_RULE_ROUNDS` rounds.
    """
    while draft.past is not None:
        past = MutableKnowledge(draft.problem, draft.past)
        _tell(draft, past, draft.touched, remember)
        settle(past, rules)
        draft.past = past.finished()
        _tell(past, draft, draft.touched, remember)
        if not draft.changed:
            return
        settle(draft, rules)


def _tell(
    one: MutableKnowledge, other: MutableKnowledge, touched: frozenset[Symbol], remember: Remembered
) -> None:
    """Adds to `other` what `one` knows of the remembered atoms and terms that no action has touched."""
    for symbol, value in one.known.items():
        if symbol not in touched and (symbol in remember or symbol[0] in remember):
            other.learn((symbol, value, True))
    for symbol, values in one.excluded.items():
        if symbol not in touched and (symbol in remember or symbol[0] in remember):
            for value in sorted(values, key=repr):
                other.learn((symbol, value, False))
