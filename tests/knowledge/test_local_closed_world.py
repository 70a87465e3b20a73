"""Local closed worlds, and conjunctions whose truth will be known at run time [docs/explanation/knowledge.md#databases]."""

from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import branching_on, holds, outcomes, state_after
from tests.support.small_problems import action, add, atom, delete, know, lit, no, problem, var

Z = var("z")
PZ, Q, R = lit("p", Z), lit("q"), lit("r")
NOT_Q, NOT_R = no("q"), no("r")
X, Y, NOT_X, NOT_Y = lit("p", "x"), lit("p", "y"), no("p", "x"), no("p", "y")
SEE = action("see", sense=[atom("q")])
SEE_X = action("see_x", sense=[atom("p", "x")])


def every(*conjuncts):
    """`forall(thing z) (…)`."""
    return f.FactForall((Z,), conjuncts[0] if len(conjuncts) == 1 else f.FactAll(conjuncts))


LIST = action("list", effects=[add(every(PZ), to="LCW")])


def test_whoever_has_been_told_all_of_them_knows_that_the_others_are_none():
    pieces = {"actions": [LIST], "initial": [add(X)]}
    assert holds(f.And((know(X), know(NOT_Y))), "list()", **pieces)
    assert not holds(f.KnowWhether(atom("p", "y")), **pieces)


def test_a_local_closed_world_at_the_start_knows_what_is_known_before_it():
    assert holds(f.And((know(X), know(NOT_Y))), initial=[add(X), add(every(PZ), to="LCW")], actions=[LIST])


def test_of_several_conjuncts_one_at_least_is_false():
    actions = [action("list", effects=[add(every(PZ, Q), to="LCW")]), SEE, SEE_X]
    pieces = {"actions": actions}
    assert holds(f.And((know(NOT_X), know(NOT_Y))), "list()", "see()", "q: true", **pieces)
    assert holds(f.Not(f.KnowWhether(atom("p", "x"))), "list()", "see()", "q: false", **pieces)
    assert holds(know(NOT_Q), "list()", "see_x()", "p(x): true", **pieces)


def test_an_instance_that_is_known_true_is_no_exception_made():
    actions = [action("list", effects=[add(every(PZ, Q), to="LCW")]), SEE]
    goal = f.And((know(X), know(Q), know(NOT_Y)))
    assert holds(goal, "list()", actions=actions, initial=[add(X, Q)])


def test_a_local_closed_world_is_taken_back():
    say, unsay = (action(n, effects=[c(every(PZ, Q), "LCW")]) for n, c in (("say", _add), ("unsay", _del)))
    pieces = {"actions": [say, unsay, SEE]}
    assert holds(know(NOT_X), "say()", "see()", "q: true", **pieces)
    assert not holds(f.KnowWhether(atom("p", "x")), "say()", "unsay()", "see()", "q: true", **pieces)


def _add(fact, database):
    return add(fact, to=database)


def _del(fact, database):
    return delete(fact, of=database)


def test_a_local_closed_world_given_at_the_start_is_taken_back_too():
    unsay = action("unsay", effects=[_del(every(PZ, Q), "LCW"), add(R)])
    pieces = {"actions": [unsay, SEE], "initial": [add(every(PZ, Q), to="LCW")]}
    assert holds(know(NOT_X), "see()", "q: true", **pieces)
    assert not holds(f.KnowWhether(atom("p", "x")), "unsay()", "see()", "q: true", **pieces)


def test_a_change_in_the_world_drops_what_it_touches_only():
    change = action("change", effects=[delete(X)])
    pieces = {"actions": [change, SEE], "initial": [add(every(PZ, Q), to="LCW")]}
    assert holds(know(NOT_Y), "change()", "see()", "q: true", **pieces)
    assert not holds(f.KnowWhether(atom("p", "x")), "change()", "see()", "q: true", **pieces)


# --------------------------------------------------------------------------------------------------- conjunctions
BOTH = action("both", effects=[add(f.FactAll((Q, NOT_R)), to="Kw")])


def test_a_sensed_conjunction_branches_into_all_true_and_one_false_at_least():
    pieces = {"actions": [BOTH, SEE]}
    task = ground(problem(**pieces))
    assert outcomes(task, state_after(task, "both()"), "q and not r") == ["false", "true"]
    assert holds(f.And((know(Q), know(NOT_R))), "both()", "q and not r: true", **pieces)
    false = "both()", "q and not r: false"
    assert holds(f.Not(f.Or((f.KnowWhether(atom("q")), f.KnowWhether(atom("r"))))), *false, **pieces)
    assert holds(know(R), *false, "see()", "q: true", **pieces)


def test_once_branched_on_it_is_not_open_any_more():
    task = ground(problem(actions=[BOTH]))
    for outcome in ("true", "false"):
        assert task.open_branching(state_after(task, "both()", f"q and not r: {outcome}")) is None


def test_a_conjunction_that_is_known_is_no_question():
    for initial in ([add(Q, NOT_R)], [add(R)], [add(NOT_Q)]):
        task = ground(problem(actions=[BOTH], initial=initial))
        assert state_after(task, "both()") == task.initial


def test_what_is_known_already_is_not_told_again():
    pieces = {"actions": [BOTH], "initial": [add(Q)]}
    assert holds(know(R), "both()", "q and not r: false", **pieces)
    assert holds(know(NOT_R), "both()", "q and not r: true", **pieces)


def test_an_outcome_that_knowledge_gained_meanwhile_contradicts_is_impossible():
    task = ground(problem(actions=[BOTH, SEE]))
    state = state_after(task, "both()", "see()", "q: false")
    assert outcomes(task, state, "q and not r") == ["false"]


def test_all_instances_are_one_conjunction():
    task = ground(problem(actions=[action("all", effects=[add(every(PZ), to="Kw")])]))
    state = state_after(task, "all()", "p(x) and p(y): true")
    assert branching_on(task, "p(x) and p(y)").fact == "p(x) and p(y)"
    goal = f.And((know(X), know(Y)))
    assert holds(goal, "all()", "p(x) and p(y): true", actions=[action("all", effects=[add(every(PZ), to="Kw")])])
    assert state != task.initial


def test_a_change_of_a_part_makes_the_answer_worthless():
    change = action("change", effects=[delete(Q)])
    task = ground(problem(actions=[BOTH, change]))
    assert task.open_branching(state_after(task, "both()", "change()")) is None


def test_the_question_can_be_withdrawn():
    drop = action("drop", effects=[delete(f.FactAll((Q, NOT_R)), of="Kw")])
    task = ground(problem(actions=[BOTH, drop]))
    assert task.open_branching(state_after(task, "both()", "drop()")) is None


def test_entries_for_the_same_facts_in_kw_are_not_conjunctions():
    two = action("two", effects=[add(Q, NOT_R, to="Kw")])
    task = ground(problem(actions=[two]))
    assert {one.fact for one in task.branchings.values()} == {"q", "r"}
