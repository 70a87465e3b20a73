"""Translates expressions of unified-planning into kabo's terms and formulas, negations pushed inwards to the claims.

As in PDDL, K stands around every claim [docs/reference/languages.md#pddl].
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from unified_planning.model.operators import OperatorKind

from kabo.language import ProblemBuilder
from kabo.language import formulas as f
from kabo.language.connectives import conjunction, denied, disjunction
from kabo.up.names import Names


class Unsayable(Exception):
    """An expression that kabo has no form for; the text says which."""


@dataclass(frozen=True)
class Expressions:
    """Translates the expressions of one problem; `scope` has the parameters and variables in force, by their names."""

    builder: ProblemBuilder
    names: Names
    scope: Mapping[str, f.Variable]

    def inside(self, variables: Any) -> "tuple[tuple[f.Variable, ...], Expressions]":
        """Kabo's variables for parameters or variables of unified-planning, and the translator within their scope."""
        scope, own = dict(self.scope), []
        for each in variables:
            if not each.type.is_user_type():
                raise Unsayable(f'"{each.name}" ranges over values, not over objects')
            made = self.builder.variable(each.name, self.names.types[each.type.name], scope.values())
            scope[each.name] = made
            own.append(made)
        return tuple(own), replace(self, scope=scope)

    # -------------------------------------------------------------------------------------------------------- terms
    def term(self, node: Any) -> f.Term:
        """A number, an object, or what has one of these as its value.

        Raises:
            Unsayable: kabo has no form for it.
        """
        kind = node.node_type
        if kind == OperatorKind.OBJECT_EXP:
            return f.Constant(self.names.objects[node.object().name])
        if kind == OperatorKind.PARAM_EXP:
            return self._variable(node.parameter())
        if kind == OperatorKind.VARIABLE_EXP:
            return self._variable(node.variable())
        if kind in (OperatorKind.INT_CONSTANT, OperatorKind.REAL_CONSTANT):
            return f.Number(number(node.constant_value()))
        if kind == OperatorKind.FLUENT_EXP and not node.type.is_bool_type():
            return f.Application(self.names.fluents[node.fluent().name], tuple(map(self.term, node.args)))
        if kind in _ARITHMETIC:
            terms = [self.term(each) for each in node.args]
            whole = terms[0]
            for each in terms[1:]:
                whole = f.Arithmetic(_ARITHMETIC[kind], whole, each)  # type: ignore[arg-type]
            return whole
        raise Unsayable(f'"{node}" is no value in kabo')

    def atom(self, node: Any) -> f.Atom:
        """An expression of a boolean fluent.

        Raises:
            Unsayable: kabo has no form for one of its arguments.
        """
        return f.Atom(self.names.fluents[node.fluent().name], tuple(map(self.term, node.args)))

    def _variable(self, named: Any) -> f.Variable:
        if named.name not in self.scope:
            raise Unsayable(f'"{named.name}" is no object')
        return self.scope[named.name]

    # --------------------------------------------------------------------------------------------------- conditions
    def condition(self, node: Any, positive: bool = True) -> f.Formula:
        """The query for a condition, or for its negation if not `positive`.

        Raises:
            Unsayable: kabo has no form for a part of it.
        """
        kind = node.node_type
        if kind == OperatorKind.BOOL_CONSTANT:
            return f.Truth(node.bool_constant_value() == positive)
        if kind == OperatorKind.NOT:
            return self.condition(node.arg(0), not positive)
        if kind == OperatorKind.FLUENT_EXP and node.type.is_bool_type():
            return f.Know(f.Literal(self.atom(node), positive))
        if kind in (OperatorKind.AND, OperatorKind.OR):
            parts = [self.condition(each, positive) for each in node.args]
            return (conjunction if (kind == OperatorKind.AND) == positive else disjunction)(parts)
        if kind == OperatorKind.IMPLIES:
            first, second = self.condition(node.arg(0), not positive), self.condition(node.arg(1), positive)
            return (disjunction if positive else conjunction)([first, second])
        if kind in (OperatorKind.FORALL, OperatorKind.EXISTS):
            return self._quantified(node, positive)
        if kind == OperatorKind.IFF or (kind == OperatorKind.EQUALS and node.arg(0).type.is_bool_type()):
            first, second = node.args
            same = conjunction([self.condition(first), self.condition(second, positive)])
            return disjunction(
                [same, conjunction([self.condition(first, False), self.condition(second, not positive)])]
            )
        if kind in _COMPARISONS:
            return self._comparison(_COMPARISONS[kind], node, positive)
        raise Unsayable(f'"{node}" is no condition in kabo')

    def _comparison(self, operator: str, node: Any, positive: bool) -> f.Formula:
        left, right = map(self.term, node.args)
        if isinstance(left, f.Constant) and isinstance(right, f.Constant):
            return f.Truth((left == right) == positive)
        if isinstance(left, f.Number) and isinstance(right, f.Number):
            return f.Truth(_HOLDS[operator](left.value, right.value) == positive)
        if not isinstance(left, f.Application) and isinstance(right, f.Application) and operator == "=":
            left, right = right, left  # effects of unknown outcome compare a term with a value
        claim: f.Claim = f.Comparison(operator, left, right)  # type: ignore[arg-type]
        return f.Know(claim if positive else denied(claim))

    def _quantified(self, node: Any, positive: bool) -> f.Formula:
        universal = (node.node_type == OperatorKind.FORALL) == positive
        variables, inner = self.inside(node.variables())
        body = inner.condition(node.arg(0), positive)
        if isinstance(body, f.Truth) and body.value == universal:
            return body  # whatever the instances, even if there are none
        return f.Forall(variables, body) if universal else f.Exists(variables, body)


_ARITHMETIC = {OperatorKind.PLUS: "+", OperatorKind.MINUS: "-", OperatorKind.TIMES: "*", OperatorKind.DIV: "/"}
_COMPARISONS = {OperatorKind.LE: "<=", OperatorKind.LT: "<", OperatorKind.EQUALS: "="}
_HOLDS: dict[str, Callable[[float, float], bool]] = {
    "<=": lambda a, b: a <= b,
    "<": lambda a, b: a < b,
    "=": lambda a, b: a == b,
}


def number(value: int | Fraction) -> float:
    """A number of unified-planning, which are exact, as one of kabo, which are floating point.

    Raises:
        Unsayable: it is too large.
    """
    try:
        return float(value)
    except OverflowError:
        raise Unsayable("a number is larger than any floating-point number") from None
