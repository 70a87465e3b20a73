"""World effects `when C then E`: an action changes the world whether or not the agent knows C, and its knowledge follows.

If C is known, E is known. If C is not known to be false, E may have come about: knowledge that contradicts E is
forgotten. Since E then reveals C, entries of Kx and Kor are added from which the closure draws *postdictions* [P,
postdiction]: if E is true after and was not before, C held; if E is false after, C did not hold.
"""

from collections.abc import Iterable, Iterator, Sequence

from kabo.knowledge.entries import Entry
from kabo.knowledge.facts import Claim, TermBits
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.grounding.effects import WorldUpdate, compile_effects
from kabo.knowledge.progression import Update
from kabo.knowledge.queries import FALSE, TRUE, AllOf, Query, conjunction, disjunction, negation
from kabo.language import formulas as f


class _Cause:
    """The condition of one world effect."""

    def __init__(self, compiler: Compiler, update: WorldUpdate) -> None:
        conditions = update.effect.conditions
        self.known = conjunction(
            [update.condition, *(compiler.query(f.Know(c), update.binding) for c in conditions)]
        )
        false = disjunction(compiler.query(f.Know(_complement(c)), update.binding) for c in conditions)
        self.possible = conjunction([update.condition, negation(false), negation(self.known)])
        self.claims = _claims(compiler, conditions, update)

    @property
    def reads(self) -> int:
        """The bits on which the condition depends."""
        return self.known.reads | self.possible.reads


def _complement(claim: f.Claim) -> f.Claim:
    if isinstance(claim, f.Literal):
        return f.Literal(claim.atom, not claim.positive)
    return f.Comparison("!=" if claim.operator == "=" else "=", claim.left, claim.right)


def _claims(compiler: Compiler, conditions: Iterable[f.Claim], update: WorldUpdate) -> tuple[Claim, ...] | None:
    """The claims of the conditions; None if one of them is about a number."""
    found = []
    for condition in conditions:
        if isinstance(condition, f.Comparison) and compiler.is_number(condition.left):
            return None
        if _is_static(compiler, condition):
            continue  # static: it is true, or the effect never happens
        claim = compiler.claim(condition, update.binding)
        if isinstance(claim, Claim):
            found.append(claim)
    return tuple(found)


def _is_static(compiler: Compiler, claim: f.Claim) -> bool:
    if isinstance(claim, f.Literal):
        return compiler.is_static(claim.atom.predicate)
    left = claim.left
    return isinstance(left, f.Application) and compiler.is_static(left.function)


def compile_world_effects(
    compiler: Compiler, worlds: Sequence[WorldUpdate], updates: Sequence[Update]
) -> Iterator[Update]:
    """The updates of all world effects of an action.

    `updates` are the action's other updates, which may change the same groups.
    """
    numbers: list[tuple[_Cause, f.Claim, WorldUpdate]] = []
    claimed: dict[tuple[int, int], tuple[_Cause, Claim]] = {}
    for number, world in enumerate(worlds):
        cause = _Cause(compiler, world)
        for outcome in world.effect.outcomes:
            claim = None if _is_number(compiler, outcome) else compiler.claim(outcome, world.binding)
            if isinstance(claim, Claim):
                claimed[number, claim.holds] = cause, claim
            elif claim is None:
                numbers.append((cause, outcome, world))
    for cause, outcome, world in numbers:
        compiler.asked |= cause.reads
        for operation, condition in (("add", cause.known), ("del", cause.possible)):
            change = f.Change(operation, "Kf", (outcome,))  # type: ignore[arg-type]
            yield from _plain(compile_effects(compiler, [change], world.binding, condition))
    pairs = list(claimed.values())
    for cause, claim in pairs:
        yield from _known_outcome(cause, claim, pairs)
        yield from _forgotten(cause, claim)
        others = _Others(cause, claim, pairs, updates)
        if others.untouched_except(claim.group.mask, along=claim) != TRUE:
            compiler.asked |= cause.reads  # more knowledge of it may lead to a contradiction
        if cause.claims:
            yield from _postdiction(compiler, cause, claim, others)


class _Others:
    """The other effects of the action, as far as they touch the groups of one world effect."""

    def __init__(
        self,
        cause: _Cause,
        own: Claim,
        claimed: Sequence[tuple[_Cause, Claim]],
        updates: Sequence[Update],
    ) -> None:
        self._updates = [(update.touch, update.condition) for update in updates if update.touch]
        self._worlds = [(claim, c.known, c.possible) for c, claim in claimed]
        self._rivals = [(claim, c.known, c.possible) for c, claim in claimed if c is not cause or claim != own]

    def untouched_except(self, group: int, along: Claim | None = None) -> Query:
        """The query that no other effect touches the group, except world effects that make the claim `along` true."""
        touching = [condition for touch, condition in self._updates if touch & group]
        for claim, known, possible in self._rivals:
            if claim.group.mask & group and (along is None or claim.holds != along.holds):
                touching += [known, possible]
        return conjunction(negation(condition) for condition in touching)

    def untouched(self, group: int) -> Query:
        """The query that no effect of the action touches the group."""
        touching = [condition for touch, condition in self._updates if touch & group]
        for claim, known, possible in self._worlds:
            if claim.group.mask & group:
                touching += [known, possible]
        return conjunction(negation(condition) for condition in touching)


def _known_outcome(cause: _Cause, claim: Claim, pairs: Sequence[tuple[_Cause, Claim]]) -> Iterator[Update]:
    """The update by which a certain outcome is known, unless another world effect may make something else true there."""
    group = claim.group.mask
    rivals = [c for c, other in pairs if other.group is claim.group and other.holds != claim.holds]
    alone = conjunction([cause.known, *(negation(rival.possible) for rival in rivals)])
    yield Update(alone, group & ~claim.makes, claim.makes, group)
    if rivals:
        yield Update(conjunction([cause.known, disjunction(r.possible for r in rivals)]), group, 0, group)
        certain = disjunction(rival.known for rival in rivals)  # then both are made true, which is a contradiction
        yield Update(conjunction([cause.known, certain]), 0, claim.makes, group)


def _plain(updates: Iterable[Update | WorldUpdate]) -> Iterator[Update]:
    for update in updates:
        assert isinstance(update, Update)
        yield update


def _is_number(compiler: Compiler, claim: f.Claim) -> bool:
    return isinstance(claim, f.Comparison) and compiler.is_number(claim.left)


def _forgotten(cause: _Cause, claim: Claim) -> Iterator[Update]:
    """The updates for an outcome that may have come about: its complement and what was sensed of it are forgotten."""
    group = claim.group
    condition = conjunction([cause.possible, negation(AllOf(claim.holds, claim.holds))])
    if isinstance(group, TermBits):
        value = next(value for value, bit in group.equal.items() if bit == claim.holds)
        for other, equal in group.equal.items():
            if other != value:  # if it was `other`, it is now one of the two
                kept = group.unequal[value] | group.unequal[other]
                was = conjunction([condition, AllOf(equal, equal)])
                yield Update(was, equal | group.settled | group.whether | kept, 0, group.mask)
        unknown = conjunction([condition, AllOf(group.known, 0)])
        yield Update(unknown, claim.fails | group.whether, 0, group.mask)
        return
    yield Update(condition, claim.fails | group.whether, 0, group.mask)


def _postdiction(compiler: Compiler, cause: _Cause, claim: Claim, others: _Others) -> Iterator[Update]:
    """The entries from which the closure infers the cause from the outcome.

    A part of the cause that the action itself changes cannot be inferred afterwards, unless it was known before.
    """
    assert cause.claims is not None
    open_ = conjunction([cause.possible, negation(AllOf(claim.holds, claim.holds))])
    stills = {c.holds: others.untouched(c.group.mask) for c in cause.claims}
    moving = [c for c in cause.claims if stills[c.holds] != TRUE]
    all_still = conjunction(stills.values())
    yield from _entries(compiler, conjunction([open_, all_still]), claim, cause.claims, others)
    staying = tuple(c for c in cause.claims if stills[c.holds] == TRUE)
    if moving and staying:
        known = conjunction([open_, negation(all_still), *(AllOf(c.holds, c.holds) for c in moving)])
        yield from _entries(compiler, known, claim, staying, others)


def _entries(
    compiler: Compiler, condition: Query, claim: Claim, causes: tuple[Claim, ...], others: _Others
) -> Iterator[Update]:
    """The entries that bind the outcome to these parts of its cause, if no other effect makes or prevents it."""
    group = claim.group.mask
    sufficient = conjunction([condition, others.untouched_except(group, along=claim)])
    necessary = conjunction([condition, others.untouched_except(group), AllOf(claim.fails, claim.fails)])
    denials = [c.denied for c in causes]
    if len(denials) == 1:
        if necessary != FALSE:
            yield _add(necessary, compiler.entry(True, [claim, *denials]))
        only = conjunction([sufficient, negation(necessary)])
        if only != FALSE:
            yield _add(only, compiler.entry(False, [claim, *denials]))
        return
    if sufficient != FALSE:
        yield _add(sufficient, compiler.entry(False, [claim, *denials]))
    for one in causes if necessary != FALSE else ():
        yield _add(necessary, compiler.entry(False, [claim.denied, one]))


def _add(condition: Query, entry: Entry) -> Update:
    return Update(condition, entry.mask & ~entry.active, entry.active)
