"""What effects do to knowledge: all conditions are read in the state before, then deletions, then additions.

Addition wins over deletion. Update rules fire until nothing changes [DESIGN section 3].
"""

from collections.abc import Iterable, Iterator

from kabo.language.formulas import (
    Application,
    Change,
    Comparison,
    Conditional,
    Effect,
    Fact,
    FactForall,
    ForEach,
    Literal,
    TermFact,
)
from kabo.language.problem import Problem
from kabo.plan import ValueOf
from kabo.verify.knowledge import (
    Binding,
    Knowledge,
    NotVerifiableError,
    Symbol,
    Value,
    holds,
    instances,
    possible_values,
    symbol_of,
    value_of,
)

ROUNDS = 1000  # of update rules; rules that still change something after so many do not settle

Update = tuple[str, str, Symbol, str, "Value | None"]  # operation, database, symbol, "=" or "!=", value


def apply(effects: Iterable[Effect], problem: Problem, state: Knowledge, binding: Binding) -> Knowledge:
    """The knowledge after the effects.

    Raises:
        NotVerifiableError: an effect that this interpreter does not judge.
    """
    updates = [update for effect in effects for update in _updates(effect, problem, state, binding)]
    known, excluded, whether = dict(state.known), set(state.excluded), set(state.whether)
    for operation, database, symbol, relation, value in updates:
        if operation != "del":
            continue
        if database in ("Kw", "Kv"):
            whether.discard(symbol)
        elif relation == "!=":
            excluded.discard((symbol, value))  # type: ignore[arg-type]
        elif value is not None and known.get(symbol) == value:
            del known[symbol]
    for operation, database, symbol, relation, value in updates:
        if operation != "add":
            continue
        if database in ("Kw", "Kv"):
            if symbol not in known:
                whether.add(symbol)
        elif relation == "!=":
            if known.get(symbol) == value:
                del known[symbol]
            excluded.add((symbol, value))  # type: ignore[arg-type]
        else:
            _learn(known, excluded, whether, symbol, value)
    return concluded(problem, Knowledge(known, frozenset(excluded), frozenset(whether)))


def _learn(known: dict, excluded: set, whether: set, symbol: Symbol, value: Value | None) -> None:  # type: ignore[type-arg]
    """The symbol takes this value, whatever was known before; None or a run-time value: it is not known now."""
    excluded -= {entry for entry in excluded if entry[0] == symbol}
    known.pop(symbol, None)
    whether.discard(symbol)
    if isinstance(value, ValueOf):
        whether.add(symbol)
    elif value is not None:
        known[symbol] = value


def concluded(problem: Problem, state: Knowledge) -> Knowledge:
    """With the terms known of which all values but one are excluded."""
    known = dict(state.known)
    for symbol in {symbol for symbol, _ in state.excluded if symbol not in known}:
        values = possible_values(problem, symbol, state)
        if values is not None and len(values) == 1:
            known[symbol] = values[0]
    whether = frozenset(symbol for symbol in state.whether if symbol not in known)
    return Knowledge(known, frozenset(e for e in state.excluded if e[0] not in known), whether)


def with_rules(problem: Problem, state: Knowledge) -> Knowledge:
    """The knowledge after the domain's update rules have fired until nothing changes.

    Raises:
        NotVerifiableError: they do not settle, or one is not judged by this interpreter.
    """
    rules = problem.domain.update_rules
    for _ in range(ROUNDS if rules else 0):
        after = apply(rules, problem, state, {})
        if after.frozen() == state.frozen():
            return after
        state = after
    if rules:
        raise NotVerifiableError(f"the update rules still change something after {ROUNDS} rounds")
    return state


def initial_knowledge(problem: Problem) -> Knowledge:
    """What the problem file says is known at the start."""
    state = Knowledge({})
    for effect in problem.initial:
        state = apply([effect], problem, state, {})
    return with_rules(problem, state)


def learned(problem: Problem, state: Knowledge, symbol: Symbol, value: Value) -> Knowledge:
    """The knowledge inside the branch where an atom or term has turned out to have this value."""
    known, excluded, whether = dict(state.known), set(state.excluded), set(state.whether)
    _learn(known, excluded, whether, symbol, value)
    return with_rules(problem, concluded(problem, Knowledge(known, frozenset(excluded), frozenset(whether))))


def _updates(effect: Effect, problem: Problem, state: Knowledge, binding: Binding) -> Iterator[Update]:
    match effect:
        case Change(operation, database, facts):
            if database not in ("Kf", "Kw", "Kv"):
                raise NotVerifiableError(f"{database} is not judged by this verifier")
            for fact in facts:
                for symbol, relation, value in ground_fact(fact, problem, state, binding):
                    yield operation, database, symbol, relation, value
        case Conditional(condition, updates):
            if holds(condition, problem, state, binding):
                for update in updates:
                    yield from _updates(update, problem, state, binding)
        case ForEach(variables, effects):
            for more in instances(problem, variables, binding):
                for inner in effects:
                    yield from _updates(inner, problem, state, more)
        case _:
            raise NotVerifiableError("world effects (when … then …) are not judged by this verifier")


def ground_fact(
    fact: Fact, problem: Problem, state: Knowledge, binding: Binding
) -> Iterator[tuple[Symbol, str, Value | None]]:
    """The facts about single atoms and terms: symbol, `=` or `!=`, value (None if not known).

    Raises:
        NotVerifiableError: the fact is not about single ones, or its arguments are not known.
    """
    if isinstance(fact, FactForall):
        for more in instances(problem, fact.variables, binding):
            yield from ground_fact(fact.body, problem, state, more)
        return
    value: Value | None
    if isinstance(fact, Literal):
        name, arguments, relation, value = fact.atom.predicate, fact.atom.arguments, "=", fact.positive
    elif isinstance(fact, TermFact):
        name, arguments, relation, value = fact.term.function, fact.term.arguments, "=", None
    elif isinstance(fact, Comparison) and isinstance(fact.left, Application) and fact.operator in ("=", "!="):
        name, arguments, relation = fact.left.function, fact.left.arguments, fact.operator
        value = _right_side(fact, state, binding)
    else:
        raise NotVerifiableError("facts about several atoms at once are not judged by this verifier")
    symbol = symbol_of(name, arguments, state, binding)
    if symbol is None:
        raise NotVerifiableError(f"an effect names {name} of something whose value is not known")
    yield symbol, relation, value


def _right_side(fact: Comparison, state: Knowledge, binding: Binding) -> Value | None:
    value = value_of(fact.right, state, binding)
    if value is None and isinstance(fact.right, Application):
        symbol = symbol_of(fact.right.function, fact.right.arguments, state, binding)
        if symbol is not None and symbol in state.whether:
            return ValueOf(symbol[0])  # it will be known at run time, so what takes its value will be, too
    return value
