"""What never changes is settled while grounding: joins over static facts find the actions, and only those."""

import pytest

from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.language.problem import Function
from tests.knowledge.asking import applicable, then
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

A, B, C = var("a"), var("b"), var("c")
NEAR = {"predicates": {"near": ("thing", "thing"), "link": ("thing", "thing", "thing")}}
OBJECTS = {"objects": dict.fromkeys(("x", "y", "z"), "thing")}


def names(*pre, parameters, facts, **more):
    """The ground actions of one schema with these preconditions, where these facts hold."""
    act = action("act", parameters=parameters, pre=pre, effects=[add(lit("q"))])
    initial = [add(*facts)] if facts else []
    return [str(one) for one in ground(problem(actions=[act], initial=initial, **NEAR, **OBJECTS, **more)).actions]


def test_a_static_literal_gives_its_pairs_in_the_order_of_the_objects():
    facts = [lit("near", "y", "z"), lit("near", "x", "z"), lit("near", "x", "y"), no("near", "z", "x")]
    found = names(know(lit("near", A, B)), parameters=[A, B], facts=facts)
    assert found == ["act(x, y)", "act(x, z)", "act(y, z)"]


def test_the_order_of_parameters_and_of_arguments_may_differ():
    facts = [lit("near", "x", "y"), lit("near", "z", "y")]
    found = names(know(lit("near", B, A)), parameters=[A, B], facts=facts)
    assert found == ["act(y, x)", "act(y, z)"]


def test_several_literals_are_joined():
    facts = [lit("near", "x", "y"), lit("near", "y", "z"), lit("near", "y", "x")]
    pre = know(lit("near", A, B)), know(lit("near", B, C)), know(cmp(A, "!=", C))
    assert names(*pre, parameters=[A, B, C], facts=facts) == ["act(x, y, z)"]


def test_a_variable_may_stand_twice_and_constants_between():
    facts = [
        lit("link", "x", "y", "x"),
        lit("link", "z", "y", "z"),
        lit("link", "y", "z", "y"),
        lit("link", "x", "y", "z"),
    ]
    found = names(know(lit("link", A, "y", A)), parameters=[A], facts=facts)
    assert found == ["act(x)", "act(z)"]


def test_a_variable_that_stands_twice_is_one_object():
    facts = [lit("link", "x", "y", "x"), lit("link", "y", "y", "z")]
    assert names(know(lit("link", A, "y", A)), parameters=[A], facts=facts) == ["act(x)"]


def test_without_any_fact_there_is_no_action():
    assert names(know(lit("near", A, B)), parameters=[A, B], facts=[]) == []


def test_negative_static_literals_must_be_known_false():
    assert names(know(no("near", A, A)), parameters=[A], facts=[no("near", "y", "y")]) == ["act(y)"]


def test_a_join_inside_a_disjunction_is_no_join():
    either = f.Or((know(lit("near", A, "x")), know(cmp(A, "=", "z"))))
    assert names(either, parameters=[A], facts=[lit("near", "y", "x")]) == ["act(y)", "act(z)"]


def test_static_terms_are_settled():
    below = Function("below", ("thing",), value_type="thing")
    facts = [cmp(app("below", "x"), "=", "y"), cmp(app("below", "y"), "=", "z")]
    found = names(know(cmp(app("below", A), "=", B)), parameters=[A, B], facts=facts, functions=[below])
    assert found == ["act(x, y)", "act(y, z)"]
    nested = know(cmp(app("below", app("below", A)), "=", "z"))
    assert names(nested, parameters=[A], facts=facts, functions=[below]) == ["act(x)"]


def test_the_last_value_of_a_static_term_is_known():
    act = action("act", pre=[know(cmp(app("colour"), "=", "w"))], effects=[add(lit("q"))])
    excluded = [cmp(app("colour"), "!=", v) for v in "uv"]
    assert applicable("act()", actions=[act], initial=[add(*excluded)], functions=[COLOUR])


@pytest.mark.parametrize(
    "opening",
    [
        {"initial": [add(lit("near", "x", "y"), to="Kw")]},
        {"initial": [add(lit("near", "x", "y"), lit("r"), to="Kor")]},
        {"update_rules": [when(know(lit("r")), add(lit("near", "x", "y")))]},
        {"actions": [action("look", sense=[atom("near", "x", "y")])]},
        {"actions": [action("use", effects=[then(lit("near", "x", "y"), lit("q"))])]},
        {"actions": [action("forget", effects=[delete(lit("near", "x", "y"))])]},
    ],
    ids=["Kw", "Kor", "rule", "sensing", "cause", "forgetting"],
)
def test_what_may_still_be_learned_or_forgotten_is_not_static(opening):
    groups = ground(problem(goal=[know(lit("near", "x", "y"))], **NEAR, **opening)).groups
    assert "near(x, y)" in [group.text for group in groups]
    assert "near(x, y)" not in [
        group.text for group in ground(problem(goal=[know(lit("near", "x", "y"))], **NEAR)).groups
    ]


def test_a_cause_that_is_known_of_all_objects_is_static():
    use = action("use", effects=[then(lit("r"), lit("q"))])
    assert [group.text for group in ground(problem(actions=[use], initial=[add(lit("r"))])).groups] == ["q"]
