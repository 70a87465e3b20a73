"""Goals about other states: `initially(φ)` is about the start as it is known now, `always(φ)` about every state."""

from kabo.knowledge import ground, unreachable_goals
from kabo.language import formulas as f
from tests.knowledge.asking import holds, then
from tests.support.small_problems import COLOUR, action, add, app, atom, cmp, delete, know, lit, no, problem, when

Q, R, X, E = lit("q"), lit("r"), lit("p", "x"), lit("p", "y")
NOT_Q, NOT_R, NOT_X, NOT_E = no("q"), no("r"), no("p", "x"), no("p", "y")
LOOK = action("look", sense=[atom("q")])
SEE = action("see", sense=[atom("p", "y")])
MAKE = action("make", effects=[add(Q)])
LOSE = action("lose", effects=[delete(Q, NOT_Q)])


def initially(formula):
    return f.Temporal("initially", formula)


def always(formula):
    return f.Temporal("always", formula)


# ------------------------------------------------------------------------------------------------------ initially
def test_what_is_known_at_the_start_is_known_of_the_start_for_ever():
    pieces = {"actions": [MAKE, LOSE], "initial": [add(NOT_Q)]}
    assert holds(initially(know(NOT_Q)), "make()", "lose()", **pieces)
    assert not holds(initially(know(Q)), "make()", **pieces)


def test_what_is_learned_later_was_so_at_the_start_if_nothing_touched_it():
    pieces = {"actions": [LOOK, MAKE]}
    goal = initially(know(NOT_Q))
    assert holds(goal, "look()", "q: false", **pieces)
    assert holds(goal, "look()", "q: false", "make()", **pieces)
    assert not holds(goal, **pieces)


def test_what_an_action_touched_says_nothing_about_the_start():
    pieces = {"actions": [LOOK, MAKE, LOSE]}
    assert not holds(initially(f.KnowWhether(atom("q"))), "make()", **pieces)
    assert not holds(initially(f.KnowWhether(atom("q"))), "lose()", "look()", "q: true", **pieces)


def test_what_may_have_changed_says_nothing_about_the_start():
    act = action("act", effects=[then(R, Q)])
    for outcome in ("true", "false"):
        goal = initially(know(Q if outcome == "true" else NOT_Q))
        assert not holds(initially(know(Q)), "act()", "look()", f"q: {outcome}", actions=[LOOK, act])
        assert holds(goal, "act()", "look()", f"q: {outcome}", actions=[LOOK, act], initial=[add(NOT_R)])


def test_postdiction_reaches_back_to_the_start():
    """A plant that was dry is wet after watering if and only if the tap worked: it did so from the start."""
    act = action("act", effects=[then(Q, E)])
    pieces = {"actions": [act, SEE, LOSE], "initial": [add(NOT_E)]}
    assert holds(initially(know(Q)), "act()", "see()", "p(y): true", **pieces)
    assert holds(initially(know(NOT_Q)), "act()", "see()", "p(y): false", **pieces)
    assert not holds(initially(know(Q)), "act()", "lose()", "see()", "p(y): true", **pieces)
    assert holds(initially(know(Q)), "act()", "see()", "p(y): true", "lose()", **pieces)


def test_what_was_untouched_when_it_was_found_and_what_follows_from_it_at_the_start():
    """Exactly one of q, r at the start: r is found out, q was changed before."""
    find = action("find", sense=[atom("r")])
    touch = action("touch", effects=[delete(R)])
    pieces = {"actions": [MAKE, find, touch], "initial": [add(Q, R, to="Kx")]}
    assert holds(initially(know(NOT_Q)), "make()", "find()", "r: true", **pieces)
    assert holds(initially(know(Q)), "make()", "find()", "r: false", **pieces)
    assert not holds(initially(know(Q)), "make()", "touch()", "find()", "r: false", **pieces)


def test_the_value_of_a_term_at_the_start_is_kept():
    paint = action("paint", effects=[add(cmp(app("colour"), "=", "u"))])
    look = action("look", sense=[app("colour")])
    pieces = {"actions": [paint, look], "functions": [COLOUR]}
    goal = initially(know(cmp(app("colour"), "=", "v")))
    assert holds(goal, "look()", "colour: v", "paint()", **pieces)
    assert holds(goal, "paint()", initial=[add(cmp(app("colour"), "=", "v"))], **pieces)
    assert not holds(initially(f.KnowValue(app("colour"))), "paint()", **pieces)
    excluded = initially(know(cmp(app("colour"), "!=", "v")))
    assert holds(excluded, "paint()", initial=[add(cmp(app("colour"), "!=", "v"))], **pieces)


def test_a_formula_about_the_start_may_be_compound():
    goal = initially(f.And((f.Not(know(Q)), f.Or((know(R), know(X))))))
    assert holds(goal, "make()", actions=[MAKE], initial=[add(X)])


def test_what_only_rules_forget_is_kept_of_the_start():
    rule = when(know(R), delete(Q))
    act = action("act", effects=[add(R)])
    pieces = {"actions": [act, LOOK], "initial": [add(Q)], "update_rules": [rule]}
    assert holds(initially(know(Q)), "act()", **pieces)


def test_what_was_otherwise_at_the_start_is_a_goal_out_of_reach():
    task = ground(problem(actions=[MAKE], initial=[add(NOT_Q)], goal=[initially(know(Q))]))
    assert unreachable_goals(task) == ["initially(K(q))"]


# --------------------------------------------------------------------------------------------------------- always
def test_always_is_lost_once_and_for_all():
    pieces = {"actions": [LOSE, MAKE], "initial": [add(Q)]}
    goal = always(know(Q))
    assert holds(goal, **pieces)
    assert holds(goal, "make()", **pieces)
    assert not holds(goal, "lose()", **pieces)
    assert not holds(goal, "lose()", "make()", **pieces)


def test_always_is_asked_at_the_start():
    assert not holds(always(know(Q)), "make()", actions=[MAKE])


def test_always_is_asked_before_an_action_branches_and_in_every_outcome():
    goal = always(f.Not(know(Q)))
    pieces = {"actions": [LOOK]}
    assert holds(goal, "look()", **pieces)
    assert holds(goal, "look()", "q: false", **pieces)
    assert not holds(goal, "look()", "q: true", **pieces)
    never_open = always(f.Not(f.And((f.KnowWhether(atom("q")), f.Not(know(Q)), f.Not(know(NOT_Q))))))
    assert not holds(never_open, "look()", "q: true", **pieces)


def test_always_is_asked_after_inference():
    rule = when(know(Q), add(R))
    goal = always(f.Not(f.And((know(Q), f.Not(know(R))))))
    assert holds(goal, "make()", actions=[MAKE], update_rules=[rule])


def test_two_goals_for_always_are_kept_apart():
    pieces = {"actions": [LOSE], "initial": [add(Q, R)]}
    assert holds(always(know(R)), "lose()", **pieces)
    both = f.And((always(know(R)), always(know(Q))))
    assert not holds(both, "lose()", **pieces)
    assert holds(f.And((always(know(R)), f.Not(always(know(Q))))), "lose()", **pieces)
