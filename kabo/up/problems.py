"""Turns a problem of unified-planning into one of kabo, in memory: declarations, actions, start and goal.

Conditions are about the world, as in PDDL; hidden fluents of a `ContingentProblem` are unknown at the start, `or` and
`oneof` constraints are known, and sensing actions sense their observed fluents. Bounds of numeric fluents and state
invariants hold at all times: `always(…)` in the goal.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

from unified_planning.model import ContingentProblem, SensingAction
from unified_planning.model import Problem as UPProblem
from unified_planning.model.operators import OperatorKind

from kabo.errors import Diagnostic, InputError
from kabo.language import ConditionalEffect, ProblemBuilder, WorldAction
from kabo.language import formulas as f
from kabo.language.connectives import conjunction
from kabo.language.problem import Problem
from kabo.up.expressions import Expressions, Unsayable, number
from kabo.up.kinds import refusals
from kabo.up.names import Names

_LARGEST = 2**32


@dataclass(frozen=True)
class Translation:
    """A problem of unified-planning and the same problem in kabo.

    Attributes:
        original: the problem of unified-planning.
        problem: the same in kabo.
        names: what everything is called in kabo.
        exact: whether kabo's arithmetic, in floating point, is certain to agree with unified-planning's fractions.
    """

    original: Any
    problem: Problem
    names: Names
    exact: bool


def problem_from_up(problem: Any) -> Translation:
    """The problem of kabo that says the same as one of unified-planning.

    Args:
        problem: a `unified_planning.model.Problem` or `ContingentProblem`.

    Raises:
        InputError: the problem uses what kabo does not support; names everything of this kind.
    """
    name = problem.name or "problem"
    beyond = refusals(problem.kind)
    if not beyond and not isinstance(problem, UPProblem):
        beyond = [f"kabo does not plan for a {type(problem).__name__}"]
    if beyond:
        raise InputError(Diagnostic(name, 1, 1, each) for each in beyond)
    return _Translator(problem, ProblemBuilder(name), Names()).translation()


@dataclass
class _Translator:
    original: Any
    builder: ProblemBuilder
    names: Names
    exact: bool = True

    def translation(self) -> Translation:
        """Everything, in the order of the problem.

        Raises:
            InputError: something cannot be said in kabo.
        """
        self._declare()
        self.outer = Expressions(self.builder, self.names, {})
        costs = costs_of(self.original)
        for action in self.original.actions:
            with_cost = costs.get(action.name) if costs is not None else None
            try:
                self.names.actions[action.name] = self.builder.action(self._action(action, with_cost))
            except Unsayable as error:
                self.builder.refuse(f'in action "{action.name}": {error}')
        goal: list[f.Formula] = []
        try:
            self._start()
            goal = self._goal()
        except Unsayable as error:
            self.builder.refuse(f"in the initial state or the goal: {error}")
        made = self.builder.problem(goal)
        self.names.title = made.name
        return Translation(self.original, made, self.names, _is_exact(self.original))

    # ------------------------------------------------------------------------------------------------ declarations
    def _declare(self) -> None:
        problem = self.original
        waiting = list(problem.user_types)
        for kind in waiting:  # the list grows: parents come before their children
            father = kind.father
            if father is not None and father.name not in self.names.types:
                waiting.append(kind)
                continue
            parent = None if father is None else self.names.types[father.name]
            self.names.types[kind.name] = self.builder.type(kind.name, parent)
        for fluent in problem.fluents:
            arguments = [self.names.types[each.type.name] for each in fluent.signature]
            if fluent.type.is_bool_type():
                self.names.fluents[fluent.name] = self.builder.predicate(fluent.name, arguments)
            else:
                value = self.names.types[fluent.type.name] if fluent.type.is_user_type() else None
                self.names.fluents[fluent.name] = self.builder.function(fluent.name, arguments, value)
        for each in problem.all_objects:
            kind = self.names.types[each.type.name]
            self.names.objects[each.name] = self.builder.object(each.name, kind).name

    # ----------------------------------------------------------------------------------------------------- actions
    def _action(self, action: Any, cost: Any) -> WorldAction:
        parameters, inner = self.outer.inside(action.parameters)
        conditions = conjunction([inner.condition(each) for each in action.preconditions])
        preconditions = list(conditions.parts) if isinstance(conditions, f.And) else [conditions]
        pieces = [piece for each in action.effects for piece in _effects(inner, each)]
        repeated = {
            id(piece) for number, piece in enumerate(pieces) if piece in pieces[:number] and not piece.changes
        }
        effects = [piece for piece in pieces if id(piece) not in repeated]
        sensed = [_sensed(inner, each) for each in action.observed_fluents] if _senses(action) else []
        return WorldAction(
            action.name, parameters, [each for each in preconditions if each != f.Truth(True)], effects, sensed,
            None if cost is None else inner.term(cost),
        )  # fmt: skip

    # ----------------------------------------------------------------------------------------------- start and goal
    def _start(self) -> None:
        problem, start = self.original, self.builder.start
        hidden = hidden_of(problem)
        for fluent in problem.fluents:
            for node in instances_of(problem, fluent):
                if node in hidden:
                    continue
                value = problem.initial_value(node)
                if fluent.type.is_bool_type():
                    atom = self.outer.atom(node)
                    if value.bool_constant_value():
                        start.facts[atom] = f.Literal(atom)
                else:
                    term = self.outer.term(node)
                    assert isinstance(term, f.Application)
                    start.values[term] = f.Comparison("=", term, self.outer.term(value))
        if isinstance(problem, ContingentProblem):
            for constraint in problem.oneof_constraints:
                self.builder.exactly_one(map(self._claim, constraint))
            for constraint in problem.or_constraints:
                self.builder.at_least_one(map(self._claim, constraint))

    def _claim(self, node: Any) -> f.Claim:
        """A member of a constraint: that a boolean fluent holds or not, or that another one has a value."""
        formula = self.outer.condition(node)
        if isinstance(formula, f.Know):
            claim = formula.claim
            if isinstance(claim, f.Literal):
                return claim
            if claim.operator == "=" and isinstance(claim.right, f.Constant):
                return claim
        raise Unsayable(
            f'"{node}" in a constraint is neither a boolean fluent nor that one has an object as its value'
        )

    def _goal(self) -> list[f.Formula]:
        problem = self.original
        whole = conjunction([self.outer.condition(each) for each in problem.goals])
        goal = list(whole.parts) if isinstance(whole, f.And) else [whole]
        goal += [f.Temporal("always", self.outer.condition(each)) for each in problem.state_invariants]
        return [each for each in [*goal, *self._bounds()] if each != f.Truth(True)]

    def _bounds(self) -> Iterator[f.Formula]:
        """That numbers stay within the bounds of their types, where an action changes them."""
        changed = {effect.fluent.fluent() for action in self.original.actions for effect in action.effects}
        for fluent in self.original.fluents:
            kind = fluent.type
            if fluent not in changed or not (kind.is_int_type() or kind.is_real_type()):
                continue
            variables, _ = self.outer.inside(fluent.signature)
            term = f.Application(self.names.fluents[fluent.name], variables)
            bounds: list[f.Formula] = []
            if kind.lower_bound is not None:
                bounds.append(f.Know(f.Comparison(">=", term, f.Number(number(kind.lower_bound)))))
            if kind.upper_bound is not None:
                bounds.append(f.Know(f.Comparison("<=", term, f.Number(number(kind.upper_bound)))))
            if bounds:
                both = conjunction(bounds)
                yield f.Temporal("always", f.Forall(variables, both) if variables else both)


def _effects(here: Expressions, effect: Any) -> Iterator[ConditionalEffect]:
    """The conditional effects of one effect: a computed truth value gives two of them."""
    variables, inner = here.inside(effect.forall)
    condition = inner.condition(effect.condition)
    arguments = tuple(map(inner.term, effect.fluent.args))
    name = here.names.fluents[effect.fluent.fluent().name]
    if effect.fluent.type.is_bool_type():
        atom = f.Atom(name, arguments)
        for positive in (True, False):
            when = conjunction([condition, inner.condition(effect.value, positive)])
            if when != f.Truth(False):
                yield ConditionalEffect(variables, when, f.Literal(atom, positive))
        return
    term, value = f.Application(name, arguments), inner.term(effect.value)
    changes = not effect.is_assignment()
    if changes:
        value = f.Arithmetic("+" if effect.is_increase() else "-", term, value)
    if condition != f.Truth(False):
        yield ConditionalEffect(variables, condition, f.Comparison("=", term, value), changes)


def _sensed(here: Expressions, node: Any) -> f.Atom | f.Application:
    if node.node_type == OperatorKind.FLUENT_EXP and node.type.is_bool_type():
        return here.atom(node)
    term = here.term(node)
    if isinstance(term, f.Application) and node.type.is_user_type():
        return term
    raise Unsayable(f'"{node}" cannot be sensed: kabo senses boolean fluents and those with objects as values')


def _senses(action: Any) -> bool:
    return isinstance(action, SensingAction)


def instances_of(problem: Any, fluent: Any) -> Iterator[Any]:
    """A fluent with all combinations of objects as its arguments."""
    domains = [list(problem.objects(each.type)) for each in fluent.signature]
    for objects in product(*domains):
        yield fluent(*objects)


def hidden_of(problem: Any) -> set[Any]:
    """The fluents about which something is unknown at the start; their values, if any are given, do not count."""
    if not isinstance(problem, ContingentProblem):
        return set()
    return {each if each.is_fluent_exp() else each.arg(0) for each in problem.hidden_fluents}


def costs_of(problem: Any) -> dict[str, Any] | None:
    """The cost of each action, by its name; None if all cost the same."""
    for metric in problem.quality_metrics:
        if metric.is_minimize_action_costs():
            zero = problem.environment.expression_manager.Int(0)
            return {each.name: metric.get_action_cost(each) or zero for each in problem.actions}
    return None


def _is_exact(problem: Any) -> bool:
    """Whether numbers are integers that are only added, subtracted and compared: then floating point is exact.

    With integers up to 2³², 2²⁰ steps stay below 2⁵³, and no search expands more nodes than some two millions.
    """
    return not any(map(_is_numeric, _values(problem))) or all(map(_is_integer, _values(problem)))


def _values(problem: Any) -> Iterator[Any]:
    """All expressions of a problem with their parts, those of its initial values, of its bounds and of its costs too."""
    waiting = [*problem.goals, *problem.state_invariants, *problem.explicit_initial_values.values()]
    waiting += [each for each in problem.fluents_defaults.values() if each is not None]
    waiting += (costs_of(problem) or {}).values()
    for action in problem.actions:
        waiting += action.preconditions
        for effect in action.effects:
            waiting += [effect.fluent, effect.value, effect.condition]
    number_of = problem.environment.expression_manager.auto_promote
    for kind in {each.type for each in problem.fluents if each.type.is_int_type() or each.type.is_real_type()}:
        waiting += [
            each
            for bound in (kind.lower_bound, kind.upper_bound)
            if bound is not None
            for each in number_of(bound)
        ]
    seen = set()
    while waiting:
        node = waiting.pop()
        if node not in seen:
            seen.add(node)
            waiting += node.args
            yield node


def _is_numeric(node: Any) -> bool:
    return bool(node.type.is_int_type() or node.type.is_real_type())


def _is_integer(node: Any) -> bool:
    """Whether an expression is none of numbers, or exact: no product, no quotient, no fraction, no large number."""
    if node.node_type in (OperatorKind.REAL_CONSTANT, OperatorKind.INT_CONSTANT):
        value = Fraction(node.constant_value())
        return value.denominator == 1 and abs(value) <= _LARGEST
    return node.node_type not in (OperatorKind.DIV, OperatorKind.TIMES)
