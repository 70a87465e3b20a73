"""Contingent PDDL of a problem of unified-planning: its own writer leaves out `:observe`, `unknown`, `oneof` and `or`.

What is written is read by kabo (docs/reference/languages.md#pddl) and, but for functions with objects as values, by
unified-planning's `PDDLReader`. Names are those of kabo's plans, since PDDL does not know all that unified-planning allows.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from unified_planning.model import ContingentProblem, SensingAction
from unified_planning.model.operators import OperatorKind

from kabo.errors import Diagnostic, InputError
from kabo.up.names import Names
from kabo.up.problems import costs_of, hidden_of, instances_of, problem_from_up

_WORDS = {
    OperatorKind.AND: "and",
    OperatorKind.OR: "or",
    OperatorKind.NOT: "not",
    OperatorKind.IMPLIES: "imply",
    OperatorKind.PLUS: "+",
    OperatorKind.MINUS: "-",
    OperatorKind.TIMES: "*",
    OperatorKind.DIV: "/",
    OperatorKind.LE: "<=",
    OperatorKind.LT: "<",
    OperatorKind.EQUALS: "=",
}
_COST = "total-cost"  # kabo's names have no hyphen


def pddl_from_up(problem: Any) -> tuple[str, str]:
    """A problem of unified-planning as PDDL, with what is sensed and what is unknown: the domain, and the problem.

    Raises:
        InputError: kabo does not support the problem, or PDDL has no form for it (bounds of numbers, state invariants,
            fractions that are no decimals); says what.
    """
    names = problem_from_up(problem).names
    refused = list(_beyond(problem))
    if refused:
        raise InputError(Diagnostic(problem.name or "problem", 1, 1, each) for each in refused)
    writer = _Writer(problem, names)
    return writer.domain(), writer.problem_text()


def _beyond(problem: Any) -> Iterator[str]:
    if problem.state_invariants:
        yield "state invariants are not written as PDDL"
    for fluent in problem.fluents:
        kind = fluent.type
        if (kind.is_int_type() or kind.is_real_type()) and (kind.lower_bound, kind.upper_bound) != (None, None):
            yield f'PDDL has no bounds of numbers, as "{fluent.name}" has them'


@dataclass
class _Writer:
    original: Any
    names: Names

    # ---------------------------------------------------------------------------------------------------- the domain
    def domain(self) -> str:
        """`(define (domain …) …)`."""
        problem = self.original
        predicates = [self._declared(each) for each in problem.fluents if each.type.is_bool_type()]
        functions = [
            f"{self._declared(each)} - {self.names.types[each.type.name] if each.type.is_user_type() else 'number'}"
            for each in problem.fluents
            if not each.type.is_bool_type()
        ]
        if costs_of(problem) is not None:
            functions.append(f"({_COST}) - number")
        parts = [f"(define (domain {self._title()})", f"  (:requirements {' '.join(self._requirements())})"]
        if problem.user_types:
            parts.append(f"  (:types {self._types()})")
        if problem.all_objects:
            parts.append(f"  (:constants {self._objects()})")
        if predicates:
            parts.append(f"  (:predicates {' '.join(predicates)})")
        if functions:
            parts.append(f"  (:functions {' '.join(functions)})")
        return "\n".join([*parts, *map(self._action, problem.actions)]) + ")\n"

    def _requirements(self) -> Iterator[str]:
        yield from (":adl", ":typing", ":equality")
        if any(not each.type.is_bool_type() for each in self.original.fluents):
            yield ":fluents"
        if isinstance(self.original, ContingentProblem):
            yield ":contingent"
        if costs_of(self.original) is not None:
            yield ":action-costs"

    def _title(self) -> str:
        return self.names.title

    def _types(self) -> str:
        names = self.names.types
        return " ".join(
            f"{names[each.name]} - {'object' if each.father is None else names[each.father.name]}"
            for each in self.original.user_types
        )

    def _objects(self) -> str:
        return " ".join(
            f"{self.names.objects[each.name]} - {self.names.types[each.type.name]}"
            for each in self.original.all_objects
        )

    def _declared(self, fluent: Any) -> str:
        return f"({' '.join([self.names.fluents[fluent.name], *self._variables(fluent.signature)])})"

    def _variables(self, named: Iterable[Any]) -> Iterator[str]:
        return (f"?{self._variable(each)} - {self.names.types[each.type.name]}" for each in named)

    def _variable(self, named: Any) -> str:
        return self.names.variable(named.name)

    def _action(self, action: Any) -> str:
        effects = [each for effect in action.effects for each in self._effects(effect)]
        costs = costs_of(self.original)
        if costs is not None:
            effects.append(f"(increase ({_COST}) {self._expression(costs[action.name])})")
        parts = [
            f"  (:action {self.names.actions[action.name]}",
            f"    :parameters ({' '.join(self._variables(action.parameters))})",
            f"    :precondition (and {' '.join(map(self._expression, action.preconditions))})",
        ]
        if effects or not isinstance(action, SensingAction):
            parts.append(f"    :effect (and {' '.join(effects)})")
        if isinstance(action, SensingAction):
            observed = list(map(self._expression, action.observed_fluents))
            whole = observed[0] if len(observed) == 1 else f"(and {' '.join(observed)})"
            parts.append(f"    :observe {whole}")
        return "\n".join(parts) + ")"

    def _effects(self, effect: Any) -> Iterator[str]:
        """The effects of one: a computed truth value takes two."""
        fluent, value = self._expression(effect.fluent), effect.value
        if not effect.fluent.type.is_bool_type():
            word = "assign" if effect.is_assignment() else "increase" if effect.is_increase() else "decrease"
            made = [(effect.condition, f"({word} {fluent} {self._expression(value)})")]
        elif value.is_bool_constant():
            made = [(effect.condition, fluent if value.bool_constant_value() else f"(not {fluent})")]
        else:
            manager = self.original.environment.expression_manager
            made = [
                (manager.And(effect.condition, value), fluent),
                (manager.And(effect.condition, manager.Not(value)), f"(not {fluent})"),
            ]
        for condition, text in made:
            whole = text if condition.is_true() else f"(when {self._expression(condition)} {text})"
            bound = " ".join(self._variables(effect.forall))
            yield f"(forall ({bound}) {whole})" if bound else whole

    # --------------------------------------------------------------------------------------------------- the problem
    def problem_text(self) -> str:
        """`(define (problem …) …)`."""
        problem = self.original
        goals = " ".join(map(self._expression, problem.goals))
        parts = [f"(define (problem {self._title()}_problem)", f"  (:domain {self._title()})", "  (:init"]
        parts += [f"    {each}" for each in self._start()]
        parts[-1] += ")"
        parts.append(f"  (:goal (and {goals}))")
        if costs_of(problem) is not None:
            parts.append(f"  (:metric minimize ({_COST}))")
        return "\n".join(parts) + ")\n"

    def _start(self) -> Iterator[str]:
        problem = self.original
        hidden = hidden_of(problem)
        if costs_of(problem) is not None:
            yield f"(= ({_COST}) 0)"
        for fluent in problem.fluents:
            for node in instances_of(problem, fluent):
                value = None if node in hidden else problem.initial_value(node)
                if value is None:
                    continue
                if not fluent.type.is_bool_type():
                    yield f"(= {self._expression(node)} {self._expression(value)})"
                elif value.bool_constant_value():
                    yield self._expression(node)
        if isinstance(problem, ContingentProblem):
            for constraint in problem.oneof_constraints:
                yield f"(oneof {' '.join(map(self._expression, constraint))})"
            for constraint in problem.or_constraints:
                atoms = {each.arg(0) if each.is_not() else each for each in constraint}
                if len(constraint) == 2 and len(atoms) == 1:
                    yield f"(unknown {self._expression(atoms.pop())})"
                else:
                    yield f"(or {' '.join(map(self._expression, constraint))})"

    # --------------------------------------------------------------------------------------------------- expressions
    def _expression(self, node: Any) -> str:
        kind = node.node_type
        if kind == OperatorKind.FLUENT_EXP:
            return f"({' '.join([self.names.fluents[node.fluent().name], *map(self._expression, node.args)])})"
        if kind == OperatorKind.OBJECT_EXP:
            return self.names.objects[node.object().name]
        if kind in (OperatorKind.PARAM_EXP, OperatorKind.VARIABLE_EXP):
            return f"?{self._variable(node.parameter() if kind == OperatorKind.PARAM_EXP else node.variable())}"
        if kind in (OperatorKind.INT_CONSTANT, OperatorKind.REAL_CONSTANT):
            return _decimal(node.constant_value(), self.original.name)
        if kind == OperatorKind.BOOL_CONSTANT:
            return "(and )" if node.bool_constant_value() else "(or )"
        if kind in (OperatorKind.FORALL, OperatorKind.EXISTS):
            word = "forall" if kind == OperatorKind.FORALL else "exists"
            return f"({word} ({' '.join(self._variables(node.variables()))}) {self._expression(node.arg(0))})"
        parts = list(map(self._expression, node.args))
        if kind == OperatorKind.IFF or (kind == OperatorKind.EQUALS and node.arg(0).type.is_bool_type()):
            return f"(and (imply {parts[0]} {parts[1]}) (imply {parts[1]} {parts[0]}))"
        return f"({_WORDS[kind]} {' '.join(parts)})"


def _decimal(value: int | Fraction, name: str | None) -> str:
    """A number as an exact decimal.

    Raises:
        InputError: it has none, as one third.
    """
    exact = Fraction(value)
    places = next((each for each in range(40) if (exact * 10**each).denominator == 1), None)
    if places is None:
        raise InputError([Diagnostic(name or "problem", 1, 1, f"PDDL cannot say {value}, which is no decimal")])
    if places == 0:
        return str(exact.numerator)
    digits = str(abs(int(exact * 10**places))).rjust(places + 1, "0")
    return f"{'-' if exact < 0 else ''}{digits[:-places]}.{digits[-places:]}"
