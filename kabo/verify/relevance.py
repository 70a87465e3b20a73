"""Which facts the rest of a plan can ask for: all else may be forgotten, so that 2^n branches stay a few states.

A node's continuation never sees more of the knowledge than the atoms and terms that its formulas mention. States
that agree on these behave alike from there on, and are replayed once.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Constant,
    Exists,
    FactForall,
    Forall,
    ForEach,
    Literal,
    Number,
    TermFact,
    Variable,
)
from kabo.language.problem import Problem
from kabo.plan import Node, Plan
from kabo.verify.knowledge import Binding, Frozen, Knowledge, Symbol, instances

Mentioned = set["Symbol | str"]  # a ground atom or term, or the name of one whose arguments depend on knowledge


def relevant(plan: Plan, problem: Problem, order: Sequence[str], mentioned_by: Any) -> dict[str, Mentioned] | None:
    """What each node and its continuation mention; None if everything matters (update rules read what they like).

    Args:
        plan: the plan.
        problem: its problem.
        order: the reached nodes, each before its successors.
        mentioned_by: gives a node mentions itself.
    """
    if problem.domain.update_rules:
        return None
    result: dict[str, Mentioned] = {}
    for name in reversed(order):
        node: Node = plan.nodes[name]
        result[name] = set(mentioned_by(node)).union(*(result.get(s, set()) for s in node.successors))
    return result


def forget(state: Knowledge, keep: Mentioned | None) -> tuple[Frozen, Knowledge]:
    """The state without what nobody asks for any more, and as a value that sets can hold."""
    if keep is not None:

        def kept(symbol: Symbol) -> bool:
            return symbol in keep or symbol[0] in keep

        known = {symbol: value for symbol, value in state.known.items() if kept(symbol)}
        excluded = frozenset(entry for entry in state.excluded if kept(entry[0]))
        state = Knowledge(known, excluded, frozenset(filter(kept, state.whether)))
    return state.frozen(), state


def mentions(tree: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """Every atom and term that stands anywhere in a formula, effect or term, ground under the binding."""
    if isinstance(tree, Forall | Exists | ForEach | FactForall):
        bodies: Iterable[Any] = tree.effects if isinstance(tree, ForEach) else (tree.body,)
        for more in instances(problem, tree.variables, binding):
            for body in bodies:
                yield from mentions(body, problem, more)
        return
    if isinstance(tree, Atom | Application):
        yield _ground(tree, binding)
        for argument in tree.arguments:
            yield from mentions(argument, problem, binding)
        return
    parts = tree if isinstance(tree, tuple | list) else ()
    if is_dataclass(tree):
        parts = [getattr(tree, field.name) for field in fields(tree) if field.name != "place"]
    for part in parts:
        yield from mentions(part, problem, binding)


def reads(effect: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """What an effect asks for: conditions, right sides and arguments, but not the facts that it writes."""
    if isinstance(effect, ForEach):
        for more in instances(problem, effect.variables, binding):
            for inner in effect.effects:
                yield from reads(inner, problem, more)
    elif isinstance(effect, Change):
        for fact in effect.facts:
            yield from _read_by_fact(fact, problem, binding)
    elif hasattr(effect, "updates"):
        yield from mentions(effect.condition, problem, binding)
        for inner in effect.updates:
            yield from reads(inner, problem, binding)
    else:
        yield from mentions(effect, problem, binding)


def _read_by_fact(fact: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    if isinstance(fact, Literal):
        yield from mentions(fact.atom.arguments, problem, binding)
    elif isinstance(fact, TermFact):
        yield from mentions(fact.term.arguments, problem, binding)
    elif hasattr(fact, "right") and isinstance(fact.left, Application):
        yield from mentions(fact.left.arguments, problem, binding)
        yield from mentions(fact.right, problem, binding)
    else:
        yield from mentions(fact, problem, binding)


def _ground(tree: Atom | Application, binding: Binding) -> Symbol | str:
    name = tree.predicate if isinstance(tree, Atom) else tree.function
    values = []
    for argument in tree.arguments:
        if isinstance(argument, Constant):
            values.append(argument.name)
        elif isinstance(argument, Number):
            values.append(argument.value)  # type: ignore[arg-type]
        elif isinstance(argument, Variable) and argument.name in binding:
            values.append(binding[argument.name])  # type: ignore[arg-type]
        else:
            return name
    return name, tuple(values)
