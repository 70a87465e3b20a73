"""What is said where bodies would come nearer to each other than they are to be kept."""

import pytest

from kabo.tasks.robots.motion.kept_distances import told_distance

PAIR = ("o1", "o2")


def test_a_distance_that_is_missing_is_told_with_what_is_to_be_kept():
    assert told_distance(PAIR, 0.0012, 0.003, 0.01) == "o1 and o2 are 1.2 mm apart, but 3 mm are to be kept"


@pytest.mark.parametrize("apart", [0.0403, 0.04001, 0.03999])
def test_a_distance_that_is_there_and_not_proven_is_no_contradiction(apart: float):
    """Not `40.3 mm apart, but 40 mm are to be kept`."""
    told = told_distance(PAIR, apart, 0.04, 0.01).partition(" (")[0]
    assert told.endswith(" apart, too near for a proof with this epsilon that 40 mm are kept")


def test_no_epsilon_is_proposed_that_no_command_takes():
    """The two are told as 40.1 and 40 mm, and what is left between them is 20 nm."""
    told = told_distance(PAIR, 0.04005001, 0.04004999, 0.01)
    assert "40.1 mm" in told and "40 mm" in told and "try" not in told


@pytest.mark.parametrize(("apart", "finer"), [(0.0494, "0.0094"), (0.3, "0.01"), (0.0403, "0.0003")])
def test_the_epsilon_that_is_proposed_fits_into_what_is_left(apart: float, finer: str):
    assert told_distance(PAIR, apart, 0.04, 0.02).endswith(f" (try --epsilon {finer})")
