"""Calls of external procedures by the verifier itself, which does not rely on the answers that the planner got."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from kabo.language.answers import checked_answer
from kabo.language.formulas import Argument, Constant, External, GroundCall, Number, ProcedureCall, Variable
from kabo.language.problem import Answer, Answers, Problem
from kabo.verify.knowledge.ground import Binding, NotVerifiableError

MAX_SEEDS = 16  # seeds tried with a procedure that takes one; the first answer counts, as when planning


def with_functions(problem: Problem, functions: Mapping[str, Callable[..., Any]], seed: int) -> Problem:
    """The problem with the given functions as its external procedures; answers to equal calls are reused."""
    known: dict[GroundCall, Answer] = {}

    def ask(call: GroundCall) -> Answer:
        if call.procedure not in functions:
            return True
        if call not in known:
            known[call] = _answer(problem, functions[call.procedure], call, seed)
        return known[call]

    return replace(problem, answers=Answers(frozenset(functions), ask))


def _answer(problem: Problem, function: Callable[..., Any], call: GroundCall, seed: int) -> Answer:
    options = dict(call.options)
    try:
        seeds = [seed + k for k in range(MAX_SEEDS)] if "seed" in inspect.signature(function).parameters else []
    except (TypeError, ValueError):
        seeds = []
    for own in [{"seed": number} for number in seeds] or [{}]:
        answer = checked_answer(problem, call, function(*call.arguments, **options, **own))
        if answer is not False and answer is not None:
            break
    return answer


def asking_function(external: External, problem: Problem) -> Callable[[GroundCall], Answer]:
    """The function that answers calls of an external procedure; a test without a function always succeeds.

    Raises:
        NotVerifiableError: the procedure returns a value, but no function for it was given.
    """
    answers, name = problem.answers, external.procedure
    if answers is None or name not in answers.given:
        if problem.domain.procedures[name].is_test:
            return lambda call: True
        raise NotVerifiableError(f'nobody answers for the procedure "{name}": give its function')
    return answers.ask


def external_of(call: ProcedureCall | None, problem: Problem) -> ProcedureCall | None:
    """The procedure call of an action, if a function for the procedure was given; otherwise None."""
    return (
        call
        if call is not None and problem.answers is not None and call.procedure in problem.answers.given
        else None
    )


def succeeds(call: ProcedureCall, problem: Problem, binding: Binding) -> bool:
    """Whether an action's procedure call succeeds according to the procedure's function."""
    assert problem.answers is not None

    def value(argument: Argument) -> str | float:
        match argument.value:
            case Constant(name=name):
                return name
            case Number(value=number):
                return number
            case Variable(name=name):
                return binding[name]  # type: ignore[return-value]

    positional = tuple(value(argument) for argument in call.arguments if argument.name is None)
    named = sorted((argument.name, value(argument)) for argument in call.arguments if argument.name is not None)
    return problem.answers.ask(GroundCall(call.procedure, positional, tuple(named))) is not False
