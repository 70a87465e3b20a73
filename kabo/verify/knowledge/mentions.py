"""The atoms and terms that formulas and effects mention, read, or may change."""

from collections.abc import Iterable, Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from kabo.language.formulas import (
    Application,
    Atom,
    Change,
    Constant,
    ExactlyOne,
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
from kabo.plan import ValueOf
from kabo.verify.knowledge.ground import Binding, Symbol, instances, read_symbol


def mentions(tree: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """Every atom and term anywhere in a formula, effect or term, ground under the binding.

    For an atom or term whose arguments depend on knowledge, its symbol's name stands for all instances.
    """
    if isinstance(tree, Forall | Exists | ForEach | FactForall | ExactlyOne):
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
    if isinstance(tree, Variable):
        value = binding.get(tree.name)
        symbol = read_symbol(value.term, problem) if isinstance(value, ValueOf) else None
        if symbol is not None:
            yield symbol
        return
    parts = tree if isinstance(tree, tuple | list) else ()
    if is_dataclass(tree):
        parts = [getattr(tree, field.name) for field in fields(tree) if field.name != "place"]
    for part in parts:
        yield from mentions(part, problem, binding)


def reads(effect: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    """The atoms and terms in an effect's conditions, right sides and arguments, without the written facts."""
    if isinstance(effect, ForEach):
        for more in instances(problem, effect.variables, binding):
            for inner in effect.effects:
                yield from reads(inner, problem, more)
    elif isinstance(effect, Change) and effect.database == "Kf" and effect.operation == "add":
        for fact in effect.facts:
            yield from _read_by_fact(fact, problem, binding)
    elif hasattr(effect, "updates"):
        yield from mentions(effect.condition, problem, binding)
        for inner in effect.updates:
            yield from reads(inner, problem, binding)
    elif isinstance(effect, Change) and effect.database in ("Kf", "Kv"):
        for fact in effect.facts:
            yield from _read_by_fact(fact, problem, binding)
    else:
        yield from mentions(effect, problem, binding)


def _read_by_fact(fact: Any, problem: Problem, binding: Binding) -> Iterator[Symbol | str]:
    if isinstance(fact, FactForall):
        for more in instances(problem, fact.variables, binding):
            yield from _read_by_fact(fact.body, problem, more)
    elif isinstance(fact, Literal):
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
        value = binding.get(argument.name) if isinstance(argument, Variable) else None
        if isinstance(argument, Constant):
            values.append(argument.name)
        elif isinstance(argument, Number):
            values.append(argument.value)  # type: ignore[arg-type]
        elif value is not None and not isinstance(value, ValueOf):
            values.append(value)  # type: ignore[arg-type]
        else:
            return name
    return name, tuple(values)
