"""Tasks without sensing in finite domains: what packed searches find is true of what is known."""

from dataclasses import replace
from random import Random

import pytest

from kabo.knowledge import ground
from kabo.knowledge.queries import AllOf, union
from kabo.language import formulas as f
from kabo.planner.search.algorithms.astar import astar as cheapest_first
from kabo.planner.search.algorithms.breadth_first import breadth_first
from kabo.planner.search.contingent import find_skeleton
from kabo.planner.search.packed import PackedTask
from kabo.planner.search.skeleton import Exhausted, FoundSkeleton, SearchLimits, Unreachable
from kabo.planner.search.to_finite_domain import classical_task
from tests.conftest import PROPERTY_SCALE
from tests.knowledge.asking import then
from tests.support.small_problems import (
    COLOUR,
    FUEL,
    action,
    add,
    app,
    atom,
    cmp,
    delete,
    know,
    lit,
    no,
    problem,
    when,
)

SEARCHES = ("best", "astar", "breadth-first")

Q, R, PX = lit("q"), lit("r"), lit("p", "x")
NOT_Q, NOT_R = no("q"), no("r")


SEEDS = range(max(20, round(6000 * PROPERTY_SCALE)))
COLOURS = [cmp(app("colour"), "=", v) for v in "uvw"]
GROUPS = [(PX, no("p", "x")), (lit("p", "y"), no("p", "y")), (Q, NOT_Q), (R, NOT_R), COLOURS]
FACTS = [fact for group in GROUPS for fact in group]


# --------------------------------------------------------------------------------------------------- random tasks
def sensing_free(seed):
    """A problem of which nothing is sensed; costs are 0 to 3; the goal asks for what some action brings about."""
    draw, made = Random(seed), []  # noqa: S311

    def asked(depth=1):
        kind = draw.random()
        if depth and kind < 0.2:
            return draw.choice([f.Or, f.And])((asked(0), asked(0)))
        one = know(draw.choice(FACTS))
        return f.Not(one) if kind < 0.45 else one

    def changed(group):
        fact, forget = draw.choice(group), draw.random() < 0.3
        if not forget:
            made.append((GROUPS.index(group), fact))
        change = delete(fact) if forget else add(fact)
        return when(asked(), change) if draw.random() < 0.5 else change

    schemas = []
    for number in range(draw.randint(3, 6)):
        pre = [asked() for _ in range(draw.choice([0, 1, 1, 2]))]
        groups = draw.sample(GROUPS, draw.randint(1, 2))
        some = [changed(group) for group in (*groups, *groups[: draw.choice([0, 0, 1])])]
        cost = f.Number(float(draw.randint(0, 3)))
        schemas.append(replace(action(f"act_{number}", pre=pre, effects=some), cost=cost))
    known = [draw.choice(group) for group in draw.sample(GROUPS, draw.randint(1, 3))]
    goal = dict(draw.sample(made, min(len(made), 3)))
    return problem(actions=schemas, initial=[add(*known)], goal=list(map(know, goal.values())), functions=[COLOUR])


@pytest.fixture(scope="module")
def tasks():
    """Random tasks, each with what it is in finite domains."""
    found = [(task, classical_task(task)) for task in (ground(sensing_free(seed)) for seed in SEEDS)]
    expressed = [(task, compiled) for task, compiled in found if compiled is not None]
    assert len(expressed) > 0.25 * len(found)
    return expressed


class States:
    """The knowledge states of a task as a graph for the searches in Python."""

    def __init__(self, task):
        self.task = task

    def key(self, state):
        return state

    confirmed_key = key

    def successors(self, state):
        after = [(act, act.after(state)) for act in self.task.actions if act.applicable(state)]
        return [(child, act, child) for act, child in after if child is not None]

    def is_end(self, state):
        return self.task.is_goal(state)

    def cost(self, act):
        return act.cost

    def bound(self, state):
        return 0.0


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


@pytest.mark.parametrize("search", SEARCHES)
def test_plans_are_plans_on_knowledge_and_there_is_one_if_python_finds_one(search, tasks):
    seen = []
    for task, _compiled in tasks:
        found = PackedTask(task).skeleton(search, None, SearchLimits())
        known = task.is_goal(task.initial) or breadth_first(task.initial, States(task)).path is not None
        assert isinstance(found, FoundSkeleton if known else Unreachable)
        seen.append(len(executed(task, found.skeleton)) if known else None)
    assert seen.count(None) > len(tasks) // 10
    assert sum(length is not None and length > 1 for length in seen) > len(tasks) // 10


def test_breadth_first_is_as_short_and_astar_as_cheap_as_in_python(tasks):
    for task, _compiled in tasks:
        graph, start = States(task), task.initial
        shortest = PackedTask(task).skeleton("breadth-first", None, SearchLimits())
        if task.is_goal(start) or not isinstance(shortest, FoundSkeleton):
            continue
        assert len(executed(task, shortest.skeleton)) == len(breadth_first(start, graph).path)
        cheapest = PackedTask(task).skeleton("astar", None, SearchLimits())
        cost = sum(act.cost for act in executed(task, cheapest.skeleton))
        assert cost == sum(act.cost for act, _ in cheapest_first(start, graph).path)


def test_every_state_of_knowledge_that_can_be_reached_is_reached(tasks):
    """Asked for as the goal, the first and the last of them are found, and no state that cannot be reached."""
    for task, _ in tasks[: len(tasks) // 2]:
        states, graph = [task.initial], States(task)
        for state in states:  # grows while it is walked
            states += [child for child, _, _ in graph.successors(state) if child not in states]
        for state in dict.fromkeys((states[0], states[-1])):
            wanted = replace(task, goal_query=_exactly(task, state))
            found = PackedTask(wanted).skeleton("breadth-first", None, SearchLimits())
            assert isinstance(found, FoundSkeleton)
            executed(wanted, found.skeleton)
        other = states[-1] ^ task.groups[0].mask
        if other not in states:
            compiled = classical_task(wanted := replace(task, goal_query=_exactly(task, other)))
            assert compiled is None or isinstance(
                PackedTask(wanted).skeleton("breadth-first", None, SearchLimits()), Unreachable
            )


def _exactly(task, state):
    mask = union(group.mask for group in task.groups)
    return AllOf(mask, state & mask)


# ---------------------------------------------------------------------------------------------------- add and del
def plan(search="breadth-first", **pieces):
    """The names of the actions of the plan that is found, or None."""
    task = ground(problem(**pieces))
    compiled = classical_task(task)
    assert compiled is not None, "it can be said"
    found = PackedTask(task).skeleton(search, None, SearchLimits())
    return [act.name for act in executed(task, found.skeleton)] if isinstance(found, FoundSkeleton) else None


def test_add_wins_over_del():
    act = action("act", effects=[delete(Q), when(know(R), add(Q))])
    make = action("make", effects=[add(R)])
    for effects_ in (act.effects, act.effects[::-1]):
        both = [replace(act, effects=effects_), make]
        assert plan(actions=both, initial=[add(R)], goal=[know(Q)]) == ["act"]
        assert plan(actions=both, goal=[know(Q)]) == ["make", "act"]
        assert plan(actions=both, initial=[add(Q)], goal=[f.Not(know(Q))]) == ["act"]
        assert plan(actions=both, initial=[add(Q, R)], goal=[f.Not(know(Q))]) is None


def test_an_addition_of_what_is_known_already_counts():
    """It is at odds with another addition, and wins over a deletion."""
    keep = when(know(R), add(R))
    odd = action("act", pre=[know(R)], effects=[keep, when(know(R), add(NOT_R))])
    more = action("more", effects=[add(R)])
    task = ground(problem(actions=[odd, more], initial=[add(R)], goal=[know(NOT_R)]))
    assert classical_task(task) is None, "an action at odds with itself is left to the others"
    win = action("act", effects=[keep, delete(R, NOT_R)])
    assert plan(actions=[win, more], initial=[add(R)], goal=[f.Not(know(R))]) is None


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
    for search in SEARCHES:
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
    found = PackedTask(task).skeleton("breadth-first", None, SearchLimits(expansions=1))
    assert isinstance(found, Exhausted)
    assert found.budget == "expansions"


# ------------------------------------------------------------------------------------------------ what cannot be said
MAKE = action("make", effects=[add(Q)])
CALL = f.SituatedCall("free")
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
