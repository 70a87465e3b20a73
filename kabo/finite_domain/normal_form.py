"""Effects of operators, sorted: unconditional, dependent on one variable (switches), and others (guarded).

A switch gives for every value of its variable the assignments to make, so that any number of effects takes one
look-up. Operators whose effects depend on a variable in the same way share the switch.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from kabo.finite_domain.task import Effect, FiniteTask, Operator, merged

Assignments = tuple[tuple[int, int], ...]  # (variable, value)
Tests = dict[int, tuple[int, ...]]  # variable: the values it may have


@dataclass(frozen=True)
class ValueSwitch:
    """A switch: the assignments to make for each previous value of one variable; none for values not listed."""

    variable: int
    outcomes: dict[int, Assignments]


@dataclass(frozen=True)
class NormalOperator:
    """An operator with its effects sorted into unconditional ones, switches (by index) and guarded ones."""

    tests: Tests
    always: Assignments
    switches: tuple[int, ...]
    guarded: tuple[tuple[Tests, Assignments], ...]
    cost: int


@dataclass(frozen=True)
class NormalTask:
    """A task with its effects sorted by kind; operators that are never applicable are None."""

    sizes: tuple[int, ...]
    operators: tuple[NormalOperator | None, ...]
    switches: tuple[ValueSwitch, ...]
    goal: Tests


def normal_form(task: FiniteTask) -> NormalTask:
    """The same task with its effects sorted by kind."""
    sizes = tuple(v.size for v in task.variables)
    known: dict[tuple[int, tuple[tuple[tuple[int, ...], int, int], ...]], int] = {}
    switches: list[ValueSwitch] = []

    def intern(variable: int, rules: list[tuple[tuple[int, ...], int, int]]) -> int:
        rules.sort(key=_target)  # the last rule for a variable counts; among others the order means nothing
        key = (variable, tuple(rules))
        if key not in known:
            known[key] = len(switches)
            switches.append(_switch(variable, rules))
        return known[key]

    operators = []
    for o in task.operators:
        tests = merged(o.preconditions, sizes)
        operators.append(None if () in tests.values() else _sorted_operator(o, tests, sizes, intern))
    return NormalTask(sizes, tuple(operators), tuple(switches), merged(task.goal, sizes))


def _sorted_operator(o: Operator, tests: Tests, sizes: Sequence[int], intern) -> NormalOperator:  # type: ignore[no-untyped-def]
    always: dict[int, int] = {}
    met: dict[int, int] = {}  # effects whose conditions the preconditions imply: they win over unconditional ones
    by_variable: dict[int, list[tuple[tuple[int, ...], int, int]]] = {}
    guarded: dict[tuple[tuple[int, tuple[int, ...]], ...], list[tuple[int, int]]] = {}
    for e in o.effects:
        if not e.conditions:
            always[e.variable] = e.value
            continue
        if len(e.conditions) == 1:  # the quick way for most effects
            ((v, values),) = e.conditions
            if len(values) == 1 and v not in tests and sizes[v] > 1:
                by_variable.setdefault(v, []).append((values, e.variable, e.value))
                continue
        left = _left_to_test(e, tests, sizes)
        if left is None:
            continue
        if not left:
            met[e.variable] = e.value
        elif len(left) == 1:
            ((v, values),) = left.items()
            by_variable.setdefault(v, []).append((values, e.variable, e.value))
        else:
            guarded.setdefault(tuple(sorted(left.items())), []).append((e.variable, e.value))
    return NormalOperator(
        tests,
        tuple({**always, **met}.items()),
        tuple(intern(v, rules) for v, rules in sorted(by_variable.items())),
        tuple((dict(conditions), tuple(assignments)) for conditions, assignments in guarded.items()),
        o.cost,
    )


def _left_to_test(e: Effect, tests: Tests, sizes: Sequence[int]) -> Tests | None:
    """The conditions of the effect that the preconditions do not imply; None if it can never happen."""
    left: Tests = {}
    for v, values in merged(e.conditions, sizes).items():
        possible = tests.get(v)
        met = values if possible is None else tuple(x for x in values if x in possible)
        if not met:
            return None
        if met != possible:
            left[v] = met
    return left


def _target(rule: tuple[tuple[int, ...], int, int]) -> int:
    return rule[1]


def _switch(variable: int, rules: list[tuple[tuple[int, ...], int, int]]) -> ValueSwitch:
    outcomes: dict[int, list[tuple[int, int]]] = {}
    for values, v, x in rules:
        for value in values:
            outcomes.setdefault(value, []).append((v, x))
    return ValueSwitch(variable, {value: tuple(assignments) for value, assignments in sorted(outcomes.items())})
