"""Compiles effects, and evaluates them to the updates that fire in a knowledge state [docs/explanation/knowledge.md].

All conditions, values and arguments are evaluated in the state before. `replay/transition.py` applies the updates to
knowledge, `worlds/acts.py` applies them to the world.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Claim,
    Comparison,
    Conditional,
    Effect,
    ExactlyOne,
    Fact,
    FactAll,
    FactForall,
    ForEach,
    Formula,
    Literal,
    TermFact,
    WorldEffect,
)
from kabo.language.problem import Problem
from kabo.verify.knowledge.facts import Facts, will_be_known
from kabo.verify.knowledge.ground import (
    Binding,
    Entry,
    GroundClaim,
    NotVerifiableError,
    Symbol,
    Value,
    instances,
    is_predicate,
)
from kabo.verify.knowledge.terms import Namer, Reader, named, symbol_of, value_of


@dataclass(frozen=True)
class Assignment:
    """An update that sets `symbol = value` or `symbol != value`; `value` is None if it is unknown now.

    Attributes:
        sensed: whether the value will be known at run time.
        source: the term whose value is assigned; None for a constant.
    """

    symbol: Symbol
    value: Value | None
    positive: bool = True
    sensed: bool = False
    source: Symbol | None = None


@dataclass(frozen=True)
class UnknownComparison:
    """A condition of `when` that compares two terms of unknown value; None for a term with unknown arguments."""

    left: Symbol | None
    right: Symbol | None


Condition = GroundClaim | UnknownComparison | bool


@dataclass(frozen=True)
class When:
    """An effect `when C then E` with its values evaluated in the state before the action."""

    conditions: tuple[Condition, ...]
    outcomes: tuple[Assignment, ...]


@dataclass
class Updates:
    """The updates that fire, grouped by database and operation, each group in the order of the file."""

    adds: list[Assignment] = field(default_factory=list)
    deletions: list[GroundClaim] = field(default_factory=list)
    run_time: list[Symbol] = field(default_factory=list)  # add(Kw, p), add(Kv, f)
    no_run_time: list[Symbol] = field(default_factory=list)
    whole: list[tuple[GroundClaim, ...]] = field(default_factory=list)  # add(Kw, a and b)
    no_whole: list[tuple[GroundClaim, ...]] = field(default_factory=list)
    entries: list[tuple[str, Entry]] = field(default_factory=list)  # Kx, Kor
    no_entries: list[tuple[str, Entry]] = field(default_factory=list)
    complete: list[tuple[GroundClaim, ...]] = field(default_factory=list)  # LCW: an instance's conjuncts
    no_complete: list[tuple[GroundClaim, ...]] = field(default_factory=list)
    worlds: list[When] = field(default_factory=list)


Rule = Callable[[Facts, Updates], None]  # adds its updates that fire in a state
Asker = Callable[[Formula, Problem, Binding], Callable[[Facts], bool]]  # compiles a condition on knowledge


def fired(rules: Iterable[Rule], state: Facts) -> Updates:
    """The updates of the compiled effects that fire in a state."""
    result = Updates()
    for rule in rules:
        rule(state, result)
    return result


def rules_of(effects: Iterable[Effect], problem: Problem, binding: Binding, ask: Asker) -> list[Rule]:
    """The effects as functions of the state, with quantifiers unrolled; `ask` compiles their conditions."""
    return [rule for effect in effects for rule in _rules(effect, problem, binding, ask)]


def sensing(things: Iterable[Atom | Application], problem: Problem, binding: Binding) -> list[Rule]:
    """The entries of `sense` as unconditional `add(Kw, …)` and `add(Kv, …)`."""
    return [_on_symbol(symbol_of(thing, problem, binding), "run_time") for thing in things]


def _rules(effect: Effect, problem: Problem, binding: Binding, ask: Asker) -> Iterator[Rule]:
    match effect:
        case Change():
            yield from _change(effect, problem, binding)
        case Conditional(condition, updates):
            holds, inner = ask(condition, problem, binding), rules_of(updates, problem, binding, ask)

            def conditional(state: Facts, out: Updates) -> None:
                if holds(state.agent_knowledge):
                    for rule in inner:
                        rule(state, out)

            yield conditional
        case ForEach(variables, effects):
            for more in instances(problem, variables, binding):
                yield from rules_of(effects, problem, more, ask)
        case WorldEffect():
            yield _when(effect, problem, binding)


# ------------------------------------------------------------------------------------------------------ databases
def _change(change: Change, problem: Problem, binding: Binding) -> Iterator[Rule]:
    adds, database = change.operation == "add", change.database
    if database in ("Kx", "Kor"):
        yield _entry(change, problem, binding)
        return
    for fact in change.facts:
        for group, more in unrolled(fact, problem, binding):
            if database == "LCW":
                yield _on_claims(group, problem, more, "complete" if adds else "no_complete")
            elif database == "Kf":
                for part in group:
                    yield _assignment(part, problem, more) if adds else _deletion(part, problem, more)
            elif isinstance(group[0], TermFact):
                namer = symbol_of(group[0].term, problem, more)
                yield _on_symbol(namer, "run_time" if adds else "no_run_time")
            else:
                yield from _knowing_whether(fact, group, problem, more, adds)
                break  # a conjunction, and the instances of a quantifier, are one fact


def unrolled(fact: Fact, problem: Problem, binding: Binding) -> Iterator[tuple[tuple[Fact, ...], Binding]]:
    """For each instance of a quantified fact, the facts of its conjunction and the variables' binding."""
    if isinstance(fact, FactForall | ExactlyOne):
        for more in instances(problem, fact.variables, binding):
            yield from unrolled(fact.body, problem, more)
    else:
        yield (fact.parts if isinstance(fact, FactAll) else (fact,)), binding


def _knowing_whether(
    fact: Fact, group: tuple[Fact, ...], problem: Problem, binding: Binding, adds: bool
) -> Iterator[Rule]:
    everything = [(part, more) for parts, more in unrolled(fact, problem, binding) for part in parts]
    if len(everything) == 1 and isinstance(everything[0][0], Literal):
        namer = symbol_of(everything[0][0].atom, problem, everything[0][1])
        yield _on_symbol(namer, "run_time" if adds else "no_run_time")
        return
    readers = [_claim_reader(part, problem, more) for part, more in everything]

    def update(state: Facts, out: Updates) -> None:
        claims = tuple(dict.fromkeys(_whole(read(state)) for read in readers))
        (out.whole if adds else out.no_whole).append(claims)

    yield update


def _entry(change: Change, problem: Problem, binding: Binding) -> Rule:
    parts = [each for fact in change.facts for each in unrolled(fact, problem, binding)]
    readers = [_claim_reader(part, problem, more) for group, more in parts for part in group]
    adds, database = change.operation == "add", change.database

    def update(state: Facts, out: Updates) -> None:
        entry = database, frozenset(_whole(read(state)) for read in readers)
        (out.entries if adds else out.no_entries).append(entry)

    return update


def _on_claims(group: tuple[Fact, ...], problem: Problem, binding: Binding, where: str) -> Rule:
    readers = [_claim_reader(part, problem, binding) for part in group]

    def update(state: Facts, out: Updates) -> None:
        getattr(out, where).append(tuple(_whole(read(state)) for read in readers))

    return update


def _on_symbol(namer: Symbol | Namer | None, where: str) -> Rule:
    def update(state: Facts, out: Updates) -> None:
        getattr(out, where).append(_symbol(namer, state))

    return update


def _symbol(namer: Symbol | Namer | None, state: Facts) -> Symbol:
    symbol = named(namer, state)
    if symbol is None:
        raise NotVerifiableError("an effect names something by a value that is not known")
    return symbol


# ---------------------------------------------------------------------------------------------------- assignments
def _assignment(fact: Fact, problem: Problem, binding: Binding) -> Rule:
    read = _claim_reader(fact, problem, binding)

    def update(state: Facts, out: Updates) -> None:
        out.adds.append(read(state))

    return update


def _deletion(fact: Fact, problem: Problem, binding: Binding) -> Rule:
    read = _claim_reader(fact, problem, binding)

    def update(state: Facts, out: Updates) -> None:
        claim = read(state)
        if claim.value is not None:  # of an unknown value nothing is known that could be deleted
            out.deletions.append((claim.symbol, claim.value, claim.positive))

    return update


def _claim_reader(fact: Fact | Claim, problem: Problem, binding: Binding) -> Callable[[Facts], Assignment]:
    """The function that makes a literal, `f = v` or `f != v`, an assignment with its value in a state."""
    if isinstance(fact, Literal):
        namer, positive = symbol_of(fact.atom, problem, binding), fact.positive
        if isinstance(namer, tuple):
            always = Assignment(namer, positive)
            return lambda state: always
        return lambda state: Assignment(_symbol(namer, state), positive)
    if not isinstance(fact, Comparison) or not isinstance(fact.left, Application):
        raise NotVerifiableError("this fact is not judged by this verifier")
    left, equal = symbol_of(fact.left, problem, binding), fact.operator == "="
    right, value = symbol_of(fact.right, problem, binding), value_of(fact.right, problem, binding)

    def read(state: Facts) -> Assignment:
        source = named(right, state)
        now = value(state)
        sensed = now is None and source is not None and will_be_known(source, state)
        return Assignment(_symbol(left, state), now, equal, sensed, source)

    return read


def _whole(claim: Assignment) -> GroundClaim:
    if claim.value is None:
        raise NotVerifiableError("an entry of several members names a value that is not known")
    return claim.symbol, claim.value, claim.positive


# -------------------------------------------------------------------------------------------------- world effects
def _when(effect: WorldEffect, problem: Problem, binding: Binding) -> Rule:
    conditions = [_condition(claim, problem, binding) for claim in effect.conditions]
    outcomes = [_claim_reader(claim, problem, binding) for claim in effect.outcomes]

    def update(state: Facts, out: Updates) -> None:
        claims = tuple(dict.fromkeys(read(state) for read in conditions))
        out.worlds.append(When(claims, tuple(read(state) for read in outcomes)))

    return update


def _condition(claim: Claim, problem: Problem, binding: Binding) -> Callable[[Facts], Condition]:
    if isinstance(claim, Literal):
        namer, positive = symbol_of(claim.atom, problem, binding), claim.positive
        return lambda state: (_symbol(namer, state), positive, True)
    namers: tuple[Symbol | Namer | None, ...] = tuple(
        symbol_of(side, problem, binding) for side in (claim.left, claim.right)
    )
    readers: tuple[Reader, ...] = tuple(value_of(side, problem, binding) for side in (claim.left, claim.right))

    def read(state: Facts) -> Condition:
        left, right = (read(state) for read in readers)
        first, second = (named(namer, state) for namer in namers)
        if first is not None and first == second:
            return True  # a term has its own value
        if first is not None and right is not None:
            return first, right, True
        if second is not None and left is not None:
            return second, left, True
        if left is not None and right is not None:
            return left == right
        return UnknownComparison(first, second)

    return read


def denies_each(problem: Problem, claims: Iterable[GroundClaim]) -> Entry:
    """The Kor entry of the complements of the claims, which says that at least one claim does not hold."""
    return frozenset(
        (symbol, not value, True) if is_predicate(problem, symbol) else (symbol, value, not positive)
        for symbol, value, positive in claims
    )
