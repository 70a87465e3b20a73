"""What add and del mean [research/knowledge-planner section 2, items 1 to 3, 7]."""

import pytest

from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import holds, state_after
from tests.support.small_problems import (
    BELOW,
    COLOUR,
    FUEL,
    X,
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

P, NOT_P = know(lit("p", "x")), know(no("p", "x"))


def act(*effects, **more):
    return {"actions": [action("act", effects=effects, **more)]}


def test_nothing_is_assumed_false_because_it_is_absent():
    assert not holds(P)
    assert not holds(NOT_P)
    assert holds(f.Not(P))
    assert holds(f.Not(NOT_P))


def test_not_known_differs_from_known_false():
    known_false = {"initial": [add(no("p", "x"))]}
    assert holds(f.Not(P), **known_false) and holds(NOT_P, **known_false)
    assert holds(f.Not(P)) and not holds(NOT_P)


@pytest.mark.parametrize(("first", "second", "gone", "kept"), [("p", "not p", P, NOT_P), ("not p", "p", NOT_P, P)])
def test_adding_a_literal_removes_its_complement(first, second, gone, kept):
    literal = {"p": lit("p", "x"), "not p": no("p", "x")}
    pieces = {"initial": [add(literal[first])], **act(add(literal[second]))}
    assert holds(kept, "act()", **pieces)
    assert not holds(gone, "act()", **pieces)


def test_deleting_a_literal_forgets_it_and_says_nothing_about_its_complement():
    pieces = {"initial": [add(lit("p", "x"))], **act(delete(lit("p", "x")))}
    assert not holds(P, "act()", **pieces)
    assert not holds(NOT_P, "act()", **pieces)


def test_deleting_the_complement_of_what_is_known_changes_nothing():
    assert holds(P, "act()", initial=[add(lit("p", "x"))], **act(delete(no("p", "x"))))


def test_add_wins_over_delete():
    for effects in ([add(lit("q")), delete(lit("q"))], [delete(lit("q")), add(lit("q"))]):
        assert holds(know(lit("q")), "act()", initial=[add(lit("q"))], **act(*effects))


def test_an_action_that_contradicts_itself_is_not_applicable():
    task = ground(problem(**act(add(lit("q")), add(no("q")))))
    assert task.actions[0].after(task.initial) is None
    task = ground(problem(functions=[COLOUR], **act(*(add(cmp(app("colour"), "=", v)) for v in "uv"))))
    assert task.actions[0].after(task.initial) is None


def test_all_conditions_are_read_in_the_state_before():
    swap = [when(know(lit("q")), add(lit("r")), add(no("q"))), when(know(lit("r")), add(lit("q")), add(no("r")))]
    pieces = {"initial": [add(lit("q"), no("r"))], **act(*swap)}
    assert holds(f.And((know(lit("r")), know(no("q")))), "act()", **pieces)
    assert holds(f.And((know(lit("q")), know(no("r")))), "act()", "act()", **pieces)


def test_universal_effects_reach_every_object_and_may_be_conditional_and_nested():
    z, w = var("z"), var("w")
    related = {"predicates": {"near": ("thing", "thing")}}
    effect = f.ForEach((z,), (f.ForEach((w,), (when(know(lit("p", z)), add(lit("near", z, w))),)),))
    pieces = {"initial": [add(lit("p", "x"))], **act(effect), **related}
    assert holds(f.Forall((w,), know(lit("near", "x", w))), "act()", **pieces)
    assert not holds(f.Exists((w,), know(lit("near", "y", w))), "act()", **pieces)


def test_a_universal_fact_of_kf_is_known_of_every_instance():
    fact = f.FactForall((var("z"),), f.FactAll((lit("p", var("z")), lit("q"))))
    goal = f.And((know(lit("p", "x")), know(lit("p", "y")), know(lit("q"))))
    assert holds(goal, "act()", **act(add(fact)))


# ---------------------------------------------------------------------------------------------- function values
def colour(value, operator="="):
    return know(cmp(app("colour"), operator, value))


def test_a_new_value_replaces_the_old_one():
    pieces = {"functions": [COLOUR], "initial": [add(cmp(app("colour"), "=", "u"))]}
    moved = act(add(cmp(app("colour"), "=", "v")))
    assert holds(f.And((colour("v"), f.Not(colour("u")))), "act()", **pieces, **moved)


def test_a_known_value_is_known_to_differ_from_all_others():
    pieces = {"functions": [COLOUR], "initial": [add(cmp(app("colour"), "=", "u"))]}
    assert holds(colour("v", "!="), **pieces)
    assert not holds(colour("u", "!="), **pieces)


def test_an_excluded_value_is_known_to_differ_until_the_value_is_known():
    pieces = {"functions": [COLOUR], "initial": [add(cmp(app("colour"), "!=", "u"))]}
    assert holds(colour("u", "!="), **pieces)
    assert not holds(colour("v", "!="), **pieces)
    forget = [action("set", effects=[add(cmp(app("colour"), "=", "u"))])]
    forget.append(action("act", effects=[delete(cmp(app("colour"), "=", "u"))]))
    assert not holds(colour("u", "!="), "set()", "act()", actions=forget, **pieces)


def test_excluding_the_known_value_forgets_it():
    pieces = {"functions": [COLOUR], "initial": [add(cmp(app("colour"), "=", "u"))]}
    exclude = act(add(cmp(app("colour"), "!=", "u")))
    assert holds(colour("u", "!="), "act()", **pieces, **exclude)
    assert not holds(f.KnowValue(app("colour")), "act()", **pieces, **exclude)


def test_excluding_another_value_changes_nothing():
    pieces = {"functions": [COLOUR], "initial": [add(cmp(app("colour"), "=", "u"))]}
    task = ground(problem(**pieces, **act(add(cmp(app("colour"), "!=", "v")))))
    assert task.actions[0].after(task.initial) == task.initial


def test_a_value_may_be_copied_from_another_term():
    below = {"functions": [BELOW], "initial": [add(cmp(app("below", "x"), "=", "y"))]}
    copy = act(add(cmp(app("below", "y"), "=", app("below", "x"))))
    assert holds(know(cmp(app("below", "y"), "=", "y")), "act()", **below, **copy)


def test_a_copy_of_an_unknown_value_is_unknown():
    below = {"functions": [BELOW], "initial": [add(cmp(app("below", "y"), "=", "y"))]}
    copy = act(add(cmp(app("below", "y"), "=", app("below", "x"))))
    assert not holds(f.KnowValue(app("below", "y")), "act()", **below, **copy)


# ------------------------------------------------------------------------------------------------------ numbers
def fuel(operator, value):
    return know(cmp(app("fuel"), operator, value))


BURN = act(add(cmp(app("fuel"), "=", f.Arithmetic("-", app("fuel"), f.Number(0.5)))))


def test_numbers_are_computed_from_what_was_known_before():
    pieces = {"functions": [FUEL], "initial": [add(cmp(app("fuel"), "=", 2))], **BURN}
    assert holds(fuel("=", 1.0), "act()", "act()", **pieces)
    assert holds(fuel("<", 1.1), "act()", "act()", **pieces)
    assert not holds(fuel(">", 1.0), "act()", "act()", **pieces)


def test_an_unknown_number_stays_unknown_and_compares_to_nothing():
    pieces = {"functions": [FUEL], **BURN}
    assert not holds(fuel("<", 1), "act()", **pieces)
    assert holds(f.Not(fuel("<", 1)), "act()", **pieces)


def test_division_by_zero_gives_nothing_known():
    divide = act(add(cmp(app("fuel"), "=", f.Arithmetic("/", f.Number(1.0), app("fuel")))))
    pieces = {"functions": [FUEL], "initial": [add(cmp(app("fuel"), "=", 0))], **divide}
    assert not holds(f.KnowValue(app("fuel")), "act()", **pieces)


def test_the_two_zeros_are_one_state():
    zero = f.Arithmetic("*", f.Number(-1.0), app("fuel"))
    pieces = {"functions": [FUEL], "initial": [add(cmp(app("fuel"), "=", 0))]}
    task = ground(problem(**pieces, **act(add(cmp(app("fuel"), "=", zero)))))
    assert task.actions[0].after(task.initial) == task.initial


def test_a_number_given_two_values_at_once_is_a_contradiction():
    twice = act(add(cmp(app("fuel"), "=", 1)), add(cmp(app("fuel"), "=", 2)))
    task = ground(problem(functions=[FUEL], **twice))
    assert task.actions[0].after(task.initial) is None


# ------------------------------------------------------------------------------------------------------ Kw, Kv
def test_kw_holds_by_its_entry_and_by_knowledge_either_way():
    whether = f.KnowWhether(atom("p", "x"))
    assert not holds(whether)
    for change in (add(lit("p", "x")), add(no("p", "x")), add(lit("p", "x"), to="Kw")):
        assert holds(whether, initial=[change])


def test_an_entry_of_kw_is_not_knowledge_of_the_fact():
    assert not holds(f.Or((P, NOT_P)), initial=[add(lit("p", "x"), to="Kw")])


def test_what_is_known_has_no_kw_entry_left_when_it_is_forgotten():
    pieces = {"initial": [add(lit("p", "x"), to="Kw")]}
    actions = [action("find", effects=[add(lit("p", "x"))]), action("lose", effects=[delete(lit("p", "x"))])]
    assert not holds(f.KnowWhether(atom("p", "x")), "find()", "lose()", actions=actions, **pieces)


def test_an_entry_of_kw_can_be_deleted():
    pieces = {"initial": [add(lit("p", "x"), to="Kw")], **act(delete(lit("p", "x"), of="Kw"))}
    assert not holds(f.KnowWhether(atom("p", "x")), "act()", **pieces)


def test_kv_holds_by_its_entry_and_by_a_known_value():
    value = f.KnowValue(app("colour"))
    assert not holds(value, functions=[COLOUR])
    for change in (add(f.TermFact(app("colour")), to="Kv"), add(cmp(app("colour"), "=", "u"))):
        assert holds(value, functions=[COLOUR], initial=[change])


def test_sense_and_add_kw_are_the_same():
    tasks = [
        ground(problem(actions=[action("look", sense=[atom("q")])])),
        ground(problem(actions=[action("look", effects=[add(lit("q"), to="Kw")])])),
    ]
    assert len({state_after(task, "look()") for task in tasks}) == 1
    assert [task.actions[0].sense for task in tasks] == [("q",), ("q",)]


def test_sensing_what_is_known_changes_nothing():
    task = ground(problem(actions=[action("look", sense=[atom("q")])], initial=[add(no("q"))]))
    assert state_after(task, "look()") == task.initial


def test_equal_knowledge_is_an_equal_state_however_it_was_reached():
    one = action("one", effects=[add(lit("q"), to="Kw")])
    two = action("two", effects=[add(lit("q"))])
    task = ground(problem(actions=[one, two]))
    assert state_after(task, "one()", "two()") == state_after(task, "two()", "one()") == state_after(task, "two()")


def test_later_updates_of_initial_knowledge_replace_earlier_ones():
    everything = f.ForEach((var("z"),), (add(no("p", var("z"))),))
    goal = f.And((know(lit("p", "x")), know(no("p", "y"))))
    assert holds(goal, initial=[everything, add(f.Literal(f.Atom("p", (X,))))])
