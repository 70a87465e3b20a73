"""Bodies that are called by a colour have it."""

import pytest

from kabo.viewer.content.colours import NAMED, colour_of_name


@pytest.mark.parametrize("name", ["red", "red_cup", "cup_red", "Red2", "bottle-red"])
def test_a_word_of_a_name_says_the_colour(name):
    assert colour_of_name(name) == NAMED["red"]


@pytest.mark.parametrize("name", ["bottle_1", "redundant", "hatred", "o4", ""])
def test_a_name_without_such_a_word_says_none(name):
    assert colour_of_name(name) is None
