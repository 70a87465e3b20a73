"""Refused calls in words: a robot that is in its own way is told with the pair of links, and how near they come."""

from dataclasses import replace

from kabo.geometry_server import Measure, Refusal, pair_text
from kabo.language.formulas import GroundCall
from kabo.planner.proofs.refused_calls import most_refused, refused

CALL = GroundCall("sense", ("arm", "box"))
OWN, OTHER = ("arm.torso", "arm.hand"), ("arm.hand", "lid")
REFUSAL = Refusal("collision", "arm cannot sense box: …", pairs=((OWN, 60), (OTHER, 4)), attempts=64)


def test_the_links_of_a_robot_that_is_in_its_own_way_are_named_with_the_measure() -> None:
    measure = Measure(pair_text(OWN), "arm.torso and arm.hand overlap by 4 mm or more", 0.01, -0.004)
    said = refused(CALL, replace(REFUSAL, measures=(measure,)))
    how = "arm.torso and arm.hand overlap by 4 mm or more"
    assert said == f"sense(arm, box): blocked by arm itself in 60 of 64 attempts, most often {how}"


def test_without_a_measure_the_pair_is_named_all_the_same() -> None:
    assert refused(CALL, REFUSAL).endswith(
        "blocked by arm itself in 60 of 64 attempts, most often arm.torso and arm.hand"
    )


def test_another_body_is_named_as_ever() -> None:
    refusal = replace(REFUSAL, pairs=((OTHER, 60), (OWN, 4)))
    assert refused(CALL, refusal) == "sense(arm, box): blocked by lid in 60 of 64 attempts"


def test_the_call_that_was_refused_most_is_told_with_its_number_and_what_was_in_the_way() -> None:
    other = GroundCall("pick", ("arm", "cup"))
    blocked = Refusal("collision", "…", pairs=((OTHER, 1_000),), attempts=1_064)
    assert most_refused([(CALL, REFUSAL), (other, blocked)]) == "pick(arm, cup) refused 1,064 times, mostly by lid"
    assert most_refused([(CALL, REFUSAL)]) == "sense(arm, box) refused 64 times, mostly by arm itself"
    rare = replace(blocked, pairs=((OTHER, 30),))
    assert most_refused([(other, rare)]) == "pick(arm, cup) refused 1,064 times, most often by lid"
    assert most_refused([(CALL, Refusal("empty_family"))]) == most_refused([]) == ""
