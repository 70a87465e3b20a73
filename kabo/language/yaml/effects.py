"""Effects: expressions of the start symbol `effect`, resolved into updates of the knowledge databases."""

from dataclasses import replace
from typing import cast

from kabo.language import formulas as f
from kabo.language.expressions import Expression
from kabo.language.resolver import NameResolver
from kabo.language.types import ANY, NUMBERS, Kind
from kabo.language.yaml.dialect import with_article
from kabo.language.yaml.queries import read_formula, read_variables

_TAKES = {
    "Kf": "literals, f = v and f != v",
    "Kw": "atoms and conjunctions",
    "Kv": "function terms",
    "Kx": "literals, f = v, or exactly_one(type x) …",
    "Kor": "literals and f = v",
    "LCW": "literals, conjunctions, or forall(type x) (… and …)",
}


def read_effects(
    here: NameResolver, node: Expression, *, world: bool = True, conditional: bool = True
) -> tuple[f.Effect, ...]:
    """The effects in one expression; faulty effects are reported and left out.

    Args:
        here: the resolver of names in scope.
        node: the expression.
        world: whether an update `when … then …` is permitted here.
        conditional: whether a conditional update `query => …` is permitted here.
    """
    if node.kind == "updates":
        effects = [read_effects(here, part, world=world, conditional=conditional) for part in node.parts]
        return tuple(effect for group in effects for effect in group)
    place = here.place(node)
    if node.kind == "change":
        change = _change(here, node)
        return () if change is None else (change,)
    if node.kind == "world_effect":
        return _world_effect(here, node, world)
    if node.kind == "for_each":
        variables, inner = read_variables(here, node)
        effects_inside = read_effects(inner, node.parts[0], world=world, conditional=conditional)
        return (f.ForEach(variables, effects_inside, place),) if effects_inside else ()
    if not conditional:
        here.report(node, f"an effect {here.where} cannot be conditional: nothing is known before")
        return ()
    condition = read_formula(here, node.parts[0])
    updates = read_effects(_outside_of_condition(here, node.parts[0]), node.parts[1], world=world)
    return () if condition is None or not updates else (f.Conditional(condition, updates, place),)


def _outside_of_condition(here: NameResolver, condition: Expression) -> NameResolver:
    """The resolver of the right side: names bound only on the left get the form that was meant as a remedy."""
    hints = dict(here.hints)
    for name, kind in condition.variables if condition.kind == "forall" else ():
        form = f"forall({kind.text if kind else ''} {name.text}) (condition => add(…))"
        hints[name.text] = f'"{name.text}" is bound on the left only: write {form} to have it on both sides'
    return replace(here, hints=hints)


def _world_effect(here: NameResolver, node: Expression, allowed: bool) -> tuple[f.Effect, ...]:
    if not allowed:
        here.report(node, f"`when … then …` is an effect of actions and may not stand {here.where}")
        return ()
    sides = [[_claim(here, claim, ("=",)) for claim in side.parts] for side in node.parts]
    if any(claim is None for side in sides for claim in side):
        return ()
    conditions, outcomes = (tuple(claim for claim in side if claim is not None) for side in sides)
    return (f.WorldEffect(conditions, outcomes, here.place(node)),)


# --------------------------------------------------------------------------------------------------- databases
def _change(here: NameResolver, node: Expression) -> f.Change | None:
    operation, database = node.text.split()
    inside = replace(here, in_update=True)
    facts = [_fact(inside, piece, database) for piece in node.parts]
    whole = tuple(fact for fact in facts if fact is not None)
    if len(whole) < len(facts):
        return None
    return f.Change("add" if operation == "add" else "del", cast(f.Database, database), whole, here.place(node))


def _fact(here: NameResolver, node: Expression, database: str, *, inner: bool = False) -> f.Fact | None:
    place = here.place(node)
    if node.kind in ("fact_forall", "exactly_one"):
        if database not in (("Kf", "Kw", "LCW") if node.kind == "fact_forall" else ("Kx",)):
            return _misplaced(here, node, database)
        variables, inside = read_variables(here, node)
        body = _fact(inside, node.parts[0], database, inner=True)
        kind = f.FactForall if node.kind == "fact_forall" else f.ExactlyOne
        return None if body is None else kind(variables, body, place)
    if node.kind == "fact_all_of":
        if database not in ("Kw", "LCW") and not (database == "Kf" and inner):
            hint = f"write the facts as several: {database}, a, b" if database == "Kf" else None
            return _misplaced(here, node, database, hint)
        parts = [_simple_fact(here, part, database, alone=False) for part in node.parts]
        whole = tuple(part for part in parts if part is not None)
        return f.FactAll(whole, place) if len(whole) == len(parts) else None
    return _simple_fact(here, node, database, alone=True)


def _simple_fact(here: NameResolver, node: Expression, database: str, *, alone: bool) -> f.Fact | None:
    place, is_term = here.place(node), node.kind in ("name", "call")
    if database == "Kv":
        if not is_term:
            return _misplaced(here, node, database)
        term = here.application(node)
        return None if term is None else f.TermFact(term, place)
    if database == "Kw" and alone:
        if not is_term:
            hint = "whether p and whether not p are the same: write the atom" if node.kind == "!" else None
            return _misplaced(here, node, database, hint)
        atom = here.atom(node)
        return None if atom is None else f.Literal(atom, True, place)
    return _claim(here, node, {"Kf": ("=", "!="), "Kw": ()}.get(database, ("=",)))


def _misplaced(here: NameResolver, node: Expression, database: str, hint: str | None = None) -> f.Fact | None:
    here.report(node, f"{database} takes {_TAKES[database]}, not this", hint)
    return None


def _claim(here: NameResolver, node: Expression, operators: tuple[str, ...]) -> f.Claim | None:
    """A literal, or a function and a value that it can take, with one of the operators (none: for Kw)."""
    claim = here.claim(node)
    if not isinstance(claim, f.Comparison):
        return claim if isinstance(claim, f.Literal) else None
    if not operators:
        here.report(node, f"Kw takes {_TAKES['Kw']}, not this", "for what value it has, write add(Kv, f(x))")
        return None
    if claim.operator not in operators:
        here.report(node, f'a fact here has the form f = v, not "{claim.operator}"')
        return None
    if not isinstance(claim.left, f.Application):
        hint = "write it on the left" if isinstance(claim.right, f.Application) else None
        here.report(node, "a fact about a value must have the function on its left", hint)
        return None
    declared, value_kind = here.find(claim.left.function), _kind_of(here, claim.right)
    if declared is not None and not here.vocabulary.types.fits(value_kind, declared.kind):
        value = f"the value of {claim.left.function} must be {with_article(declared.kind)}"
        here.report(node.parts[1], f"{value}, this is {with_article(value_kind)}")
        return None
    return claim


def _kind_of(here: NameResolver, term: f.Term) -> Kind:
    if isinstance(term, f.Number | f.Arithmetic):
        return NUMBERS
    if isinstance(term, f.External):
        name = term.procedure
    else:
        name = term.function if isinstance(term, f.Application) else term.name
    symbol = here.find(name)
    return ANY if symbol is None else symbol.kind
