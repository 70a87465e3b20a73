"""What a trial function raises or gives that is no result is told at the function, and names the trial."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import math
import pickle
from collections.abc import Mapping
from functools import partial, wraps
from typing import Any

import numpy as np
import pytest

from kabo.errors import CutOff, Diagnostic, InputError
from kabo.exploration import Exploration, Question, Space
from kabo.trials import Invalid, TrialError, TrialResult, Valid
from kabo.trials.calling import call_trial

SPACE = Space({"along": (-1.0, 1.0)}, {"bar": ["steel", "wood"]})
QUESTION = Question({"bar": "wood"}, {"along": 0.25}, 0.7)
NAME = "trial 12 (bar wood; along 0.25)"


def called(result: Any) -> TrialResult:
    def give(case: object, parameters: object, seed: int) -> Any:
        if isinstance(result, BaseException):
            raise result
        return result

    return call_trial(give, Exploration(SPACE, ["torque"]), QUESTION, 12, 99)


def test_results_are_given_as_they_are() -> None:
    for result in (Valid({"torque": 1.0}), Valid({"torque": np.float64(2)}, "well"), Invalid("dropped", "late")):
        assert called(result) is result


@pytest.mark.parametrize(
    ("result", "message"),
    [
        (None, "gave None, which is neither Valid nor Invalid"),
        (3.0, "gave 3.0, which is neither Valid nor Invalid"),
        (Valid({}), "gave outcomes that cannot be used: a valid trial has an outcome, torque is missing"),
        (Valid({"torqe": 1.0, "torque": 1.0}), 'gave outcomes that cannot be used: unknown outcome "torqe": did you mean "torque"?'),
        (Valid({"torque": math.nan}), "gave outcomes that cannot be used: torque must be a finite number up to 1e+100, this is nan"),
        (Valid({"torque": "much"}), "gave outcomes that cannot be used: torque must be a finite number up to 1e+100, this is 'much'"),
        (Valid(5.0), "gave outcomes that cannot be used: outcomes must map names to numbers, this is 5.0"),  # type: ignore[arg-type]
        (Invalid(""), "is invalid for the reason '', which is no word"),
        (Invalid(3), "is invalid for the reason 3, which is no word"),  # type: ignore[arg-type]
        (Invalid("a\nb"), "is invalid for a reason that cannot be used: a reason is one line of at most 200 characters, this is 'a\\nb'"),
    ],
)  # fmt: skip
def test_what_is_no_result_is_told_where_the_function_begins(result: object, message: str) -> None:
    with pytest.raises(TrialError) as caught:
        called(result)
    (one,) = caught.value.diagnostics
    assert one.message == f"{NAME} {message}"
    assert one.hint == 'a trial gives Valid({"torque": …}) or Invalid("why")'
    assert one.file == __file__ and one.line == called.__code__.co_firstlineno + 1
    assert (caught.value.number, caught.value.case, caught.value.parameters) == (
        12,
        {"bar": "wood"},
        {"along": 0.25},
    )


def deep(case: object, parameters: Mapping[str, float], seed: int) -> TrialResult:
    return Valid({"torque": math.sqrt(-parameters["along"])})


@wraps(deep)
def decorated(*arguments: Any) -> TrialResult:
    return deep(*arguments)


class Deep:
    def __call__(self, case: object, parameters: object, seed: int) -> TrialResult:
        raise OSError("no gripper")


def test_what_a_trial_raises_is_told_at_its_line_with_its_seed() -> None:
    for trial in (deep, decorated, partial(deep)):
        with pytest.raises(TrialError) as caught:
            call_trial(trial, Exploration(SPACE, ["torque"]), QUESTION, 12, 99)
        (one,) = caught.value.diagnostics
        assert one.message.startswith(f"{NAME} raised ValueError: ")
        assert one.hint == "its seed is 99; all trials before it are kept"
        assert (one.file, one.line) == (__file__, deep.__code__.co_firstlineno + 1)
        assert isinstance(caught.value.__cause__, ValueError)
    with pytest.raises(TrialError, match="raised OSError: no gripper") as caught:
        call_trial(Deep(), Exploration(SPACE, ["torque"]), QUESTION, 12, 99)
    assert caught.value.diagnostics[0].line == Deep.__call__.__code__.co_firstlineno + 1


@pytest.mark.parametrize(
    ("raised", "said"),
    [
        (SystemExit(3), "raised SystemExit: 3"),
        (SystemExit(), "raised SystemExit"),
        (MemoryError(), "raised MemoryError"),
    ],
)
def test_a_trial_that_would_end_the_program_is_named_too(raised: BaseException, said: str) -> None:
    with pytest.raises(TrialError) as caught:
        called(raised)
    assert caught.value.diagnostics[0].message == f"{NAME} {said}"


def test_findings_in_files_keep_their_places_and_name_the_trial() -> None:
    with pytest.raises(TrialError) as caught:
        called(InputError([Diagnostic("scene.yaml", 3, 7, "no such body", "did you mean")]))
    assert caught.value.diagnostics == (Diagnostic("scene.yaml", 3, 7, f"{NAME}: no such body", "did you mean"),)


def test_a_trial_that_was_stopped_has_no_result_and_an_interrupt_is_no_error() -> None:
    for stopped in (CutOff(), KeyboardInterrupt()):
        with pytest.raises(type(stopped)):
            called(stopped)


def test_a_trial_cannot_change_what_is_written_down() -> None:
    def spoil(case: Any, parameters: Any, seed: int) -> TrialResult:
        case["bar"], parameters["along"] = "glass", 7.0
        return Invalid("spoilt")

    call_trial(spoil, Exploration(SPACE, ["torque"]), QUESTION, 12, 99)
    assert (QUESTION.case, QUESTION.parameters) == ({"bar": "wood"}, {"along": 0.25})


def test_the_error_reaches_another_process_whole() -> None:
    with pytest.raises(TrialError) as caught:
        called(None)
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is TrialError and str(again) == str(caught.value)
    assert (again.number, again.case, again.parameters) == (12, {"bar": "wood"}, {"along": 0.25})
