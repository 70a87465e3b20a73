"""Sensing waits, but never past what it depends on, and procedures keep their order."""

from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.planner.delay import delay_sensing
from kabo.planner.space import Act, Decide, Space
from tests.small_problems import action, add, atom, know, lit, no, problem

CALL = f.ProcedureCall("do")


def order(*schemas, decide=True):
    """The names of the steps: the first action senses q and hopes for `true`, the others follow in order."""
    first, *others = schemas
    task = ground(problem(actions=schemas, initial=[add(lit("p", "x"))]))
    acts = {act.name: Act(act, 0, None) for act in task.actions}
    (branching,) = [one for one in task.branchings.values() if one.fact == "q"]
    steps = [acts[first.name], Decide(branching, "true"), *(acts[other.name] for other in others)]
    space = Space(task, None)
    delayed = delay_sensing(space, space.start, steps)
    return ["decide" if isinstance(step, Decide) else step.action.name for step in delayed]


LOOK = action("look", sense=[atom("q")])
OTHER = action("other", effects=[add(lit("r"))])


def test_sensing_waits_behind_what_it_has_nothing_to_do_with():
    assert order(LOOK, OTHER) == ["other", "look", "decide"]


def test_sensing_comes_before_what_reads_it():
    needs = action("needs", pre=[know(lit("q"))], effects=[add(lit("p", "y"))])
    assert order(LOOK, OTHER, needs) == ["other", "look", "decide", "needs"]


def test_sensing_comes_before_what_takes_its_precondition_away():
    look = action("look", pre=[know(lit("p", "x"))], sense=[atom("q")])
    leave = action("leave", effects=[add(no("p", "x"))])
    assert order(look, leave) == ["look", "leave", "decide"]


def test_procedures_keep_their_order_but_the_decision_waits():
    look = action("look", sense=[atom("q")], geometry=CALL)
    other = action("other", effects=[add(lit("r"))], geometry=CALL)
    assert order(look, other) == ["look", "other", "decide"]


def test_sensing_by_a_procedure_waits_behind_what_needs_no_procedure():
    look = action("look", sense=[atom("q")], geometry=CALL)
    assert order(look, OTHER) == ["other", "look", "decide"]


def test_an_action_that_also_changes_something_does_not_wait():
    look = action("look", effects=[add(lit("p", "y"))], sense=[atom("q")])
    assert order(look, OTHER) == ["look", "other", "decide"]
