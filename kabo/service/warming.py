"""Warming up: loads and compiles in a worker, before its first job, whatever requests would otherwise wait for.

A worker solves problems that are shipped with kabo, which loads all packages, libraries and geometric kernels.
The kernels for large symbolic searches are called once separately.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import kabo
from kabo.children import made_in_children
from kabo.compilation import note_compiled
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
from kabo.geometry import enclosing_parts
from kabo.meshes import Mesh
from kabo.motion import MotionLimits, timed_path
from kabo.requests import solve_file

PROBLEMS = (
    Path("doors", "n3.yaml"),  # branches on what is sensed
    Path("stacked", "n2.yaml"),  # two blocks, a robot of meshes, tasks that pick and place
    Path("assembly", "gearbox.yaml"),  # two arms, which draw configurations, and bodies near each other
    Path("force_sensing", "n1.yaml"),  # an arm that keeps a cup upright
    Path("bartender", "four_bottles.yaml"),  # an arm whose inverse kinematics has a closed form
)
_LIGHTS = FiniteTask(
    (StateVariable("first light", 2), StateVariable("second light", 2)),
    (0, 0),
    tuple(Operator(f"switch {n}", (), (Effect((), n, 1),)) for n in (0, 1)),
    ((0, (1,)), (1, (1,))),
)


def compile_usual() -> None:
    """Compiles the kernels that planning needs, in two processes, and records that they are.

    What one of them has compiled the other one finds; at first they need no kernel in common.

    Raises:
        KaboError: a process died.
    """
    for _, made in made_in_children((_solve_once, _call_once), 2):
        if isinstance(made, Exception):
            raise made
    note_compiled()


def plan_once() -> None:
    """Plans small problems, symbolic and geometric ones, and runs each compiled search on a task of two lights."""
    _call_once()
    _solve_once()


def _solve_once() -> None:
    for problem in (_domains() / each for each in PROBLEMS):
        if problem.is_file():
            solve_file(problem, {})


def _call_once() -> None:
    """Calls rooms that know nothing of collisions: searches, bounding, time laws."""
    _search_once()
    prepare_once()
    corners, ones = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), np.ones(2)
    timed_path(corners, MotionLimits(ones, ones, ones), deviation=0.2, shares=np.ones(3))


def prepare_once() -> None:
    """Makes the convex parts of a small body that needs several, whatever is stored."""
    with TemporaryDirectory() as folder:
        enclosing_parts(Mesh(_CORNERS, _FACES), 0.01, cache=Path(folder))


def _domains() -> Path:
    """The domains that kabo brings along: inside an installed package, or beside a checked-out one."""
    package = Path(kabo.__file__).parent
    installed = package / "data" / "domains"
    return installed if installed.is_dir() else package.parent / "domains"


# An angle of two plates: six corners below, six above.
_OUTLINE = ((0.0, 0.0), (0.5, 0.0), (0.5, 0.1), (0.1, 0.1), (0.1, 0.5), (0.0, 0.5))
_CORNERS = np.array([(x, y, z) for z in (0.0, 0.1) for x, y in _OUTLINE])
_LID = ((0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5))
_FACES = np.array(
    [(c, b, a) for a, b, c in _LID]
    + [(a + 6, b + 6, c + 6) for a, b, c in _LID]
    + [side for i in range(6) for j in ((i + 1) % 6,) for side in ((i, j, j + 6), (i, j + 6, i + 6))]
)


def _search_once() -> None:
    for search in (bfws, breadth_first, astar):
        search(CompiledTask(_LIGHTS), plain_work=0)
    RelaxedTask(2, [RelaxedOperator((0,), (1,))], [1], engine="compiled").evaluate([0])
