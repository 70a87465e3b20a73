"""Kinds: which may stand where which is asked for, and which can be equal."""

import pytest

from kabo.language.types import ANY, NUMBERS, TEST, Kind, Types, Values


@pytest.fixture
def types() -> Types:
    """thing > bottle, thing > cup > mug; place."""
    found = Types()
    for name, parent in (("thing", None), ("bottle", "thing"), ("cup", "thing"), ("mug", "cup"), ("place", None)):
        found.add(name, None, parent)
    return found


@pytest.mark.parametrize(
    ("kind", "wanted", "fits"),
    [
        (("mug",), ("thing",), True),
        (("thing",), ("mug",), False),
        (("mug", "bottle"), ("cup", "bottle"), True),
        (("mug", "place"), ("cup", "bottle"), False),
        (NUMBERS, ("thing",), False),
        (("thing",), NUMBERS, False),
        (TEST, ("thing",), False),
        (ANY, ("thing",), True),
        (("thing",), ANY, True),
        (Values(("red",)), Values(("blue", "red")), True),
        (Values(("red", "green")), Values(("blue", "red")), False),
        (Values(("thing",)), ("thing",), False),
    ],
)
def test_a_kind_fits_where_all_its_types_are_asked_for(types: Types, kind: Kind, wanted: Kind, fits: bool) -> None:
    assert types.fits(kind, wanted) == fits


@pytest.mark.parametrize(
    ("first", "second", "comparable"),
    [
        (("mug",), ("thing",), True),
        (("mug",), ("bottle",), False),
        (("mug", "bottle"), ("cup",), True),  # both are things, as a cup is
        (NUMBERS, NUMBERS, True),
        (NUMBERS, ("thing",), False),
        (ANY, NUMBERS, True),
        (Values(("red", "green")), Values(("blue", "red")), True),
        (Values(("green",)), Values(("blue", "red")), False),
        (Values(("thing",)), ("thing",), False),
    ],
)
def test_kinds_can_be_equal_if_one_contains_the_other_or_they_share_a_value(
    types: Types, first: Kind, second: Kind, comparable: bool
) -> None:
    assert types.comparable(first, second) == types.comparable(second, first) == comparable


def test_the_common_type_is_the_nearest_that_contains_all(types: Types) -> None:
    assert types.common(("mug",)) == "mug"
    assert types.common(("mug", "bottle")) == "thing"
    assert types.common(("mug", "cup")) == "cup"
    assert types.common(ANY) == ""
    assert types.common(Values(("red", "green"))) == "{red, green}"


def test_a_type_of_another_language_gets_a_free_name_and_object_is_the_root() -> None:
    types = Types()
    assert [types.declare(name, None) for name in ("object", "Big-Box", "big_box", "number")] == [
        "object",
        "big_box",
        "big_box_2",
        "number_2",
    ]
    assert types.common(ANY) == "object"
