"""A problem and a plan of unified-planning as Python source that builds both anew, with unified-planning alone.

unified-planning has no file format for contingent plans. The source is text that a person can read, and nothing of kabo is
needed to run it: `problem` and `plan` are what it leaves behind.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from unified_planning.model import ContingentProblem, SensingAction
from unified_planning.model.operators import OperatorKind
from unified_planning.plans import SequentialPlan

from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.up.exported import problem_to_up
from kabo.up.plans import plan_to_up

_CALLS = {
    OperatorKind.AND: "And",
    OperatorKind.OR: "Or",
    OperatorKind.NOT: "Not",
    OperatorKind.IMPLIES: "Implies",
    OperatorKind.IFF: "Iff",
    OperatorKind.PLUS: "Plus",
    OperatorKind.MINUS: "Minus",
    OperatorKind.TIMES: "Times",
    OperatorKind.DIV: "Div",
    OperatorKind.LE: "LE",
    OperatorKind.LT: "LT",
    OperatorKind.EQUALS: "Equals",
    OperatorKind.ALWAYS: "Always",
}
_IMPORTS = """from collections import OrderedDict
from fractions import Fraction

from unified_planning.model import ContingentProblem, SensingAction, Variable
from unified_planning.plans import ActionInstance, ContingentPlan, ContingentPlanNode, SequentialPlan
from unified_planning.shortcuts import *
"""


def export_up(problem: Problem, plan: Plan) -> str:
    """The plan for `kabo export --to up`: Python source that builds the problem and the plan in unified-planning.

    Its first lines are comments that name what unified-planning has no form for.

    Args:
        problem: the problem of the plan.
        plan: the plan; motions, certificates and the options that made it stay in its own file.

    Raises:
        InputError: the plan is too large as a tree, or belongs to another problem.
    """
    exported = problem_to_up(problem)
    written = source_of(exported.translation.original, plan_to_up(plan, exported.translation))
    notes = [f"# The plan of {plan.problem} for unified-planning, written by kabo: `problem` and `plan`."]
    if any(node.motion for node in plan.nodes.values()):
        notes.append("# Motions are not in it: they are in kabo's plan.")
    notes += [f"# left out: {' '.join(each.split())}" for each in exported.omitted]
    return "\n".join([*notes, written])


def source_of(problem: Any, plan: Any = None) -> str:
    """Python source that builds a problem of unified-planning and, if one is given, a plan: `problem` and `plan`."""
    writer = _Writer(problem)
    lines = [_IMPORTS, *writer.problem_lines()]
    if plan is not None:
        lines += ["", *writer.plan_lines(plan)]
    return "\n".join(lines) + "\n"


@dataclass
class _Writer:
    """Writes the source of one problem: things are found by name in the dictionaries that the source makes."""

    problem: Any

    def problem_lines(self) -> Iterator[str]:
        """The lines that build the problem."""
        problem = self.problem
        kind = "ContingentProblem" if isinstance(problem, ContingentProblem) else "Problem"
        yield "types = {}"
        for each in problem.user_types:
            father = "" if each.father is None else f", types[{each.father.name!r}]"
            yield f"types[{each.name!r}] = UserType({each.name!r}{father})"
        yield f"problem = {kind}({problem.name!r})"
        for each in problem.fluents:
            signature = self._signature(each.signature)
            yield f"problem.add_fluent(Fluent({each.name!r}, {self._type(each.type)}, {signature}))"
        for each in problem.all_objects:
            yield f"problem.add_object(Object({each.name!r}, {self._type(each.type)}))"
        for each in problem.actions:
            yield from self._action(each)
        for fluent, value in problem.explicit_initial_values.items():
            yield f"problem.set_initial_value({self._expression(fluent)}, {self._expression(value)})"
        for fluent, default in problem.fluents_defaults.items():
            if default is not None:
                yield f"problem._fluents_defaults[problem.fluent({fluent.name!r})] = {self._expression(default)}"
        if isinstance(problem, ContingentProblem):
            yield from self._constraints()
        for goal in problem.goals:
            yield f"problem.add_goal({self._expression(goal)})"
        for invariant in problem.state_invariants:
            yield f"problem.add_state_invariant({self._expression(invariant)})"
        yield from self._metrics()

    def _constraints(self) -> Iterator[str]:
        for constraint in self.problem.oneof_constraints:
            yield f"problem.add_oneof_initial_constraint({self._list(constraint)})"
        for constraint in self.problem.or_constraints:
            atoms = {each.arg(0) if each.is_not() else each for each in constraint}
            if len(constraint) == 2 and len(atoms) == 1:
                yield f"problem.add_unknown_initial_constraint({self._expression(atoms.pop())})"
            else:
                yield f"problem.add_or_initial_constraint({self._list(constraint)})"

    def _metrics(self) -> Iterator[str]:
        for metric in self.problem.quality_metrics:
            if metric.is_minimize_action_costs():
                costs = ", ".join(
                    f"problem.action({action.name!r}): {self._expression(cost)}"
                    for action, cost in metric.costs.items()
                    if cost is not None
                )
                default = "" if metric.default is None else f", default={self._expression(metric.default)}"
                yield f"problem.add_quality_metric(MinimizeActionCosts({{{costs}}}{default}))"
            elif metric.is_minimize_sequential_plan_length():
                yield "problem.add_quality_metric(MinimizeSequentialPlanLength())"

    def _type(self, kind: Any) -> str:
        if kind.is_user_type():
            return f"types[{kind.name!r}]"
        if kind.is_bool_type():
            return "BoolType()"
        bounds = (
            ""
            if (kind.lower_bound, kind.upper_bound) == (None, None)
            else f"{kind.lower_bound!r}, {kind.upper_bound!r}"
        )
        return f"{'IntType' if kind.is_int_type() else 'RealType'}({bounds})"

    def _signature(self, named: Any) -> str:
        """Names with types: as keywords, some of them would not be Python."""
        pairs = ", ".join(f"({each.name!r}, {self._type(each.type)})" for each in named)
        return f"OrderedDict([{pairs}])"

    def _action(self, action: Any) -> Iterator[str]:
        kind = "SensingAction" if isinstance(action, SensingAction) else "InstantaneousAction"
        yield f"action = {kind}({action.name!r}, {self._signature(action.parameters)})"
        for each in action.preconditions:
            yield f"action.add_precondition({self._expression(each)})"
        for effect in action.effects:
            word = (
                "effect"
                if effect.is_assignment()
                else "increase_effect"
                if effect.is_increase()
                else "decrease_effect"
            )
            parts = [self._expression(effect.fluent), self._expression(effect.value)]
            if not effect.condition.is_true():
                parts.append(self._expression(effect.condition))
            if effect.forall:
                parts.append(f"forall=[{', '.join(map(self._variable, effect.forall))}]")
            yield f"action.add_{word}({', '.join(parts)})"
        if isinstance(action, SensingAction):
            for each in action.observed_fluents:
                yield f"action.add_observed_fluent({self._expression(each)})"
        yield "problem.add_action(action)"

    # ---------------------------------------------------------------------------------------------------- the plan
    def plan_lines(self, plan: Any) -> Iterator[str]:
        """The lines that build a plan: of a tree, children come before their parents."""
        if isinstance(plan, SequentialPlan):
            yield "plan = SequentialPlan(["
            for each in plan.actions:
                yield f"    {self._instance(each)},"
            yield "])"
            return
        names: dict[int, str] = {}
        waiting = [] if plan.root_node is None else [plan.root_node]
        while waiting:
            node = waiting[-1]
            missing = [child for _, child in node.children if id(child) not in names]
            if missing:
                waiting += missing
                continue
            name = names[id(waiting.pop())] = f"node{len(names)}"
            yield f"{name} = ContingentPlanNode({self._instance(node.action_instance)})"
            for seen, child in node.children:
                pairs = ", ".join(
                    f"{self._expression(key)}: {self._expression(value)}" for key, value in seen.items()
                )
                yield f"{name}.add_child({{{pairs}}}, {names[id(child)]})"
        root = "None" if plan.root_node is None else names[id(plan.root_node)]
        yield f"plan = ContingentPlan({root}, problem.environment)"

    def _instance(self, instance: Any) -> str:
        parameters = "".join(f"{self._expression(each)}, " for each in instance.actual_parameters)
        return f"ActionInstance(problem.action({instance.action.name!r}), ({parameters}))"

    # ------------------------------------------------------------------------------------------------- expressions
    def _list(self, nodes: Any) -> str:
        return f"[{', '.join(map(self._expression, nodes))}]"

    def _variable(self, variable: Any) -> str:
        return f"Variable({variable.name!r}, {self._type(variable.type)})"

    def _expression(self, node: Any) -> str:
        kind = node.node_type
        if kind == OperatorKind.FLUENT_EXP:
            return f"problem.fluent({node.fluent().name!r})({', '.join(map(self._expression, node.args))})"
        if kind == OperatorKind.OBJECT_EXP:
            return f"ObjectExp(problem.object({node.object().name!r}))"
        if kind == OperatorKind.PARAM_EXP:
            return f"ParameterExp(action.parameter({node.parameter().name!r}))"
        if kind == OperatorKind.VARIABLE_EXP:
            return f"VariableExp({self._variable(node.variable())})"
        if kind == OperatorKind.BOOL_CONSTANT:
            return "TRUE()" if node.bool_constant_value() else "FALSE()"
        if kind == OperatorKind.INT_CONSTANT:
            return f"Int({node.constant_value()})"
        if kind == OperatorKind.REAL_CONSTANT:
            return f"Real({Fraction(node.constant_value())!r})"
        parts = ", ".join(map(self._expression, node.args))
        if kind in (OperatorKind.FORALL, OperatorKind.EXISTS):
            word = "Forall" if kind == OperatorKind.FORALL else "Exists"
            return f"{word}({parts}, {', '.join(map(self._variable, node.variables()))})"
        return f"{_CALLS[kind]}({parts})"
