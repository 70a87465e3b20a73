"""Run-time variables: a parameter `c: {value_of: f(s)}` stands for the value that f(s) will have [P].

They are not bound to each object in turn: in the action's formulas c stands for the term f(s). A fluent to which c
is assigned is known at run time only, unless the value of the term is known before.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, TypeVar

from kabo.language.formulas import Application, Comparison, KnowValue, Variable
from kabo.language.problem import Action
from kabo.language.spelling import Manner, spelling

Tree = TypeVar("Tree")


@dataclass(frozen=True)
class RunTimeValue:
    """A mark around a term: its value is taken at run time."""

    term: Application


@spelling.register
def _(tree: RunTimeValue, how: Manner) -> str:
    return spelling(tree.term, how)


def without_runtime_variables(action: Action) -> Action:
    """The action with run-time variables replaced by their terms; new preconditions require Kv of the terms."""
    terms = {p.name: p.value_of for p in action.parameters if p.value_of is not None}
    if not terms:
        return action
    wanted = tuple(KnowValue(term, term.place) for term in terms.values())
    return replace(
        action,
        parameters=tuple(p for p in action.parameters if p.value_of is None),
        preconditions=wanted + _substituted(action.preconditions, terms),
        effects=_substituted(action.effects, terms),
        sense=_substituted(action.sense, terms),
        cost=_substituted(action.cost, terms),
    )


def _substituted(tree: Tree, terms: Mapping[str, Application]) -> Tree:
    """The tree with the variables replaced; in `f = c` the value is marked as one of run time."""
    result: Any = tree
    if isinstance(tree, Variable):
        result = RunTimeValue(terms[tree.name]) if tree.name in terms else tree
    elif isinstance(tree, tuple):
        result = tuple(_substituted(part, terms) for part in tree)
    elif is_dataclass(tree) and not isinstance(tree, type):
        changed = {}
        for item in fields(tree):
            before = getattr(tree, item.name)
            after = _substituted(before, terms) if item.name != "place" else before
            if (
                item.name in ("left", "right")
                and not isinstance(tree, Comparison)
                and isinstance(after, RunTimeValue)
            ):
                after = after.term
            if after is not before:
                changed[item.name] = after
        result = replace(tree, **changed) if changed else tree
    return result  # type: ignore[no-any-return]
