"""Run-time variables: `c: {value_of: f(s)}` means the term wherever the action says c.

Source: docs/explanation/knowledge.md#actions.
"""

from kabo.knowledge import ground
from kabo.knowledge.runtime import RunTimeValue
from kabo.language import formulas as f
from kabo.language import spell_bound
from kabo.language.problem import Action, Function, Parameter
from tests.knowledge.asking import applicable, holds, outcomes, state_after, then
from tests.support.small_problems import (
    COLOUR,
    FUEL,
    Y,
    action,
    add,
    app,
    cmp,
    delete,
    know,
    lit,
    problem,
    var,
    when,
)

SHADE = Function("shade", (), values=("u", "v", "w"))
LEVEL = Function("level", ())
C = var("c", "")
LOOK = action("look", sense=[app("colour")])
LOOK_SHADE = action("look_shade", sense=[app("shade")])
TERMS = {"functions": [COLOUR, SHADE, FUEL, LEVEL]}


def using(term, *, pre=(), effects=(), parameters=()):
    """An action `use` with the run-time variable c of a term."""
    declared = (*(Parameter(p.name, p.type) for p in parameters), Parameter("c", "", term))
    return Action("use", declared, tuple(pre), None, tuple(effects), (), f.Number(1.0))


def colour(value, operator="="):
    return know(cmp(app("colour"), operator, value))


def shade(value, operator="="):
    return know(cmp(app("shade"), operator, value))


COPY = using(app("colour"), effects=[add(cmp(app("shade"), "=", C))])


def test_the_value_must_be_known_at_run_time():
    assert not applicable("use(colour)", actions=[LOOK, COPY], **TERMS)
    assert applicable("use(colour)", actions=[COPY], initial=[add(cmp(app("colour"), "=", "u"))], **TERMS)
    task = ground(problem(actions=[LOOK, COPY], **TERMS))
    assert task.actions[1].applicable(state_after(task, "look()"))


def test_the_variable_is_not_enumerated_and_is_named_by_its_term():
    below = Function("below", ("thing",), value_type="thing")
    a = var("a")
    use = using(app("below", a), parameters=[a], effects=[add(lit("p", a))])
    task = ground(
        problem(actions=[action("look", parameters=[a], sense=[app("below", a)]), use], functions=[below])
    )
    assert [str(one) for one in task.actions] == ["look(x)", "look(y)", "use(x, below(x))", "use(y, below(y))"]
    assert str(task.actions[3].arguments["c"]) == "below(y)"


def test_a_known_value_is_copied():
    pieces = {"actions": [COPY], "initial": [add(cmp(app("colour"), "=", "v"))], **TERMS}
    assert holds(shade("v"), "use(colour)", **pieces)


def test_a_value_that_is_open_will_be_known_in_both_places():
    pieces = {"actions": [LOOK, COPY], "initial": [add(cmp(app("shade"), "=", "u"))], **TERMS}
    goal = f.And((f.KnowValue(app("shade")), f.Not(shade("u"))))
    assert holds(goal, "look()", "use(colour)", **pieces)
    task = ground(problem(**pieces))
    assert outcomes(task, state_after(task, "look()", "use(colour)"), "shade") == ["u", "v", "w"]
    assert holds(shade("v"), "look()", "colour: v", "use(colour)", **pieces)


def test_numbers_are_copied_alike():
    use = using(app("fuel"), effects=[add(cmp(app("level"), "=", C))])
    read = action("read", sense=[app("fuel")])
    full = {"actions": [use], "initial": [add(cmp(app("fuel"), "=", 2))], **TERMS}
    assert holds(know(cmp(app("level"), ">", 1)), "use(fuel)", **full)
    open_ = {"actions": [read, use], **TERMS}
    goal = f.And((f.KnowValue(app("level")), f.Not(know(cmp(app("level"), ">", 1)))))
    assert holds(goal, "read()", "use(fuel)", **open_)


def test_conditions_about_the_variable_are_about_the_term():
    pre = [f.Not(know(cmp(C, "=", "u")))]
    use = using(app("colour"), pre=pre, effects=[when(know(cmp(C, "=", "v")), add(lit("q")))])
    start = {"actions": [use], **TERMS}
    assert not applicable("use(colour)", initial=[add(cmp(app("colour"), "=", "u"))], **start)
    assert holds(know(lit("q")), "use(colour)", initial=[add(cmp(app("colour"), "=", "v"))], **start)
    assert not holds(know(lit("q")), "use(colour)", initial=[add(cmp(app("colour"), "=", "w"))], **start)


def test_the_term_equals_its_variable_whatever_it_is():
    """Also while nobody knows the value, and in the condition of a world effect."""
    for effect in (
        when(know(cmp(app("colour"), "=", C)), add(lit("q"))),
        then(cmp(app("colour"), "=", C), lit("q")),
    ):
        use = using(app("colour"), effects=[effect])
        assert holds(know(lit("q")), "look()", "use(colour)", actions=[LOOK, use], **TERMS)
        assert holds(
            know(lit("q")), "use(colour)", actions=[use], initial=[add(cmp(app("colour"), "=", "u"))], **TERMS
        )


def test_a_copy_drops_what_was_known_of_its_target():
    pieces = {"actions": [LOOK, COPY, LOOK_SHADE], **TERMS}
    entry = {**pieces, "initial": [add(cmp(app("shade"), "=", "u"), lit("q"), to="Kor")]}
    steps = "look()", "use(colour)", "colour: v", "look_shade()", "shade: w"
    assert not holds(know(lit("q")), *steps, **entry)
    assert holds(know(lit("q")), "look_shade()", "shade: w", **entry)


def test_a_copy_to_itself_changes_nothing():
    use = using(app("colour"), effects=[add(cmp(app("colour"), "=", C))])
    pieces = {"actions": [LOOK, use], "initial": [add(cmp(app("colour"), "!=", "u"))], **TERMS}
    assert holds(f.KnowValue(app("colour")), "look()", "use(colour)", **pieces)
    known = {**pieces, "initial": [add(cmp(app("colour"), "=", "w"))]}
    assert holds(colour("w"), "use(colour)", **known)


def test_forgetting_the_value_of_the_variable_forgets_the_term_that_has_it():
    use = using(app("colour"), effects=[delete(cmp(app("shade"), "=", C))])
    initial = [add(cmp(app("colour"), "=", "u"), cmp(app("shade"), "=", "u"))]
    assert not holds(f.KnowValue(app("shade")), "use(colour)", actions=[use], initial=initial, **TERMS)
    other = [add(cmp(app("colour"), "=", "v"), cmp(app("shade"), "=", "u"))]
    assert holds(shade("u"), "use(colour)", actions=[use], initial=other, **TERMS)


def test_the_value_may_be_an_object_that_arguments_are_compared_with():
    below = Function("below", ("thing",), value_type="thing")
    a = var("a")
    use = using(app("below", a), parameters=[a], pre=[know(cmp(C, "=", Y))], effects=[add(lit("p", a))])
    initial = [add(cmp(app("below", "x"), "=", "y"), cmp(app("below", "y"), "=", "x"))]
    task = ground(problem(actions=[use], initial=initial, functions=[below]))
    assert [str(one) for one in task.actions] == ["use(x, below(x))"]


def test_a_value_of_run_time_is_spelled_as_its_term():
    claim = f.Comparison("=", RunTimeValue(app("shade")), f.Constant("u"))  # type: ignore[arg-type]
    assert spell_bound(know(claim), {}) == "K(shade = u)"
