"""The effect of `when C then E` on knowledge, and the conclusions that it allows later [P, postdiction].

If all of C is known to hold, E is known afterwards. If a part of C is known to be false, nothing happens. Otherwise E
may have come true: its complement is forgotten, and entries are added from which C follows once E is found true or false.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import GroundClaim, Symbol, denied
from kabo.verify.knowledge.replay.mutable_knowledge import MutableKnowledge
from kabo.verify.knowledge.replay.states import Knowledge
from kabo.verify.knowledge.updates import Assignment, Condition, UnknownComparison, When

Open = tuple[GroundClaim, ...]  # the unknown conditions; empty if they cannot be written as claims


@dataclass
class WorldEffects:
    """The outcomes of an action's `when` effects: certain ones, and possible ones with their unknown conditions."""

    sure: dict[Assignment, None] = field(default_factory=dict)
    possible: dict[tuple[Assignment, Open], None] = field(default_factory=dict)

    @property
    def symbols(self) -> set[Symbol]:
        """The atoms and terms that may change."""
        return {outcome.symbol for outcome in self.sure} | {outcome.symbol for outcome, _ in self.possible}


def world_effects(effects: Iterable[When], state: Knowledge) -> WorldEffects:
    """The outcomes of `when` effects: certain if all conditions are known to hold in `state`, else possible."""
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
    return None if isinstance(condition, UnknownComparison) else truth(condition, state)


def _claim(outcome: Assignment) -> GroundClaim:
    assert outcome.value is not None
    return outcome.symbol, outcome.value, True


def forget_what_may_change(draft: MutableKnowledge, effects: WorldEffects) -> None:
    """Forgets the complement of every outcome that may have come true."""
    for outcome, _ in effects.possible:
        if outcome.value is None:
            draft.forget(outcome.symbol)
        else:
            draft.may_become(outcome.symbol, outcome.value)


def postdict(
    draft: MutableKnowledge, effects: WorldEffects, before: Knowledge, updated: set[Symbol], changing: set[Symbol]
) -> None:
    """Adds the entries that relate outcomes to the conditions that were not known.

    Args:
        draft: the state after the action's updates.
        effects: the outcomes of its `when` effects.
        before: the state before the action.
        updated: the atoms and terms that the action's updates of Kf change.
        changing: the atoms and terms that the action changes or may change.
    """
    for outcome, claims in effects.possible:
        if outcome.value is None or not claims or outcome.symbol in updated:
            continue
        if any(claim[0] in changing for claim in claims):
            continue
        others = [each for each in _all(effects) if each[0].symbol == outcome.symbol]
        if any(each[0] != outcome for each in others):
            continue  # several effects set different values
        found, complements = _claim(outcome), [denied(draft.problem, claim) for claim in claims]
        if truth(found, before):
            continue  # the outcome held before
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
