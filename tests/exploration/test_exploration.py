"""An exploration is told trials and asked: misuse is refused with one sentence, and leaves it as it was."""

import hashlib
import json

import numpy as np
import pytest

from kabo.exploration import Exploration, ExplorationError, NoParametersError, Space, Trial, Validity
from tests.support.small_explorations import exploration, run, space, tell_random

BARS = {"bar": ["steel", "wood"]}
STEEL = {"bar": "steel"}
HERE = {"a": 0.5, "b": 0.0}
NAN, INFINITE = float("nan"), float("inf")


@pytest.fixture
def explored() -> Exploration:
    found = exploration(outcomes=("torque", "noise"), cases=BARS, start=HERE)
    tell_random(found, 30, case=STEEL, spread=0.9)
    return found


def refused(explored, message, call):
    """The call raises ExplorationError with this message, and changes nothing."""
    digest, trials, asked = explored.digest, explored.trials, explored.ask(STEEL)
    with pytest.raises(ExplorationError, match=message) as caught:
        call(explored)
    assert isinstance(caught.value, ValueError)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 600
    assert (explored.digest, explored.trials, explored.ask(STEEL)) == (digest, trials, asked)


FINE = {"torque": 1.0, "noise": 2.0}


@pytest.mark.parametrize(
    ("case", "parameters", "valid", "outcomes", "reason", "message"),
    [
        ({}, HERE, True, FINE, "", r"the case must say bar \(steel or wood\)"),
        (None, HERE, True, FINE, "", "the case must say bar"),
        ({"bar": "wod"}, HERE, True, FINE, "", 'did you mean "wood"'),
        (STEEL, {"a": 0.5}, True, FINE, "", "the parameter b is missing"),
        (STEEL, {"a": 0.5, "b": 1.0}, True, FINE, "", "b is 1, outside its bounds"),
        (STEEL, {"a": NAN, "b": 0.0}, False, None, "", "a must be a finite number"),
        (STEEL, None, False, None, "", "the parameter a is missing"),
        (STEEL, HERE, True, None, "", "torque is missing; .*noise is missing"),
        (STEEL, HERE, True, {"torque": 1.0}, "", "a valid trial has an outcome, noise is missing"),
        (STEEL, HERE, True, FINE | {"torqe": 1.0}, "", 'unknown outcome "torqe": did you mean "torque"'),
        (STEEL, HERE, True, FINE | {"torque": NAN}, "", "torque must be a finite number"),
        (STEEL, HERE, True, FINE | {"torque": -INFINITE}, "", "torque must be a finite number"),
        (STEEL, HERE, True, FINE | {"torque": 1e300}, "", "torque must be a finite number up to 1e.100"),
        (STEEL, HERE, True, FINE | {"torque": True}, "", "torque must be a finite number"),
        (STEEL, HERE, True, FINE | {"torque": "1"}, "", "torque must be a finite number"),
        (STEEL, HERE, True, [1.0, 2.0], "", "outcomes must map names to numbers"),
        (STEEL, HERE, True, FINE, "dropped", "a valid trial has no reason"),
        (STEEL, HERE, False, FINE, "", "an invalid trial has no outcome"),
        (STEEL, HERE, False, [1.0], "", "an invalid trial has no outcome"),
        (STEEL, HERE, False, None, 3, "the reason must be a text"),
        (STEEL, HERE, False, None, "\ud800", "the reason must be a text"),
        (STEEL, HERE, False, None, "two\nlines", "a reason is one line of at most 200 characters, this is 'two"),
        (STEEL, HERE, False, None, "\x1b[31m", "a reason is one line"),
        (STEEL, HERE, False, None, "x" * 201, "a reason is one line"),
        (STEEL, HERE, 1, FINE, "", "a trial is valid or not: True or False, this is 1"),
        (STEEL, HERE, None, FINE, "", "a trial is valid or not"),
    ],
)
def test_a_trial_that_cannot_be_is_refused(explored, case, parameters, valid, outcomes, reason, message):
    refused(explored, message, lambda e: e.tell(case, parameters, valid, outcomes, reason))


@pytest.mark.parametrize(
    ("message", "call"),
    [
        ("unknown case variable", lambda e: e.ask({"rod": "steel"})),
        ("the case must say bar", lambda e: e.ask({})),
        ("alpha must be a probability above 0 and below 1, this is 1", lambda e: e.ask(STEEL, alpha=1)),
        ("alpha must be a probability", lambda e: e.ask(alpha=0.0)),
        ("alpha must be a probability", lambda e: e.ask(STEEL, alpha=NAN)),
        ("alpha must be a probability", lambda e: e.ask(STEEL, alpha="0.7")),
        ("the case must say bar", lambda e: e.validity(None, [HERE])),
        ("outside its bounds", lambda e: e.validity(STEEL, [HERE, {"a": 2, "b": 0}])),
        ("points must be a list of parameters", lambda e: e.validity(STEEL, HERE)),
        ("points must be a list of parameters", lambda e: e.validity(STEEL, None)),
        ("parameters must map names to values", lambda e: e.predict(STEEL, np.zeros((3, 2)))),
        ("the parameter b is missing", lambda e: e.predict(STEEL, [{"a": 0.5}])),
        ("unknown value of bar", lambda e: e.predict({"bar": "brass"}, [HERE])),
        ("the case must say bar", lambda e: e.leave_one_out({})),
        ("unknown value", lambda e: e.trials_of({"bar": 3})),
        ("a target maps one outcome or more", lambda e: e.infer({})),
        ("a target maps one outcome or more", lambda e: e.infer("torque")),
        ('unknown outcome "torqe": did you mean', lambda e: e.infer({"torqe": 1.0})),
        ("torque must be a finite number.*, least or most", lambda e: e.infer({"torque": "lest"})),
        ("torque must be a finite number", lambda e: e.infer({"torque": INFINITE})),
        ("torque must be a finite number", lambda e: e.infer({"torque": None})),
        ("unknown case variable", lambda e: e.infer({"torque": 1.0}, {"rod": "steel"})),
        ("unknown value of bar", lambda e: e.infer({"torque": 1.0}, {"bar": "brass"})),
        ("alpha must be a probability", lambda e: e.infer({"torque": 1.0}, alpha=1.5)),
        ("the tolerance must be a number from 0 on, this is -1", lambda e: e.infer({"torque": 1.0}, tolerance=-1)),
        ("the tolerance must be a number", lambda e: e.infer({"torque": 1.0}, tolerance=NAN)),
        ("the tolerance must be a number", lambda e: e.infer({"torque": 1.0}, tolerance="deviations")),
        ("the tolerance must be a number", lambda e: e.infer({"torque": 1.0}, tolerance=True)),
        ("unknown outcome", lambda e: e.infer({"torque": 1.0}, tolerance={"torq": 1.0})),
        ("the tolerance must be", lambda e: e.infer({"torque": 1.0}, tolerance={"torque": -1.0})),
        ("tolerance for noise, which the target", lambda e: e.infer({"torque": 1.0}, tolerance={"noise": 1.0})),
        ("count must be a positive whole number, this is 0", lambda e: e.alternatives({"torque": 1.0}, count=0)),
        ("count must be", lambda e: e.alternatives({"torque": 1.0}, count=1.5)),
        ("count must be", lambda e: e.alternatives({"torque": 1.0}, count=True)),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(explored, message, call):
    refused(explored, message, call)


@pytest.mark.parametrize(
    ("message", "options"),
    [
        ("has one outcome or more", {"outcomes": []}),
        ("has one outcome or more", {"outcomes": ["torque", ""]}),
        ("has one outcome or more", {"outcomes": [3]}),
        ("has one outcome or more", {"outcomes": None}),
        ("outcomes must differ", {"outcomes": ["torque", "torque"]}),
        ("the seed must be a whole number of 64 bits", {"seed": 1.5}),
        ("the seed must be a whole number", {"seed": True}),
        ("the seed must be a whole number", {"seed": "1"}),
        ("the seed must be a whole number", {"seed": 10**5_000}),
        ("the name must be a text", {"name": 3}),
        ("the name must be a text", {"name": "\ud834"}),
        ("scale of validity must be between 0.01 and 10, this is 0", {"validity": Validity(scale=0.0)}),
        ("scale of validity", {"validity": Validity(scale=NAN)}),
        ("noise of validity must be between 0.01 and 10, this is 11", {"validity": Validity(noise=11)}),
        ("alpha must be a probability", {"validity": Validity(alpha=1.0)}),
        ("alpha must be a probability", {"validity": Validity(alpha=None)}),
        ("validity must be a Validity", {"validity": 0.12}),
        ("budget of invalid trials must be above 0 and below 1", {"invalid_budget": 0.0}),
        ("budget of invalid trials", {"invalid_budget": 1}),
        ("budget of invalid trials", {"invalid_budget": NAN}),
        ("a is 2, outside its bounds", {"start": {"a": 2, "b": 0}}),
        ("the parameter b is missing", {"start": {"a": 1}}),
        ("must map names to values", {"start": [0.5, 0.0]}),
        ("retry must map reasons to changes", {"retry": ["dropped"]}),
        ("a change maps parameters to numbers, this is 3", {"retry": {"dropped": 3}}),
        ('retry after dropped: unknown parameter "c"', {"retry": {"dropped": {"c": 1}}}),
        ("retry after dropped: a must change by a finite number", {"retry": {"dropped": {"a": NAN}}}),
        ("a reason must be a text", {"retry": {3: {"a": 1}}}),
        ('unknown outcome "torqe": did you mean', {"units": {"torqe": "Nm"}}),
        ("the unit of torque must be a text", {"units": {"torque": 1}}),
    ],
)
def test_an_exploration_that_cannot_be_is_refused(message, options):
    outcomes = options.pop("outcomes", ["torque"])
    with pytest.raises(ExplorationError, match=message):
        Exploration(space(), outcomes, **options)


def test_a_trial_is_returned_as_it_is_kept():
    explored = exploration(cases=BARS)
    told = explored.tell(STEEL, {"b": np.float64(0.01), "a": 1}, np.True_, {"torque": np.float32(0.5)})
    assert told == Trial(STEEL, {"a": 1.0, "b": 0.01}, True, {"torque": 0.5}, "")
    assert [type(each) for each in (told.valid, told.parameters["a"], told.outcomes["torque"])] == [
        bool,
        float,
        float,
    ]
    assert list(told.parameters) == ["a", "b"]
    other = explored.tell({"bar": "wood"}, HERE, False, {}, "dropped")
    assert explored.trials == (told, other)
    assert explored.trials_of(STEEL) == (told,)


def test_outcomes_and_parameters_of_numpy_types_are_saved(tmp_path):
    explored = exploration()
    explored.tell(None, {"a": np.float32(0.25), "b": np.int64(0)}, np.bool_(True), {"torque": np.float64(2.0)})
    explored.save(tmp_path / "model.jsonl")
    assert json.loads((tmp_path / "model.jsonl").read_text().splitlines()[1])["parameters"] == {
        "a": 0.25,
        "b": 0.0,
    }


def test_an_outcome_alone_may_be_named_by_a_text():
    assert Exploration(Space({"a": (0, 1)}), "torque").outcomes == ("torque",)


def test_before_a_valid_trial_nothing_can_be_predicted():
    explored = exploration(cases=BARS)
    with pytest.raises(NoParametersError) as caught:
        explored.predict(STEEL, [HERE])
    assert caught.value.reason == "not_explored"
    explored.tell(STEEL, HERE, False, reason="dropped")
    with pytest.raises(NoParametersError, match="none of 1 trials is valid: 1 × dropped") as caught:
        explored.predict(STEEL, [HERE])
    assert caught.value.reason == "nothing_valid"
    assert explored.validity(STEEL, [HERE])[0] < 0.01


def test_predictions_of_no_points_are_empty(explored):
    assert explored.validity(STEEL, []).shape == (0,)
    assert {name: mean.shape for name, (mean, _) in explored.predict(STEEL, []).items()} == {
        "torque": (0,),
        "noise": (0,),
    }


def test_cases_share_nothing(explored):
    assert explored.validity({"bar": "wood"}, [HERE])[0] == 0.5
    before = explored.predict(STEEL, [HERE])
    tell_random(explored, 20, seed=9, case={"bar": "wood"})
    np.testing.assert_array_equal(before["torque"], explored.predict(STEEL, [HERE])["torque"])


def test_the_digest_is_that_of_the_file_and_changes_with_each_trial(tmp_path):
    explored, seen = exploration(start=HERE), set()
    for _ in range(3):
        explored.save(tmp_path / "model.jsonl")
        assert explored.digest == hashlib.sha256((tmp_path / "model.jsonl").read_bytes()).hexdigest()
        seen.add(explored.digest)
        run(explored, 1)
    assert len(seen) == 3


@pytest.mark.parametrize(
    "options",
    [{"seed": 6}, {"name": "other"}, {"validity": Validity(alpha=0.8)}, {"invalid_budget": 0.1}, {"start": HERE}],
)
def test_the_digest_tells_options_apart(options):
    assert exploration(**options).digest != exploration().digest


# ------------------------------------------------------------------------------------------------ extreme worlds
@pytest.mark.parametrize("value", [0.0, 1.0, -1e100, 1e100, 1e-300, 5e-324])
def test_an_outcome_that_never_changes_is_expected_everywhere(value):
    explored = exploration()
    generator = np.random.default_rng(0)
    for a, b in generator.random((30, 2)):
        explored.tell({}, {"a": a, "b": 0.16 * b - 0.08}, True, {"torque": value})
    found = explored.infer({"torque": 0.0})
    assert found.expected["torque"] == pytest.approx(value, rel=1e-11)
    assert found.deviation["torque"] <= max(abs(value) * 1e-11, 1e-29)
    assert explored.leave_one_out({})["torque"] == pytest.approx(0.0, abs=max(abs(value) * 1e-12, 1e-300))
    assert explored.ask().validity > 0.7


@pytest.mark.parametrize("factor", [1e-25, 1e-3, 1e3, 1e99])
def test_the_unit_of_an_outcome_does_not_matter(factor):
    asked, inferred = [], []
    for scale in (1.0, factor):
        explored = exploration()
        for trial in trials():
            outcomes = {"torque": scale * trial.outcomes["torque"]} if trial.valid else None
            explored.tell({}, trial.parameters, trial.valid, outcomes)
        asked.append(explored.ask().parameters)
        inferred.append(explored.infer({"torque": scale * 1.7}).parameters)
    assert asked[0] == asked[1]
    assert inferred[0] == pytest.approx(inferred[1], abs=1e-3)


def trials():
    explored = exploration()
    tell_random(explored, 40)
    return explored.trials


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("scale", [0.01, 10.0])
@pytest.mark.parametrize("noise", [0.01, 10.0])
def test_extreme_options_give_parameters_or_say_that_there_are_none(scale, noise):
    explored = exploration(validity=Validity(scale, noise), start=HERE)
    tell_random(explored, 80)
    for call in (explored.ask, lambda: explored.infer({"torque": 1.5})):
        try:
            assert call().validity > 0.7
        except NoParametersError as error:
            assert error.reason == "nothing_valid"


@pytest.mark.filterwarnings("error")
def test_the_same_trial_told_again_and_again_changes_little():
    explored = exploration()
    for _ in range(400):
        explored.tell({}, HERE, True, {"torque": 3.0})
    assert explored.validity({}, [HERE])[0] > 0.999
    assert explored.infer({"torque": 3.0}).parameters == HERE
    assert explored.ask().parameters != HERE


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4, 5, 6])
def test_questions_can_be_asked_in_one_to_six_dimensions(dimensions):
    middle = {name: (low + high) / 2 for name, (low, high) in space(dimensions).parameters.items()}
    explored = exploration(dimensions, start=middle, validity=Validity(scale=0.3))
    run(explored, 20)
    assert len({tuple(each.parameters.values()) for each in explored.trials}) == 20
    assert explored.infer({"torque": "most"}, alpha=0.7).validity > 0.7
