"""Compiles formula trees into queries on bits: binds variables, unrolls quantifiers, evaluates static knowledge.

`Compiler` maps ground atoms and terms to bits: it allocates the bits on first mention and knows which symbols are
static.
"""

from collections.abc import Callable, Iterable, Iterator
from itertools import product

from kabo.knowledge.binding import Binding, object_of, plain
from kabo.knowledge.entries import Entry
from kabo.knowledge.external import Externals
from kabo.knowledge.facts import AtomBits, BitTable, Claim, NumberBits, TermBits
from kabo.knowledge.grounding.symbols import Symbols
from kabo.knowledge.numbers import Compare, NumberTerm, computed, stored
from kabo.knowledge.queries import (
    FALSE,
    TRUE,
    AllOf,
    AnyOf,
    GeometricTest,
    Query,
    conjunction,
    disjunction,
    negation,
    truth,
)
from kabo.knowledge.runtime import RunTimeValue
from kabo.language.formulas import (
    And,
    Application,
    Arithmetic,
    Atom,
    Comparison,
    Constant,
    Exists,
    External,
    Forall,
    Formula,
    Know,
    KnowValue,
    KnowWhether,
    Literal,
    Not,
    Number,
    Or,
    ProcedureCall,
    Temporal,
    Term,
    Test,
    Truth,
    Variable,
    Xor,
)
from kabo.language.problem import Problem

Case = tuple[Query, str]  # a condition, and the object that the term is known to be under it


class Compiler:
    """Compiles the formulas of one problem; holds the knowledge of symbols that never change."""

    def __init__(self, problem: Problem, symbols: Symbols) -> None:
        self.problem = problem
        self.symbols = symbols
        self.fluents = BitTable()
        self.statics = BitTable()
        self.static = 0
        self.entries: dict[tuple[bool, frozenset[int]], Entry] = {}
        self.inferring = False  # True while update rules are compiled: they change what is known, not the world
        self.asked = 0  # the bits that conditions of effects read
        self._values: dict[str, tuple[str, ...]] = {}
        self._numeric: dict[str, bool] = {}
        self._types: dict[str, tuple[str, ...]] = {}
        self.starting = False  # True while initial knowledge is compiled: its entries may be permanent
        self.temporal: Callable[[Temporal, Binding], Query] | None = None  # compiles a temporal goal

    # ------------------------------------------------------------------------------------------------ formulas
    def query(self, formula: Formula, binding: Binding) -> Query:
        """The query of the formula, with its free variables bound by `binding`."""
        match formula:
            case Truth(value=value):
                return truth(value)
            case Know(claim=Literal() as literal):
                return self._literal(literal, binding)
            case Know(claim=Comparison() as comparison):
                return self._comparison(comparison, binding)
            case KnowWhether(atom=atom):
                return self._each(atom.arguments, binding, lambda names: self._whether(atom, names))
            case KnowValue(term=term):
                return self._each(term.arguments, binding, lambda names: self._value_known(term, names))
            case Test(call=External() as external):
                return self._externals(binding).test(external)
            case Test(call=ProcedureCall() as call):
                return GeometricTest(call.ground(binding))
        return self._compound(formula, binding)

    def _compound(self, formula: Formula, binding: Binding) -> Query:
        match formula:
            case Not(body=body):
                return negation(self.query(body, binding))
            case And(parts=parts):
                return conjunction(self.query(part, binding) for part in parts)
            case Or(parts=parts):
                return disjunction(self.query(part, binding) for part in parts)
            case Xor():
                first, second = self.query(formula.first, binding), self.query(formula.second, binding)
                one = conjunction([first, negation(second)])
                return disjunction([one, conjunction([negation(first), second])])
            case Forall(body=body):
                return conjunction(self.query(body, inner) for inner in self.instances(formula.variables, binding))
            case Exists(body=body):
                return disjunction(self.query(body, inner) for inner in self.instances(formula.variables, binding))
            case Temporal() if self.temporal is not None:
                return self.temporal(formula, binding)
        raise TypeError(f"not supported and not refused: {formula!r}")

    def instances(self, variables: tuple[Variable, ...], binding: Binding) -> Iterator[Binding]:
        """The binding, extended by each combination of objects for the variables, in the order of declaration."""
        names = [variable.name for variable in variables]
        for values in product(*(self.of_type(variable.type) for variable in variables)):
            yield {**binding, **dict(zip(names, values, strict=True))}

    def of_type(self, kind: str) -> tuple[str, ...]:
        """The objects of a type."""
        if kind not in self._types:
            self._types[kind] = self.problem.of_type(kind)
        return self._types[kind]

    # --------------------------------------------------------------------------------------------------- groups
    def is_static(self, symbol: str) -> bool:
        """Whether knowledge about this predicate or function never changes."""
        return symbol not in self.symbols.changing and " " not in symbol

    def is_number(self, term: Term | RunTimeValue) -> bool:
        """Whether the term's value is a number."""
        if isinstance(term, RunTimeValue):
            term = term.term
        if isinstance(term, Application):
            if term.function not in self._numeric:
                plain_name = term.function.rsplit(" ", 1)[-1]
                self._numeric[term.function] = self.problem.values_of(plain_name) is None
            return self._numeric[term.function]
        if isinstance(term, External):
            return self.problem.domain.procedures[term.procedure].is_number
        return isinstance(term, Number | Arithmetic)

    def atom(self, name: str, arguments: tuple[str, ...]) -> AtomBits:
        """The bits of a ground atom."""
        return self._home(name).atom(name, arguments)

    def term(self, name: str, arguments: tuple[str, ...]) -> TermBits:
        """The bits of a ground term with a finite range."""
        plain_name = name.rsplit(" ", 1)[-1]  # copies for temporal goals are named "initially f"
        if plain_name not in self._values:
            self._values[plain_name] = self.problem.values_of(plain_name) or ()
        values = self._values[plain_name]
        return self._home(name).term(name, arguments, values, plain_name in self.symbols.excludable)

    def number_term(self, name: str, arguments: tuple[str, ...]) -> NumberBits:
        """The bits of a ground term whose value is a number."""
        return self._home(name).number(name, arguments)

    def _home(self, name: str) -> BitTable:
        return self.statics if self.is_static(name) else self.fluents

    def _settled(self, symbol: str, query: Query) -> Query:
        """The query; a constant if its symbol is static."""
        return truth(query.holds(self.static)) if self.is_static(symbol) else query

    # --------------------------------------------------------------------------------------------------- claims
    def _each(
        self, arguments: tuple[Term, ...], binding: Binding, ask: Callable[[tuple[str, ...]], Query]
    ) -> Query:
        """The query `ask(objects)` for whatever objects the arguments are known to be."""
        if all(isinstance(argument, Variable | Constant) for argument in arguments):
            return ask(tuple([object_of(argument, binding) for argument in arguments]))  # type: ignore[arg-type]
        return disjunction(
            conjunction([condition, ask(names)]) for condition, names in self.argument_cases(arguments, binding)
        )

    def argument_cases(
        self, arguments: tuple[Term, ...], binding: Binding
    ) -> Iterator[tuple[Query, tuple[str, ...]]]:
        """Pairs of a condition and a tuple of objects that the terms are known to be where it holds."""
        for combination in product(*(self.cases(argument, binding) for argument in arguments)):
            condition = conjunction(case[0] for case in combination)
            if condition != FALSE:
                yield condition, tuple(case[1] for case in combination)

    def cases(self, term: Term, binding: Binding) -> list[Case]:
        """Pairs of a condition and an object: where the condition holds, the term is known to be this object."""
        match term:
            case Constant(name=name):
                return [(TRUE, name)]
            case Variable(name=name):
                return [(TRUE, binding[name])]
            case RunTimeValue():
                return self.cases(term.term, binding)
            case Application(function=function):
                return [
                    (conjunction([condition, self._settled(function, AllOf(bit, bit))]), value)
                    for condition, names in self.argument_cases(term.arguments, binding)
                    for value, bit in self.term(function, names).equal.items()
                ]
            case External():
                return list(self._externals(binding).cases(term))
        raise TypeError(f"not an object term: {term!r}")

    def _externals(self, binding: Binding) -> Externals:
        return Externals(
            self.problem,
            lambda arguments: self.argument_cases(arguments, binding),
            lambda term: self.number(term, binding),
        )

    def _literal(self, literal: Literal, binding: Binding) -> Query:
        def ask(names: tuple[str, ...]) -> Query:
            group = self.atom(literal.atom.predicate, names)
            bit = group.true if literal.positive else group.false
            return self._settled(literal.atom.predicate, AllOf(bit, bit))

        return self._each(literal.atom.arguments, binding, ask)

    def _whether(self, atom: Atom, names: tuple[str, ...]) -> Query:
        bit = self.atom(atom.predicate, names).whether
        return self._settled(atom.predicate, AllOf(bit, bit))

    def _value_known(self, term: Application, names: tuple[str, ...]) -> Query:
        bits = self.number_term(term.function, names) if self.is_number(term) else self.term(term.function, names)
        return self._settled(term.function, AllOf(bits.whether, bits.whether))

    def _comparison(self, claim: Comparison, binding: Binding) -> Query:
        if plain(claim.left) == plain(claim.right) and claim.operator in ("=", "!="):
            return truth(claim.operator == "=")
        if isinstance(claim.left, Variable | Constant) and isinstance(claim.right, Variable | Constant):
            same = object_of(claim.left, binding) == object_of(claim.right, binding)
            return truth(same == (claim.operator == "="))
        if self.is_number(claim.left) or self.is_number(claim.right):
            left, right = self.number(claim.left, binding), self.number(claim.right, binding)
            query = Compare(claim.operator, left, right)
            return query if query.reads or query.has_tests else truth(query.holds(0))
        if claim.operator == "=":
            return self._equal(claim.left, claim.right, binding)
        return self._different(claim.left, claim.right, binding)

    def _equal(self, left: Term, right: Term, binding: Binding) -> Query:
        """K(left = right), which holds if both are known to be the same object."""
        for one, other in ((left, right), (right, left)):
            if isinstance(one, Application) and isinstance(other, Variable | Constant):
                return self._has_value(one, object_of(other, binding), binding)
        return disjunction(
            conjunction([one, other])
            for one, name in self.cases(left, binding)
            for other, same in self.cases(right, binding)
            if name == same
        )

    def _has_value(self, term: Application, value: str, binding: Binding) -> Query:
        """K(term = value) for one object."""

        def ask(names: tuple[str, ...]) -> Query:
            bit = self.term(term.function, names).equal.get(value)
            return FALSE if bit is None else self._settled(term.function, AllOf(bit, bit))

        return self._each(term.arguments, binding, ask)

    def _different(self, left: Term, right: Term, binding: Binding) -> Query:
        """K(left != right), which holds if one is known and the other is known not to be that object."""
        known_left = [
            conjunction([condition, self._is_not(right, name, binding)])
            for condition, name in self.cases(left, binding)
        ]
        known_right = [
            conjunction([condition, self._is_not(left, name, binding)])
            for condition, name in self.cases(right, binding)
        ]
        return disjunction([*known_left, *known_right])

    def _is_not(self, term: Term, name: str, binding: Binding) -> Query:
        """K(term != name)."""
        term = plain(term)
        if isinstance(term, External):
            return disjunction(condition for condition, answer in self.cases(term, binding) if answer != name)
        if not isinstance(term, Application):
            return truth(self.cases(term, binding)[0][1] != name)

        def ask(names: tuple[str, ...]) -> Query:
            bits = self.term(term.function, names)
            if name not in bits.equal:
                return TRUE
            excluded = bits.unequal.get(name)
            others = AnyOf(bits.known & ~bits.equal[name])
            return self._settled(term.function, others if excluded is None else AllOf(excluded, excluded))

        return self._each(term.arguments, binding, ask)

    # ------------------------------------------------------------------------------------- claims and entries
    def claim(self, claim: Literal | Comparison, binding: Binding) -> Claim | bool:
        """The claim that a ground literal or comparison makes.

        It is True or False if the comparison holds always or never, for example since the term cannot have this
        value.
        """
        if isinstance(claim, Literal):
            names = tuple(self.cases(argument, binding)[0][1] for argument in claim.atom.arguments)
            return self.atom(claim.atom.predicate, names).claim(claim.positive)
        term, value = plain(claim.left), claim.right
        assert isinstance(term, Application)
        if plain(value) == term:
            return claim.operator == "="
        name = self.cases(value, binding)[0][1]
        bits = self.term(term.function, tuple(self.cases(a, binding)[0][1] for a in term.arguments))
        if name not in bits.equal:
            return claim.operator == "!="
        return bits.claim(name, claim.operator == "=")

    def entry(self, exactly: bool, members: Iterable[Claim], *, given: bool = False) -> Entry:
        """The entry of Kx or Kor with these members; always the same object for the same members.

        An entry that is `given` in the initial knowledge is permanent if no action can change its members.
        """
        members = tuple(dict.fromkeys(members))
        key = exactly, frozenset(member.holds for member in members)
        found = self.entries.get(key)
        if found is None:
            written = self.symbols.written
            if given and not any(self.fluents.key_of(member.group)[0] in written for member in members):
                found = Entry(exactly, members)
            else:
                found = Entry(exactly, members, self.fluents.bit(), tuple(self.fluents.bit() for _ in members))
            self.entries[key] = found
        return found

    # -------------------------------------------------------------------------------------------------- numbers
    def number(self, term: Term, binding: Binding) -> NumberTerm:
        """The number term, compiled to a function that reads its value from a state."""
        match plain(term):
            case Number(value=value):
                return NumberTerm(0, lambda _state: value)
            case Arithmetic() as sum_:
                return computed(sum_.operator, self.number(sum_.left, binding), self.number(sum_.right, binding))
            case Application(function=function) as applied:
                choices = [
                    (condition, self.number_term(function, names))
                    for condition, names in self.argument_cases(applied.arguments, binding)
                ]
                return stored(choices, self.static if self.is_static(function) else None)
            case External() as external:
                return self._externals(binding).number(external)
        raise TypeError(f"not a number: {term!r}")
