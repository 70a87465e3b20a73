"""Traversal and substitution of formula trees."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

from kabo.language import formulas as f

_Tree = TypeVar("_Tree")
_BINDERS = (f.Forall, f.Exists, f.FactForall, f.ExactlyOne, f.ForEach)
_Binder = f.Forall | f.Exists | f.FactForall | f.ExactlyOne | f.ForEach
_SPARED = (f.Place, str, float, int, bool, type(None))


def nodes(tree: object) -> Iterator[Any]:
    """The tree and all its subtrees, in the order in which they are written."""
    waiting: list[object] = [tree]
    while waiting:
        here = waiting.pop()
        if isinstance(here, tuple | list):
            waiting.extend(reversed(here))
        elif not isinstance(here, _SPARED) and is_dataclass(here):
            yield here
            inner = [getattr(here, each.name) for each in fields(here) if each.name != "place"]
            waiting.extend(reversed(inner))


def symbols(tree: object) -> set[str]:
    """The predicates and functions that a tree mentions."""
    found = set()
    for node in nodes(tree):
        if isinstance(node, f.Atom):
            found.add(node.predicate)
        elif isinstance(node, f.Application):
            found.add(node.function)
    return found


def variable_names(tree: object) -> set[str]:
    """The names of all variables that occur in a tree, bound ones too."""
    return {node.name for node in nodes(tree) if isinstance(node, f.Variable)}


def substituted(tree: _Tree, terms: Mapping[str, f.Term]) -> _Tree:
    """The tree with terms substituted for free variables; bound variables are renamed to avoid capture."""
    if not terms:
        return tree
    if isinstance(tree, f.Variable):
        return terms.get(tree.name, tree)  # type: ignore[return-value]
    if isinstance(tree, tuple):
        return tuple(substituted(part, terms) for part in tree)  # type: ignore[return-value]
    if isinstance(tree, _SPARED) or not is_dataclass(tree):
        return tree
    if isinstance(tree, _BINDERS):
        return _inside_binder(tree, terms)  # type: ignore[return-value]
    changed = {each.name: substituted(getattr(tree, each.name), terms) for each in fields(tree)}
    return replace(tree, **changed)  # type: ignore[type-var]


def _inside_binder(tree: _Binder, terms: Mapping[str, f.Term]) -> _Binder:
    bound = {variable.name for variable in tree.variables}
    inner = {name: term for name, term in terms.items() if name not in bound}
    caught = variable_names(tuple(inner.values()))
    renamed = renaming(tree.variables, caught, variable_names(tree) | caught)
    inner |= renamed
    variables = tuple(renamed.get(variable.name, variable) for variable in tree.variables)
    body = "effects" if isinstance(tree, f.ForEach) else "body"
    return replace(tree, variables=variables, **{body: substituted(getattr(tree, body), inner)})


def rebound(tree: _Tree, avoided: set[str]) -> _Tree:
    """The tree with its bound variables renamed if their names are among `avoided`."""
    if isinstance(tree, tuple):
        return tuple(rebound(part, avoided) for part in tree)  # type: ignore[return-value]
    if isinstance(tree, _SPARED) or not is_dataclass(tree):
        return tree
    if isinstance(tree, _BINDERS):
        own: Any = tree
        renamed = renaming(own.variables, avoided, variable_names(own) | avoided)
        variables = tuple(renamed.get(variable.name, variable) for variable in own.variables)
        tree = replace(substituted(replace(own, variables=()), renamed), variables=variables)
    changed = {each.name: rebound(getattr(tree, each.name), avoided) for each in fields(tree)}  # type: ignore[arg-type]
    return replace(tree, **changed)  # type: ignore[type-var]


def renaming(variables: Iterable[f.Variable], avoided: set[str], taken: set[str]) -> dict[str, f.Variable]:
    """New variables, with names not in `taken`, for the variables with names in `avoided`, by the old names."""
    found: dict[str, f.Variable] = {}
    taken = set(taken)
    for variable in variables:
        if variable.name not in avoided:
            continue
        number = 2
        while (name := f"{variable.name}_{number}") in taken:
            number += 1
        taken.add(name)
        found[variable.name] = replace(variable, name=name)
    return found
