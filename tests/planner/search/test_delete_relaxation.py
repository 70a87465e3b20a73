"""The relaxation never gives up what can be done, and tells what to begin with."""

import pytest

from kabo.errors import InputError
from kabo.knowledge import ground
from kabo.language import formulas as f
from kabo.language import load_problem
from kabo.planner.search.delete_relaxation import Relaxation
from tests.conftest import PROPERTY_SCALE
from tests.knowledge.asking import state_after, then
from tests.support.random_knowledge import random_problem
from tests.support.small_problems import COLOUR, action, add, app, atom, cmp, delete, know, lit, no, problem, when

Q, R, X = lit("q"), lit("r"), lit("p", "x")
NOT_Q, NOT_R, NOT_X = no("q"), no("r"), no("p", "x")
LOOK = action("look", sense=[atom("q")])
STATES = 400


def estimate(*steps, goal, **pieces):
    """The value after the steps and the names of the preferred actions."""
    task = ground(problem(goal=goal, **pieces))
    found = Relaxation(task).estimate(state_after(task, *steps), range(len(task.goal)))
    return found.value, [task.actions[index].name for index in found.preferred]


# --------------------------------------------------------------------------------------------------- random problems
@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    folder, found = tmp_path_factory.mktemp("problems"), []
    for seed in range(max(20, round(800 * PROPERTY_SCALE))):
        domain, text = random_problem(seed)
        (folder / "domain.yaml").write_text(domain)
        (folder / "problem.yaml").write_text(text)
        try:
            found.append(ground(load_problem(folder / "problem.yaml")))
        except InputError:
            continue
    return found


def arrows(task):
    """The states that can be reached, each with those one step away; branching comes first, or waits."""
    after = {task.initial: []}
    waiting = [task.initial]
    for state in waiting:  # grows while it is walked
        branching = task.open_branching(state)
        children = [] if branching is None else [child for _, child in branching.outcomes(state)]
        children += [one.after(state) for one in task.actions if one.applicable(state)]
        after[state] = [child for child in children if child is not None]
        for child in after[state]:
            if child not in after and len(after) < STATES:
                after[child] = []
                waiting.append(child)
    return after


def hopeful(task, after, part):
    """The states from which some way leads to where the conjunct holds."""
    found = {state for state in after if task.goal[part].query.holds(state)}
    while True:
        more = {state for state, children in after.items() if state not in found and found.intersection(children)}
        if not more:
            return found
        found |= more


def test_what_seems_out_of_reach_is_out_of_reach(tasks):
    """By brute force: if some way leads to a conjunct, with every outcome as hoped, it has an estimate."""
    reached = hopeless = 0
    for task in tasks:
        relaxation, after = Relaxation(task), arrows(task)
        for part in range(len(task.goal)):
            hope = hopeful(task, after, part)
            for state in after:
                value = relaxation.estimate(state, [part]).value
                hopeless += value is None
                if state in hope:
                    reached += 1
                    assert value is not None, task.goal[part].text
    assert reached > 3 * len(tasks) and hopeless > len(tasks) // 2


def test_where_a_conjunct_holds_nothing_is_to_be_done(tasks):
    for task in tasks:
        relaxation = Relaxation(task)
        for state in arrows(task):
            for part, conjunct in enumerate(task.goal):
                if conjunct.query.holds(state):
                    assert relaxation.estimate(state, [part])[:2] == (0, ())


def test_preferred_actions_are_applicable(tasks):
    preferred = 0
    for task in tasks:
        relaxation = Relaxation(task)
        for state in arrows(task):
            if task.open_branching(state) is None:
                for index in relaxation.estimate(state, range(len(task.goal))).preferred:
                    preferred += 1
                    assert task.actions[index].index == index
                    assert task.actions[index].applicable(state), str(task.actions[index])
    assert preferred > len(tasks)


# ------------------------------------------------------------------------------------------------------ one by one
def test_sensing_what_is_unknown_gives_both_outcomes():
    assert estimate(goal=[know(Q)], actions=[LOOK]) == (1, ["look"])
    assert estimate(goal=[know(NOT_Q)], actions=[LOOK]) == (1, ["look"])


def test_sensing_what_is_known_helps_nobody():
    assert estimate(goal=[know(Q)], actions=[LOOK], initial=[add(NOT_Q)]) == (None, [])


def test_what_is_known_may_be_forgotten_and_sensed_anew():
    shake = action("shake", effects=[delete(Q, NOT_Q)])
    assert estimate(goal=[know(Q)], actions=[LOOK, shake], initial=[add(NOT_Q)]) == (2, ["shake"])


def test_what_was_sensed_and_stands_open_is_known_for_nothing():
    assert estimate("look()", goal=[know(Q)], actions=[LOOK])[0] == 0


def test_what_may_come_about_in_the_world_can_be_sensed():
    act = action("act", effects=[then(R, Q)])
    assert estimate(goal=[know(Q)], actions=[LOOK, act], initial=[add(NOT_Q)]) == (2, ["act"])


def test_what_follows_costs_nothing():
    entry = {"actions": [LOOK], "initial": [add(Q, R, X, to="Kx")]}
    assert estimate(goal=[know(NOT_R)], **entry) == (1, ["look"])
    pair = {"actions": [LOOK], "initial": [add(Q, R, to="Kor")]}
    assert estimate(goal=[know(R)], **pair) == (1, ["look"])
    rule = {"actions": [LOOK], "update_rules": [when(know(Q), add(R))]}
    assert estimate(goal=[know(R)], **rule) == (1, ["look"])


def test_the_last_member_needs_all_others_out():
    see = action("see", sense=[atom("r")])
    entry = {"actions": [LOOK, see], "initial": [add(Q, R, X, to="Kor")]}
    assert estimate(goal=[know(X)], **entry) == (2, ["look", "see"])
    assert estimate("look()", "q: false", goal=[know(X)], **entry) == (1, ["see"])


def test_an_entry_that_nobody_has_tells_nothing():
    say = action("say", pre=[know(Q)], effects=[add(R, X, to="Kor")])
    see = action("see", sense=[atom("r")])
    pieces = {"actions": [LOOK, say, see]}
    assert estimate(goal=[know(X)], **pieces)[0] == 3


def test_the_last_value_follows_from_the_others():
    exclude = [
        action(f"exclude_{v}", pre=[know(Q)], effects=[add(cmp(app("colour"), "!=", v))]) for v in ("u", "v")
    ]
    goal = [know(cmp(app("colour"), "=", "w"))]
    value, preferred = estimate(goal=goal, actions=[*exclude], initial=[add(Q)], functions=[COLOUR])
    assert (value, preferred) == (2, ["exclude_u", "exclude_v"])


def test_that_something_is_not_known_is_a_fact_too():
    lose = action("lose", effects=[delete(Q)])
    assert estimate(goal=[f.Not(know(Q))], actions=[lose], initial=[add(Q)]) == (1, ["lose"])


def test_of_alternatives_the_nearer_counts():
    make = action("make", effects=[add(R)])
    one = action("one", pre=[know(R)], effects=[add(X)])
    goal = [f.Or((f.And((know(X), know(R))), f.And((know(R), know(Q)))))]
    assert estimate(goal=goal, actions=[make, one, LOOK])[0] == 2
    assert estimate("make()", "look()", "q: true", goal=goal, actions=[make, one, LOOK])[0] == 0


def test_some_conjuncts_may_be_asked_for_alone():
    make = [action("make_q", effects=[add(Q)]), action("make_r", effects=[add(R)])]
    task = ground(problem(actions=make, goal=[know(Q), know(R)]))
    relaxation = Relaxation(task)
    assert [relaxation.estimate(task.initial, parts).value for parts in ([0], [1], [1, 0], [])] == [1, 1, 2, 0]
