"""Warming up: loads and compiles in a worker, before its first job, whatever requests would otherwise wait for.

A worker solves two problems that are shipped with kabo, which loads all packages, libraries and geometric kernels.
The kernels for large symbolic searches are called once separately.
"""

from pathlib import Path

import kabo
from kabo.finite_domain import (
    CompiledTask,
    Effect,
    FiniteTask,
    Operator,
    RelaxedOperator,
    RelaxedTask,
    StateVariable,
    astar,
    bfws,
    breadth_first,
)
from kabo.requests import solve_file

PROBLEMS = (
    Path("doors", "n3.yaml"),  # branches on what is sensed
    Path("stacked", "n2.yaml"),  # two blocks, a robot of meshes, tasks that pick and place
)
_LIGHTS = FiniteTask(
    (StateVariable("first light", 2), StateVariable("second light", 2)),
    (0, 0),
    tuple(Operator(f"switch {n}", (), (Effect((), n, 1),)) for n in (0, 1)),
    ((0, (1,)), (1, (1,))),
)


def plan_once() -> None:
    """Plans a small symbolic and a small geometric problem, and runs each compiled search on a task of two lights."""
    _search_once()
    for problem in (_domains() / each for each in PROBLEMS):
        if problem.is_file():
            solve_file(problem, {})


def _domains() -> Path:
    """The domains that kabo brings along: inside an installed package, or beside a checked-out one."""
    package = Path(kabo.__file__).parent
    installed = package / "data" / "domains"
    return installed if installed.is_dir() else package.parent / "domains"


def _search_once() -> None:
    for search in (bfws, breadth_first, astar):
        search(CompiledTask(_LIGHTS), plain_work=0)
    RelaxedTask(2, [RelaxedOperator((0,), (1,))], [1], engine="compiled").evaluate([0])
