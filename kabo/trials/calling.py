"""Calls a trial function; what it raises, and unusable results, become a TrialError that names trial and function."""

import inspect
import traceback
from functools import partial
from pathlib import Path
from typing import Any

from kabo.errors import CutOff, Diagnostic, InputError
from kabo.exploration import Exploration, ExplorationError, Question
from kabo.trials.errors import TrialError
from kabo.trials.results import Invalid, TrialFunction, TrialResult, Valid

_KABO = Path(__file__).resolve().parents[1]


def call_trial(
    trial: TrialFunction, exploration: Exploration, question: Question, number: int, seed: int
) -> TrialResult:
    """The result of a trial, which the exploration accepts.

    Args:
        trial: the function.
        exploration: decides which results are usable; the trial is not added to it.
        question: case and parameters.
        number: of the trial, from 1, for messages.
        seed: determines everything that is random in the trial.

    Raises:
        TrialError: the function raised an error, or returned neither Valid with all outcomes nor Invalid with a reason.
        CutOff: the trial was stopped before it had a result.
    """
    name = f"trial {number} ({named(question)})"

    def fault(
        message: str, hint: str | None, place: tuple[str, int], cause: BaseException | None = None
    ) -> TrialError:
        error = TrialError(
            [Diagnostic(*place, 1, f"{name} {message}", hint)], number, question.case, question.parameters
        )
        error.__cause__ = cause
        return error

    try:
        result = trial(dict(question.case), dict(question.parameters), seed)
    except CutOff:
        raise
    except InputError as error:
        told = [_named(each, name) for each in error.diagnostics]
        raise TrialError(told, number, question.case, question.parameters) from error
    except (Exception, SystemExit) as error:  # `sys.exit` in a trial would end the run without a message
        raise fault(
            f"raised {type(error).__name__}{f': {error}' if str(error) else ''}",
            f"its seed is {seed}; all trials before it are kept",
            _place_of_error(error, trial),
            error,
        ) from error
    problem = _fault_of_result(result, exploration, question)
    if problem is not None:
        names = ", ".join(f'"{each}": …' for each in exploration.outcomes)
        hint = f'a trial gives Valid({{{names}}}) or Invalid("why")'
        raise fault(problem, hint, _place_of(trial))
    return result


def named(question: Question) -> str:
    """Case and parameters in one line: `bar steel; along 0.01, force 12`."""
    case = ", ".join(f"{name} {value}" for name, value in question.case.items())
    parameters = ", ".join(f"{name} {value:g}" for name, value in question.parameters.items())
    return f"{case}; {parameters}" if case else parameters


def _named(diagnostic: Diagnostic, name: str) -> Diagnostic:
    return Diagnostic(
        diagnostic.file, diagnostic.line, diagnostic.column, f"{name}: {diagnostic.message}", diagnostic.hint,
        diagnostic.length, diagnostic.severity, diagnostic.source,
    )  # fmt: skip


def _fault_of_result(result: Any, exploration: Exploration, question: Question) -> str | None:
    """What is wrong with the result of a trial; None if nothing is."""
    if isinstance(result, Invalid):
        reason: Any = result.reason
        if not isinstance(reason, str) or not reason.strip() or reason != reason.strip():
            return f"is invalid for the reason {reason!r:.80}, which is no word"
        try:
            exploration.checked_trial(question.case, question.parameters, False, reason=reason)
        except ExplorationError as error:
            return f"is invalid for a reason that cannot be used: {error}"
        return None
    if not isinstance(result, Valid):
        return f"gave {result!r:.80}, which is neither Valid nor Invalid"
    try:
        exploration.checked_trial(question.case, question.parameters, True, result.outcomes)
    except ExplorationError as error:
        return f"gave outcomes that cannot be used: {error}"
    return None


def _place_of_error(error: BaseException, trial: TrialFunction) -> tuple[str, int]:
    """The innermost line of the function's file in the traceback, else the first line of the function.

    For kabo's own function, which plans a task: the innermost line outside kabo, which belongs to a user's stage.
    """
    file, line = _place_of(trial)
    frames = traceback.extract_tb(error.__traceback__)
    if _is_of_kabo(file):
        found = [each for each in frames if not _is_of_kabo(each.filename)]
    else:
        found = [each for each in frames if each.filename == file]
    return (found[-1].filename, found[-1].lineno or line) if found else (file, line)


def _is_of_kabo(file: str) -> bool:
    return Path(file).is_relative_to(_KABO)


def _place_of(trial: Any) -> tuple[str, int]:
    """File and line of a function, or of the `__call__` of an object."""
    while isinstance(trial, partial):
        trial = trial.func
    trial = inspect.unwrap(trial)
    function = trial if hasattr(trial, "__code__") else vars(type(trial)).get("__call__")
    code = getattr(function, "__code__", None)
    return ("trial", 1) if code is None else (code.co_filename, code.co_firstlineno)
