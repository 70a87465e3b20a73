"""Objects that were there before planning are set apart from collections, and only while it lasts."""

import gc
import weakref
from collections.abc import Iterator
from threading import Barrier, Thread

import pytest

from kabo.frozen_gc import YOUNG, frozen_gc


@pytest.fixture(autouse=True)
def _nothing_apart() -> Iterator[None]:
    gc.unfreeze()
    yield
    gc.unfreeze()


class Ring:
    """Garbage that only a collection finds."""

    def __init__(self) -> None:
        self.itself = self


def test_older_objects_are_apart_while_it_lasts_and_no_longer() -> None:
    ring = Ring()
    seen = weakref.ref(ring)
    with frozen_gc():
        del ring
        gc.collect()
        assert seen() is not None
    gc.collect()
    assert seen() is None
    assert gc.get_freeze_count() == 0


def test_garbage_made_meanwhile_is_collected() -> None:
    with frozen_gc():
        seen = weakref.ref(Ring())
        gc.collect()
        assert seen() is None


def test_collections_are_less_frequent_while_it_lasts() -> None:
    before = gc.get_threshold()
    with frozen_gc():
        with frozen_gc():
            pass
        assert gc.get_threshold() == (YOUNG, *before[1:])
    assert gc.get_threshold() == before


@pytest.mark.parametrize("young", [0, 2 * YOUNG])
def test_collections_are_not_made_more_frequent(young: int) -> None:
    before = gc.get_threshold()
    gc.set_threshold(young)
    try:
        with frozen_gc():
            assert gc.get_threshold()[0] == young
        assert gc.get_threshold()[0] == young
    finally:
        gc.set_threshold(*before)


def test_an_error_ends_it() -> None:
    with pytest.raises(KeyError), frozen_gc():
        raise KeyError
    assert gc.get_freeze_count() == 0


def test_what_the_caller_set_apart_stays_apart() -> None:
    gc.freeze()
    apart = gc.get_freeze_count()
    with frozen_gc():
        pass
    assert 0 < gc.get_freeze_count() <= apart


def test_it_lasts_until_the_last_thread_has_left() -> None:
    first_left, counts = Barrier(2), []

    def longer() -> None:
        with frozen_gc():
            first_left.wait()
            first_left.wait()
            counts.append(gc.get_freeze_count())

    thread = Thread(target=longer)
    with frozen_gc():
        thread.start()
        first_left.wait()
    assert gc.get_freeze_count() > 0
    first_left.wait()
    thread.join()
    assert counts[0] > 0
    assert gc.get_freeze_count() == 0


def test_what_has_become_garbage_since_it_was_frozen_does_not_pile_up() -> None:
    """Each freeze sets Python's counts to zero, so that it would never make a full collection by itself."""
    seen = []
    for _ in range(20):
        rings = [Ring() for _ in range(50_000)]
        seen.append(weakref.ref(rings[0]))
        with frozen_gc():
            pass  # from here on they are as old as objects can be
        del rings
    assert seen[0]() is None
    assert sum(each() is not None for each in seen) < 15


def test_nothing_is_collected_where_the_caller_wants_no_collections() -> None:
    seen = []
    gc.disable()
    try:
        for _ in range(20):
            rings = [Ring() for _ in range(50_000)]
            seen.append(weakref.ref(rings[0]))
            with frozen_gc():
                pass
            del rings
        assert all(each() is not None for each in seen)
    finally:
        gc.enable()
