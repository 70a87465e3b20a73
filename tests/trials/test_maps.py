"""Sections of what was learned: along one parameter, over two, or slices through the point of greatest validity."""

import numpy as np
import pytest

from kabo.exploration import Exploration, Space
from kabo.trials.maps import most_valid, nearness, sections
from tests.support.discs import explored


@pytest.mark.parametrize(("count", "figures"), [(1, 1), (2, 1), (3, 3), (4, 6)])
def test_there_is_one_section_for_each_pair_of_parameters(count, figures):
    names = ("a", "b", "c", "d")[:count]
    made = explored(30, names)
    found = list(sections(made, {}))
    assert len(found) == figures and len({each.names for each in found}) == figures
    for each in found:
        assert len(each.names) == min(count, 2)
        assert {*each.names, *each.through} == {*names}


def test_values_are_those_of_the_exploration():
    made = explored(40, ("a", "b", "c"))
    section = list(sections(made, {}))[1]
    assert section.names == ("a", "c") and section.through == {"b": most_valid(made, {})["b"]}
    row, column = 3, 17
    point = {"a": section.values[0][column], "c": section.values[1][row], **section.through}
    assert section.validity[row, column] == pytest.approx(made.validity({}, [point])[0])
    for known, expected in zip(section.outcomes["torque"], made.predict({}, [point])["torque"], strict=True):
        assert known[row, column] == pytest.approx(expected[0])


def test_the_point_of_greatest_validity_is_a_valid_trial_and_the_middle_without_one():
    made = explored(30)
    assert most_valid(made, {}) in [trial.parameters for trial in made.trials if trial.valid]
    empty = Exploration(Space({"a": (1.0, 3.0)}), ["x"])
    assert most_valid(empty, {}) == {"a": 2.0}


def test_without_a_valid_trial_nothing_is_known_of_outcomes():
    made = Exploration(Space({"a": (0.0, 1.0), "b": (0.0, 1.0)}), ["x"])
    made.tell({}, {"a": 0.5, "b": 0.5}, False)
    (section,) = sections(made, {})
    assert section.outcomes == {} and np.isfinite(section.validity).all()


def test_trials_fade_with_their_distance_from_a_slice():
    made = explored(40, ("a", "b", "c"))
    section = next(sections(made, {}))
    at = [
        (abs(trial.parameters["c"] - section.through["c"]), nearness(made, trial, section))
        for trial in made.trials
    ]
    assert [near for _, near in sorted(at)] == sorted((near for _, near in at), reverse=True)
    assert max(near for _, near in at) == 1.0
    (whole,) = sections(explored(5), {})
    assert all(nearness(made, trial, whole) == 1.0 for trial in made.trials)
