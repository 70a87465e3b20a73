"""The engine `kabo` in unified-planning: what it solves holds there, what it proves is so, what it cannot do is refused."""

import subprocess
import sys
from collections import deque
from pathlib import Path

import pytest
import unified_planning.test as up_tests
from unified_planning.engines import PlanGenerationResultStatus as Status
from unified_planning.engines.sequential_simulator import UPSequentialSimulator
from unified_planning.environment import get_environment
from unified_planning.exceptions import UPUsageError
from unified_planning.io import PDDLReader
from unified_planning.model import ContingentProblem, Problem, SensingAction
from unified_planning.plans import ContingentPlan, SequentialPlan
from unified_planning.shortcuts import (
    BoolType,
    Fluent,
    InstantaneousAction,
    Int,
    IntType,
    MinimizeActionCosts,
    MinimizeSequentialPlanLength,
    OneshotPlanner,
    RealType,
)
from unified_planning.test import get_test_cases

import kabo.up
from kabo.up.kinds import refusals
from tests.conftest import PROPERTY_SCALE
from tests.support.oracles_up import failures
from tests.support.random_up import random_problem

CASES = {name: case for name, case in get_test_cases().items() if not refusals(case.problem.kind)}
REFUSED = {name: case for name, case in get_test_cases().items() if refusals(case.problem.kind)}
CONTINGENT = Path(up_tests.__file__).parent / "contingent_pddl"


@pytest.fixture(autouse=True)
def _quiet():
    get_environment().credits_stream = None


def solved(problem, **options):
    with OneshotPlanner(name="kabo", params=options) as planner:
        return planner.solve(problem)


def least_actions(problem) -> int | None:
    """The length of the shortest plan of a classical problem, by breadth-first search in unified-planning's simulator."""
    simulator = UPSequentialSimulator(problem, error_on_failed_checks=False)
    fluents = list(problem.initial_values)
    start = simulator.get_initial_state()
    seen, waiting = {tuple(map(start.get_value, fluents))}, deque([(start, 0)])
    while waiting:
        state, done = waiting.popleft()
        if simulator.is_goal(state):
            return done
        for action, values in simulator.get_applicable_actions(state):
            after = simulator.apply(state, action, values)
            key = None if after is None else tuple(map(after.get_value, fluents))
            if key is not None and key not in seen:
                seen.add(key)
                waiting.append((after, done + 1))
    return None


def test_importing_the_room_is_all_that_a_user_does():
    program = (
        "import kabo.up\nfrom unified_planning.shortcuts import OneshotPlanner\n"
        "print(OneshotPlanner(name='kabo').name, 'numba' in __import__('sys').modules)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith("kabo False")


def test_a_configuration_file_of_unified_planning_makes_the_engine_known(tmp_path):
    (tmp_path / "up.ini").write_text("[engine kabo]\nmodule_name: kabo.up.engine\nclass_name: KaboEngine\n")
    program = tmp_path / "program.py"
    program.write_text("from unified_planning.shortcuts import *\nprint(OneshotPlanner(name='kabo').name)")
    done = subprocess.run([sys.executable, program], capture_output=True, text=True, check=True)
    assert done.stdout.rstrip().endswith("kabo")


def test_importing_kabo_does_not_load_unified_planning():
    program = "import sys, kabo, kabo.language, kabo.planner; print('unified_planning' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"]


@pytest.mark.parametrize("name", CASES)
def test_a_problem_of_unified_plannings_own_tests_is_solved_and_its_plan_is_valid(name):
    problem = CASES[name].problem
    result = solved(problem)
    assert result.status == Status.SOLVED_SATISFICING
    assert isinstance(result.plan, SequentialPlan)
    assert not failures(problem, result.plan)


@pytest.mark.parametrize("name", REFUSED)
def test_what_kabo_cannot_do_is_refused_with_the_reason(name):
    problem = REFUSED[name].problem
    with OneshotPlanner(name="kabo") as planner:
        assert not planner.supports(problem.kind)
        result = planner.solve(problem)
        assert result.status == Status.UNSUPPORTED_PROBLEM
        assert result.plan is None and result.log_messages
        planner.error_on_failed_checks = True
        with pytest.raises(UPUsageError, match=r"kabo does not support this problem: .*\([A-Z_, ]+\)"):
            planner.solve(problem)


@pytest.mark.parametrize("name", ["colorballs", "logistic_conf"])
def test_unified_plannings_contingent_problems_are_solved_in_every_world(name):
    folder = CONTINGENT / name
    problem = PDDLReader().parse_problem(str(folder / "domain.pddl"), str(folder / "problem.pddl"))
    result = solved(problem)
    assert isinstance(result.plan, ContingentPlan)
    assert not failures(problem, result.plan, number=4)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["counters", "depot", "miconic", "safe_road", "sailing"])
def test_unified_plannings_pddl_problems_are_solved_and_their_plans_are_valid(name):
    folder = CONTINGENT.parent / "pddl" / name
    for file in sorted(folder.glob("problem*.pddl")):
        problem = PDDLReader().parse_problem(str(folder / "domain.pddl"), str(file))
        assert not failures(problem, solved(problem).plan)


def judge(seed: int, *, contingent: bool) -> str:
    """Checks kabo's answer to a random problem; what it was."""
    problem = random_problem(seed, contingent=contingent)
    result = solved(problem)
    if result.plan is not None:
        assert failures(problem, result.plan) == [], seed
    elif result.status == Status.UNSOLVABLE_PROVEN and not contingent:
        assert least_actions(problem) is None, seed
    elif not contingent:
        raise AssertionError(f"{seed}: {result}")
    return result.status.name


@pytest.mark.parametrize("contingent", [False, True])
def test_answers_to_random_problems_hold_in_unified_planning(contingent):
    found = [judge(seed, contingent=contingent) for seed in range(25)]
    assert found.count("SOLVED_SATISFICING") >= 5
    assert found.count("UNSOLVABLE_PROVEN") >= 2


@pytest.mark.slow
@pytest.mark.parametrize("contingent", [False, True])
def test_answers_to_many_random_problems_hold_in_unified_planning(contingent):
    for seed in range(25, 25 + max(100, round(375 * PROPERTY_SCALE))):
        judge(seed, contingent=contingent)


def counting(target: int, step, kind) -> Problem:
    problem = Problem("counting")
    number = problem.add_fluent("number", kind, default_initial_value=0)
    action = InstantaneousAction("count")
    action.add_increase_effect(number, step)
    problem.add_action(action)
    problem.add_goal(number().Equals(target))
    return problem


def test_bounds_of_numbers_hold_at_all_times_and_that_there_is_no_plan_is_proven():
    assert solved(counting(3, 1, IntType(0, 5))).status == Status.SOLVED_SATISFICING
    assert solved(counting(6, 1, IntType(0, 5))).status == Status.UNSOLVABLE_PROVEN


def test_fractions_prove_nothing_and_plans_hold_in_exact_arithmetic():
    from fractions import Fraction

    problem = counting(1, Fraction(1, 3), RealType(0, 2))
    result = solved(problem, max_expansions=1000)
    assert result.status != Status.UNSOLVABLE_PROVEN
    assert result.plan is None or not failures(problem, result.plan)


def test_an_optimal_plan_is_only_said_to_be_optimal_where_it_is():
    problem = Problem("ways")
    done = problem.add_fluent("done", BoolType(), default_initial_value=False)
    half = problem.add_fluent("half", BoolType(), default_initial_value=False)
    costs = {}
    for name, needs, gives, cost in (("dear", None, done, 5), ("first", None, half, 1), ("second", half, done, 2)):
        action = InstantaneousAction(name)
        if needs is not None:
            action.add_precondition(needs)
        action.add_effect(gives, True)
        problem.add_action(action)
        costs[action] = Int(cost)
    problem.add_goal(done)
    problem.add_quality_metric(MinimizeActionCosts(costs))
    result = solved(problem, search="astar")
    assert result.status == Status.SOLVED_OPTIMALLY
    assert [each.action.name for each in result.plan.actions] == ["first", "second"]
    assert solved(problem).status == Status.SOLVED_SATISFICING


@pytest.mark.parametrize("seed", range(12))
def test_a_plan_that_is_said_to_be_optimal_is_as_short_as_any(seed):
    problem = random_problem(seed, contingent=False)
    problem.add_quality_metric(MinimizeSequentialPlanLength())
    result = solved(problem, search="astar")
    assert result.status in (Status.SOLVED_OPTIMALLY, Status.UNSOLVABLE_PROVEN)
    assert (None if result.plan is None else len(result.plan.actions)) == least_actions(problem)


def doors(*, with_listening: bool) -> ContingentProblem:
    """A tiger is behind one of two doors: written for kabo, not one of unified-planning's."""
    problem = ContingentProblem("tiger")
    left, right = Fluent("tiger-left"), Fluent("tiger-right")
    safe, dead = Fluent("safe"), Fluent("dead")
    for each in (left, right, safe, dead):
        problem.add_fluent(each, default_initial_value=False)
    problem.add_oneof_initial_constraint([left(), right()])
    for name, tiger in (("open-left", left), ("open-right", right)):
        action = InstantaneousAction(name)
        action.add_effect(dead, True, tiger)
        action.add_effect(safe, True)
        problem.add_action(action)
    if with_listening:
        listen = SensingAction("listen")
        listen.add_observed_fluent(left())
        problem.add_action(listen)
    problem.add_goal(safe())
    problem.add_goal(dead().Not())
    return problem


def test_a_tiger_is_listened_to_before_a_door_is_opened():
    problem = doors(with_listening=True)
    result = solved(problem)
    assert result.plan.root_node.action_instance.action.name == "listen"
    assert len(result.plan.root_node.children) == 2
    assert not failures(problem, result.plan)


def test_a_tiger_that_nobody_hears_is_proven_to_be_deadly():
    result = solved(doors(with_listening=False))
    assert result.status in (Status.UNSOLVABLE_PROVEN, Status.UNSOLVABLE_INCOMPLETELY)
    assert result.plan is None and result.log_messages


def test_a_time_that_is_up_is_a_timeout():
    with OneshotPlanner(name="kabo") as planner:
        assert planner.solve(counting(10**9, 1, IntType()), timeout=0.05).status == Status.TIMEOUT


def test_an_effect_that_kabo_has_no_form_for_is_refused_by_name():
    problem = doors(with_listening=True)
    number = problem.add_fluent("number", IntType(), default_initial_value=0)
    problem.action("open-left").add_increase_effect(number, 1, problem.fluent("tiger-left"))
    result = solved(problem)
    assert result.status == Status.UNSUPPORTED_PROBLEM
    assert "depending on what may be unknown" in str(result.log_messages[0])


def test_problems_are_translated_the_same_way_each_time():
    problem = random_problem(3, contingent=True)
    first, second = kabo.up.problem_from_up(problem).problem, kabo.up.problem_from_up(problem).problem
    assert first == second
