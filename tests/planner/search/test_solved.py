"""Solved continuations are found by what they need: in equal geometry, the shortest, of equals the oldest."""

from hypothesis import given
from hypothesis import strategies as st

from kabo.planner.search.solved import Memo, Solved


def solved(needed, length=1, node=None):
    return Solved(needed, node, length)


def test_a_state_that_has_the_needed_bits_finds_the_continuation():
    memo, found = Memo(), solved(0b011)
    memo.add(0b001, None, found)
    assert memo.find(0b101, None) is found
    assert memo.find(0b011, None) is None, "a bit that must not be set"
    assert memo.find(0b100, None) is None, "a bit that must be set"


def test_a_continuation_that_needs_nothing_set_serves_whoever_lacks_the_rest():
    memo = Memo()
    memo.add(0, None, solved(0b10))
    assert memo.find(0b101, None) is not None
    assert memo.find(0b010, None) is None


def test_a_continuation_that_needs_nothing_serves_everybody():
    memo = Memo()
    memo.add(0b1, None, solved(0))
    assert memo.find(0, None) is not None


def test_another_geometry_is_another_memory():
    memo = Memo()
    memo.add(1, "here", solved(1))
    assert memo.find(1, "there") is None
    assert memo.find(1, "here") is not None


def test_the_shortest_is_taken_and_of_equals_the_oldest():
    memo = Memo()
    long, old, new = solved(0b001, 3), solved(0b010, 2), solved(0b100, 2)
    for one in (long, old, new):
        memo.add(0b111, None, one)
    assert memo.find(0b111, None) is old
    assert memo.find(0b101, None) is new
    assert memo.find(0b001, None) is long


def test_an_older_continuation_for_the_same_need_stays():
    memo = Memo()
    first = solved(1, 5)
    memo.add(0b01, None, first)
    memo.add(0b11, None, solved(1, 2))
    assert memo.find(1, None) is first


def test_it_is_empty_until_something_is_added():
    memo = Memo()
    assert memo.is_empty and memo.find(0, None) is None
    memo.add(0, None, solved(0))
    assert not memo.is_empty


BITS = st.integers(0, 31)


@given(BITS, st.lists(st.tuples(BITS, BITS, st.integers(0, 3), st.booleans())), st.lists(BITS))
def test_it_answers_as_a_list_would(functional, added, asked):
    """The files are for speed only, and so is the choice of the bit under which something is filed."""
    memo, listed = Memo(functional), []
    for state, needed, length, geometry in added:
        one = solved(needed, length)
        memo.add(state, geometry, one)
        key = geometry, state & needed, needed & ~state
        if key not in [other for other, _ in listed]:
            listed.append((key, one))
    for state in asked:
        for geometry in (False, True):
            fits = [
                s for (g, ones, zeros), s in listed if g == geometry and not ones & ~state and not zeros & state
            ]
            assert memo.find(state, geometry) is min(fits, key=lambda one: one.length, default=None)
