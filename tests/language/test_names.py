"""Names in kabo's spelling: valid, never two for one, and the same in every run."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kabo.language.names import RESERVED, Names


@pytest.mark.parametrize(
    ("original", "expected"),
    [
        ("pick-up", "pick_up"), ("on", "on"), ("1st", "n1st"), ("_x", "x"), ("isEmpty", "is_empty"), ("-", "n"),
        ("then", "then_1"), ("not", "not_1"), ("a__b", "a__b"), ("k", "k"), ("größe", "groesse"),
        ("Würfel", "wuerfel"),  # letters that have a spelling, or an accent, are no gaps
        ("W\u0075\u0308rfel", "wuerfel"),
        ("Maßstab", "massstab"),
        ("été", "ete"),
    ],
)  # fmt: skip
def test_a_name_is_spelled_as_near_as_possible(original, expected):
    assert Names().take(original) == expected


def test_names_that_would_be_the_same_get_numbers_in_their_order():
    names = Names(["taken"])
    assert [names.take(each) for each in ("a-b", "a_b", "A_B", "a.b", "taken")] == [
        "a_b", "a_b_2", "a_b_3", "a_b_4", "taken_2",
    ]  # fmt: skip
    assert names.originals == {"a_b": "a-b", "a_b_2": "a_b", "a_b_3": "A_B", "a_b_4": "a.b", "taken_2": "taken"}


def test_a_free_name_is_not_taken_yet():
    names = Names()
    assert names.free("x") == names.free("x") == "x"
    assert names.free("x", ["x", "x_2"]) == "x_3"


@given(st.lists(st.text(min_size=1, max_size=8), max_size=30))
def test_every_name_is_valid_and_has_one_original(originals):
    names = Names()
    given_ = [names.take(each) for each in originals]
    assert len(set(given_)) == len(originals)
    assert all(re.fullmatch(r"[a-z][a-z0-9_]*", name) and name not in RESERVED for name in given_)
    assert [names.originals[name] for name in given_] == originals
