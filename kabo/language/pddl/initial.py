"""Translates PDDL's initial states into initial knowledge: atoms that are not mentioned are known to be false.

The initial knowledge is built by updates in this order: all instances of every predicate become known to be false;
the atoms in `unknown`, `oneof` and `or` become unknown; true facts and values are added; last come the
disjunctions that exactly one (`oneof`) or at least one (`or`) of several unknown atoms holds.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Literal

from kabo.language import formulas as f
from kabo.language.pddl.conditions import read_condition
from kabo.language.pddl.dialect import read_term
from kabo.language.pddl.forms import Form, Node
from kabo.language.resolver import NameResolver, one_of
from kabo.language.types import NUMBERS
from kabo.language.vocabulary import Symbol, Vocabulary

_FACTS_AT_ONCE = 100
_MOST_CLAUSES = 1000
_LETTERS = "xyzuvwabcdefgh"


@dataclass
class Initial:
    """An initial state of a PDDL file; atoms in the order of their first mention."""

    facts: dict[f.Atom, f.Literal] = field(default_factory=dict)
    values: dict[f.Application, f.Comparison] = field(default_factory=dict)
    unknown: dict[f.Atom, f.Literal] = field(default_factory=dict)
    exactly_one: list[f.Change] = field(default_factory=list)
    at_least_one: list[f.Change] = field(default_factory=list)

    def unknown_symbols(self) -> set[str]:
        """The predicates with an atom that is unknown in the initial state."""
        return {atom.predicate for atom in self.unknown}


def read_initial(here: NameResolver, section: Form | None) -> Initial:
    """Reads the initial state from `(:init …)`, which contains a list of facts, or one `(and …)`."""
    initial = Initial()
    members: list[f.Literal] = []
    for node in [] if section is None else section.rest:
        _read_entry(here, initial, node, members)
    for literal in members:
        if literal.atom not in initial.facts:
            initial.unknown.setdefault(literal.atom, literal)
    for atom, literal in initial.unknown.items():
        if atom in initial.facts and literal.place is not None:
            truth = "true" if initial.facts[atom].positive else "false"
            message = f"this atom is said to be unknown, and to be {truth}"
            here.findings.add(literal.place, message, _other(initial.facts[atom]))
    return initial


def _read_entry(here: NameResolver, initial: Initial, node: Node, members: list[f.Literal]) -> None:
    head = node.head if isinstance(node, Form) else ""
    if isinstance(node, Form) and not here.vocabulary.is_predicate(head):
        if head == "and" or not node.items:
            for part in node.rest:
                _read_entry(here, initial, part, members)
            return
        read = {"oneof": _oneof, "or": _or, "imply": _or, "unknown": _unknown, "=": _value}.get(head)
        if read is not None:
            read(here, initial, node, members)
            return
        if head == "not" and len(node.items) == 2 and _head(node.items[1]) in ("and", "or", "imply", "not"):
            _or(here, initial, node, members)
            return
        if head in ("forall", "exists", "when", "<", ">", "<=", ">=", "probabilistic"):
            here.report(node, f'"{head}" is not supported {here.where}')
            return
    if head == "at" and isinstance(node, Form) and len(node.items) == 3 and isinstance(node.items[2], Form):
        here.report(node, f"a fact at a later time (at t …) is not supported {here.where}")
        return
    literal = _literal(here, node)
    if literal is not None:
        _add_fact(here, initial, node, literal)


def _head(node: Node) -> str:
    return node.head if isinstance(node, Form) else ""


def _literal(here: NameResolver, node: Node) -> f.Literal | None:
    """A ground literal."""
    formula = read_condition(here, node)
    if formula is None:
        return None
    if isinstance(formula, f.Know) and isinstance(formula.claim, f.Literal):
        arguments = formula.claim.atom.arguments
        if all(isinstance(argument, f.Constant) for argument in arguments):
            return formula.claim
        here.report(node, f"only objects may be arguments {here.where}")
        return None
    here.report(node, f'unexpected "{here.quote(node)}" {here.where}, expected an atom')
    return None


def _add_fact(here: NameResolver, initial: Initial, node: Node, literal: f.Literal) -> None:
    earlier = initial.facts.setdefault(literal.atom, literal)
    if earlier.positive != literal.positive:
        here.report(node, f'"{here.quote(node)}" contradicts what stands before', _other(earlier))


def _other(earlier: f.Claim) -> str | None:
    """The remedy for two facts that contradict each other, with the place of the earlier one."""
    place = earlier.place
    return None if place is None else f"remove this one, or the one at {place.file}:{place.line}:{place.column}"


def _unknown(here: NameResolver, initial: Initial, form: Form, members: list[f.Literal]) -> None:
    if len(form.items) < 2:
        here.report(form, 'expected "(unknown (p …))"')
    for node in form.rest:
        literal = _literal(here, node)
        if literal is not None:
            initial.unknown.setdefault(literal.atom, literal)


def _oneof(here: NameResolver, initial: Initial, form: Form, members: list[f.Literal]) -> None:
    conjunctions: list[list[f.Literal]] = []
    for node in form.rest:
        both = _head(node) == "and" and not here.vocabulary.is_predicate("and")
        if _head(node) in ("or", "oneof", "imply") and not here.vocabulary.is_predicate(_head(node)):
            here.report(node, f'"{_head(node)}" inside of (oneof …) is not supported {here.where}')
            return
        literals = [_literal(here, part) for part in (node.rest if both and isinstance(node, Form) else [node])]
        whole = list(dict.fromkeys(literal for literal in literals if literal is not None))
        if None in literals or not whole:
            return
        if whole not in conjunctions:
            conjunctions.append(whole)
    if not conjunctions:
        here.report(form, f"(oneof) has no members {here.where}")
    elif len(conjunctions) == 1:
        for literal in conjunctions[0]:
            _add_fact(here, initial, form, literal)
    else:
        whole = [_case(here, initial, form, each, members) for each in conjunctions]
        members += whole
        initial.exactly_one.append(f.Change("add", "Kx", tuple(whole), here.place(form)))


def _case(
    here: NameResolver, initial: Initial, form: Form, parts: list[f.Literal], members: list[f.Literal]
) -> f.Literal:
    """A literal that holds where all of the parts do: the only one, or an atom of its own, tied to them by clauses."""
    if len(parts) == 1:
        return parts[0]
    vocabulary, place = here.vocabulary, here.place(form)
    name = f"case-{1 + sum(each.startswith('case-') for each in vocabulary.written('predicate'))}"
    symbol = Symbol("predicate", vocabulary.names.take(name), place, original=name)
    vocabulary.symbols[name] = symbol
    case = f.Literal(f.Atom(symbol.name, (), place), True, place)
    opposites = [replace(part, positive=not part.positive) for part in parts]
    clauses = [(replace(case, positive=False), part) for part in parts]
    for clause in [*clauses, (case, *opposites)]:
        members.extend(clause)
        initial.at_least_one.append(f.Change("add", "Kor", tuple(clause), place))
    return case


def _or(here: NameResolver, initial: Initial, form: Form, members: list[f.Literal]) -> None:
    formula = read_condition(here, form)
    if formula is None:
        return
    place = here.place(form)
    try:
        clauses = list(_clauses(formula))
    except _TooMany:
        here.report(form, f"this disjunction has more than {_MOST_CLAUSES} clauses {here.where}")
        return
    except _NoClause as error:
        here.report(form, f"{error} inside of a disjunction is not supported {here.where}")
        return
    for clause in clauses:
        literals = tuple(dict.fromkeys(clause))
        if any(replace(each, positive=not each.positive) in literals for each in literals):
            continue  # always true
        if len(literals) == 1:
            _add_fact(here, initial, form, literals[0])
        else:
            members.extend(literals)
            initial.at_least_one.append(f.Change("add", "Kor", literals, place))


class _TooMany(Exception):
    """The conjunctive normal form is too large."""


class _NoClause(Exception):
    """Raised for what is no disjunction of ground literals; carries its name."""


def _clauses(formula: f.Formula) -> list[tuple[f.Literal, ...]]:
    """The conjunctive normal form of a formula in which K stands for plain truth."""
    if isinstance(formula, f.Know) and isinstance(formula.claim, f.Literal):
        if not all(isinstance(argument, f.Constant) for argument in formula.claim.atom.arguments):
            raise _NoClause("an atom of what is no object")
        return [(formula.claim,)]
    if isinstance(formula, f.And):
        return [clause for part in formula.parts for clause in _clauses(part)]
    if isinstance(formula, f.Truth):
        return [] if formula.value else [()]
    if not isinstance(formula, f.Or):
        raise _NoClause("a comparison" if isinstance(formula, f.Know) else "a quantifier")
    sides = [_clauses(part) for part in formula.parts]
    count = 1
    for side in sides:
        count *= len(side)
    if count > _MOST_CLAUSES:
        raise _TooMany
    return [tuple(literal for clause in combination for literal in clause) for combination in product(*sides)]


def _value(here: NameResolver, initial: Initial, form: Form, members: list[f.Literal]) -> None:
    """`(= (f a) 3)` or `(= (f a) b)`."""
    if len(form.items) != 3:
        here.report(form, f'"=" compares two things, not {len(form.items) - 1}')
        return
    left, right = read_term(here, form.items[1]), read_term(here, form.items[2])
    if left is None or right is None:
        return
    term, value = left[0], right[0]
    ground = isinstance(term, f.Application) and all(isinstance(each, f.Constant) for each in term.arguments)
    if not (ground and isinstance(term, f.Application) and isinstance(value, f.Constant | f.Number)):
        here.report(form, f'expected "(= (function object …) value)" {here.where}')
    elif NUMBERS not in (left[1], right[1]) and not here.vocabulary.types.fits(right[1], left[1]):
        here.report(form.items[2], f"the value must be of type {one_of(left[1])}")
    elif NUMBERS in (left[1], right[1]) and left[1] != right[1]:
        here.report(form.items[2], "a number is compared with an object")
    else:
        known = f.Comparison("=", term, value, here.place(form))
        earlier = initial.values.setdefault(term, known)
        if earlier != known:
            message = f'"{here.quote(form)}" contradicts what stands before'
            here.report(form, message, _other(earlier))


# -------------------------------------------------------------------------------------------------------- building
def build_initial(vocabulary: Vocabulary, initial: Initial, left_out: str | None) -> tuple[f.Effect, ...]:
    """The updates that make the initial knowledge, in order; values of the function `left_out` are omitted."""
    effects: list[f.Effect] = [_all_false(vocabulary, each) for each in vocabulary.all_of("predicate")]
    forgotten = [f.Literal(atom, False, literal.place) for atom, literal in initial.unknown.items()]
    effects += _together("del", forgotten)
    effects += _together("add", [each for each in initial.facts.values() if each.positive])
    values = [each for term, each in initial.values.items() if term.function != left_out]
    effects += _together("add", values)
    return (*effects, *initial.exactly_one, *initial.at_least_one)


def _all_false(vocabulary: Vocabulary, symbol: Symbol) -> f.Effect:
    variables: list[f.Variable] = []
    for number, kind in enumerate(symbol.arguments):
        letter = _LETTERS[number % len(_LETTERS)]
        name = vocabulary.names.free(letter, [variable.name for variable in variables])
        variables.append(f.Variable(name, vocabulary.types.common(kind), symbol.place))
    atom = f.Atom(symbol.name, tuple(variables), symbol.place)
    change = f.Change("add", "Kf", (f.Literal(atom, False, symbol.place),), symbol.place)
    return f.ForEach(tuple(variables), (change,), symbol.place) if variables else change


def _together(operation: Literal["add", "del"], facts: Sequence[f.Claim]) -> Iterator[f.Change]:
    """The facts in a few updates, so that a large initial state is not a long list of small steps."""
    for start in range(0, len(facts), _FACTS_AT_ONCE):
        some = tuple(facts[start : start + _FACTS_AT_ONCE])
        yield f.Change(operation, "Kf", some, some[0].place)
