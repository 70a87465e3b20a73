"""What follows is known: last values, update rules in rounds, contradictions, and all of it to a fixpoint."""

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import holds, outcomes, state_after
from tests.support.small_problems import (
    COLOUR,
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
    var,
    when,
)

Q, R, X, Y = lit("q"), lit("r"), lit("p", "x"), lit("p", "y")
NOT_Q, NOT_R, NOT_X, NOT_Y = no("q"), no("r"), no("p", "x"), no("p", "y")
LOOK = action("look", sense=[atom("q")])
MAKE = action("make", effects=[add(Q)])
UNMAKE = action("unmake", effects=[add(NOT_Q)])
TERM = {"functions": [COLOUR]}


def colour(value, operator="="):
    return cmp(app("colour"), operator, value)


# ------------------------------------------------------------------------------------------------------ last value
def test_a_term_of_which_all_values_but_one_are_excluded_has_that_value():
    two = [add(colour("u", "!="), colour("v", "!="))]
    assert holds(f.And((know(colour("w")), f.KnowValue(app("colour")))), initial=two, **TERM)
    assert not holds(f.KnowValue(app("colour")), initial=[add(colour("u", "!="))], **TERM)


def test_the_last_value_is_found_after_an_action_and_tells_the_entries():
    exclude = action("exclude", effects=[when(know(Q), add(colour("v", "!=")))])
    rule = when(know(NOT_X), add(colour("v", "!=")))
    find = action("find", sense=[atom("p", "x")])
    initial = [add(colour("u", "!=")), add(colour("w"), R, to="Kx")]
    pieces = {"actions": [find, exclude], "initial": initial, "update_rules": [rule], **TERM}
    assert holds(f.And((know(colour("w")), know(NOT_R))), "find()", "p(x): false", **pieces)
    assert not holds(f.KnowWhether(atom("r")), "find()", "p(x): true", **pieces)


def test_a_term_without_any_value_left_is_a_contradiction():
    with pytest.raises(InputError, match="contradicts"):
        ground(problem(initial=[add(*(colour(v, "!=") for v in "uvw"))], **TERM))


def test_a_known_value_excludes_others_and_its_exclusion_is_impossible_later():
    look = action("look", sense=[app("colour")])
    task = ground(problem(actions=[look], initial=[add(colour("u", "!=")), add(colour("v"), Q, to="Kor")], **TERM))
    state = state_after(task, "look()")
    assert outcomes(task, state, "colour") == ["v", "w"]


# ------------------------------------------------------------------------------------------------------------ rules
def test_a_rule_draws_its_conclusion_as_soon_as_its_condition_is_known():
    rule = when(know(Q), add(R))
    pieces = {"actions": [LOOK, MAKE], "update_rules": [rule]}
    assert not holds(know(R), "look()", **pieces)
    assert not holds(know(R), "look()", "q: false", **pieces)
    assert holds(know(R), "look()", "q: true", **pieces)
    assert holds(know(R), "make()", **pieces)
    assert holds(know(R), actions=[LOOK], initial=[add(Q)], update_rules=[rule])


def test_rules_follow_on_rules_and_on_entries_and_entries_on_rules():
    rules = [when(know(Q), add(X)), when(know(NOT_Y), add(R))]
    pieces = {"actions": [LOOK], "update_rules": rules, "initial": [add(X, Y, to="Kx")]}
    assert holds(f.And((know(X), know(NOT_Y), know(R))), "look()", "q: true", **pieces)


def test_rules_of_one_round_read_the_same_state():
    """Both fire: the second does not see what the first takes away."""
    rules = [when(know(Q), delete(Q), add(R)), when(know(Q), add(X))]
    pieces = {"actions": [MAKE], "update_rules": rules}
    assert holds(f.And((know(R), know(X), f.Not(know(Q)))), "make()", **pieces)


def test_a_rule_may_forget_and_may_speak_of_every_object():
    z = var("z")
    rule = f.ForEach((z,), (when(f.And((know(Q), know(lit("p", z)))), delete(lit("p", z))),))
    pieces = {"actions": [MAKE], "update_rules": [rule], "initial": [add(X, NOT_Y)]}
    assert holds(f.And((f.Not(know(X)), know(NOT_Y))), "make()", **pieces)


def test_an_unconditional_rule_always_holds():
    pieces = {"actions": [action("lose", effects=[delete(R)])], "update_rules": [add(R)]}
    assert holds(know(R), **pieces)
    assert holds(know(R), "lose()", **pieces)


def test_a_forgotten_conclusion_is_drawn_again_as_long_as_its_reason_is_known():
    pieces = {
        "actions": [action("lose", effects=[delete(R)])],
        "initial": [add(Q)],
        "update_rules": [when(know(Q), add(R))],
    }
    assert holds(know(R), "lose()", **pieces)


def test_a_conclusion_stays_when_its_reason_is_forgotten():
    lose = action("lose", effects=[delete(Q)])
    assert holds(know(R), "lose()", actions=[lose], initial=[add(Q)], update_rules=[when(know(Q), add(R))])


def test_rules_may_ask_for_what_is_not_known():
    rule = when(f.Not(f.KnowWhether(atom("q"))), add(R))
    pieces = {"actions": [LOOK], "update_rules": [rule]}
    assert holds(know(R), **pieces)
    assert not holds(know(R), initial=[add(Q)], **pieces)


def test_an_action_that_leads_to_a_contradiction_is_not_applicable():
    rules = [when(know(Q), add(R)), when(know(Q), add(NOT_R))]
    task = ground(problem(actions=[MAKE], update_rules=rules))
    assert task.actions[0].after(task.initial) is None


def test_a_conclusion_contrary_to_what_is_known_is_a_contradiction():
    task = ground(problem(actions=[MAKE], update_rules=[when(know(Q), add(R))], initial=[add(NOT_R)]))
    assert task.actions[0].after(task.initial) is None


def test_an_outcome_that_leads_to_a_contradiction_is_impossible():
    task = ground(problem(actions=[LOOK], update_rules=[when(know(Q), add(R))], initial=[add(NOT_R)]))
    assert outcomes(task, state_after(task, "look()"), "q") == ["false"]


def test_two_values_of_one_term_are_a_contradiction():
    rules = [when(know(Q), add(colour("u"))), when(know(Q), add(colour("v")))]
    task = ground(problem(actions=[MAKE], update_rules=rules, **TERM))
    assert task.actions[0].after(task.initial) is None


def test_an_initial_contradiction_is_an_error():
    with pytest.raises(InputError, match="contradicts"):
        ground(problem(actions=[LOOK, MAKE], initial=[add(Q, NOT_R)], update_rules=[when(know(Q), add(R))]))


def test_rules_that_never_settle_are_an_error():
    rules = [when(know(Q), delete(Q)), when(f.Not(know(Q)), add(Q))]
    with pytest.raises(InputError, match="1000 rounds"):
        ground(problem(actions=[MAKE], update_rules=rules))


def test_knowing_a_fact_is_knowing_whether():
    whether = f.KnowWhether(atom("r"))
    for conclusion in (R, NOT_R):
        assert holds(whether, "make()", actions=[MAKE], update_rules=[when(know(Q), add(conclusion))])


def test_two_entries_together_tell_more_than_each():
    """Exactly one of q, r; at least one of not r, p(x): q false, so r, so p(x)."""
    initial = [add(Q, R, to="Kx"), add(NOT_R, X, to="Kor")]
    assert holds(know(X), "look()", "q: false", actions=[LOOK], initial=initial)
    assert not holds(f.KnowWhether(atom("p", "x")), "look()", "q: true", actions=[LOOK], initial=initial)


def test_no_case_is_split():
    """q or r, q or not r, not q or … : only unit propagation is asked for."""
    initial = [add(Q, R, to="Kor"), add(Q, NOT_R, to="Kor")]
    assert not holds(know(Q), actions=[LOOK], initial=initial)
