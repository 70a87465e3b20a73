"""Facts that only dead actions read do not tell states apart."""

from kabo.knowledge import ground
from kabo.language import formulas as f
from tests.knowledge.asking import state_after
from tests.support.small_problems import action, add, atom, know, lit, no, problem, var

A = var("a")
ONCE = [
    action("look", parameters=[A], pre=[know(no("done", A))], sense=[atom("heavy", A)]),
    action(
        "carry", parameters=[A], pre=[know(lit("heavy", A)), know(no("done", A))], effects=[add(lit("done", A))]
    ),
    action(
        "throw", parameters=[A], pre=[know(no("heavy", A)), know(no("done", A))], effects=[add(lit("done", A))]
    ),
]
PIECES = {
    "predicates": {"heavy": ("thing",), "done": ("thing",)},
    "initial": [f.ForEach((A,), (add(no("done", A)),))],
    "goal": [f.Forall((A,), know(lit("done", A)))],
}


def two_ends(task):
    """The states after carrying x because it is heavy, and after throwing it because it is not."""
    looked = state_after(task, "look(x)")
    light, heavy = (state for _, state in task.open_branching(looked).outcomes(looked))
    carry, throw = (next(a for a in task.actions if str(a) == f"{name}(x)") for name in ("carry", "throw"))
    return carry.after(heavy), throw.after(light), (light, heavy)


def test_a_fact_whose_readers_are_all_dead_is_dropped():
    task = ground(problem(actions=ONCE, **PIECES))
    carried, thrown, _ = two_ends(task)
    assert carried != thrown
    assert task.relevance.reduced(carried) == task.relevance.reduced(thrown)


def test_a_fact_is_kept_while_a_reader_lives():
    task = ground(problem(actions=ONCE, **PIECES))
    _, _, (light, heavy) = two_ends(task)
    assert task.relevance.reduced(light) != task.relevance.reduced(heavy)


def test_a_fact_that_the_goal_reads_is_kept():
    goal = [*PIECES["goal"], f.KnowWhether(atom("heavy", "x"))]
    task = ground(problem(actions=ONCE, **{**PIECES, "goal": goal}))
    carried, thrown, _ = two_ends(task)
    assert task.relevance.reduced(carried) != task.relevance.reduced(thrown)


def test_a_fact_is_kept_if_its_readers_can_come_back():
    again = action("again", parameters=[A], effects=[add(no("done", A))])
    task = ground(problem(actions=[*ONCE, again], **PIECES))
    carried, thrown, _ = two_ends(task)
    assert task.relevance.reduced(carried) != task.relevance.reduced(thrown)


def test_while_an_entry_stands_open_nothing_is_dropped():
    task = ground(problem(actions=ONCE, **PIECES))
    looked = state_after(task, "look(x)")
    assert task.relevance.reduced(looked) == looked


def test_what_was_asked_before_does_not_change_the_answer():
    def fresh():
        return ground(problem(actions=ONCE, **PIECES))

    task = fresh()
    carried, thrown, open_ones = two_ends(task)
    states = [task.initial, carried, thrown, *open_ones]
    alone = [fresh().relevance.reduced(state) for state in states]
    assert len(set(alone)) < len(states)
    assert [task.relevance.reduced(state) for state in states] == alone
    assert [task.relevance.reduced(state) for state in states[::-1]] == alone[::-1]
    backwards = fresh()
    assert [backwards.relevance.reduced(state) for state in states[::-1]] == alone[::-1]
