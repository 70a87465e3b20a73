"""Merges several states of knowledge into one that knows only what all of them know.

A plan of thousands of nodes reaches each of them in dozens of states. Where more knowledge never hurts, a plan that works
for the merged state works for all of them, since they know more: every condition still holds, no further outcome becomes
possible, and the goal is reached. If the plan fails for the merged state, nothing follows: then the states must be
examined one by one.
"""

from collections.abc import Iterable, Iterator
from collections.abc import Set as AbstractSet

from kabo.language.formulas import (
    And,
    Change,
    Comparison,
    Constant,
    Effect,
    Exists,
    Fact,
    FactAll,
    FactForall,
    Forall,
    ForEach,
    Formula,
    Literal,
    Not,
    Number,
    Or,
    Temporal,
    Term,
    TermFact,
    Variable,
    Xor,
)
from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import truth
from kabo.verify.knowledge.ground import Entry, Symbol, Value, range_of
from kabo.verify.knowledge.replay.states import Knowledge, mentioning


# -------------------------------------------------------------------------------------------- more never hurts
def more_never_hurts(problem: Problem) -> bool:
    """Whether a plan that works with some knowledge also works with more.

    True if conditions only require that something is known, never that it is unknown, and the effects of actions do not
    depend on what is known. False if some effect could contradict what is known.
    """
    domain = problem.domain
    if domain.update_rules or not all(map(_is_positive, problem.goal)):
        return False
    return all(
        all(parameter.value_of is None for parameter in action.parameters)
        and all(map(_is_positive, action.preconditions))
        and all(map(_is_certain, action.effects))
        for action in domain.actions.values()
    )


def _is_positive(formula: Formula) -> bool:
    """Whether more knowledge never makes the formula false."""
    match formula:
        case And(parts=parts) | Or(parts=parts):
            return all(map(_is_positive, parts))
        case Forall(body=body) | Exists(body=body):
            return _is_positive(body)
    return not isinstance(formula, Not | Xor | Temporal)


def _is_certain(effect: Effect) -> bool:
    """Whether the effect adds and deletes the same literals, or the same run-time knowledge, in every state."""
    if isinstance(effect, ForEach):
        return all(map(_is_certain, effect.effects))
    return (
        isinstance(effect, Change) and effect.database in ("Kf", "Kw", "Kv") and all(map(_is_plain, effect.facts))
    )


def _is_plain(fact: Fact) -> bool:
    match fact:
        case FactAll(parts=parts):
            return all(map(_is_plain, parts))
        case FactForall(body=body):
            return _is_plain(body)
        case Literal(atom=atom):
            return _are_names(atom.arguments)
        case TermFact(term=term):
            return _are_names(term.arguments)
        case Comparison(operator="=", left=left, right=right):
            return _are_names(getattr(left, "arguments", ())) and _are_names([right])
    return False


def _are_names(terms: Iterable[Term]) -> bool:
    return all(isinstance(term, Variable | Constant | Number) for term in terms)


# ---------------------------------------------------------------------------------------------------- one state
def meet(one: Knowledge, other: Knowledge, start: Knowledge, problem: Problem) -> Knowledge:
    """A state that knows almost all, and nothing more, of what both given states know.

    Args:
        one, other: the two states, after closure.
        start: the initial state; its entries are looked for in both states, even where neither has them any more because
            each knows another member to hold.
        problem: the problem.
    """
    known = {symbol: value for symbol, value in one.known.items() if other.known.get(symbol) == value}
    lost = {symbol for state in (one, other) for symbol in state.known if symbol not in known}
    weak = Knowledge(known, dict(_excluded(one, other, lost, problem)))
    return Knowledge(
        known,
        weak.excluded,
        frozenset(
            symbol
            for symbol in (one.whether | other.whether) - known.keys()
            if all(symbol in state.whether or symbol in state.known for state in (one, other))
        ),
        _entries(weak, ((one, one.exclusive), (other, other.exclusive)), start.exclusive, lost, True),
        _entries(weak, ((one, one.some), (other, other.some)), start.some, lost, False),
        one.conjunctions & other.conjunctions,
        settled=one.settled & other.settled,
    )


def _excluded(
    one: Knowledge, other: Knowledge, lost: AbstractSet[Symbol], problem: Problem
) -> Iterator[tuple[Symbol, frozenset[Value]]]:
    """The values that terms are known in both states not to have."""
    symbols = dict.fromkeys((*one.excluded, *other.excluded))
    symbols |= dict.fromkeys(symbol for symbol in one.known if symbol in lost and symbol in other.known)
    for symbol in symbols:
        values = range_of(problem, symbol) or ()
        common = _ruled_out(one, symbol, values) & _ruled_out(other, symbol, values)
        if common:
            yield symbol, common


def _ruled_out(state: Knowledge, symbol: Symbol, values: Iterable[Value]) -> frozenset[Value]:
    if symbol in state.known:
        return frozenset(values) - {state.known[symbol]}
    return state.excluded.get(symbol, frozenset())


def _entries(
    weak: Knowledge,
    states: tuple[tuple[Knowledge, frozenset[Entry]], tuple[Knowledge, frozenset[Entry]]],
    initial: frozenset[Entry],
    lost: AbstractSet[Symbol],
    exactly: bool,
) -> frozenset[Entry]:
    """The entries of Kx (`exactly`) or Kor that both states imply, without members whose truth `weak` knows."""
    (one, first), (other, second) = states
    found = set(first & second)
    for entry in dict.fromkeys((*(first ^ second), *mentioning(initial, lost))):
        if entry in found:
            continue
        truths = {claim: truth(claim, weak) for claim in entry}
        left = frozenset(claim for claim, known in truths.items() if known is None)
        if True in truths.values() or left in found:
            continue
        if _implies(one, left, first, exactly) and _implies(other, left, second, exactly):
            found.add(left)
    return frozenset(found)


def _implies(state: Knowledge, entry: Entry, entries: frozenset[Entry], exactly: bool) -> bool:
    if entry in entries:
        return True
    truths = {claim: truth(claim, state) for claim in entry}
    known = list(truths.values())
    if True in known:
        return not exactly or (known.count(True) == 1 and None not in known)
    return frozenset(claim for claim in entry if truths[claim] is None) in entries
