"""Bodies that are not seen: the time counts in which somebody looks."""

import pytest

from kabo.execution.sightings import GONE_AFTER, Sightings


def test_a_body_is_gone_after_a_second_of_looking_and_not_of_waiting() -> None:
    sightings = Sightings(("cup", "jug"))
    assert sightings.gone(0.0) is None
    sightings.saw(("cup", "jug"), 0.0)
    for k in range(1, 81):
        sightings.saw(("jug",), 0.01 * k)
    assert sightings.gone(0.8) is None
    sightings.saw((), 5.8)  # five seconds in which a sensor was waited for
    assert sightings.gone(5.8) is None
    for k in range(1, 31):
        sightings.saw(("jug",), 5.8 + 0.01 * k)
    name, seconds = sightings.gone(6.1)
    assert name == "cup" and seconds == pytest.approx(1.2) and seconds > GONE_AFTER
    sightings.saw(("cup",), 6.11)
    assert sightings.gone(6.11) is None


@pytest.mark.parametrize("apart", [0.05, 0.2, 1.0])
def test_a_body_that_no_look_sees_is_gone_however_seldom_a_busy_machine_looks(apart: float) -> None:
    sightings = Sightings(("cup", "jug"))
    sightings.saw(("cup", "jug"), 0.0)
    for k in range(1, 30):
        sightings.saw(("jug",), apart * k)
    found = sightings.gone(apart * 29)
    assert found is not None and found[0] == "cup"


def test_what_has_never_seen_anything_is_no_camera() -> None:
    sightings = Sightings(("cup", "jug"))
    for k in range(300):
        sightings.saw((), 0.01 * k)
    assert sightings.gone(3.0) is None
    sightings.saw(("cup",), 3.01)
    for k in range(2, 200):
        sightings.saw(("cup",), 3.0 + 0.01 * k)
    assert sightings.gone(5.0)[0] == "jug"


@pytest.mark.parametrize(("period", "seconds"), [(0.0, 1.0), (0.1, 1.0), (2.0, 6.0)])
def test_of_a_slow_camera_three_pictures_are_waited_for(period: float, seconds: float) -> None:
    sightings = Sightings(("cup",), 100.0, period)
    sightings.saw(("cup",), 0.0)
    gone = next(k for k in range(1, 1000) if not sightings.saw((), 0.01 * k) and sightings.gone(0.01 * k))
    assert 0.01 * gone == pytest.approx(seconds, abs=0.02)
