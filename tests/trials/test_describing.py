"""Explorations in words."""

from kabo.exploration import Exploration, Space
from kabo.trials import describe_exploration, described_case, described_values, summaries_of


def test_the_text_has_a_table_for_each_case_with_trials():
    made = Exploration(
        Space({"a": (0.0, 1.0)}, {"k": ["x", "y"]}), ["torque", "o"], units={"torque": "Nm"}, name="n"
    )
    for value, torque in ((0.2, -1.25), (0.4, 0.5), (0.6, 2.0)):
        made.tell({"k": "y"}, {"a": value}, True, {"torque": torque, "o": 7.0})
    made.tell({"k": "y"}, {"a": 0.9}, False, reason="dropped")
    made.tell({"k": "y"}, {"a": 0.95}, False)
    lines = describe_exploration(made, summaries_of(made)).splitlines()
    assert lines[0] == "n: 5 trials, 3 valid, 2 cases, seed 0"
    assert lines[2:4] == ["k y: 5 trials, 3 valid (60 %), alpha 0.7", "  invalid: 1 no reason given, 1 dropped"]
    assert lines[4].split() == ["outcome", "lowest", "highest", "error"]
    assert lines[5].split()[:5] == ["torque", "-1.25", "Nm", "2", "Nm"]
    assert len({len(line) for line in lines[4:7]}) == 1
    assert lines[-1] == "1 case without trials"


def test_an_exploration_without_trials_is_one_line_and_the_count():
    made = Exploration(Space({"a": (0.0, 1.0)}), ["o"])
    assert describe_exploration(made, summaries_of(made)).splitlines() == [
        "0 trials, 0 valid, 1 case, seed 0",
        "",
        "1 case without trials",
    ]


def test_cases_and_values_are_told_with_their_names_and_units():
    assert described_case({"string": "d4", "direction": "in"}) == "string d4, direction in"
    assert described_case({}) == "the only case"
    assert described_values({"along": 0.0123456, "n": 2.0}, {"along": "m"}) == "along 0.01235 m, n 2"
