"""Imported problems are solved, and their plans are right by a simulator that reads the PDDL text itself."""

import random

import pytest

import kabo
from kabo.language.problem import Problem
from kabo.plan import Plan
from tests.language.meaning import after, parsed, true_in
from tests.language.samples import CLG, LOGISTICS, PKS_UNTYPED
from tests.language.written import read

BLOCKS = """
(define (domain towers)
  (:predicates (on ?a ?b) (on-table ?a) (clear ?a) (held ?a) (hand-empty))
  (:action pick-up :parameters (?a) :precondition (and (clear ?a) (on-table ?a) (hand-empty))
    :effect (and (held ?a) (not (on-table ?a)) (not (clear ?a)) (not (hand-empty))))
  (:action put-down :parameters (?a) :precondition (held ?a)
    :effect (and (on-table ?a) (clear ?a) (hand-empty) (not (held ?a))))
  (:action stack :parameters (?a ?b) :precondition (and (held ?a) (clear ?b))
    :effect (and (on ?a ?b) (clear ?a) (hand-empty) (not (held ?a)) (not (clear ?b))))
  (:action unstack :parameters (?a ?b) :precondition (and (on ?a ?b) (clear ?a) (hand-empty))
    :effect (and (held ?a) (clear ?b) (not (on ?a ?b)) (not (clear ?a)) (not (hand-empty)))))
"""

GRIPPER = """
(define (domain carrier)
  (:predicates (room ?r) (ball ?b) (hand ?h) (here ?r) (at ?b ?r) (free ?h) (holds ?h ?b) (tired) (visited ?r))
  (:action go :parameters (?from ?to) :precondition (and (room ?from) (room ?to) (here ?from))
    :effect (and (here ?to) (not (here ?from)) (visited ?to)
                 (forall (?h) (when (and (hand ?h) (not (free ?h))) (tired)))))
  (:action take :parameters (?h ?b ?r)
    :precondition (and (hand ?h) (ball ?b) (here ?r) (at ?b ?r) (free ?h) (imply (tired) (visited ?r)))
    :effect (and (holds ?h ?b) (not (at ?b ?r)) (not (free ?h))))
  (:action drop-all :parameters (?r) :precondition (and (room ?r) (here ?r) (exists (?h ?b) (holds ?h ?b)))
    :effect (forall (?h ?b) (when (holds ?h ?b) (and (at ?b ?r) (free ?h) (not (holds ?h ?b)))))))
"""


def blocks(count: int, seed: int) -> str:
    """Random towers, and one tower in a random order as the goal."""
    chance = random.Random(seed)
    names = [f"b-{n}" for n in range(count)]
    order = chance.sample(names, count)
    initial = ["(hand-empty)", f"(on-table {order[0]})"]
    for below, above in zip(order, order[1:], strict=False):
        high = chance.random() < 0.6
        initial.append(f"(on {above} {below})" if high else f"(on-table {above})")
        initial += [] if high else [f"(clear {below})"]
    initial.append(f"(clear {order[-1]})")
    wanted = chance.sample(names, count)
    goal = " ".join(f"(on {a} {b})" for a, b in zip(wanted, wanted[1:], strict=False))
    return f"""(define (problem b) (:domain towers) (:objects {" ".join(names)})
        (:init {" ".join(initial)}) (:goal (and {goal})))"""


def balls(count: int) -> str:
    """Balls to carry to another room."""
    names = [f"ball{n}" for n in range(count)]
    initial = " ".join(f"(ball {name}) (at {name} den)" for name in names)
    goal = " ".join(f"(at {name} attic)" for name in names)
    return f"""(define (problem c) (:domain carrier) (:objects den attic left right {" ".join(names)})
        (:init (room den) (room attic) (hand left) (hand right) (free left) (free right) (here den) {initial})
        (:goal (and {goal} (not (holds left ball0)))))"""


def sections(text: str, keyword: str) -> list[list]:
    """The sections of a definition with a keyword, without it."""
    (definition,) = parsed(text)
    return [part[1:] for part in definition if part[0] == keyword]


def simulate(problem: Problem, plan: Plan, domain: str, text: str) -> int:
    """Runs a plan without branches on the text of untyped files; the number of its actions.

    Raises:
        AssertionError: an action is not applicable, or the goal is not reached.
    """
    names = {name.replace("_", "-"): name for name in problem.objects} | {name: name for name in problem.objects}
    (objects,), (initial,), (goal,) = (sections(text, each) for each in (":objects", ":init", ":goal"))
    spelled = {names[each]: each for each in objects}
    state = frozenset((each[0], tuple(each[1:])) for each in initial)
    schemas = {each[0].replace("-", "_"): each[1:] for each in sections(domain, ":action")}
    node, count = plan.nodes[plan.root], 0
    while node.action is not None:
        schema = dict(zip(schemas[node.action][::2], schemas[node.action][1::2], strict=True))
        arguments = {f"?{name}": spelled[value] for name, value in node.arguments.items()}
        assert true_in(schema[":precondition"], state, arguments, objects), node
        state = after(schema[":effect"], state, arguments, objects)
        node, count = plan.nodes[node.next], count + 1
    assert true_in(goal[0], state, {}, objects)
    return count


@pytest.mark.parametrize(
    ("domain", "text"),
    [
        (BLOCKS, blocks(3, 1)),
        (BLOCKS, blocks(5, 2)),
        (BLOCKS, blocks(4, 3)),
        (GRIPPER, balls(1)),
        (GRIPPER, balls(4)),
    ],
    ids=["three blocks", "five blocks", "four blocks", "one ball", "four balls"],
)
def test_plans_of_classical_problems_reach_the_goal(tmp_path, domain, text):
    problem = read(tmp_path, domain, text)
    result = kabo.solve(problem)
    assert result.status == "solved"
    assert simulate(problem, result.plan, domain, text) > 0
    assert kabo.verify(problem, result.plan).ok


def test_a_goal_that_cannot_be_reached_has_no_plan(tmp_path):
    text = balls(1).replace("(free left) (free right)", "")
    assert kabo.solve(read(tmp_path, GRIPPER, text)).status == "no_plan"


@pytest.mark.parametrize(
    ("text", "ending"), [(LOGISTICS, "pddl"), (CLG, "pddl"), (PKS_UNTYPED, "xml")], ids=["costs", "sensing", "pks"]
)
def test_the_samples_are_solved_and_verified(tmp_path, text, ending):
    problem = read(tmp_path, text, ending=ending)
    result = kabo.solve(problem)
    assert result.status == "solved"
    report = kabo.verify(problem, result.plan)
    assert report.ok, str(report)
