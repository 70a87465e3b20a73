"""Compiles effect trees into updates on bits: defines add and del for each database.

Source: docs/explanation/knowledge.md, PKS.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from kabo.knowledge.binding import Binding, plain
from kabo.knowledge.facts import AtomBits, Claim, Group, NumberBits, TermBits
from kabo.knowledge.grounding.compiler import Compiler
from kabo.knowledge.numbers import Compare
from kabo.knowledge.progression import Assignment, Update
from kabo.knowledge.queries import TRUE, AllOf, Query, conjunction, disjunction, negation
from kabo.knowledge.runtime import RunTimeValue
from kabo.language import spell_bound
from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    External,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Literal,
    Term,
    TermFact,
    WorldEffect,
)

Sensed = Atom | Application


@dataclass(frozen=True)
class WorldUpdate:
    """A ground world effect `when C then E`, the condition around it, and the binding of its variables."""

    condition: Query
    effect: WorldEffect
    binding: Binding


def compile_effects(
    compiler: Compiler, effects: Iterable[Effect], binding: Binding, condition: Query = TRUE
) -> Iterator[Update | WorldUpdate]:
    """The updates of the effects, quantifiers unrolled; each has the conjunction of all conditions around it."""
    for effect in effects:
        match effect:
            case ForEach(variables=variables, effects=inner):
                for instance in compiler.instances(variables, binding):
                    yield from compile_effects(compiler, inner, instance, condition)
            case Conditional():
                asked = compiler.query(effect.condition, binding)
                compiler.asked |= asked.reads
                both = conjunction([condition, asked])
                yield from compile_effects(compiler, effect.updates, binding, both)
            case Change():
                yield from _Databases(compiler, binding, condition).change(effect)
            case WorldEffect():
                yield WorldUpdate(condition, effect, binding)


def compile_sensing(compiler: Compiler, sensed: Sensed, binding: Binding) -> Update:
    """The update for one entry of `sense`: the truth or value of the entry will be known at run time."""
    group = group_of(compiler, sensed, binding)
    return Update(TRUE, 0, group.whether, entry=group)


def group_of(compiler: Compiler, thing: Sensed, binding: Binding) -> Group:
    """The bits of an atom or of a function term with its variables bound."""
    names = tuple(_name(compiler, argument, binding) for argument in thing.arguments)
    if isinstance(thing, Atom):
        return compiler.atom(thing.predicate, names)
    if compiler.is_number(thing):
        return compiler.number_term(thing.function, names)
    return compiler.term(thing.function, names)


def _name(compiler: Compiler, term: Term, binding: Binding) -> str:
    return compiler.cases(term, binding)[0][1]


class _Databases:
    """Compiles one `add` or `del` under a binding and a condition."""

    def __init__(self, compiler: Compiler, binding: Binding, condition: Query) -> None:
        self.compiler, self.binding, self.condition = compiler, binding, condition

    def change(self, change: Change) -> Iterator[Update]:
        """The updates of the change."""
        adds = change.operation == "add"
        if change.database in ("Kx", "Kor"):
            members = [claim for fact in change.facts for claim in self._members(fact)]
            given = self.compiler.starting and self.condition == TRUE
            yield self._entry(change.database == "Kx", members, adds, given)
            return
        for fact in change.facts:
            if change.database == "Kf":
                yield from self._known(fact, adds)
            elif change.database == "LCW":
                yield from self._local_closed_world(fact, adds)
            else:
                yield self._at_run_time(fact, adds)

    def inside(self, binding: Binding) -> "_Databases":
        """A compiler with the same condition under another binding."""
        return _Databases(self.compiler, binding, self.condition)

    # ------------------------------------------------------------------------------------------------------ Kf
    def _known(self, fact: Fact, adds: bool) -> Iterator[Update]:
        match fact:
            case FactAll(parts=parts):
                for part in parts:
                    yield from self._known(part, adds)
            case FactForall(variables=variables, body=body):
                for instance in self.compiler.instances(variables, self.binding):
                    yield from self.inside(instance)._known(body, adds)
            case Literal():
                claim = self.compiler.claim(fact, self.binding)
                assert isinstance(claim, Claim)
                yield from self._learned(claim, adds)
            case Comparison():
                yield from self._value(fact, adds)

    def _learned(self, claim: Claim, adds: bool) -> Iterator[Update]:
        """Adding a claim forgets its complement and its open Kw or Kv; deleting forgets it, and removes its entries."""
        mask = claim.group.mask
        assert isinstance(claim.group, AtomBits)
        if adds:
            yield self._world(claim.group, self.condition, mask & ~claim.makes, claim.makes)
            return
        known = conjunction([self.condition, AllOf(claim.holds, claim.holds)])
        yield self._world(claim.group, known, mask)
        yield self._uncertain(claim.group)

    def _uncertain(self, group: AtomBits | TermBits) -> Update:
        """The update that removes an open Kw or Kv: the world may have changed since it was sensed."""
        known = group.known if isinstance(group, AtomBits) else group.settled
        unknown = conjunction([self.condition, AllOf(known, 0)])
        return self._world(group, unknown, 0 if self.compiler.inferring else group.whether)

    def _world(self, group: Group, condition: Query, clear: int, make: int = 0) -> Update:
        """An update of one group because the world changes there."""
        return Update(condition, clear, make, group.mask, static=group not in self.compiler.fluents)

    def _value(self, fact: Comparison, adds: bool) -> Iterator[Update]:
        term, value = (fact.left, fact.right) if isinstance(fact.left, Application) else (fact.right, fact.left)
        assert isinstance(term, Application)
        if self.compiler.is_number(term):
            yield self._number(term, value, adds)
        elif fact.operator == "!=":
            yield from self._unequal(term, value, adds)
        else:
            yield from self._equal(term, value, adds)

    def _equal(self, term: Application, value: Term, adds: bool) -> Iterator[Update]:
        """`f = v`, where a term v has its value in the state before; if that is unknown, f is unknown."""
        bits = self._term(term)
        cases = [case for case in self.compiler.cases(value, self.binding) if case[1] in bits.equal]
        for case, name in cases:
            made = bits.learned(name)
            if adds:
                yield self._world(bits, conjunction([self.condition, case]), bits.mask & ~made, made)
            else:
                known = conjunction([self.condition, case, AllOf(bits.equal[name], bits.equal[name])])
                yield self._world(bits, known, bits.mask)
        if not adds:
            yield self._uncertain(bits)
        if adds and isinstance(value, Application | External | RunTimeValue):
            unknown = conjunction([self.condition, *(negation(case) for case, _ in cases)])
            later = bits.whether if isinstance(value, RunTimeValue) else 0
            yield self._world(bits, unknown, bits.mask & ~later, later)

    def _unequal(self, term: Application, value: Term, adds: bool) -> Iterator[Update]:
        """`f != v`: if f was known to be v it is now unknown, and no run-time value of f is left."""
        bits = self._term(term)
        name = _name(self.compiler, value, self.binding)
        if name not in bits.equal:
            return
        equal, unequal = bits.equal[name], bits.unequal[name]
        if adds:
            was = conjunction([self.condition, AllOf(equal, equal)])
            yield self._world(bits, was, bits.mask & ~unequal, unequal)
            not_known = conjunction([self.condition, AllOf(unequal | bits.known, 0)])
            stale = 0 if self.compiler.inferring else bits.whether
            yield self._world(bits, not_known, stale, unequal)
        else:
            unknown = conjunction([self.condition, AllOf(bits.known | unequal, unequal)])
            yield self._world(bits, unknown, unequal)
            yield self._uncertain(bits)

    def _number(self, term: Application, value: Term, adds: bool) -> Update:
        bits = self._number_bits(term)
        number = self.compiler.number(value, self.binding)
        if adds:
            later = isinstance(value, RunTimeValue)
            return replace(
                self._world(bits, self.condition, bits.mask), assignment=Assignment(bits, number, later)
            )
        known = Compare("=", self.compiler.number(term, self.binding), number)
        return self._world(bits, conjunction([self.condition, known]), bits.mask)

    # ------------------------------------------------------------------------------------------------- Kw and Kv
    def _at_run_time(self, fact: Fact, adds: bool) -> Update:
        """Adds or removes an entry of Kw or Kv; no knowledge is forgotten."""
        if isinstance(fact, FactAll | FactForall):
            return self._conjunction(fact, adds)
        thing = fact.term if isinstance(fact, TermFact) else fact.atom  # type: ignore[union-attr]
        group = group_of(self.compiler, thing, self.binding)
        if adds:
            return Update(self.condition, 0, group.whether, entry=group)
        known = group.settled if isinstance(group, TermBits) else group.known
        return Update(conjunction([self.condition, AllOf(known, 0)]), group.whether)

    def _conjunction(self, fact: Fact, adds: bool) -> Update:
        pairs = list(self._conjuncts(fact))
        text = " and ".join(spell_bound(literal, binding) for literal, binding in pairs)
        claims = tuple(self._claim(literal, binding) for literal, binding in pairs)
        group = self.compiler.fluents.conjunction(text, claims)
        if not adds:
            return Update(self.condition, group.whether)
        known = conjunction(AllOf(claim.holds, claim.holds) for claim in claims)
        false = disjunction(AllOf(claim.fails, claim.fails) for claim in claims)
        open_ = conjunction([self.condition, negation(known), negation(false)])
        self.compiler.entry(False, [claim.denied for claim in claims])  # the inference if it turns out to be false
        return Update(open_, 0, group.whether, entry=group)

    def _conjuncts(self, fact: Fact) -> Iterator[tuple[Literal | Comparison, Binding]]:
        match fact:
            case FactAll(parts=parts):
                for part in parts:
                    yield from self._conjuncts(part)
            case FactForall(variables=variables, body=body):
                for instance in self.compiler.instances(variables, self.binding):
                    yield from self.inside(instance)._conjuncts(body)
            case Literal() | Comparison():
                yield fact, self.binding

    # ---------------------------------------------------------------------------------------- Kx, Kor and LCW
    def _members(self, fact: Fact) -> Iterator[Claim]:
        if isinstance(fact, ExactlyOne):
            for instance in self.compiler.instances(fact.variables, self.binding):
                yield from self.inside(instance)._members(fact.body)
        else:
            assert isinstance(fact, Literal | Comparison)
            yield self._claim(fact, self.binding)

    def _entry(self, exactly: bool, members: list[Claim], adds: bool, given: bool = False) -> Update:
        entry = self.compiler.entry(exactly, members, given=given)
        outs = entry.mask & ~entry.active
        if adds:
            return Update(self.condition, outs, entry.active)
        return Update(self.condition, entry.mask)

    def _local_closed_world(self, fact: Fact, adds: bool) -> Iterator[Update]:
        """LCW: all true instances are known, so of every other instance some literal is false."""
        if isinstance(fact, FactForall):
            for instance in self.compiler.instances(fact.variables, self.binding):
                yield from self.inside(instance)._local_closed_world(fact.body, adds)
            return
        claims = [self._claim(literal, binding) for literal, binding in self._conjuncts(fact)]
        denials = [claim.denied for claim in claims]
        unknown = negation(conjunction(AllOf(claim.holds, claim.holds) for claim in claims))
        condition = conjunction([self.condition, unknown])
        if len(claims) > 1:
            inner = _Databases(self.compiler, self.binding, condition if adds else self.condition)
            yield inner._entry(False, denials, adds)
        elif adds:
            yield Update(condition, claims[0].group.mask & ~denials[0].makes, denials[0].makes)

    def _claim(self, literal: Literal | Comparison, binding: Binding) -> Claim:
        claim = self.compiler.claim(literal, binding)
        assert isinstance(claim, Claim), "the language has checked the values of functions"
        return claim

    def _term(self, term: Application) -> TermBits:
        return self.compiler.term(term.function, self._names(term))

    def _number_bits(self, term: Application) -> NumberBits:
        return self.compiler.number_term(term.function, self._names(term))

    def _names(self, term: Application) -> tuple[str, ...]:
        return tuple(_name(self.compiler, argument, self.binding) for argument in plain(term).arguments)  # type: ignore[union-attr]
