"""Summaries: the trials of each case counted, with reasons in order and the ranges of outcomes."""

import pytest

from kabo.exploration import Exploration, Space
from kabo.trials import summaries_of, summary_to_json


def test_each_case_is_summed_up_also_one_without_trials() -> None:
    space = Space({"x": (0.0, 1.0)}, {"bar": ["steel", "wood", "glass"]})
    exploration = Exploration(space, ["torque"], units={"torque": "Nm"})
    for x, torque in ((0.2, 1.0), (0.4, 3.0), (0.6, 2.0)):
        exploration.tell({"bar": "steel"}, {"x": x}, True, {"torque": torque})
    for x, reason in ((0.8, "b"), (0.9, "a"), (1.0, "c"), (0.95, "c")):
        exploration.tell({"bar": "steel"}, {"x": x}, False, reason=reason)
    exploration.tell({"bar": "wood"}, {"x": 0.0}, False, reason="a")
    steel, wood, glass = summaries_of(exploration)
    assert (steel.case, steel.trials, steel.valid, steel.alpha) == ({"bar": "steel"}, 7, 3, 0.7)
    assert list(steel.reasons.items()) == [("c", 2), ("a", 1), ("b", 1)]
    assert (wood.trials, wood.valid, wood.outcomes, wood.reasons) == (1, 0, {}, {"a": 1})
    assert (glass.trials, glass.valid, glass.outcomes, glass.reasons) == (0, 0, {}, {})
    error = exploration.leave_one_out({"bar": "steel"})["torque"]
    assert error == pytest.approx(steel.outcomes["torque"].error)
    assert summary_to_json(steel)["outcomes"] == {
        "torque": {"lowest": 1.0, "highest": 3.0, "error": error, "unit": "Nm"}
    }
