"""Tasks without sensing in finite domains: what packed searches find is true of what is known."""

from collections import deque
from dataclasses import replace

import pytest
from hypothesis import assume, event, given, settings
from hypothesis import strategies as st

from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.planner.classical import classical_task
from kabo.planner.contingent import find_skeleton
from kabo.planner.packed import PACKED, packed_skeleton
from kabo.planner.searches import breadth_first, cheapest_first
from kabo.planner.skeleton import Exhausted, Found, Limits, Unreachable
from tests.knowledge.asking import then
from tests.small_problems import (
    COLOUR,
    FUEL,
    X,
    Y,
    action,
    add,
    app,
    atom,
    cmp,
    delete,
    effects,
    know,
    lit,
    no,
    problem,
    queries,
    var,
    when,
)

Q, R, PX = lit("q"), lit("r"), lit("p", "x")
NOT_Q, NOT_R = no("q"), no("r")


FEWER = settings(max_examples=max(20, settings().max_examples // 4))


# --------------------------------------------------------------------------------------------------- random tasks
def is_plain(effect):
    """Whether an effect is about Kf only: nothing to be sensed."""
    inner = getattr(effect, "updates", ()) or getattr(effect, "effects", ())
    return all(map(is_plain, inner)) if inner else effect.database == "Kf"


@st.composite
def sensing_free(draw):
    """A problem of which nothing is sensed; costs are 0 to 3."""
    schemas = []
    for number in range(draw(st.integers(1, 5))):
        parameters = [var("a")] if draw(st.booleans()) else []
        names = [X, Y, *parameters]
        some = draw(st.lists(effects(names).filter(is_plain), min_size=1, max_size=3))
        one = action(
            f"act_{number}", parameters=parameters, pre=draw(st.lists(queries(names, 1), max_size=2)), effects=some
        )
        schemas.append(replace(one, cost=f.Number(float(draw(st.integers(0, 3))))))
    known = st.sampled_from([PX, no("p", "x"), Q, NOT_Q, R, cmp(app("colour"), "=", "u")])
    return problem(
        actions=schemas,
        initial=[add(fact) for fact in draw(st.lists(known, max_size=3))],
        goal=draw(st.lists(queries([X, Y]), min_size=1, max_size=2)),
        functions=[COLOUR],
    )


class States:
    """The knowledge states of a task as a graph for the searches in Python."""

    def __init__(self, task):
        self.task = task

    def key(self, state):
        return state

    def successors(self, state):
        after = [(act, act.after(state)) for act in self.task.actions if act.applicable(state)]
        return [(child, act, child) for act, child in after if child is not None]

    def is_end(self, state):
        return self.task.is_goal(state)

    def cost(self, act):
        return act.cost


def executed(task, skeleton):
    """The actions of a skeleton without branches; each must be applicable, and the goal hold at the end."""
    state, node, acts = task.initial, skeleton.root, []
    while not node.is_goal:
        assert node.action.applicable(state), str(node.action)
        state = node.action.after(state)
        assert state is not None, str(node.action)
        acts.append(node.action)
        node = node.next
    assert task.is_goal(state)
    return acts


def expressed(problem_):
    task = ground(problem_)
    compiled = classical_task(task)
    assume(compiled is not None)
    return task, compiled


@pytest.mark.parametrize("search", PACKED)
@FEWER
@given(problem=sensing_free())
def test_plans_are_plans_on_knowledge_and_there_is_one_if_python_finds_one(search, problem):
    task, compiled = expressed(problem)
    found = packed_skeleton(task, compiled, search, None, Limits())
    event(type(found).__name__)
    graph = States(task)
    known = task.is_goal(task.initial) or breadth_first(task.initial, graph).path is not None
    assert isinstance(found, Found if known else Unreachable)
    if isinstance(found, Found):
        executed(task, found.skeleton)


@FEWER
@given(problem=sensing_free())
def test_breadth_first_is_as_short_and_astar_as_cheap_as_in_python(problem):
    task, compiled = expressed(problem)
    assume(not task.is_goal(task.initial))
    shortest = packed_skeleton(task, compiled, "breadth-first", None, Limits())
    assume(isinstance(shortest, Found))
    graph = States(task)
    assert len(executed(task, shortest.skeleton)) == len(breadth_first(task.initial, graph).path)
    cheapest = packed_skeleton(task, compiled, "astar", None, Limits())
    cost = sum(act.cost for act in executed(task, cheapest.skeleton))
    assert cost == sum(act.cost for act, _ in cheapest_first(task.initial, graph).path)


@FEWER
@given(problem=sensing_free())
def test_as_many_states_can_be_reached(problem):
    """Every state that is known to be reachable is a state of the finite-domain task, and reached as a goal there."""
    task, _ = expressed(problem)
    states, waiting = {task.initial}, deque([task.initial])
    graph = States(task)
    while waiting and len(states) < 20:
        for state, _, _ in graph.successors(waiting.popleft()):
            if state not in states:
                states.add(state)
                waiting.append(state)
    for state in sorted(states)[:4]:
        wanted = replace(task, goal_query=_exactly(task, state))
        compiled = classical_task(wanted)
        assert compiled is not None
        found = packed_skeleton(wanted, compiled, "breadth-first", None, Limits())
        assert isinstance(found, Found)
        executed(wanted, found.skeleton)


def _exactly(task, state):
    from kabo.knowledge.queries import AllOf, union

    mask = union(group.mask for group in task.groups)
    return AllOf(mask, state & mask)


# ---------------------------------------------------------------------------------------------------- add and del
def plan(search="breadth-first", **pieces):
    """The names of the actions of the plan that is found, or None."""
    task = ground(problem(**pieces))
    compiled = classical_task(task)
    assert compiled is not None, "it can be said"
    found = packed_skeleton(task, compiled, search, None, Limits())
    return [act.name for act in executed(task, found.skeleton)] if isinstance(found, Found) else None


def test_add_wins_over_del():
    act = action("act", effects=[delete(Q), when(know(R), add(Q))])
    make = action("make", effects=[add(R)])
    for effects_ in (act.effects, act.effects[::-1]):
        both = [replace(act, effects=effects_), make]
        assert plan(actions=both, initial=[add(R)], goal=[know(Q)]) == ["act"]
        assert plan(actions=both, goal=[know(Q)]) == ["make", "act"]
        assert plan(actions=both, initial=[add(Q)], goal=[f.Not(know(Q))]) == ["act"]
        assert plan(actions=both, initial=[add(Q, R)], goal=[f.Not(know(Q))]) is None


def test_add_that_seems_never_to_happen_may_happen_after_all():
    """What adds and what forgets can meet only after two other steps; then what adds wins."""
    act = action("act", pre=[know(PX)], effects=[delete(Q), when(know(R), add(Q))])
    steps = [action("one", effects=[add(R)]), action("two", pre=[know(R)], effects=[add(PX)])]
    assert plan(actions=[act, *steps], goal=[know(Q)]) == ["one", "two", "act"]


def test_what_is_known_false_is_not_what_is_unknown():
    deny = action("deny", effects=[add(NOT_Q)])
    lose = action("lose", pre=[know(NOT_Q)], effects=[delete(NOT_Q)])
    goal = [f.And((f.Not(know(Q)), f.Not(know(NOT_Q))))]
    assert plan(actions=[deny, lose], initial=[add(Q)], goal=goal) == ["deny", "lose"]


def test_the_first_state_may_be_the_goal():
    assert plan(actions=[action("act", effects=[add(Q)])], initial=[add(R)], goal=[know(R)]) == []


def test_a_task_without_sensing_is_given_to_the_packed_searches():
    """The same answer through the door that everybody uses."""
    steps = [action("one", effects=[add(R)]), action("two", pre=[know(R)], effects=[add(Q)])]
    task = ground(problem(actions=steps, goal=[know(Q)]))
    for search in PACKED:
        found = find_skeleton(task, search=search)
        assert [act.name for act in executed(task, found.skeleton)] == ["one", "two"]


def test_the_budget_ends_a_packed_search():
    steps = [
        action(f"step_{n}", pre=[know(cmp(app("colour"), "=", a))], effects=[add(cmp(app("colour"), "=", b))])
        for n, (a, b) in enumerate(["uv", "vw"])
    ]
    task = ground(
        problem(
            actions=steps,
            initial=[add(cmp(app("colour"), "=", "u"))],
            goal=[know(cmp(app("colour"), "=", "w"))],
            functions=[COLOUR],
        )
    )
    found = packed_skeleton(task, classical_task(task), "breadth-first", None, Limits(expansions=1))
    assert isinstance(found, Exhausted)
    assert found.budget == "expansions"


# ------------------------------------------------------------------------------------------------ what cannot be said
MAKE = action("make", effects=[add(Q)])
CALL = f.ProcedureCall("free")
INEXPRESSIBLE = {
    "sensing": {"actions": [MAKE, action("look", sense=[atom("r")])]},
    "an entry of Kw": {"actions": [MAKE], "initial": [add(R, to="Kw")]},
    "an entry of Kor": {"actions": [MAKE], "initial": [add(Q, R, to="Kor")]},
    "a rule": {"actions": [MAKE], "update_rules": [when(know(Q), add(R))]},
    "postdiction": {"actions": [action("make", effects=[then(R, Q)])]},
    "a number": {
        "actions": [
            action(
                "make", effects=[add(Q), add(cmp(app("fuel"), "=", f.Arithmetic("-", app("fuel"), f.Number(1.0))))]
            )
        ],
        "initial": [add(cmp(app("fuel"), "=", 2))],
        "functions": [FUEL],
    },
    "an excluded value": {
        "actions": [action("make", effects=[add(Q), add(cmp(app("colour"), "!=", "u"))])],
        "functions": [COLOUR],
    },
    "a geometric test": {"actions": [action("make", pre=[f.Test(CALL)], effects=[add(Q)])]},
    "always": {"actions": [MAKE], "goal": [f.Temporal("always", f.Not(know(R)))]},
}


@pytest.mark.parametrize("pieces", INEXPRESSIBLE.values(), ids=INEXPRESSIBLE)
def test_what_finite_domains_cannot_say_is_left_to_the_others(pieces):
    task = ground(problem(**{"goal": [know(Q)], **pieces}))
    assert classical_task(task) is None


def test_without_any_of_these_it_can_be_said():
    assert classical_task(ground(problem(actions=[MAKE], goal=[know(Q)]))) is not None
