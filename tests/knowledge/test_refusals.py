"""What is not supported yet is refused by name and place, all of it at once."""

from dataclasses import replace

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.language.problem import Parameter
from tests.small_problems import COLOUR, action, add, app, atom, cmp, delete, know, lit, problem, var

PLACE = f.Place("domain.yaml", 7, 5, 3)
RUN_TIME = replace(action("dial"), parameters=(Parameter("c", "thing", app("colour"), PLACE),))

REFUSED = [
    ({"update_rules": [add(lit("q"))]}, "update rules are not supported yet"),
    ({"actions": [RUN_TIME]}, 'the run-time variable "c" (value_of) of action "dial" is not supported yet'),
    (
        {"actions": [action("a", effects=[f.WorldEffect((lit("q"),), (lit("r"),), PLACE)])]},
        "a world effect (when … then …)",
    ),
    ({"initial": [add(lit("q"), lit("r"), to="Kx")]}, "the database Kx is not supported yet"),
    ({"initial": [add(f.FactForall((var("z"),), lit("p", var("z"))), to="LCW")]}, "the database LCW is not"),
    ({"initial": [add(f.FactAll((lit("q"), lit("r"))), to="Kw")]}, "a conjunction as one fact of add(Kw, …) is"),
    (
        {"initial": [delete(f.FactForall((var("z"),), lit("p", var("z"))))]},
        "a forall as one fact of del(Kf, …) is",
    ),
    ({"initial": [add(lit("p", app("colour")))]}, "a function term as an argument of a fact is"),
    ({"initial": [add(cmp(app("colour"), "!=", app("colour", "x")))]}, '"!=" between two terms as a fact is'),
    ({"goal": [f.Temporal("initially", know(lit("q")), PLACE)]}, "initially(…) in a goal is not supported yet"),
    ({"goal": [f.Not(f.Temporal("always", know(lit("q")), PLACE))]}, "always(…) in a goal is not supported yet"),
]


@pytest.mark.parametrize(("pieces", "message"), REFUSED, ids=[message for _, message in REFUSED])
def test_it_is_refused_by_name(pieces, message):
    with pytest.raises(InputError) as caught:
        ground(problem(functions=[COLOUR], **pieces))
    assert message in str(caught.value)


def test_the_place_is_where_it_stands():
    goal = [f.Temporal("always", know(lit("q")), PLACE)]
    with pytest.raises(InputError) as caught:
        ground(problem(goal=goal))
    (found,) = caught.value.diagnostics
    assert (found.file, found.line, found.column, found.length) == ("domain.yaml", 7, 5, 3)


def test_everything_is_refused_at_once():
    with pytest.raises(InputError) as caught:
        ground(problem(actions=[RUN_TIME], initial=[add(lit("q"), to="Kx")], update_rules=[add(lit("q"))]))
    assert len(caught.value.diagnostics) == 3


def test_what_is_supported_is_not_refused():
    ground(problem(actions=[action("a", effects=[add(lit("q"), to="Kw")], sense=[atom("r")])]))
