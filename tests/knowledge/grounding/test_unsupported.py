"""What is not supported is refused by name and place, all of it at once."""

from dataclasses import replace

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.language.problem import Parameter
from tests.support.small_problems import COLOUR, FUEL, action, add, app, atom, cmp, know, lit, problem, var

PLACE = f.Place("domain.yaml", 7, 5, 3)
NESTED = f.Literal(atom("p", app("colour")), True, PLACE)
RUN_TIME = replace(
    action("dial", effects=[add(lit("p", var("c")))]),
    parameters=(Parameter("c", "thing", app("colour"), PLACE),),
)
COUNTING = f.Conditional(know(lit("q")), (add(cmp(app("fuel"), "=", f.Number(1.0))),))
TESTING = f.Conditional(f.Test(f.ProcedureCall("near"), PLACE), (add(lit("q")),))

REFUSED = [
    ({"initial": [add(NESTED)]}, "a function term as an argument of a fact is not supported"),
    ({"initial": [add(cmp(app("colour"), "!=", app("colour", "x")))]}, '"!=" between two terms as a fact is'),
    ({"actions": [RUN_TIME]}, 'the run-time variable "c" as an argument of a fact is not supported'),
    ({"update_rules": [COUNTING]}, "assigning a number in an update rule is not supported"),
    ({"update_rules": [TESTING]}, "a geometric test in an update rule is not supported"),
]


@pytest.mark.parametrize(("pieces", "message"), REFUSED, ids=[message for _, message in REFUSED])
def test_it_is_refused_by_name(pieces, message):
    with pytest.raises(InputError) as caught:
        ground(problem(functions=[COLOUR, FUEL], **pieces))
    assert message in str(caught.value)


def test_the_place_is_where_it_stands():
    with pytest.raises(InputError) as caught:
        ground(problem(functions=[COLOUR], initial=[add(NESTED)]))
    (found,) = caught.value.diagnostics
    assert (found.file, found.line, found.column, found.length) == ("domain.yaml", 7, 5, 3)


def test_everything_is_refused_at_once():
    with pytest.raises(InputError) as caught:
        ground(problem(functions=[COLOUR], actions=[RUN_TIME], initial=[add(NESTED)], update_rules=[TESTING]))
    assert len(caught.value.diagnostics) == 3


def test_what_is_supported_is_not_refused():
    ground(problem(actions=[action("a", effects=[add(lit("q"), to="Kw")], sense=[atom("r")])]))
