"""World effects `when C then E`: what is known of E after them, and what E then tells about C.

Source: docs/explanation/knowledge.md#actions.

q, r, p(x) are causes and never change unless a test says so; p(y) is the outcome.
"""

import pytest

from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import holds, outcomes, state_after, then
from tests.support.small_problems import (
    COLOUR,
    FUEL,
    action,
    add,
    app,
    atom,
    cmp,
    delete,
    know,
    lit,
    no,
    problem,
    when,
)

Q, R, X, E = lit("q"), lit("r"), lit("p", "x"), lit("p", "y")
NOT_Q, NOT_R, NOT_X, NOT_E = no("q"), no("r"), no("p", "x"), no("p", "y")
LOOKS = [
    action("see_e", sense=[atom("p", "y")]),
    action("see_q", sense=[atom("q")]),
    action("see_r", sense=[atom("r")]),
]
KNOWN_E, UNKNOWN_E = know(E), f.Not(f.KnowWhether(atom("p", "y")))
UNKNOWN_Q, UNKNOWN_R = f.Not(f.KnowWhether(atom("q"))), f.Not(f.KnowWhether(atom("r")))


def doing(*effects, initial=(), **more):
    """A problem with one action `act` that has these effects, and looking."""
    facts = [add(*initial)] if initial else []
    return {"actions": [*LOOKS, action("act", effects=effects)], "initial": facts, **more}


# ------------------------------------------------------------------------------------------- what is known of E
def test_if_the_condition_is_known_the_outcome_is_known():
    assert holds(KNOWN_E, "act()", **doing(then(Q, E), initial=[Q]))
    assert holds(know(NOT_E), "act()", **doing(then((Q, NOT_R), NOT_E), initial=[Q, NOT_R, E]))


def test_if_a_claim_is_known_false_nothing_happens():
    pieces = doing(then((Q, R), E), initial=[NOT_Q, NOT_E])
    assert holds(know(NOT_E), "act()", **pieces)
    sensed = doing(then((Q, R), E), initial=[NOT_Q])
    assert holds(KNOWN_E, "see_e()", "act()", "p(y): true", **sensed)


def test_if_the_condition_is_open_the_complement_is_forgotten():
    assert holds(UNKNOWN_E, "act()", **doing(then(Q, E), initial=[NOT_E]))


def test_an_outcome_that_is_known_already_stays_known_and_tells_nothing():
    pieces = doing(then(Q, E), initial=[E])
    assert holds(f.And((KNOWN_E, UNKNOWN_Q)), "act()", **pieces)
    task = ground(problem(**pieces))
    assert state_after(task, "act()") == task.initial


def test_what_was_sensed_of_the_outcome_before_is_worth_nothing_afterwards():
    assert holds(UNKNOWN_E, "see_e()", "act()", **doing(then(Q, E)))


def test_every_outcome_is_treated_for_itself():
    pieces = doing(then(Q, (E, R)), initial=[NOT_E, R])
    assert holds(f.And((UNKNOWN_E, know(R))), "act()", **pieces)


def test_the_condition_is_read_in_the_state_before():
    pieces = doing(then(Q, E), add(NOT_Q), initial=[Q, NOT_E])
    assert holds(f.And((KNOWN_E, know(NOT_Q))), "act()", **pieces)


def test_a_known_outcome_wins_over_a_deletion_by_the_same_action():
    for initial in ([Q], [Q, E], [Q, NOT_E]):
        assert holds(KNOWN_E, "act()", **doing(then(Q, E), delete(E, NOT_E), initial=initial))


def test_entries_with_the_outcome_are_dropped_where_it_may_change():
    pieces = doing(then(Q, E))
    pieces["initial"] = [add(E, R, to="Kor")]
    assert not holds(know(R), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(know(R), "see_e()", "p(y): false", **pieces)
    known = {**pieces, "initial": [add(E, R, to="Kor"), add(NOT_Q)]}
    assert holds(know(R), "act()", "see_e()", "p(y): false", **known)


# ------------------------------------------------------------------------------------------------- postdiction
def test_one_cause_of_an_outcome_that_was_false_is_found_both_ways():
    pieces = doing(then(Q, E), initial=[NOT_E])
    assert holds(know(Q), "act()", "see_e()", "p(y): true", **pieces)
    assert holds(know(NOT_Q), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(know(E), "act()", "see_q()", "q: true", **pieces)
    assert holds(know(NOT_E), "act()", "see_q()", "q: false", **pieces)


def test_one_cause_of_an_outcome_that_was_unknown_is_refuted_only():
    pieces = doing(then(Q, E))
    assert holds(UNKNOWN_Q, "act()", "see_e()", "p(y): true", **pieces)
    assert holds(know(NOT_Q), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(know(E), "act()", "see_q()", "q: true", **pieces)
    assert holds(UNKNOWN_E, "act()", "see_q()", "q: false", **pieces)


def test_negative_causes_and_outcomes_are_found_alike():
    pieces = doing(then(NOT_Q, NOT_E), initial=[E])
    assert holds(know(NOT_Q), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(know(Q), "act()", "see_e()", "p(y): true", **pieces)


def test_two_causes_of_an_outcome_that_was_false():
    """Found true: both. Found false: one of them was not."""
    pieces = doing(then((Q, R), E), initial=[NOT_E])
    assert holds(f.And((know(Q), know(R))), "act()", "see_e()", "p(y): true", **pieces)
    found = "act()", "see_e()", "p(y): false"
    assert holds(f.And((UNKNOWN_Q, UNKNOWN_R)), *found, **pieces)
    assert holds(know(NOT_R), *found, "see_q()", "q: true", **pieces)
    assert holds(UNKNOWN_R, *found, "see_q()", "q: false", **pieces)
    assert holds(know(NOT_E), "act()", "see_q()", "q: false", **pieces)


def test_two_causes_of_an_outcome_that_was_unknown():
    pieces = doing(then((Q, R), E))
    assert holds(f.And((UNKNOWN_Q, UNKNOWN_R)), "act()", "see_e()", "p(y): true", **pieces)
    assert holds(know(NOT_R), "act()", "see_e()", "p(y): false", "see_q()", "q: true", **pieces)
    assert holds(KNOWN_E, "act()", "see_q()", "q: true", "see_r()", "r: true", **pieces)
    assert holds(UNKNOWN_E, "act()", "see_q()", "q: false", **pieces)


def test_claims_known_true_before_are_no_question():
    pieces = doing(then((Q, R), E), initial=[NOT_E, R])
    assert holds(know(NOT_Q), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(know(Q), "act()", "see_e()", "p(y): true", **pieces)


def test_what_was_false_at_the_start_of_this_action_counts_and_not_at_that_of_an_earlier_one():
    pieces = doing(then(Q, E), initial=[NOT_E])
    assert holds(know(NOT_Q), "act()", "act()", "see_e()", "p(y): false", **pieces)
    assert holds(f.And((KNOWN_E, know(Q))), "act()", "see_e()", "p(y): true", "act()", **pieces)


def test_sensing_that_stands_open_is_sensing_of_the_cause_all_the_same():
    pieces = doing(then(Q, E), initial=[NOT_E])
    assert holds(KNOWN_E, "see_q()", "act()", "q: true", **pieces)


# ------------------------------------------------------------------------------------- causes that change as well
def test_a_cause_that_the_action_changes_is_not_found():
    for change in (add(NOT_Q), delete(Q), delete(Q, NOT_Q), then(R, Q)):
        pieces = doing(then(Q, E), change, initial=[NOT_E])
        for outcome in ("true", "false"):
            steps = "act()", "see_e()", f"p(y): {outcome}"
            assert holds(UNKNOWN_Q, *steps, **pieces) or change == add(NOT_Q)
            assert not holds(know(Q), *steps, **pieces)


def test_of_two_causes_one_that_changes_and_is_unknown_spoils_it():
    pieces = doing(then((Q, R), E), delete(Q), initial=[NOT_E])
    assert holds(UNKNOWN_R, "act()", "see_e()", "p(y): false", **pieces)


def test_of_two_causes_one_that_changes_but_was_known_does_not_spoil_it():
    pieces = doing(then((Q, R), E), add(NOT_Q), initial=[NOT_E, Q])
    assert holds(know(R), "act()", "see_e()", "p(y): true", **pieces)
    assert holds(know(NOT_R), "act()", "see_e()", "p(y): false", **pieces)


def test_an_effect_that_does_not_happen_spoils_nothing():
    pieces = doing(then(Q, E), when(know(R), delete(Q)), initial=[NOT_E, NOT_R])
    assert holds(know(Q), "act()", "see_e()", "p(y): true", **pieces)
    spoiled = doing(then(Q, E), when(know(R), delete(Q)), initial=[NOT_E, R])
    assert holds(UNKNOWN_Q, "act()", "see_e()", "p(y): true", **spoiled)


def test_an_outcome_that_is_its_own_cause_is_nothing_to_be_found():
    pieces = doing(then(NOT_E, E))
    assert holds(UNKNOWN_E, "act()", **pieces)
    assert set(
        outcomes(ground(problem(**pieces)), state_after(ground(problem(**pieces)), "act()", "see_e()"), "p(y)")
    ) == {
        "true",
        "false",
    }


# ------------------------------------------------------------------------------------------- other effects on E
def test_two_world_effects_in_the_same_direction_each_refute_their_cause_and_prove_nothing():
    pieces = doing(then(Q, E), then(R, E), initial=[NOT_E])
    assert holds(f.And((know(NOT_Q), know(NOT_R))), "act()", "see_e()", "p(y): false", **pieces)
    assert holds(f.And((UNKNOWN_Q, UNKNOWN_R)), "act()", "see_e()", "p(y): true", **pieces)
    assert holds(UNKNOWN_R, "act()", "see_e()", "p(y): true", "see_q()", "q: false", **pieces)


def test_two_world_effects_against_each_other_tell_nothing():
    pieces = doing(then(Q, E), then(R, NOT_E))
    for outcome in ("true", "false"):
        assert holds(f.And((UNKNOWN_Q, UNKNOWN_R)), "act()", "see_e()", f"p(y): {outcome}", **pieces)


def test_a_rival_that_is_known_not_to_happen_does_not_count():
    pieces = doing(then(Q, E), then(R, NOT_E), initial=[NOT_E, NOT_R])
    assert holds(know(Q), "act()", "see_e()", "p(y): true", **pieces)


def test_a_plain_effect_on_the_outcome_spoils_it():
    pieces = doing(then(Q, E), delete(E, NOT_E), initial=[NOT_E])
    assert holds(UNKNOWN_Q, "act()", "see_e()", "p(y): false", **pieces)


def test_what_postdiction_ties_together_is_untied_by_the_next_change():
    pieces = doing(then(Q, E), initial=[NOT_E])
    pieces["actions"].append(action("blur", effects=[delete(E)]))
    assert holds(UNKNOWN_Q, "act()", "blur()", "see_e()", "p(y): true", **pieces)


# ------------------------------------------------------------------------------------------------- terms, numbers
COLOURS = {"functions": [COLOUR]}


def colour(value, operator="="):
    return cmp(app("colour"), operator, value)


LOOK_COLOUR = action("look", sense=[app("colour")])


def test_a_term_that_may_change_has_its_old_value_or_the_new_one():
    pieces = doing(then(Q, colour("u")), initial=[colour("v")], **COLOURS)
    pieces["actions"].append(LOOK_COLOUR)
    assert holds(f.And((know(colour("w", "!=")), f.Not(f.KnowValue(app("colour"))))), "act()", **pieces)
    assert holds(know(Q), "act()", "look()", "colour: u", **pieces)
    assert holds(know(NOT_Q), "act()", "look()", "colour: v", **pieces)
    assert holds(know(colour("v")), "act()", "see_q()", "q: false", **pieces)


def test_an_excluded_value_that_may_come_about_is_not_excluded_any_more():
    pieces = doing(then(Q, colour("u")), initial=[colour("u", "!="), colour("v", "!=")], **COLOURS)
    assert holds(f.Not(know(colour("u", "!="))), "act()", **pieces)


def test_a_value_may_be_a_cause():
    pieces = doing(then(colour("u"), E), initial=[NOT_E], **COLOURS)
    assert holds(know(colour("u")), "act()", "see_e()", "p(y): true", **pieces)
    assert holds(know(colour("u", "!=")), "act()", "see_e()", "p(y): false", **pieces)
    exclude = doing(then(colour("u", "!="), E), initial=[NOT_E], **COLOURS)
    assert holds(know(colour("u")), "act()", "see_e()", "p(y): false", **exclude)


def test_a_number_as_a_cause_is_asked_but_not_found():
    pieces = doing(then(cmp(app("fuel"), "=", 2), E), initial=[NOT_E], functions=[FUEL])
    assert holds(UNKNOWN_E, "act()", **pieces)
    full = doing(then(cmp(app("fuel"), "=", 2), E), initial=[cmp(app("fuel"), "=", 2)], functions=[FUEL])
    assert holds(KNOWN_E, "act()", **full)
    empty = doing(then(cmp(app("fuel"), "=", 2), E), initial=[cmp(app("fuel"), "=", 0), NOT_E], functions=[FUEL])
    assert holds(know(NOT_E), "act()", **empty)


# -------------------------------------------------------------------------------------------------- a known example
@pytest.mark.parametrize(("armed", "outcome"), [(True, "true"), (False, "false")])
def test_several_bombs_one_toilet(armed, outcome):
    """Dunking a package disarms the bomb if it is inside; nothing is left to sense afterwards [McDermott]."""
    dunk = action("dunk", effects=[then(X, NOT_E), then(lit("r"), NOT_E)])
    pieces = {"actions": [dunk, *LOOKS], "initial": [add(E), add(X, R, to="Kx")]}
    assert holds(UNKNOWN_E, "dunk()", **pieces)
    known = holds(know(NOT_E), "dunk()", "see_r()", f"r: {outcome}", **pieces)
    assert known, "in whichever package the bomb was found, it was in the toilet"
