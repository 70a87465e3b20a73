"""Grounding: the order of actions, what is left out, procedure calls, what can be reached."""

from hypothesis import assume, given
from hypothesis import strategies as st

from kabo.knowledge import ground, relaxed_reach, unreachable_goals
from kabo.language import formulas as f
from tests.knowledge.asking import applicable, state_after
from tests.support.small_problems import (
    COLOUR,
    FUEL,
    action,
    add,
    app,
    atom,
    branching_problems,
    cmp,
    know,
    lit,
    no,
    problem,
    problems,
    var,
)

A, B = var("a"), var("b")
NEAR = {"predicates": {"near": ("thing", "thing")}}


def test_actions_keep_the_order_of_the_file_and_arguments_that_of_declaration():
    pair = action("pair", parameters=[A, B], effects=[add(lit("near", A, B))])
    task = ground(problem(actions=[pair, action("first", effects=[add(lit("q"))])], **NEAR))
    assert list(map(str, task.actions)) == ["pair(x, x)", "pair(x, y)", "pair(y, x)", "pair(y, y)", "first()"]
    assert [action.index for action in task.actions] == list(range(5))
    assert dict(task.actions[1].arguments) == {"a": "x", "b": "y"}


def test_static_preconditions_are_settled_and_cost_no_bits():
    pair = action(
        "pair",
        parameters=[A, B],
        pre=[know(cmp(A, "!=", B)), know(lit("near", A, B)), know(cmp(app("fuel"), ">", 1))],
        effects=[add(lit("q"))],
    )
    initial = [add(lit("near", "x", "y"), lit("near", "y", "y"), cmp(app("fuel"), "=", 2))]
    task = ground(problem(actions=[pair], initial=initial, functions=[FUEL], **NEAR))
    assert list(map(str, task.actions)) == ["pair(x, y)"]
    assert task.width == 3  # K(q), K(not q), Kw(q)


def test_what_an_initial_kw_entry_decides_is_not_static():
    shut = action("shut", pre=[know(lit("r"))], effects=[add(lit("q"))])
    assert [str(a) for a in ground(problem(actions=[shut], initial=[add(lit("r"), to="Kw")])).actions] == [
        "shut()"
    ]


def test_actions_out_of_reach_are_left_out():
    never = action("never", pre=[know(lit("r"))], effects=[add(lit("q")), add(no("r"))])
    assert ground(problem(actions=[never])).actions == ()


def test_a_call_is_ground_with_its_options_sorted_by_name():
    call = f.ProcedureCall(
        "pick",
        (
            f.Argument(A),
            f.Argument(f.Number(2.0), name="tries"),
            f.Argument(f.Constant("side"), name="grasp"),
            f.Argument(f.Constant("table")),
        ),
    )
    task = ground(problem(actions=[action("pick", parameters=[A], effects=[add(lit("p", A))], geometry=call)]))
    assert [str(a.call) for a in task.actions] == [f"pick({x}, table, grasp = side, tries = 2.0)" for x in "xy"]


def test_preconditions_may_be_compound():
    either = f.Or((know(lit("q")), f.Forall((var("z"),), know(lit("p", var("z"))))))
    act = action("act", pre=[either], effects=[add(lit("r"), lit("q"), lit("p", "x"), lit("p", "y"))])
    assert applicable("act()", actions=[act], initial=[add(lit("p", "x"), lit("p", "y"))])
    assert not applicable("act()", actions=[act], initial=[add(lit("p", "x"), no("q"))])


def test_sensing_splits_on_the_values_that_are_not_excluded():
    look = action("look", sense=[app("colour")])
    task = ground(problem(actions=[look], initial=[add(cmp(app("colour"), "!=", "v"))], functions=[COLOUR]))
    branching = task.open_branching(state_after(task, "look()"))
    assert branching.fact == "colour"
    assert [outcome for outcome, _ in branching.outcomes(state_after(task, "look()"))] == ["u", "w"]


def test_sensing_an_atom_splits_into_false_and_true():
    task = ground(problem(actions=[action("look", sense=[atom("p", "x")])]))
    open_state = state_after(task, "look()")
    branching = task.open_branching(open_state)
    assert (branching.fact, [outcome for outcome, _ in branching.outcomes(open_state)]) == (
        "p(x)",
        ["false", "true"],
    )
    assert all(task.open_branching(state) is None for _, state in branching.outcomes(open_state))


def test_goals_that_nothing_ever_makes_true_are_named():
    goal = f.And((f.Forall((var("z"),), f.Or((know(lit("p", var("z"))), know(lit("r"))))), know(lit("q"))))
    task = ground(problem(actions=[action("a", effects=[add(lit("q"), lit("p", "x"))])], goal=[goal]))
    assert unreachable_goals(task) == ["K(p(y)) or K(r)"]


def test_layers_count_how_long_the_relaxation_goes_on():
    chain = [
        action("one", effects=[add(lit("q"))]),
        action("two", pre=[know(lit("q"))], effects=[add(lit("r"))]),
        action("three", pre=[know(lit("r"))], effects=[add(lit("p", "x"))]),
    ]
    task = ground(problem(actions=chain))
    assert relaxed_reach(task.initial, task.actions, task.branchings, task.closure).layers == 3


@given(problem=st.one_of(branching_problems(), problems()), data=st.data())
def test_the_relaxation_contains_every_state_that_actions_reach(problem, data):
    """Otherwise "unreachable" would be wrong; random walks never leave it."""
    task = ground(problem)
    reach = relaxed_reach(task.initial, task.actions, task.branchings, task.closure)
    state = task.initial
    for _ in range(6):
        assert not state & ~reach.ones and not ~state & ~reach.zeros
        branching = task.open_branching(state)
        if branching is not None:
            after = [child for _, child in branching.outcomes(state)]
        else:
            after = [action.after(state) for action in task.actions if action.applicable(state)]
        after = [child for child in after if child is not None]
        if not after:
            return
        state = data.draw(st.sampled_from(after))


@given(problem=st.one_of(branching_problems(), problems()), data=st.data())
def test_what_an_action_needs_is_enough_for_what_is_needed_after_it(problem, data):
    """The law of regression: any state that agrees on the needs reaches a state that agrees on the needed bits."""
    task = ground(problem)
    pairs = [
        (a, task.initial) for a in task.actions if a.applicable(task.initial) and a.after(task.initial) is not None
    ]
    assume(pairs)
    act, state = data.draw(st.sampled_from(pairs))
    everything = st.integers(0, (1 << task.width) - 1)
    needed, noise = data.draw(everything), data.draw(everything)
    needs = act.needs(state, needed)
    other = state & needs | noise & ~needs
    assert act.applicable(other)
    after = act.after(other)
    assert after is not None
    assert (after ^ act.after(state)) & needed == 0


def test_actions_with_the_same_effects_share_them():
    go = action("go", parameters=[A, B], effects=[add(lit("near", B, B))])
    effects = {str(one): one.effects for one in ground(problem(actions=[go], **NEAR)).actions}
    assert effects["go(x, x)"] is effects["go(y, x)"] is not effects["go(x, y)"]
