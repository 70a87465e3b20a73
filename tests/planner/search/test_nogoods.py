"""What failed is known to fail again: for the same node, and for all that know less where less is never more."""

import pytest

from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.nogoods import Nogood, Nogoods
from kabo.planner.search.skeleton import Unreachable
from tests.support.small_problems import action, add, atom, know, lit, no, problem, when


def test_a_failure_without_ancestors_holds_for_states_that_know_less():
    nogoods = Nogoods(less_is_less=True)
    nogoods.add_nodes("here", 0b1110, ["here"], {"here"})
    assert nogoods.of_node("less", 0b0110) == Nogood(frozenset())
    assert nogoods.of_node("more", 0b1111) is None
    assert nogoods.of_node("other", 0b0001) is None


def test_a_failure_that_hangs_on_an_ancestor_says_nothing_of_other_nodes():
    nogoods = Nogoods(less_is_less=True)
    nogoods.path.add("above")
    nogoods.add_nodes("here", 0b1110, ["here"], {"above"})
    assert nogoods.of_node("here", 0b1110) == Nogood(frozenset(["above"]))
    assert nogoods.of_node("less", 0b0110) is None
    nogoods.path.clear()
    assert nogoods.of_node("here", 0b1110) is None


def test_where_less_may_be_more_a_failure_is_that_of_its_nodes():
    nogoods = Nogoods()
    nogoods.add_nodes("here", 0b1110, ["here"], set())
    assert nogoods.of_node("here", 0b1110) == Nogood(frozenset())
    assert nogoods.of_node("less", 0b0110) is None


LOOK = action("look", sense=[atom("p", "x")])
MAKE = action("make", pre=[know(lit("p", "x"))], effects=[add(lit("r"))])


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ([], True),
        ([action("ask", pre=[know(no("q"))], effects=[add(lit("q"))])], True),
        ([action("told", effects=[when(know(lit("p", "x")), add(lit("q")))])], False),
        ([action("blind", pre=[f.Not(know(lit("q")))], effects=[add(lit("q"))])], False),
    ],
)
def test_less_is_less_where_nothing_depends_on_not_knowing(more, expected):
    task = ground(problem(actions=[LOOK, MAKE, *more], goal=[know(lit("r"))]))
    assert task.less_is_less == expected
    assert isinstance(find_skeleton(task, search="depth-first"), Unreachable)
