"""Effect trees to updates on bits: what add and del mean for each database [DESIGN section 3, PKS]."""

from collections.abc import Iterable, Iterator

from kabo.knowledge.compiler import Binding, Compiler
from kabo.knowledge.facts import Group
from kabo.knowledge.progression import Assignment, Update
from kabo.knowledge.queries import TRUE, Compare, Query, conjunction, negation
from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Comparison,
    Conditional,
    Effect,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Literal,
    Term,
    TermFact,
)

Sensed = Atom | Application


def compile_effects(
    compiler: Compiler, effects: Iterable[Effect], binding: Binding, condition: Query = TRUE
) -> Iterator[Update]:
    """The updates of effects, quantifiers unrolled, each under the conjunction of its conditions."""
    for effect in effects:
        match effect:
            case ForEach(variables=variables, effects=inner):
                for instance in compiler.instances(variables, binding):
                    yield from compile_effects(compiler, inner, instance, condition)
            case Conditional():
                both = conjunction([condition, compiler.query(effect.condition, binding)])
                yield from compile_effects(compiler, effect.updates, binding, both)
            case Change():
                for fact in effect.facts:
                    yield from _change(compiler, effect, fact, binding, condition)
            case _:
                raise TypeError(f"not supported and not refused: {effect!r}")


def compile_sensing(compiler: Compiler, sensed: Sensed, binding: Binding) -> Update:
    """The update of one entry of `sense`: its truth or value will be known at run time."""
    group = group_of(compiler, sensed, binding)
    return Update(group, TRUE, 0, group.entry)


def group_of(compiler: Compiler, thing: Sensed, binding: Binding) -> Group:
    """The bits of an atom or of a function term, its variables bound."""
    names = tuple(_name(compiler, argument, binding) for argument in thing.arguments)
    if isinstance(thing, Atom):
        return compiler.atom(thing.predicate, names)
    if compiler.is_number(thing):
        return compiler.number_term(thing.function, names)
    return compiler.term(thing.function, names)


def _name(compiler: Compiler, term: Term, binding: Binding) -> str:
    return compiler.cases(term, binding)[0][1]


def _change(
    compiler: Compiler, change: Change, fact: Fact, binding: Binding, condition: Query
) -> Iterator[Update]:
    adds = change.operation == "add"
    match fact:
        case FactAll(parts=parts):
            for part in parts:
                yield from _change(compiler, change, part, binding, condition)
        case FactForall(variables=variables, body=body):
            for instance in compiler.instances(variables, binding):
                yield from _change(compiler, change, body, instance, condition)
        case TermFact(term=term):
            yield _entry(group_of(compiler, term, binding), adds, condition)
        case Literal(atom=atom) if change.database == "Kw":
            yield _entry(group_of(compiler, atom, binding), adds, condition)
        case Literal():
            yield _literal(compiler, fact, adds, binding, condition)
        case Comparison():
            yield from _Values(compiler, binding, condition).change(fact, adds)
        case _:
            raise TypeError(f"not supported and not refused: {fact!r}")


def _entry(group: Group, adds: bool, condition: Query) -> Update:
    """An entry of Kw or Kv comes or goes; normal form drops it where the fact is known."""
    entry = group.entry
    return Update(group, condition, 0 if adds else entry, entry if adds else 0)


def _literal(compiler: Compiler, literal: Literal, adds: bool, binding: Binding, condition: Query) -> Update:
    """A literal of Kf: adding removes its complement and the Kw entry, deleting forgets it."""
    names = tuple(_name(compiler, argument, binding) for argument in literal.atom.arguments)
    group = compiler.atom(literal.atom.predicate, names)
    bit = group.true if literal.positive else group.false
    return Update(group, condition, group.mask, bit) if adds else Update(group, condition, bit)


class _Values:
    """Facts `f = v` and `f != v` under one binding and condition."""

    def __init__(self, compiler: Compiler, binding: Binding, condition: Query) -> None:
        self.compiler, self.binding, self.condition = compiler, binding, condition

    def change(self, fact: Comparison, adds: bool) -> Iterator[Update]:
        """The updates of `add` or `del` of the comparison."""
        term, value = fact.left, fact.right
        if not isinstance(term, Application):
            term, value = value, term
        assert isinstance(term, Application)
        if self.compiler.is_number(term):
            yield self._number(term, value, adds)
        elif fact.operator == "!=":
            yield self._unequal(term, value, adds)
        else:
            yield from self._equal(term, value, adds)

    def _equal(self, term: Application, value: Term, adds: bool) -> Iterator[Update]:
        """`f = v`; with a term for v, its value in the state before, and nothing known of f if that is unknown."""
        bits = self.compiler.term(term.function, self._names(term))
        cases = self.compiler.cases(value, self.binding)
        for case, name in cases:
            if name in bits.equal:
                when = conjunction([self.condition, case])
                yield Update(bits, when, *((bits.mask, bits.equal[name]) if adds else (bits.equal[name], 0)))
        if adds and isinstance(value, Application):
            unknown = [negation(case) for case, name in cases if name in bits.equal]
            yield Update(bits, conjunction([self.condition, *unknown]), bits.mask)

    def _unequal(self, term: Application, value: Term, adds: bool) -> Update:
        """`f != v`: what was known to be v is now something else, unknown, and no run-time value is left."""
        bits = self.compiler.term(term.function, self._names(term))
        name = _name(self.compiler, value, self.binding)
        equal, unequal = bits.equal.get(name, 0), bits.unequal.get(name, 0)
        if adds:
            return Update(bits, self.condition, equal | bits.entry if equal else 0, unequal)
        return Update(bits, self.condition, unequal)

    def _number(self, term: Application, value: Term, adds: bool) -> Update:
        bits = self.compiler.number_term(term.function, self._names(term))
        number = self.compiler.number(value, self.binding)
        if adds:
            return Update(bits, self.condition, bits.mask, 0, Assignment(bits, number))
        known = Compare("=", self.compiler.number(term, self.binding), number)
        return Update(bits, conjunction([self.condition, known]), bits.field)

    def _names(self, term: Application) -> tuple[str, ...]:
        return tuple(_name(self.compiler, argument, self.binding) for argument in term.arguments)
