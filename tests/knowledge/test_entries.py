"""Entries of Kx (exactly one member holds) and Kor (at least one): what they say, when they go.

Source: docs/explanation/knowledge.md.
"""

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import holds, outcomes, state_after, then
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
LOOKS = [
    action("look_q", sense=[atom("q")]),
    action("look_r", sense=[atom("r")]),
    action("look_x", sense=[atom("p", "x")]),
    action("look_colour", sense=[app("colour")]),
]
TERM = {"functions": [COLOUR]}


def told(database, *members, revocable):
    """A problem that starts with one entry about facts that actions change, or about facts that they do not."""
    more = [action("change", effects=[delete(*members)])] if revocable else []
    return {"actions": [*LOOKS, *more], "initial": [add(*members, to=database)], **TERM}


either = pytest.mark.parametrize("revocable", [False, True], ids=["permanent", "revocable"])


@either
def test_of_exactly_one_a_true_member_makes_all_others_false(revocable):
    pieces = told("Kx", Q, R, X, revocable=revocable)
    assert holds(f.And((know(NOT_R), know(NOT_X))), "look_q()", "q: true", **pieces)


@either
def test_a_false_member_leaves_the_others_open_and_the_last_one_is_true(revocable):
    pieces = told("Kx", Q, R, X, revocable=revocable)
    one = ("look_q()", "q: false")
    assert not holds(f.Or((f.KnowWhether(atom("r")), f.KnowWhether(atom("p", "x")))), *one, **pieces)
    two = (*one, "look_r()", "r: false")
    assert holds(know(X), *two, **pieces)


@either
def test_of_at_least_one_a_true_member_says_nothing_about_the_others(revocable):
    pieces = told("Kor", Q, R, revocable=revocable)
    assert not holds(f.KnowWhether(atom("r")), "look_q()", "q: true", **pieces)
    assert holds(know(R), "look_q()", "q: false", **pieces)


@either
@pytest.mark.parametrize("database", ["Kx", "Kor"])
def test_members_may_be_negative_and_values(revocable, database):
    pieces = told(database, NOT_Q, cmp(app("colour"), "=", "u"), revocable=revocable)
    assert holds(know(cmp(app("colour"), "=", "u")), "look_q()", "q: true", **pieces)
    assert holds(know(NOT_Q), "look_colour()", "colour: v", **pieces)
    excluded = holds(know(cmp(app("colour"), "!=", "u")), "look_q()", "q: false", **pieces)
    assert excluded == (database == "Kx")


@either
def test_exactly_one_of_all_instances_is_one_entry(revocable):
    z = var("z")
    members = f.ExactlyOne((z,), lit("p", z))
    more = [action("change", effects=[delete(X, Y)])] if revocable else []
    pieces = {"actions": [*LOOKS, *more], "initial": [add(members, NOT_Q, to="Kx")], **TERM}
    assert holds(f.And((know(NOT_Y), know(Q))), "look_x()", "p(x): true", **pieces)
    assert holds(know(Y), "look_x()", "p(x): false", "look_q()", "q: true", **pieces)


@either
def test_an_outcome_that_an_entry_contradicts_is_impossible(revocable):
    pieces = told("Kx", Q, R, revocable=revocable)
    task = ground(problem(**pieces))
    state = state_after(task, "look_q()", "look_r()", "q: true")
    assert outcomes(task, state, "r") == ["false"]


def test_known_members_are_told_from_the_start():
    assert holds(f.And((know(NOT_R), know(NOT_X))), initial=[add(Q), add(Q, R, X, to="Kx")])
    assert holds(know(R), initial=[add(NOT_Q), add(Q, R, to="Kor")])


@pytest.mark.parametrize(
    "initial",
    [
        [add(Q, R), add(Q, R, to="Kx")],
        [add(NOT_Q, NOT_R), add(Q, R, to="Kx")],
        [add(NOT_Q, NOT_R), add(Q, R, to="Kor")],
        [add(Q, R, to="Kx"), add(Q, NOT_R, to="Kx"), add(Q)],
    ],
)
@either
def test_an_entry_without_a_way_to_hold_is_an_error_at_the_start(initial, revocable):
    more = [action("change", effects=[delete(Q, R)])] if revocable else []
    with pytest.raises(InputError, match="contradicts"):
        ground(problem(initial=initial, actions=[*LOOKS, *more], **TERM))


# ------------------------------------------------------------------------------------------------ entries that go
def same_state(first, second, **pieces):
    """Whether two ways lead to the same knowledge."""
    task = ground(problem(**pieces))
    return state_after(task, *first) == state_after(task, *second)


@pytest.mark.parametrize(
    ("database", "outcome"), [("Kx", "true"), ("Kx", "false"), ("Kor", "true"), ("Kor", "false")]
)
def test_an_entry_that_has_said_everything_is_gone(database, outcome):
    unsay = action("unsay", effects=[delete(Q, R, of=database)])
    pieces = told(database, Q, R, revocable=True)
    pieces["actions"].append(unsay)
    steps = "look_q()", f"q: {outcome}"
    assert same_state(steps, (*steps, "unsay()"), **pieces)


def test_an_entry_with_the_same_members_in_another_order_is_the_same():
    say = action("say", effects=[add(R, Q, Q, to="Kx")])
    pieces = told("Kx", Q, R, revocable=True)
    pieces["actions"].append(say)
    assert same_state((), ("say()",), **pieces)


def test_the_same_members_in_the_other_database_are_another_entry():
    say = action("say", effects=[delete(Q, R, of="Kor")])
    pieces = told("Kx", Q, R, revocable=True)
    pieces["actions"].append(say)
    assert holds(know(NOT_R), "say()", "look_q()", "q: true", **pieces)


@either
def test_a_deleted_entry_says_nothing_any_more(revocable):
    unsay = action("unsay", effects=[delete(R, Q, of="Kx"), add(Y)])
    pieces = told("Kx", Q, R, revocable=revocable)
    pieces["actions"].append(unsay)
    assert not holds(f.KnowWhether(atom("r")), "unsay()", "look_q()", "q: true", **pieces)


CHANGE_Q = [add(Q), add(NOT_Q), delete(Q), delete(NOT_Q), delete(Q, NOT_Q)]


@pytest.mark.parametrize("change", CHANGE_Q, ids=["add", "add not", "del", "del not", "forget"])
@pytest.mark.parametrize("database", ["Kx", "Kor"])
def test_a_change_of_a_member_in_the_world_drops_the_entry(database, change):
    pieces = {"actions": [*LOOKS, action("act", effects=[change])], "initial": [add(Q, R, to=database)], **TERM}
    assert not holds(f.KnowWhether(atom("r")), "act()", **pieces)
    if change.operation == "del":
        for outcome in ("true", "false"):
            assert not holds(f.KnowWhether(atom("r")), "act()", "look_q()", f"q: {outcome}", **pieces)
    for outcome in ("true", "false"):
        known = holds(know(Q), "act()", "look_r()", f"r: {outcome}", **pieces)
        assert known == (change == add(Q))


def test_a_change_that_does_not_happen_drops_nothing():
    act = action("act", effects=[when(know(X), delete(Q))])
    pieces = {"actions": [*LOOKS, act], "initial": [add(Q, R, to="Kx")], **TERM}
    assert holds(know(NOT_R), "act()", "look_q()", "q: true", **pieces)
    dropped = {**pieces, "initial": [add(X), add(Q, R, to="Kx")]}
    assert not holds(f.KnowWhether(atom("r")), "act()", "look_q()", "q: true", **dropped)


def test_members_that_are_out_already_do_not_count():
    """q was found false: the entry is about r and p(x) only, whatever then happens to q."""
    pieces = {"actions": [*LOOKS, action("act", effects=[add(Q)])], "initial": [add(Q, R, X, to="Kx")], **TERM}
    steps = "look_q()", "q: false", "act()", "look_r()", "r: false"
    assert holds(f.And((know(X), know(Q))), *steps, **pieces)


def test_what_the_world_may_do_to_a_member_drops_the_entry():
    act = action("act", effects=[then(lit("p", "y"), Q)])
    pieces = {"actions": [*LOOKS, act], "initial": [add(Q, R, to="Kx")], **TERM}
    assert not holds(f.KnowWhether(atom("r")), "act()", "look_q()", "q: true", **pieces)
    never = {**pieces, "initial": [add(NOT_Y), add(Q, R, to="Kx")]}
    assert holds(know(NOT_R), "act()", "look_q()", "q: true", **never)


def test_sensing_and_update_rules_are_no_changes():
    rule = when(know(Y), delete(Q, NOT_Q))
    actions = [*LOOKS, action("act", effects=[add(Y)]), action("change", effects=[delete(Q, R)])]
    pieces = {"actions": actions, "initial": [add(Q, R, to="Kx")], "update_rules": [rule], **TERM}
    assert holds(know(NOT_Q), "act()", "look_q()", "look_r()", "r: true", **{**pieces, "update_rules": ()})
    task = ground(problem(**pieces, goal=[know(Q)]))
    assert task.is_goal(state_after(task, "look_r()", "r: false"))
    without = {**pieces, "actions": [*actions, action("unsay", effects=[delete(Q, R, of="Kx")])]}
    assert not same_state(("act()",), ("act()", "unsay()"), **without)


def test_an_entry_that_an_action_adds_is_about_the_values_after_it():
    shuffle = action("shuffle", effects=[delete(Q, NOT_Q, R, NOT_R), add(Q, R, to="Kx")])
    pieces = {"actions": [*LOOKS, shuffle], "initial": [add(Q, NOT_R)], **TERM}
    assert not holds(f.KnowWhether(atom("q")), "shuffle()", **pieces)
    assert holds(know(R), "shuffle()", "look_q()", "q: false", **pieces)


def test_an_entry_added_again_has_all_its_members_again():
    shuffle = action("shuffle", effects=[delete(Q, NOT_Q, R, NOT_R, X, NOT_X), add(Q, R, X, to="Kx")])
    pieces = {"actions": [*LOOKS, shuffle], "initial": [add(Q, R, X, to="Kx")], **TERM}
    steps = "look_q()", "q: false", "shuffle()"
    assert same_state(("shuffle()",), steps, **pieces)


def test_an_action_whose_entry_contradicts_what_is_known_is_not_applicable():
    say = action("say", effects=[add(Q, R, to="Kor")])
    task = ground(problem(actions=[say], initial=[add(NOT_Q, NOT_R)]))
    assert task.actions[0].after(task.initial) is None
