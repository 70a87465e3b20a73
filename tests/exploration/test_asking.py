"""What to try next: the start, retries, the greatest entropy within the valid set, cases and budgets [T 4.3.1, e10]."""

import numpy as np
import pytest

from kabo.exploration import Exploration, NoParametersError, Question, Validity, load_exploration, trial_seed
from kabo.exploration.asking import CANDIDATES, TRIES, case_order, caution
from kabo.exploration.candidates import spread_candidates
from kabo.exploration.models import NOISE, SCALE
from kabo.streams import stream_key
from tests.support import oracles_exploration as oracles
from tests.support import small_explorations as small
from tests.support.small_explorations import CASES, answer, exploration, run, tell, tell_random

START = {"a": 0.5, "b": 0.0}
STEEL = {"bar": "steel", "end": "left"}


# ------------------------------------------------------------------------------------------------- the next trial
@pytest.mark.parametrize("count", [1, 8, 15])
def test_the_next_trial_has_the_greatest_entropy_among_valid_candidates(count):
    explored = exploration()
    tell_random(explored, count, spread=0.5)
    valid = [each for each in explored.trials if each.valid]
    known = oracles.scaled(explored, [each.parameters for each in valid])
    key = stream_key(explored.seed, "ask", len(explored.trials))
    drawn = spread_candidates(key, CANDIDATES, known, explored.validity_options.scale)
    low_and_span = [(low, high - low) for low, high in explored.space.parameters.values()]
    named = [
        {n: lo + u * span for n, u, (lo, span) in zip("ab", each, low_and_span, strict=True)} for each in drawn
    ]
    allowed = np.flatnonzero(explored.validity({}, named) > 0.7)
    scale = min(SCALE, explored.validity_options.scale)
    deviation = oracles.Gaussian(known, np.zeros(len(valid)), scale, NOISE).mean_and_deviation(drawn[allowed])[1]
    asked = explored.ask()
    chosen = oracles.scaled(explored, [asked.parameters])[0]
    best = drawn[allowed[int(np.argmax(deviation))]]
    np.testing.assert_allclose(chosen, best, atol=1e-5)  # but for the rounding of parameters


@pytest.mark.parametrize("alpha", [0.3, 0.7, 0.95])
def test_a_question_is_strictly_within_the_valid_set(alpha):
    explored = exploration(validity=Validity(alpha=alpha), start=START)
    for _ in range(25):
        asked = explored.ask()
        if explored.trials_of({}):
            assert asked.validity > alpha
        assert asked.validity == explored.validity({}, [asked.parameters])[0]
        tell(explored, asked.parameters)


def test_alpha_of_a_question_overrides_that_of_the_exploration():
    explored = exploration(start=START)
    run(explored, 12)
    assert explored.ask(alpha=0.99).validity > 0.99
    assert 0.7 < explored.ask().validity < 0.99


def test_questions_walk_outward_from_the_first_valid_trial():
    explored = exploration(start=START)
    run(explored, 40)
    assert sum(each.valid for each in explored.trials) >= 16
    inner = [p for p in small.grid(explored.space, 21) if answer(explored.space, p)[0]]
    assert np.mean(explored.validity({}, inner) > 0.75) > 0.7


def test_parameters_that_are_asked_for_have_six_digits_of_their_range():
    explored = exploration(3, start={"a": 0.5, "b": 0.0, "c": 20.0})
    run(explored, 8)
    for trial in explored.trials[1:]:
        assert [
            round(value, digits) for value, digits in zip(trial.parameters.values(), (5, 6, 4), strict=True)
        ] == list(trial.parameters.values())


# ---------------------------------------------------------------------------------------------------- determinism
def test_the_question_of_a_case_does_not_depend_on_other_cases():
    alone, mixed = exploration(cases=CASES, start=START), exploration(cases=CASES, start=START)
    for number in range(12):
        run(alone, 1, STEEL)
        run(mixed, 1, {"bar": "wood", "end": "both"})
        if number % 3 == 0:
            tell_random(mixed, 2, number, {"bar": "steel", "end": "right"})
        run(mixed, 1, STEEL)
    assert alone.trials_of(STEEL) == mixed.trials_of(STEEL)
    assert alone.ask(STEEL) == mixed.ask(STEEL)
    assert alone.infer({"torque": 2.0}, STEEL) == mixed.infer({"torque": 2.0}, STEEL)


def test_asking_twice_and_asking_other_things_changes_nothing():
    explored = exploration(start=START)
    run(explored, 10)
    first, digest = explored.ask(), explored.digest
    (
        explored.infer({"torque": 1.0}),
        explored.validity({}, [START]),
        explored.predict({}, [START]),
        explored.leave_one_out({}),
    )
    assert explored.ask() == first
    assert explored.digest == digest


def test_saving_and_loading_between_trials_does_not_matter(tmp_path):
    whole, interrupted = exploration(start=START), exploration(start=START)
    for _ in range(25):
        run(whole, 1)
        interrupted.save(tmp_path / "model.jsonl")
        interrupted = load_exploration(tmp_path / "model.jsonl")
        run(interrupted, 1)
    assert whole.text == interrupted.text


def test_another_seed_asks_other_questions():
    asked = []
    for seed in (1, 2):
        explored = exploration(start=START, seed=seed)
        run(explored, 3)
        asked.append(explored.ask().parameters)
    assert asked[0] != asked[1]


def test_the_cases_of_an_exploration_have_streams_of_their_own():
    explored = exploration(cases=CASES)
    for end in ("left", "right"):
        tell(explored, START, {"bar": "steel", "end": end})
    assert explored.ask(STEEL).parameters != explored.ask({"bar": "steel", "end": "right"}).parameters


def test_seeds_of_trials_differ_and_stay_below_2_to_the_53():
    seeds = {
        trial_seed(seed, case, n) for seed in (0, 1) for case in ({}, STEEL, {"bar": "steel"}) for n in range(50)
    }
    assert len(seeds) == 300
    assert all(0 <= each < 2**53 for each in seeds)


# ------------------------------------------------------------------------------------------------ start and retry
def test_without_a_start_and_trials_nothing_is_asked():
    with pytest.raises(NoParametersError) as caught:
        exploration().ask()
    assert caught.value.reason == "not_explored"
    assert caught.value.nearest is None


def test_the_first_question_is_the_start_as_it_was_given():
    explored = exploration(start={"b": 0.0123456789, "a": 1 / 3})
    assert explored.ask() == Question({}, {"a": 1 / 3, "b": 0.0123456789}, 0.5)


def test_after_an_invalid_trial_parameters_change_as_its_reason_says():
    explored = exploration(start=START, retry={"low": {"a": 0.25}, "high": {"b": -0.01}})
    explored.tell({}, explored.ask().parameters, False, reason="low")
    assert explored.ask().parameters == {"a": 0.75, "b": 0.0}
    explored.tell({}, explored.ask().parameters, False, reason="high")
    assert explored.ask().parameters == {"a": 0.75, "b": -0.01}
    explored.tell({}, explored.ask().parameters, False, reason="low")
    assert explored.ask().parameters == {"a": 1.0, "b": -0.01}


@pytest.mark.parametrize("reason", ["unknown", "", "at the bound"])
def test_where_retries_say_nothing_new_parameters_are_drawn_around_the_start(reason):
    explored = exploration(start={"a": 1.0, "b": 0.0}, retry={"at the bound": {"a": 0.5}})
    explored.tell({}, {"a": 1.0, "b": 0.0}, False, reason=reason)
    asked = explored.ask().parameters
    assert asked != {"a": 1.0, "b": 0.0}
    assert 0.3 < asked["a"] <= 1.0


def test_opposite_changes_do_not_go_back_and_forth():
    explored = exploration(start=START, retry={"low": {"a": 0.125}, "high": {"a": -0.125}})
    tried = []
    for number in range(TRIES):
        tried.append(tuple(explored.ask().parameters.values()))
        explored.tell({}, explored.ask().parameters, False, reason=("low", "high")[number % 2])
    assert len(set(tried)) == TRIES


def test_after_ten_invalid_trials_an_exploration_gives_up_and_says_why():
    explored = exploration(start=START)
    for number in range(TRIES):
        explored.tell({}, explored.ask().parameters, False, reason="dropped" if number else "crushed")
    with pytest.raises(NoParametersError, match="9 × dropped, 1 × crushed") as caught:
        explored.ask()
    assert caught.value.reason == "nothing_valid"


def test_invalid_trials_without_a_start_are_no_place_to_begin():
    explored = exploration()
    explored.tell({}, START, False, reason="dropped")
    with pytest.raises(NoParametersError) as caught:
        explored.ask()
    assert caught.value.reason == "nothing_valid"


def test_after_a_valid_trial_retries_do_not_matter():
    explored = exploration(start=START, retry={"right": {"a": -0.4}})
    tell(explored, START)
    explored.tell({}, {"a": 0.95, "b": 0.0}, False, reason="right")
    assert explored.ask().validity > 0.7


def test_contradictory_trials_at_one_point_end_an_exploration_without_a_budget():
    explored = exploration()
    for number in range(20):
        explored.tell({}, START, number % 2 == 0, {"torque": 1.0} if number % 2 == 0 else None)
    with pytest.raises(NoParametersError) as caught:
        explored.ask()
    assert caught.value.reason == "nothing_valid"


# ------------------------------------------------------------------------------------------------------- budgets
@pytest.mark.parametrize("budget", [0.01, 0.1, 0.25, 0.5, 0.9])
def test_a_budget_moves_alpha_as_its_formula_says(budget):
    explored = exploration(start=START, invalid_budget=budget)
    for _ in range(30):
        told = [each.valid for each in explored.trials]
        expected = small.caution(explored.validity_options, budget, told)
        assert explored.alpha({}) == pytest.approx(expected, abs=1e-14)
        tell(explored, explored.ask().parameters)
    assert not all(told)


def test_the_first_steps_of_a_budget_by_hand():
    # z: Φ⁻¹(0.9) = 1.28155; an invalid trial adds ½ · 0.9, a valid one takes ½ · 0.1
    assert caution([], 0.7, 0.1) == pytest.approx(0.9)
    assert caution([False], 0.7, 0.1) == pytest.approx(0.958323, abs=1e-6)  # Φ(1.73155)
    assert caution([False, True], 0.7, 0.1) == pytest.approx(0.953672, abs=1e-6)  # Φ(1.68155)
    assert caution([False] * 9, 0.7, 0.1) == pytest.approx(0.9999683, abs=1e-7)  # Φ(4), not Φ(5.33)
    assert caution([True] * 99, 0.7, 0.1) == 0.5  # Φ(0)
    assert caution([], 0.95, 0.1) == pytest.approx(0.95)
    assert caution([], 0.3, 0.8) == 0.5


def test_alpha_of_one_case_does_not_depend_on_others():
    explored = exploration(cases=CASES, invalid_budget=0.2)
    before = explored.alpha(STEEL)
    tell_random(explored, 9, case={"bar": "wood", "end": "left"})
    assert explored.alpha(STEEL) == before
    assert explored.alpha({"bar": "wood", "end": "left"}) != before


def test_with_a_budget_the_safest_parameters_are_asked_where_none_are_safe_enough():
    explored = exploration(invalid_budget=0.05)
    for number in range(21):
        explored.tell({}, START, number % 3 == 0, {"torque": 1.0} if number % 3 == 0 else None)
    assert explored.alpha({}) > 0.99
    asked = explored.ask()
    assert asked.validity < explored.alpha({})
    assert asked.validity >= max(explored.validity({}, small.grid(explored.space, 60))) - 0.01


@pytest.mark.parametrize("budget", [0.1, 0.3])
def test_a_budget_is_kept_in_a_world_with_a_border(budget):
    shares = []
    for seed in range(2):
        explored = exploration(start=START, invalid_budget=budget, seed=seed)
        run(explored, 120)
        shares.append(np.mean([not each.valid for each in explored.trials]))
    assert budget - 0.04 <= np.mean(shares) <= budget + 0.06
    free = exploration(start=START)
    run(free, 120)
    assert np.mean([not each.valid for each in free.trials]) > np.mean(shares)


# --------------------------------------------------------------------------------------------------------- cases
def chosen(explored: Exploration, seeds: int) -> list[tuple[str, ...]]:
    header = {"cases": CASES, "start": START}
    found = []
    for seed in range(seeds):
        other = exploration(**header, seed=seed)
        for each in explored.trials:
            other.tell(each.case, each.parameters, each.valid, each.outcomes or None, each.reason)
        found.append(tuple(other.ask().case.values()))
    return found


def test_cases_with_few_trials_near_the_last_one_are_chosen_more_often():
    explored = exploration(cases=CASES)
    for bar, end, count in (
        ("steel", "left", 3),
        ("steel", "right", 0),
        ("wood", "both", 0),
        ("wood", "right", 1),
    ):
        for _ in range(count):
            tell(explored, START, {"bar": bar, "end": end})
    found = chosen(explored, 400)
    # weights 1 / ((1 + steps from the last) (1 + trials)²), the last is (wood, right)
    weights = {
        ("steel", "left"): 1 / (3 * 16),
        ("steel", "right"): 1 / 2,
        ("steel", "both"): 1 / 3,
        ("wood", "left"): 1 / 2,
        ("wood", "right"): 1 / 4,
        ("wood", "both"): 1 / 2,
    }
    for case, weight in weights.items():
        assert found.count(case) / 400 == pytest.approx(weight / sum(weights.values()), abs=0.06), case


def test_the_order_of_cases_holds_each_once():
    cases = exploration(cases=CASES).space.all_cases
    for number in range(20):
        order = case_order(exploration(cases=CASES).space, cases, [number] * 6, cases[0], stream_key(number))
        assert sorted(order) == list(range(6))


def test_a_case_in_which_nothing_is_valid_is_passed_over():
    explored = exploration(cases={"bar": ["steel", "wood"]})
    tell(explored, START, {"bar": "wood"})
    explored.tell({"bar": "steel"}, START, False)
    for _ in range(6):
        assert explored.ask().case == {"bar": "wood"}
        tell(explored, explored.ask().parameters, {"bar": "wood"})


def test_where_no_case_has_anything_to_try_the_reason_is_said():
    explored = exploration(cases={"bar": ["steel", "wood"]})
    with pytest.raises(NoParametersError) as caught:
        explored.ask()
    assert caught.value.reason == "not_explored"
    explored.tell({"bar": "steel"}, START, False, reason="dropped")
    with pytest.raises(NoParametersError) as caught:
        explored.ask()
    assert caught.value.reason == "nothing_valid"
