"""Sensing waits, but never past what it depends on, and procedures keep their order."""

from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.planner.search.late_sensing import delay_sensing
from kabo.planner.search.nodes import Act, Assume, SearchSpace
from tests.support.small_problems import action, add, atom, delete, know, lit, no, problem, when

CALL = f.SituatedCall("do")


def order(*schemas, decide=True):
    """The names of the steps: the first action senses q and hopes for `true`, the others follow in order."""
    first, *others = schemas
    task = ground(problem(actions=schemas, initial=[add(lit("p", "x"))]))
    acts = {act.name: Act(act, 0, None) for act in task.actions}
    (branching,) = [one for one in task.branchings.values() if one.fact == "q"]
    steps = [acts[first.name], Assume(branching, "true"), *(acts[other.name] for other in others)]
    space = SearchSpace(task, None)
    delayed = delay_sensing(space, space.start, steps)
    return ["decide" if isinstance(step, Assume) else step.action.name for step in delayed]


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


# ------------------------------------------------------------------------------------------------------- inference
def late(*schemas, hoped="true", **pieces):
    """The names of the steps where the first action senses q, hopes for an outcome, and the others follow."""
    first, *others = schemas
    task = ground(problem(actions=schemas, **pieces))
    acts = {act.name: Act(act, 0, None) for act in task.actions}
    (branching,) = [one for one in task.branchings.values() if one.fact == "q"]
    steps = [acts[first.name], Assume(branching, hoped), *(acts[other.name] for other in others)]
    space = SearchSpace(task, None)
    delayed = delay_sensing(space, space.start, steps)
    ends = []
    for order_ in (steps, delayed):
        node = space.start
        for step in order_:
            node = space.possible(node, step)
            assert node is not None, "the delayed steps are possible"
        ends.append(node)
    assert ends[0] == ends[1], "and lead to the same knowledge"
    return ["decide" if isinstance(step, Assume) else step.action.name for step in delayed]


def test_sensing_comes_before_what_reads_what_follows_from_it():
    use = action("use", pre=[know(no("r"))], effects=[add(lit("p", "y"))])
    assert late(LOOK, use, initial=[add(lit("q"), lit("r"), to="Kx")]) == ["look", "decide", "use"]


def test_sensing_comes_before_what_takes_the_reason_of_a_conclusion_away():
    """And what has nothing to do with it passes all the same."""
    rule = when(f.And((know(lit("q")), know(lit("p", "x")))), add(lit("r")))
    lose = action("lose", effects=[delete(lit("p", "x"))])
    other = action("other", effects=[add(lit("p", "y"))])
    found = late(LOOK, other, lose, initial=[add(lit("p", "x"))], update_rules=[rule])
    assert found == ["other", "look", "decide", "lose"]


def test_sensing_comes_before_what_a_rule_needs_it_for():
    rule = when(know(lit("q")), add(lit("r")))
    use = action("use", pre=[know(lit("r"))], effects=[add(lit("p", "y"))])
    assert late(LOOK, use, update_rules=[rule]) == ["look", "decide", "use"]


def test_sensing_comes_before_a_change_of_what_its_entry_is_about():
    """r changes afterwards: then the entry is gone, and q would tell nothing."""
    change = action("change", effects=[delete(lit("r"))])
    known = late(LOOK, change, hoped="false", initial=[add(lit("q"), lit("r"), to="Kor")])
    assert known == ["look", "decide", "change"]


def test_sensing_comes_before_a_world_effect_that_it_decides():
    act = action("act", effects=[f.WorldEffect((lit("q"),), (lit("p", "y"),))])
    assert late(LOOK, act, initial=[add(no("p", "y"))]) == ["look", "decide", "act"]


def test_sensing_waits_behind_entries_that_it_has_nothing_to_do_with():
    other = action("other", effects=[delete(lit("r"))])
    initial = [add(lit("r"), lit("p", "x"), to="Kx")]
    assert late(LOOK, other, initial=initial) == ["other", "look", "decide"]
