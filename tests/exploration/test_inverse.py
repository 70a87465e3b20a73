"""From outcomes to parameters: the nearest in Φ^α, as on a fine grid; alternatives; what is out of range [T e5]."""

import numpy as np
import pytest

from kabo.exploration import NoParametersError
from tests.support import oracles_exploration as oracles
from tests.support.small_explorations import exploration, grid, run, tell_random

BARS = {"bar": ["steel", "wood"]}


def explored(outcomes=("torque",), count=60, dimensions=2, **options):
    found = exploration(dimensions, outcomes, **options)
    tell_random(found, count, spread=0.9)
    return found


def on_grid(e, alpha, steps=120):
    """Valid parameters on a grid, and each expected outcome there."""
    points = grid(e.space, steps)
    points = [p for p, v in zip(points, e.validity({}, points), strict=True) if v > alpha]
    return points, {name: mean for name, (mean, _) in e.predict({}, points).items()}


@pytest.mark.parametrize("wanted", [-4.0, 0.9, 1.5, 2.0, 2.3, 9.0])
@pytest.mark.parametrize("alpha", [0.5, 0.95, 0.999])
def test_the_expected_outcome_is_as_near_to_the_target_as_on_a_fine_grid(wanted, alpha):
    e = explored()
    _, expected = on_grid(e, alpha)
    found = e.infer({"torque": wanted}, alpha=alpha)
    best = np.abs(expected["torque"] - wanted).min()
    # outcomes that differ by a twentieth of the deviation are equally good, and the safer one is offered
    assert abs(found.expected["torque"] - wanted) <= best + 0.05 * found.deviation["torque"] + 1e-3
    assert found.validity > alpha


@pytest.mark.parametrize(("word", "sign"), [("least", 1), ("most", -1)])
def test_least_and_most_are_those_of_a_fine_grid(word, sign):
    e = explored()
    _, expected = on_grid(e, 0.95)
    found = e.infer({"torque": word})
    assert (
        sign * found.expected["torque"]
        <= sign * (sign * expected["torque"]).min() * sign + 0.05 * found.deviation["torque"]
    )


def test_what_is_said_of_parameters_is_what_the_models_say_of_them():
    e = explored(("torque", "noise"))
    found = e.infer({"torque": 1.7, "noise": 41.0})
    assert found.validity == pytest.approx(e.validity({}, [found.parameters])[0], abs=1e-12)
    for name, (mean, deviation) in e.predict({}, [found.parameters]).items():
        assert found.expected[name] == pytest.approx(mean[0], abs=1e-9)
        assert found.deviation[name] == pytest.approx(deviation[0], abs=1e-9)


@pytest.mark.parametrize("target", [{"torque": 1.2, "noise": 35.0}, {"torque": 0.8, "noise": 60.0}])
def test_of_several_outcomes_the_normalised_sum_of_squares_is_the_least(target):
    e = explored(("torque", "noise"), 120)
    _, expected = on_grid(e, 0.95)
    valid = [each.outcomes for each in e.trials if each.valid]
    spreads = {name: np.std([each[name] for each in valid]) for name in target}
    loss = sum(((expected[name] - target[name]) / spreads[name]) ** 2 for name in target)
    found = e.infer(target)
    reached = sum(((found.expected[name] - target[name]) / spreads[name]) ** 2 for name in target)
    assert reached <= loss.min() + 0.02


def test_of_equally_good_parameters_the_safest_are_offered():
    e = exploration()
    generator = np.random.default_rng(0)
    for _ in range(40):
        a, b = generator.random(2)
        e.tell({}, {"a": a, "b": 0.16 * b - 0.08}, b < 0.6, {"torque": 1.0} if b < 0.6 else None)
    points, _ = on_grid(e, 0.95, 60)
    assert e.infer({"torque": 1.0}).validity >= max(e.validity({}, points)) - 1e-6


@pytest.mark.parametrize("dimensions", [1, 3, 6])
def test_targets_within_the_range_are_met_in_one_to_six_dimensions(dimensions):
    e = exploration(dimensions)
    tell_random(e, 150, spread=0.5 / dimensions**0.5 + 0.2)
    known = [each.outcomes["torque"] for each in e.trials if each.valid]
    for wanted in np.quantile(known, [0.2, 0.5, 0.8]):
        found = e.infer({"torque": float(wanted)}, alpha=0.9)
        assert abs(found.expected["torque"] - wanted) < 0.2 * found.deviation["torque"]


# --------------------------------------------------------------------------------------------------------- cases
def test_the_nearest_over_all_cases_asked_for_is_offered():
    e = exploration(cases=BARS)
    for bar, offset in (("steel", 0.0), ("wood", 10.0)):
        for k in range(9):
            e.tell({"bar": bar}, {"a": k / 8, "b": 0.0}, True, {"torque": offset + k / 8})
    assert e.infer({"torque": 0.5}).case == {"bar": "steel"}
    assert e.infer({"torque": 10.5}).case == {"bar": "wood"}
    assert e.infer({"torque": 10.5}, {"bar": "steel"}).case == {"bar": "steel"}
    assert e.infer({"torque": 10.5}, {"bar": "steel"}).expected["torque"] < 2


def test_cases_without_a_valid_trial_are_passed_over():
    e = exploration(cases=BARS)
    tell_random(e, 20, case={"bar": "wood"})
    e.tell({"bar": "steel"}, {"a": 0.5, "b": 0.0}, False, reason="dropped")
    assert e.infer({"torque": 2.0}).case == {"bar": "wood"}
    with pytest.raises(NoParametersError, match="dropped") as caught:
        e.infer({"torque": 2.0}, {"bar": "steel"})
    assert caught.value.reason == "nothing_valid"


# -------------------------------------------------------------------------------------------------- alternatives
@pytest.mark.parametrize("count", [1, 4, 12])
def test_alternatives_are_a_scale_apart_and_the_nearest_first(count):
    e = explored()
    found = e.alternatives({"torque": 1.6}, count=count)
    at = oracles.scaled(e, [each.parameters for each in found])
    for k in range(len(found)):
        assert found[k].validity > 0.95
        assert (np.linalg.norm(at[k] - at[:k], axis=1) >= e.validity_options.scale - 1e-9).all()
    off = [abs(each.expected["torque"] - 1.6) for each in found]
    assert all(a <= b + 0.05 * found[0].deviation["torque"] + 1e-3 for a, b in zip(off, off[1:], strict=False))
    assert len(found) == count or count == 12


def test_the_first_alternative_is_what_infer_gives():
    e = explored()
    assert e.alternatives({"torque": 1.6}, count=3)[0] == e.infer({"torque": 1.6})


def test_there_are_as_many_alternatives_as_fit_into_the_valid_set():
    e = exploration()
    e.tell({}, {"a": 0.5, "b": 0.0}, True, {"torque": 1.0})
    assert len(e.alternatives({"torque": 1.0}, count=50)) == 1
    assert 2 <= len(e.alternatives({"torque": 1.0}, count=50, alpha=0.7)) <= 8


def test_alternatives_of_different_cases_need_not_be_apart():
    e = exploration(cases=BARS)
    for bar in BARS["bar"]:
        e.tell({"bar": bar}, {"a": 0.5, "b": 0.0}, True, {"torque": 1.0})
    assert [each.case["bar"] for each in e.alternatives({"torque": 1.0}, count=9)] == ["steel", "wood"]


# ------------------------------------------------------------------------------------------------------ tolerance
def test_without_a_tolerance_the_nearest_is_offered_however_far():
    e = explored()
    assert e.infer({"torque": 1e9}).expected["torque"] < 4
    assert e.infer({"torque": -1e100}).expected["torque"] > 0


@pytest.mark.parametrize("tolerance", [0.05, {"torque": 0.05}, "deviation"])
def test_farther_off_than_the_tolerance_is_out_of_range_with_the_nearest(tolerance):
    e = explored()
    nearest = e.infer({"torque": 30.0})
    with pytest.raises(NoParametersError, match="torque 30 cannot be had: the nearest is torque") as caught:
        e.infer({"torque": 30.0}, tolerance=tolerance)
    assert caught.value.reason == "out_of_range"
    assert caught.value.nearest == nearest
    assert e.infer({"torque": 1.6}, tolerance=tolerance) == e.infer({"torque": 1.6})


def test_the_tolerance_is_a_closed_bound():
    e = explored()
    nearest = e.infer({"torque": 30.0})
    off = 30.0 - nearest.expected["torque"]
    assert e.infer({"torque": 30.0}, tolerance=off) == nearest
    with pytest.raises(NoParametersError):
        e.infer({"torque": 30.0}, tolerance=np.nextafter(off, 0.0))


def test_twice_the_deviation_there_is_the_bound_of_the_word_deviation():
    e = explored()
    reached = e.infer({"torque": "most"})
    top = reached.expected["torque"]
    near = e.infer({"torque": top + 1.5 * reached.deviation["torque"]}, tolerance="deviation")
    assert near.expected["torque"] == pytest.approx(top, abs=reached.deviation["torque"])
    with pytest.raises(NoParametersError):
        e.infer({"torque": top + 4 * reached.deviation["torque"]}, tolerance="deviation")


def test_a_tolerance_for_one_outcome_leaves_the_others_free():
    e = explored(("torque", "noise"))
    target = {"torque": 1.6, "noise": 900.0}
    e.infer(target, tolerance={"torque": 50.0})
    with pytest.raises(NoParametersError):
        e.infer(target, tolerance={"noise": 50.0})


def test_alternatives_beyond_the_tolerance_are_left_out():
    e = explored()
    found = e.alternatives({"torque": 1.6}, tolerance=0.02, count=30)
    assert 1 <= len(found) < len(e.alternatives({"torque": 1.6}, count=30))
    assert all(abs(each.expected["torque"] - 1.6) <= 0.02 for each in found)


def test_least_and_most_have_no_tolerance():
    e = explored()
    assert e.infer({"torque": "most"}, tolerance=0.0) == e.infer({"torque": "most"})


# ------------------------------------------------------------------------------------------------ nothing to offer
def test_before_any_trial_nothing_can_be_inferred():
    with pytest.raises(NoParametersError) as caught:
        exploration(cases=BARS).infer({"torque": 1.0})
    assert (caught.value.reason, caught.value.nearest) == ("not_explored", None)


def test_where_nothing_is_valid_enough_there_is_nothing_to_offer():
    e = explored()
    with pytest.raises(NoParametersError, match=r"above 0\.999999999999999") as caught:
        e.infer({"torque": 1.0}, alpha=1 - 1e-16)
    assert (caught.value.reason, caught.value.nearest) == ("nothing_valid", None)


def test_answers_do_not_depend_on_what_was_asked_before():
    e, other = explored(), explored()
    e.alternatives({"torque": 1.0}, count=5)
    e.ask()
    assert e.infer({"torque": 2.0}) == other.infer({"torque": 2.0})


def test_an_exploration_by_questions_finds_what_is_asked_for():
    e = exploration(start={"a": 0.5, "b": 0.0})
    run(e, 60)
    found = e.infer({"torque": 2.0}, tolerance="deviation")
    true = 3.0 * found.parameters["a"] + 0.5 * np.sin(5 * (found.parameters["b"] + 0.08) / 0.16)
    assert abs(true - 2.0) < 0.05
