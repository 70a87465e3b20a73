"""How often is looked: by the probabilities of Bayes, not more often than needed, and right as often as promised."""

from fractions import Fraction

import pytest

from kabo.execution.sequential import decide, expected_looks, most_probable
from kabo.language import Measurement, SensorBinding
from kabo.streams import stream_key, uniforms

WORLDS = 6_000


def looks_of(seed: int, wrong: float, outcomes: tuple[str, ...]):
    """Answers of a sensor in a world where the first outcome is true."""
    drawn = uniforms(stream_key("look", seed), 0, 400, 2)

    def look(number: int) -> str:
        errs, which = drawn[number]
        return outcomes[1 + int(which * (len(outcomes) - 1))] if errs < wrong else outcomes[0]

    return look


@pytest.mark.parametrize("counts", [{"a": 3, "b": 1}, {"a": 0, "b": 2, "c": 2}, {"a": 5, "b": 0, "c": 1, "d": 1}])
def test_the_error_is_that_of_bayes_in_exact_numbers(counts: dict[str, int]) -> None:
    wrong = Fraction(3, 20)
    weights = {}
    for true in counts:
        weight = Fraction(1)
        for seen, count in counts.items():
            weight *= (1 - wrong if seen == true else wrong / (len(counts) - 1)) ** count
        weights[true] = weight
    best, error = most_probable(counts, float(wrong))
    assert weights[best] == max(weights.values())
    assert error == pytest.approx(float(1 - weights[best] / sum(weights.values())), rel=1e-12)


@pytest.mark.parametrize(("wrong", "error"), [(0.02, 1e-3), (0.2, 1e-2), (0.35, 0.05)])
def test_two_outcomes_are_told_apart_as_surely_and_as_soon_as_wald_says(wrong: float, error: float) -> None:
    binding = SensorBinding("p", ("true", "false"), Measurement("told"), wrong=wrong, error=error)
    lead = binding.least_looks
    found = [
        decide(looks_of(k, wrong, ("true", "false")), ("true", "false"), wrong, error, 400) for k in range(WORLDS)
    ]
    mistakes = sum(each.outcome != "true" for each in found) / WORLDS
    assert all(each.error <= error for each in found)
    assert mistakes <= error + 4.0 * (error / WORLDS) ** 0.5
    mean = sum(each.looks for each in found) / WORLDS
    assert mean == pytest.approx(expected_looks(wrong, lead), rel=0.03)
    assert min(each.looks for each in found) == lead


def test_the_mean_number_of_looks_is_that_of_a_walk_counted_step_by_step() -> None:
    wrong, lead = 0.3, 3
    places, mean, number = {0: 1.0}, 0.0, 0
    while sum(places.values()) > 1e-12:
        number += 1
        after: dict[int, float] = {}
        for place, share in places.items():
            for step, probability in ((1, 1.0 - wrong), (-1, wrong)):
                if abs(place + step) == lead:
                    mean += number * share * probability
                else:
                    after[place + step] = after.get(place + step, 0.0) + share * probability
        places = after
    assert expected_looks(wrong, lead) == pytest.approx(mean)


def test_more_than_two_outcomes_need_a_lead_over_all_others() -> None:
    outcomes = ("red", "green", "blue")
    found = [decide(looks_of(k, 0.2, outcomes), outcomes, 0.2, 0.01, 400) for k in range(2000)]
    assert sum(each.outcome != "red" for each in found) / 2000 < 0.015
    assert all(each.error <= 0.01 for each in found)


def test_a_sensor_that_is_never_wrong_is_asked_once_and_one_that_sees_nothing_says_nothing() -> None:
    assert decide(lambda _: "a", ("a", "b"), 0.0, 1e-3, 100).looks == 1
    silent = decide(lambda _: None, ("a", "b"), 0.1, 1e-3, 7)
    assert silent.outcome is None and silent.looks == 7
    assert decide(lambda _: None, ("a", "b"), 0.0, 1e-3, 100).looks == 1


def test_looks_that_contradict_each_other_end_at_the_cap_without_an_answer() -> None:
    found = decide(lambda number: ("a", "b")[number % 2], ("a", "b"), 0.1, 1e-3, 30)
    assert found.outcome is None and found.looks == 30 and found.error == pytest.approx(0.5)
