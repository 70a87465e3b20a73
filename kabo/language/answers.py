"""Checks the answers of external procedures on receipt, so that a wrong answer is not mistaken for a missing plan."""

import math
from typing import Any

from kabo.errors import Diagnostic, InputError
from kabo.language.formulas import GroundCall
from kabo.language.problem import Answer, Problem


def checked_answer(problem: Problem, call: GroundCall, answer: Any) -> Answer:
    """The answer in kabo's form: True or False for a test, else a float or an object's name; None for no value.

    A procedure that the domain does not declare is a geometric procedure: it succeeds or fails.

    Raises:
        InputError: the declaration of the procedure does not allow this answer.
    """
    declared = problem.domain.procedures.get(call.procedure)
    if declared is None or declared.is_test:
        return bool(answer)
    if answer is None:
        return None
    if declared.is_number:
        if isinstance(answer, int | float) and not isinstance(answer, bool) and math.isfinite(answer):
            return float(answer) + 0.0
        expected = "a finite number"
    else:
        if isinstance(answer, str) and answer in problem.answers_of(call.procedure):
            return answer
        kind = f"a {declared.value_type}"
        expected = kind if declared.values is None else f"one of {', '.join(declared.values)}"
    place = declared.place
    file, line, column = (str(problem.path), 1, 1) if place is None else (place.file, place.line, place.column)
    message = f"{call} answered {answer!r}, which is not {expected}"
    raise InputError([Diagnostic(file, line, column, message, length=1 if place is None else place.length)])
