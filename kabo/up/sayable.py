"""kabo's formulas, terms and effects as expressions and effects of unified-planning, as far as it has them.

unified-planning's conditions are about the world. `K(p)` becomes p; what is about knowledge alone (`not K(p)`, `Kw`, `Kv`,
forgetting) has no form there.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from unified_planning.model import Variable

from kabo.language import formulas as f


class Beyond(Exception):
    """A part of a problem that unified-planning has no form for."""


@dataclass(frozen=True)
class Assignment:
    """One effect, as unified-planning has it: for all `variables`, `fluent` gets the `value` if the `condition` holds."""

    fluent: Any
    value: Any
    condition: Any
    variables: tuple[Any, ...]


@dataclass(frozen=True)
class Sayer:
    """Translates the trees of one problem; `scope` has the parameters and variables in force."""

    manager: Any  # unified-planning's of expressions
    types: Mapping[str, Any]
    fluents: Mapping[str, Any]
    objects: Mapping[str, Any]
    values: Mapping[str, Mapping[str, Any]]  # function -> value of its enumeration -> object
    scope: Mapping[str, Any]

    def inside(self, variables: tuple[f.Variable, ...]) -> "tuple[tuple[Any, ...], Sayer]":
        """unified-planning's variables for kabo's, and the translator within their scope."""
        made = tuple(Variable(each.name, self.types[each.type], self.manager.environment) for each in variables)
        bound = dict(zip((each.name for each in variables), map(self.manager.VariableExp, made), strict=True))
        return made, replace(self, scope={**self.scope, **bound})

    # -------------------------------------------------------------------------------------------------------- terms
    def term(self, term: f.Term, function: str = "") -> Any:
        """A term; where it is the value of a `function`, a constant may be one of its listed values.

        Raises:
            Beyond: it is the value of an external procedure.
        """
        match term:
            case f.Constant(name=name):
                listed = self.values.get(function, {})
                return self.manager.ObjectExp(listed[name] if name in listed else self.objects[name])
            case f.Variable(name=name):
                if name not in self.scope:
                    raise Beyond(f'"{name}" is known only at run time')
                return self.scope[name]
            case f.Number(value=value):
                return self.manager.auto_promote(Fraction(value))[0]
            case f.Application(function=name, arguments=arguments):
                return self.manager.FluentExp(self.fluents[name], tuple(map(self.term, arguments)))
            case f.Arithmetic(operator=operator, left=left, right=right):
                make = {"+": "Plus", "-": "Minus", "*": "Times", "/": "Div"}[operator]
                return getattr(self.manager, make)(self.term(left), self.term(right))
        raise Beyond("the value of an external procedure")

    def atom(self, atom: f.Atom) -> Any:
        """A predicate with its arguments.

        Raises:
            Beyond: an argument has no form.
        """
        return self.manager.FluentExp(self.fluents[atom.predicate], tuple(map(self.term, atom.arguments)))

    def claim(self, claim: f.Claim) -> Any:
        """A claim about the world.

        Raises:
            Beyond: a part of it has no form.
        """
        if isinstance(claim, f.Literal):
            atom = self.atom(claim.atom)
            return atom if claim.positive else self.manager.Not(atom)
        left, right = claim.left, claim.right
        function = next((each.function for each in (left, right) if isinstance(each, f.Application)), "")
        one, other = self.term(left, function), self.term(right, function)
        equal = claim.operator in ("=", "!=")
        name = "Equals" if equal else {"<": "LT", "<=": "LE", ">": "GT", ">=": "GE"}[claim.operator]
        made = getattr(self.manager, name)(one, other)
        return self.manager.Not(made) if claim.operator == "!=" else made

    # --------------------------------------------------------------------------------------------------- conditions
    def formula(self, formula: f.Formula) -> Any:
        """A query, as a condition on the world.

        Raises:
            Beyond: it is about knowledge alone, or asks a procedure.
        """
        match formula:
            case f.Know(claim=claim):
                return self.claim(claim)
            case f.Truth(value=value):
                return self.manager.Bool(value)
            case f.And(parts=parts):
                return self.manager.And(*map(self.formula, parts))
            case f.Or(parts=parts):
                return self.manager.Or(*map(self.formula, parts))
            case f.Forall(variables=variables, body=body):
                own, inner = self.inside(variables)
                return self.manager.Forall(inner.formula(body), *own)
            case f.Exists(variables=variables, body=body):
                own, inner = self.inside(variables)
                return self.manager.Exists(inner.formula(body), *own)
            case f.Temporal(kind="always", body=body):
                return self.manager.Always(self.formula(body))
        raise Beyond("it is about knowledge, not about the world")

    # ------------------------------------------------------------------------------------------------------ effects
    def assignments(
        self, effect: f.Effect, condition: Any = None, bound: tuple[Any, ...] = ()
    ) -> Iterator[Assignment]:
        """The effects of unified-planning that an effect of kabo becomes.

        Raises:
            Beyond: it changes knowledge, not the world.
        """
        condition = self.manager.TRUE() if condition is None else condition
        match effect:
            case f.Change(operation="add", database="Kf", facts=facts):
                for fact in facts:
                    yield self._assigned(fact, condition, bound)
            case f.WorldEffect(conditions=conditions, outcomes=outcomes):
                both = self.manager.And(condition, *map(self.claim, conditions))
                for outcome in outcomes:
                    yield self._assigned(outcome, both, bound)
            case f.Conditional(condition=query, updates=updates):
                both = self.manager.And(condition, self.formula(query))
                for each in updates:
                    yield from self.assignments(each, both, bound)
            case f.ForEach(variables=variables, effects=effects):
                own, inner = self.inside(variables)
                for each in effects:
                    yield from inner.assignments(each, condition, (*bound, *own))
            case _:
                raise Beyond("it changes what is known, not the world")

    def _assigned(self, fact: f.Fact, condition: Any, bound: tuple[Any, ...]) -> Assignment:
        if isinstance(fact, f.Literal):
            return Assignment(self.atom(fact.atom), self.manager.Bool(fact.positive), condition, bound)
        if isinstance(fact, f.Comparison) and fact.operator == "=" and isinstance(fact.left, f.Application):
            return Assignment(self.term(fact.left), self.term(fact.right, fact.left.function), condition, bound)
        raise Beyond("what becomes so is no literal and no value")
