"""Problems from text and plans from nested tuples, for tests that say exactly what a plan does."""

from pathlib import Path

from kabo.language import load_problem
from kabo.language.problem import Problem
from kabo.plan import Node, Plan, PlanBuilder

GOAL = None  # where a plan ends


def problem_of(folder: Path, domain: str, problem: str) -> Problem:
    """The problem of two texts; `domain:` and `problem:` are put in front."""
    (folder / "domain.yaml").write_text("domain: hand_made\n" + domain)
    (folder / "one.yaml").write_text("problem: one\n" + problem)
    return load_problem(folder / "one.yaml")


def do(action, then, **arguments):
    """An action."""
    return "action", action, arguments, then


def look(action, on, branches, **arguments):
    """A sensing action and what follows each outcome."""
    return "look", action, arguments, on, branches


def get(action, delivers, then, **arguments):
    """A sensing action whose result is used later."""
    return "get", action, arguments, delivers, then


def branch(on, branches):
    """Decides on what was sensed before."""
    return "branch", on, branches


def plan_of(problem: Problem, tree: object) -> Plan:
    """The plan of nested tuples; nodes are numbered breadth-first from n0."""
    builder = PlanBuilder()

    def add(tree) -> str:
        if tree is GOAL:
            return builder.goal()
        kind, *rest = tree
        if kind == "branch":
            on, branches = rest
            return builder.add(Node("branch", on=on, branches={value: add(t) for value, t in branches.items()}))
        action, arguments, *rest = rest
        if kind == "action":
            return builder.add(Node("action", action, arguments, next=add(rest[0])))
        if kind == "get":
            return builder.add(Node("sense", action, arguments, delivers=tuple(rest[0]), next=add(rest[1])))
        branches = {value: add(t) for value, t in rest[1].items()}
        return builder.add(Node("sense", action, arguments, on=rest[0], branches=branches))

    options = {"search": "by hand", "seed": 0, "epsilon": None, "geometry": "none"}
    return builder.build(add(tree), problem=problem.name, files=problem.files, options=options)
