"""What `when C then E` does to knowledge, and what it lets one conclude later [P, postdiction].

All of C known: E is known afterwards. Some of C known false: nothing. Otherwise E may have come true: its
complement is forgotten, and entries remember what finding E true, or false, will then say about C.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import GroundClaim, Symbol, denied
from kabo.verify.knowledge.replay.draft import Draft
from kabo.verify.knowledge.replay.states import Knowledge
from kabo.verify.knowledge.updates import Assignment, Condition, Pair, When

Open = tuple[GroundClaim, ...]  # the conditions that are not known; empty: not even a claim can be made of them


@dataclass
class WorldEffects:
    """What the `when` effects of an action do: outcomes that are certain, and those that may happen."""

    sure: dict[Assignment, None] = field(default_factory=dict)
    possible: dict[tuple[Assignment, Open], None] = field(default_factory=dict)

    @property
    def symbols(self) -> set[Symbol]:
        """What may change."""
        return {outcome.symbol for outcome in self.sure} | {outcome.symbol for outcome, _ in self.possible}


def world_effects(effects: Iterable[When], state: Knowledge) -> WorldEffects:
    """Sorts the outcomes of `when` effects by what is known of their conditions in the state before."""
    result = WorldEffects()
    for effect in effects:
        truths = [(condition, _truth(condition, state)) for condition in effect.conditions]
        if any(known is False for _, known in truths):
            continue
        unknown = [condition for condition, known in truths if known is None]
        for outcome in effect.outcomes:
            if not unknown:
                result.sure[outcome] = None
            else:
                claims = tuple(each for each in unknown if isinstance(each, tuple))
                result.possible[outcome, claims if len(claims) == len(unknown) else ()] = None
    return result


def _truth(condition: Condition, state: Knowledge) -> bool | None:
    if isinstance(condition, bool):
        return condition
    return None if isinstance(condition, Pair) else truth(condition, state)


def _claim(outcome: Assignment) -> GroundClaim:
    assert outcome.value is not None
    return outcome.symbol, outcome.value, True


def forget_what_may_change(draft: Draft, effects: WorldEffects) -> None:
    """The complement of what may have come true is not known any more."""
    for outcome, _ in effects.possible:
        if outcome.value is None:
            draft.forget(outcome.symbol)
        else:
            draft.may_become(outcome.symbol, outcome.value)


def postdict(
    draft: Draft, effects: WorldEffects, before: Knowledge, updated: set[Symbol], changing: set[Symbol]
) -> None:
    """Adds the entries that relate outcomes to the conditions that were not known.

    Args:
        draft: the state after the action's updates.
        effects: what its `when` effects may do.
        before: the state before.
        updated: what the action's updates of Kf change.
        changing: all that the action changes or may change.
    """
    for outcome, claims in effects.possible:
        if outcome.value is None or not claims or outcome.symbol in updated:
            continue
        if any(claim[0] in changing for claim in claims):
            continue
        others = [each for each in _all(effects) if each[0].symbol == outcome.symbol]
        if any(each[0] != outcome for each in others):
            continue  # pulled in several directions
        found, complements = _claim(outcome), [denied(draft.problem, claim) for claim in claims]
        if truth(found, before):
            continue  # it held already
        if len(others) > 1 or truth(found, before) is None:
            draft.add_entry("Kor", frozenset([found, *complements]))
        elif len(claims) == 1:
            draft.add_entry("Kx", frozenset([found, complements[0]]))
        else:
            draft.add_entry("Kor", frozenset([found, *complements]))
            for claim in claims:
                draft.add_entry("Kor", frozenset([denied(draft.problem, found), claim]))


def _all(effects: WorldEffects) -> list[tuple[Assignment, Open]]:
    return [*((outcome, ()) for outcome in effects.sure), *effects.possible]
