"""Effects: parse trees of the start symbol `effect`, resolved into updates of the knowledge databases."""

from dataclasses import replace
from typing import cast

from kabo.language import formulas as f
from kabo.language.vocabulary import NUMBER, Kind
from kabo.language.yaml.queries import read_formula
from kabo.language.yaml.syntax import Tree
from kabo.language.yaml.terms import (
    Context,
    kind_with_article,
    read_atom,
    read_claim,
    read_function_term,
    read_variables,
)

_TAKES = {
    "Kf": "literals, f = v and f != v",
    "Kw": "atoms and conjunctions",
    "Kv": "function terms",
    "Kx": "literals, f = v, or exactly_one(type x) …",
    "Kor": "literals and f = v",
    "LCW": "literals, conjunctions, or forall(type x) (… and …)",
}


def read_effects(
    context: Context, tree: Tree, *, world: bool = True, conditional: bool = True
) -> tuple[f.Effect, ...]:
    """The effects of one string; those that are wrong are reported and left out.

    Args:
        context: scope and place.
        tree: the parse tree.
        world: whether `when … then …` may stand here.
        conditional: whether `query => …` may stand here.
    """
    if tree.data == "updates":
        effects = [read_effects(context, child, world=world, conditional=conditional) for child in tree.children]
        return tuple(effect for group in effects for effect in group)
    place = context.parsed.place(tree)
    if tree.data == "change":
        change = _change(context, tree)
        return () if change is None else (change,)
    if tree.data == "world_effect":
        return _world_effect(context, tree, world)
    if tree.data == "for_each":
        variables, inner = read_variables(context, tree.children[0])
        effects_inside = read_effects(inner, tree.children[1], world=world, conditional=conditional)
        return (f.ForEach(variables, effects_inside, place),) if effects_inside else ()
    if not conditional:
        context.report(tree, f"an effect {context.where} cannot be conditional: nothing is known before")
        return ()
    condition = read_formula(context, tree.children[0])
    updates = read_effects(_outside_of_condition(context, tree.children[0]), tree.children[1], world=world)
    return () if condition is None or not updates else (f.Conditional(condition, updates, place),)


def _outside_of_condition(context: Context, condition: Tree) -> Context:
    """The context of the right side: names bound only on the left get the form that was meant as a remedy."""
    hints = dict(context.hint_of)
    if condition.data == "forall":
        children = condition.children[0].children
        for kind, name in zip(children[::2], children[1::2], strict=True):
            form = f"forall({kind} {name}) (condition => add(…))"
            hints[str(name)] = f'"{name}" is bound on the left only: write {form} to have it on both sides'
    return replace(context, hint_of=hints)


def _world_effect(context: Context, tree: Tree, allowed: bool) -> tuple[f.Effect, ...]:
    if not allowed:
        context.report(tree, f"`when … then …` is an effect of actions and may not stand {context.where}")
        return ()
    sides = [[_world_claim(context, claim) for claim in side.children] for side in tree.children]
    if any(claim is None for side in sides for claim in side):
        return ()
    conditions, outcomes = (tuple(claim for claim in side if claim is not None) for side in sides)
    return (f.WorldEffect(conditions, outcomes, context.parsed.place(tree)),)


def _world_claim(context: Context, tree: Tree) -> f.Claim | None:
    claim = read_claim(context, tree)
    if isinstance(claim, f.Comparison):
        return _assignment(context, tree, claim, ("=",))
    return claim


# --------------------------------------------------------------------------------------------------- databases
def _change(context: Context, tree: Tree) -> f.Change | None:
    operation, database, *pieces = tree.children
    facts = [_fact(context, piece, str(database)) for piece in pieces]
    if None in facts:
        return None
    return f.Change(
        "add" if operation == "add" else "del",
        cast(f.Database, str(database)),
        tuple(fact for fact in facts if fact is not None),
        context.parsed.place(tree),
    )


def _fact(context: Context, tree: Tree, database: str, *, inner: bool = False) -> f.Fact | None:
    place = context.parsed.place(tree)
    if tree.data in ("fact_forall", "exactly_one"):
        if database not in (("Kf", "Kw", "LCW") if tree.data == "fact_forall" else ("Kx",)):
            return _misplaced(context, tree, database)
        variables, inside = read_variables(context, tree.children[0])
        body = _fact(inside, tree.children[1], database, inner=True)
        kind = f.FactForall if tree.data == "fact_forall" else f.ExactlyOne
        return None if body is None else kind(variables, body, place)
    if tree.data == "fact_all_of":
        if database not in ("Kw", "LCW") and not (database == "Kf" and inner):
            hint = f"write the facts as several: {database}, a, b" if database == "Kf" else None
            return _misplaced(context, tree, database, hint)
        parts = [_simple_fact(context, part, database, alone=False) for part in tree.children]
        whole = tuple(part for part in parts if part is not None)
        return f.FactAll(whole, place) if len(whole) == len(parts) else None
    return _simple_fact(context, tree, database, alone=True)


def _simple_fact(context: Context, tree: Tree, database: str, *, alone: bool) -> f.Fact | None:
    place = context.parsed.place(tree)
    if database == "Kv":
        if tree.data != "term":
            return _misplaced(context, tree, database)
        term = read_function_term(replace(context, in_update=True), tree)
        return None if term is None else f.TermFact(term, place)
    if database == "Kw" and alone and tree.data != "term":
        hint = "whether p and whether not p are the same: write the atom" if tree.data == "denial" else None
        return _misplaced(context, tree, database, hint)
    if database == "Kw" and alone:
        atom = read_atom(replace(context, in_update=True), tree)
        return None if atom is None else f.Literal(atom, True, place)
    claim = read_claim(replace(context, in_update=True), tree)
    if isinstance(claim, f.Comparison):
        if database == "Kw":
            return _misplaced(context, tree, database, "for what value it has, write add(Kv, f(x))")
        return _assignment(context, tree, claim, ("=", "!=") if database == "Kf" else ("=",))
    return claim


def _misplaced(context: Context, tree: Tree, database: str, hint: str | None = None) -> f.Fact | None:
    context.report(tree, f"{database} takes {_TAKES[database]}, not this", hint)
    return None


def _assignment(
    context: Context, tree: Tree, claim: f.Comparison, operators: tuple[str, ...]
) -> f.Comparison | None:
    """A comparison as a fact: a function on the left, a value that it can take on the right."""
    if claim.operator not in operators:
        context.report(tree, f'a fact here has the form f = v, not "{claim.operator}"')
        return None
    if not isinstance(claim.left, f.Application):
        hint = "write it on the left" if isinstance(claim.right, f.Application) else None
        context.report(tree, "a fact about a value must have the function on its left", hint)
        return None
    declared = context.scope.find(claim.left.function)
    right = tree.children[2]
    value_kind = _kind_of(context, claim.right)
    if declared is not None and not context.vocabulary.fits(value_kind, declared.kind):
        value = f"the value of {claim.left.function} must be {kind_with_article(declared.kind)}"
        context.report(right, f"{value}, this is {kind_with_article(value_kind)}")
        return None
    return claim


def _kind_of(context: Context, term: f.Term) -> Kind:
    if isinstance(term, f.Number | f.Arithmetic):
        return NUMBER
    if isinstance(term, f.External):
        name = term.procedure
    else:
        name = term.function if isinstance(term, f.Application) else term.name
    symbol = context.scope.find(name)
    return None if symbol is None else symbol.kind
