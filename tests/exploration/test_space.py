"""Spaces: bounds of any size, exact ways to the unit cube and back, and messages that name every fault."""

import json
import math

import numpy as np
import pytest

from kabo.exploration import ExplorationError, Space

RANGES = [
    (0.0, 1.0),
    (0.0, 1e-12),
    (0.0, 1e15),
    (1e9, 1e9 + 1e-3),
    (-0.1, 0.2),
    (-0.0041659107951907, -1.0951061951466885e-10),
    (-857699959.3888491, -5.022445517110371e-13),
    (-1e100, 1e100),
    (0.0, 1e-300),
    (0.0, 5e-324),
    (1.0, math.nextafter(1.0, 2.0)),
    (1e15, 1e15 + 1),
    (-40, 1),
]


@pytest.mark.parametrize("bounds", RANGES)
def test_rounded_parameters_stay_within_bounds_and_lead_back_exactly(bounds):
    space = Space({"a": bounds})
    cube = np.vstack([np.random.default_rng(0).random((500, 1)), [[-0.5], [0.0], [1.0], [1.5]]])
    parameters, points = space.rounded(cube)
    named = [space.named(row) for row in parameters]
    assert all(bounds[0] <= each["a"] <= bounds[1] for each in named)
    np.testing.assert_array_equal(space.scaled(named), points)
    assert points.min() >= 0.0
    assert points.max() <= 1.0
    again, same = space.rounded(points)
    np.testing.assert_array_equal(again, parameters)
    np.testing.assert_array_equal(same, points)


@pytest.mark.parametrize("bounds", [(0.0, 1.0), (0.0, 1e-12), (0.0, 1e15), (-0.1, 0.2), (-40, 1)])
def test_rounding_moves_by_less_than_a_hundred_thousandth_of_the_range(bounds):
    cube = np.random.default_rng(0).random((500, 1))
    assert np.abs(Space({"a": bounds}).rounded(cube)[1] - cube).max() <= 5.1e-6


def test_rounded_parameters_are_short_in_a_file():
    parameters, _ = Space({"a": (0.0, 1.0), "b": (-0.08, 0.08)}).rounded(np.random.default_rng(0).random((200, 2)))
    assert max(len(json.dumps(value)) for value in parameters.ravel()) <= 9
    assert "-0.0" not in {
        json.dumps(value) for value in Space({"b": (-1.0, 1.0)}).rounded(np.array([[0.499999999]]))[0].ravel()
    }


def test_scaled_parameters_are_shares_of_their_bounds():
    space = Space({"a": (-2.0, 6.0), "b": (1.0, 3.0)})
    np.testing.assert_array_equal(
        space.scaled([{"b": 2.0, "a": 0.0}, {"a": 6, "b": 1}]), [[0.25, 0.5], [1.0, 0.0]]
    )
    assert space.scaled([]).shape == (0, 2)


def test_the_last_variable_of_cases_changes_first():
    space = Space({"a": (0, 1)}, {"bar": ["steel", "wood"], "end": ("left", "right")})
    assert [tuple(each.values()) for each in space.all_cases] == [
        ("steel", "left"),
        ("steel", "right"),
        ("wood", "left"),
        ("wood", "right"),
    ]
    assert Space({"a": (0, 1)}).all_cases == ({},)


def test_a_case_is_kept_in_the_order_of_its_variables():
    space = Space({"a": (0, 1)}, {"bar": ["steel", "wood"], "end": ["left", "right"]})
    assert list(space.case({"end": "left", "bar": "wood"}).items()) == [("bar", "wood"), ("end", "left")]
    assert space.matching({"end": "left"}) == ({"bar": "steel", "end": "left"}, {"bar": "wood", "end": "left"})
    assert len(space.matching(None)) == 4


def test_what_is_given_may_change_afterwards():
    bounds = {"a": (0.0, 1.0)}
    values = ["steel"]
    space = Space(bounds, {"bar": values})
    bounds["b"] = (0.0, 1.0)
    values.append("wood")
    assert space == Space({"a": (0.0, 1.0)}, {"bar": ("steel",)})


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({}, "1 to 6 parameters"),
        (dict.fromkeys("abcdefg", (0, 1)), "1 to 6 parameters"),
        ([("a", (0, 1))], "1 to 6 parameters"),
        ({"": (0, 1)}, "must have a name"),
        ({3: (0, 1)}, "must have a name, this is 3"),
        ({"a\ud800": (0, 1)}, "must have a name"),
        ({"a": 3}, "bounds of a must be two numbers"),
        ({"a": "ab"}, "bounds of a must be two numbers"),
        ({"a": (0, 1, 2)}, "bounds of a must be two numbers"),
        ({"a": (0, True)}, "each bound of a must be a finite number"),
        ({"a": (0, float("nan"))}, "finite number up to 1e.100, these are 0 and nan"),
        ({"a": (-float("inf"), 0)}, "finite number"),
        ({"a": (0, 10**400)}, "finite number"),
        ({"a": (0, 1e101)}, "finite number"),
        ({"a": ("0", "1")}, "finite number"),
        ({"a": (1, 1)}, "bounds of a are equal: 1"),
        ({"a": (2, 1)}, "wrong way round: from 2 to 1"),
        ({"a": (2, 1), "b": (1, 1)}, "a are the wrong way round.*; the bounds of b are equal"),
    ],
)
def test_unusable_parameters_are_refused(parameters, message):
    with pytest.raises(ExplorationError, match=message):
        Space(parameters)


@pytest.mark.parametrize(
    ("cases", "message"),
    [
        (["bar"], "cases must map variables"),
        ({"": ["steel"]}, "must have a name"),
        ({"bar": "steel"}, "must be a list of names"),
        ({"bar": []}, "must be a list of names"),
        ({"bar": ["steel", 3]}, "values of bar must be names"),
        ({"bar": ["steel", ""]}, "values of bar must be names"),
        ({"bar": ["\udfff"]}, "values of bar must be names"),
        ({"bar": ["steel", "steel"]}, "values of bar must differ"),
        ({str(number): ["a", "b"] for number in range(40)}, "1099511627776 cases, and at most 10000"),
    ],
)
def test_unusable_cases_are_refused(cases, message):
    with pytest.raises(ExplorationError, match=message):
        Space({"a": (0, 1)}, cases)


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ({"aa": "m"}, 'unknown parameter "aa": did you mean "a"'),
        ({"a": 3}, "unit of a must be a text"),
        (["m"], "must map"),
    ],
)
def test_unusable_units_are_refused(units, message):
    with pytest.raises(ExplorationError, match=message):
        Space({"a": (0, 1)}, units=units)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "parameter along is missing; the parameter force is missing"),
        (
            {"along": 0.0, "forc": 1.0},
            'unknown parameter "forc": did you mean "force".*; the parameter force is missing',
        ),
        ({"along": 0.09, "force": 41}, "along is 0.09, outside its bounds -0.08 to 0.08; force is 41, outside"),
        ({"along": float("nan"), "force": 2}, "along must be a finite number up to 1e.100, this is nan"),
        ({"along": True, "force": 2}, "along must be a finite number"),
        ({"along": "0", "force": 2}, "along must be a finite number"),
        ({"along": None, "force": 2}, "along must be a finite number"),
        ([0.0, 1.0], "must map names to values"),
        ({"along": [[[[[[[[[[]]]]]]]]]], "force": 2}, "this is .*\\.\\.\\."),
    ],
)
def test_unusable_parameters_of_a_point_are_all_named(given, message):
    with pytest.raises(ExplorationError, match=message):
        Space({"along": (-0.08, 0.08), "force": (1, 40)}).checked(given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, r"the case must say bar \(steel or wood\), end \(left or right\)"),
        ({"bar": "steal", "end": "left"}, 'unknown value of bar "steal": did you mean "steel"'),
        ({"rod": "steel"}, 'unknown case variable "rod": .*bar'),
        ({"bar": ["steel"], "end": "left"}, "unknown value of bar"),
        ("steel", "a case must map names to values"),
    ],
)
def test_unusable_cases_of_a_trial_are_refused(given, message):
    with pytest.raises(ExplorationError, match=message):
        Space({"a": (0, 1)}, {"bar": ["steel", "wood"], "end": ["left", "right"]}).case(given)


def test_numbers_of_numpy_and_fractions_are_numbers():
    from fractions import Fraction

    given = {"a": np.float32(0.5), "b": np.int64(1), "c": Fraction(1, 4)}
    assert Space(dict.fromkeys("abc", (0, 1))).checked(given) == {"a": 0.5, "b": 1.0, "c": 0.25}


def test_a_message_does_not_repeat_a_text_of_any_length():
    with pytest.raises(ExplorationError) as caught:
        Space({"a": (0, 1)}).checked({"x" * 100_000: 1, "a": "y" * 100_000})
    assert len(str(caught.value)) < 500
