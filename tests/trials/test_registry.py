"""The names of trial functions: what is registered is found, a name is taken once, an unknown one gets a hint."""

import pytest

from kabo.exploration import ExplorationError
from kabo.trials import Invalid, TrialResult, register
from kabo.trials.registry import find, names, near


def slip(case: object, parameters: object, seed: int) -> TrialResult:
    return Invalid("slipped")


class Slip:
    def __call__(self, case: object, parameters: object, seed: int) -> TrialResult:
        return Invalid("slipped")


def test_a_function_is_found_under_its_name_or_another() -> None:
    assert register(slip) is slip
    register(slip, "mine/Slip")
    assert find("slip") is slip is find("mine/Slip")
    assert {"slip", "mine/Slip"} <= set(names())
    assert find("mine/Slop") is None and near("mine/Slop") == 'did you mean "mine/Slip"?'


def test_an_object_that_can_be_called_is_a_trial_too() -> None:
    made = Slip()
    register(made, "mine/Object")
    assert find("mine/Object") is made


def test_the_same_function_may_be_registered_again_and_another_may_not_take_its_name() -> None:
    register(slip, "mine/Again")
    register(slip, "mine/Again")
    with pytest.raises(ExplorationError, match="the name 'mine/Again' of a trial is taken by .*slip"):
        register(Slip(), "mine/Again")


@pytest.mark.parametrize(("function", "name"), [(3, "three"), (Slip(), None), (slip, ""), (slip, 3)])
def test_what_cannot_be_called_or_has_no_name_is_refused(function: object, name: object) -> None:
    with pytest.raises(ExplorationError, match="a trial is registered as a function of case, parameters and seed"):
        register(function, name)  # type: ignore[type-var, arg-type]
