"""The mean number of actions in drawn worlds, by the executor without motions, beside what `kabo verify` computes.

What a plan asks is true in half of the worlds, independently: so problems are taken in which every combination is possible.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from table import Table

import kabo
from kabo.execution import KnownTruth, execute
from kabo.plan import Plan

ROOT = Path(__file__).resolve().parent.parent
PROBLEMS = (
    "domains/force_sensing/n2.yaml",
    "domains/bartender/four_bottles.yaml",
    "examples/execution/problem.yaml",
)


def worlds(options: argparse.Namespace) -> Table:
    """A row for each problem."""
    table = Table("Actions in drawn worlds")
    for path in (ROOT / name for name in options.problems or PROBLEMS):
        problem = kabo.load_problem(path)
        plan = kabo.solve(problem).plan
        report = None if plan is None else kabo.verify(problem, plan, knowledge_only=True).worlds
        if plan is None or report is None:
            table.add(problem.name, verified="no plan that worlds can judge")
            continue
        reached, mean = walked(plan, options.worlds)
        off = mean / report.mean - 1.0
        table.add(problem.name, worlds=options.worlds, goals=reached, mean=mean, verified=report.mean, off=off)
    return table


def walked(plan: Plan, count: int) -> tuple[int, float]:
    """How many of so many worlds end at a goal, and the mean number of actions."""
    still = replace(plan, nodes={n: replace(node, motion=()) for n, node in plan.nodes.items()}, certificate=None)
    reached = actions = 0
    for seed in range(count):
        run = execute(still, None, None, KnownTruth(seed=seed))
        reached += run.reached_goal
        actions += sum(plan.nodes[name].kind in ("action", "sense") for name, _ in run.history)
    return reached, actions / count
