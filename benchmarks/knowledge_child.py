"""One instance of `knowledge.py` in a process of its own: generates, solves, verifies, and prints a line for each.

    python benchmarks/knowledge_child.py '{"name": "unix-4", "repeat": 3, "timeout": 60, "memory_gb": 6}'

What is known so far is printed at once, one JSON object a line, so that a process that is stopped loses no more
than the stage it was in.
"""

import json
import resource
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

from knowledge_instances import INSTANCES, Instance
from knowledge_sizes import sizes

import kabo
from kabo.knowledge import ground
from kabo.language.problem import Problem
from kabo.plan import plan_statistics


def tell(**figures: Any) -> None:
    """Prints what is known now."""
    print(json.dumps(figures), flush=True)


def load(instance: Instance, folder: Path) -> Problem:
    """The problem, read from a file as anybody would read it."""
    path = folder / "problem.yaml"
    path.write_text(instance.text())
    return kabo.load_problem(path)


def solve(problem: Problem, instance: Instance, repeat: int, timeout: float) -> kabo.Result:
    """Solves repeatedly; tells the median of the runs after the first, and of grounding alone."""
    results, seconds, processor = [], [], []
    while len(seconds) < repeat + 1 and sum(seconds) < timeout / 2:
        began = process_time()
        results.append(kabo.solve(problem, geometry="none", timeout=timeout, **instance.options))
        processor.append(process_time() - began)
        seconds.append(float(results[-1].statistics["symbolic_s"]))
        if results[-1].plan is None:
            break
    last = results[-1]
    began = perf_counter()
    ground(problem)
    grounding = perf_counter() - began
    figures = last.statistics
    tell(
        status=last.status,
        why=None if last.reason is None else last.reason.message,
        first_s=seconds[0],
        s=median(seconds[1:] or seconds),
        processor_s=median(processor[1:] or processor),
        grounding_s=grounding,
        runs=len(seconds),
        expanded=figures.get("expanded"),
        generated=figures.get("generated"),
        peak_mb=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    )
    return last


def verify(problem: Problem, plan: kabo.Plan) -> None:
    """Tells the plan's size, and what the verifier says, which shares no code with the planner; and which judge it was."""
    figures = plan_statistics(plan)
    tell(nodes=figures.plan_nodes, actions=figures.plan_actions, leaves=figures.plan_leaves)
    began = perf_counter()
    report = kabo.verify(problem, plan, knowledge_only=True)
    worlds = None if report.worlds is None else report.worlds.worlds
    tell(verified=report.ok, judge=report.judge, worlds=worlds, verification_s=perf_counter() - began)


def run(request: Mapping[str, Any]) -> None:
    """Everything about one instance."""
    limit = int(float(request["memory_gb"]) * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    instance = next(each for each in INSTANCES if each.name == request["name"])
    with tempfile.TemporaryDirectory() as folder:
        began = perf_counter()
        problem = load(instance, Path(folder))
        tell(load_s=perf_counter() - began)
        counted = sizes(problem)
        tell(
            objects=counted.objects,
            unknown=counted.unknown_atoms,
            sensing=counted.sensing_actions,
            ground_actions=counted.ground_actions,
        )
        result = solve(problem, instance, int(request["repeat"]), float(request["timeout"]))
        if result.plan is not None:
            verify(problem, result.plan)


if __name__ == "__main__":
    run(json.loads(sys.argv[1]))
