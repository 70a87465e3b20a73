"""Finite-domain tasks: variables with finitely many values, and operators that test and set them.

All conditions of an operator are evaluated in the state before it. Effects may be conditional. Any number of
effects that depend on different values of the same variable costs no more than one effect
[kabo.finite_domain.tables], so there is no need to expand conditional effects into operators.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

Conditions = tuple[tuple[int, tuple[int, ...]], ...]  # a conjunction of (variable, the values it may have)


@dataclass(frozen=True)
class StateVariable:
    """A variable of the state, with the values 0 … size − 1."""

    name: str
    size: int


@dataclass(frozen=True)
class Effect:
    """An effect that sets a variable to a value if all its conditions hold in the state before the operator."""

    conditions: Conditions
    variable: int
    value: int


@dataclass(frozen=True)
class Operator:
    """An operator: preconditions and effects. Where two effects set one variable, the one with conditions wins.

    Two conditional effects must never set one variable to different values at the same time, nor two unconditional ones.
    """

    name: str
    preconditions: Conditions
    effects: tuple[Effect, ...]
    cost: int = 1  # from 0 to 2^31 - 1
    owner: int = -1  # a number of the caller's, which searches ignore


@dataclass(frozen=True)
class FiniteTask:
    """A planning task: operators have to lead from the initial values to a state that fulfils the goal."""

    variables: tuple[StateVariable, ...]
    initial: tuple[int, ...]
    operators: tuple[Operator, ...]
    goal: Conditions


def holds(conditions: Conditions, state: Sequence[int]) -> bool:
    """Whether the values in `state` meet all conditions."""
    return all(state[v] in values for v, values in conditions)


def successor(operator: Operator, state: tuple[int, ...]) -> tuple[int, ...]:
    """The values after an operator whose preconditions are met, by definition; searches use faster tables."""
    after = list(state)
    for effect in sorted(operator.effects, key=lambda e: len(e.conditions) > 0):
        if holds(effect.conditions, state):
            after[effect.variable] = effect.value
    return tuple(after)


def validate(task: FiniteTask) -> list[str]:
    """The faults of a task, a sentence each; empty if there is none."""
    return list(_faults(task))


def _faults(task: FiniteTask) -> Iterator[str]:
    sizes = [v.size for v in task.variables]
    for v in task.variables:
        if v.size < 1:
            yield f"variable {v.name} has no value"
    if len(task.initial) != len(sizes) or any(not 0 <= x < n for x, n in zip(task.initial, sizes, strict=False)):
        yield "the initial values do not fit the variables"
    yield from _condition_faults("the goal", task.goal, sizes)
    for o in task.operators:
        yield from _operator_faults(o, sizes)


def _operator_faults(o: Operator, sizes: list[int]) -> Iterator[str]:
    if not 0 <= o.cost < 1 << 31:
        yield f"operator {o.name} costs {o.cost}, not from 0 to 2^31 - 1"
    yield from _condition_faults(f"operator {o.name}", o.preconditions, sizes)
    for e in o.effects:
        yield from _condition_faults(f"an effect of {o.name}", e.conditions, sizes)
        if not (0 <= e.variable < len(sizes) and 0 <= e.value < sizes[e.variable]):
            yield f"operator {o.name} sets variable {e.variable} to {e.value}, which it does not have"
    by_variable: dict[int, list[Effect]] = {}
    for e in o.effects:
        by_variable.setdefault(e.variable, []).append(e)
    for effects in by_variable.values():
        for one, other in combinations(effects, 2):
            alike = bool(one.conditions) == bool(other.conditions)
            if (
                alike
                and one.value != other.value
                and compatible(o.preconditions + one.conditions + other.conditions)
            ):
                yield f"operator {o.name} may set variable {one.variable} to {one.value} and {other.value} at once"


def _condition_faults(where: str, conditions: Conditions, sizes: list[int]) -> Iterator[str]:
    for v, values in conditions:
        if not 0 <= v < len(sizes) or any(not 0 <= x < sizes[v] for x in values):
            yield f"{where} tests variable {v} for {values}, which it does not have"


def compatible(conditions: Conditions) -> bool:
    """Whether there is a state that meets all of these conditions."""
    allowed: dict[int, set[int]] = {}
    for v, values in conditions:
        allowed[v] = allowed[v].intersection(values) if v in allowed else set(values)
    return all(allowed.values())


def merged(conditions: Conditions, sizes: Sequence[int]) -> dict[int, tuple[int, ...]]:
    """For each variable the sorted values that meet all its conditions, without variables that every value meets.

    An empty tuple means that no value of the variable meets them.
    """
    allowed: dict[int, set[int]] = {}
    for v, values in conditions:
        allowed[v] = allowed[v].intersection(values) if v in allowed else set(values)
    return {v: tuple(sorted(values)) for v, values in allowed.items() if len(values) < sizes[v]}
