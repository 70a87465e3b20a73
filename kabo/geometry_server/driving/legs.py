"""Long ways of a robot whose base drives: the arm folds, the base drives, the arm reaches out, each found on its own.

A path search over all joints at once has twice the dimensions; three searches over the arm's or the base's joints alone
find most ways that there are. Where they find none, all joints are searched together.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise

import numpy as np

from kabo.arrays import Array
from kabo.scene import BASE_VALUES, Robot
from kabo.ways import NoPath

LEG_SAMPLES_SHARE, LEAST_LEG_SAMPLES = 0.25, 150  # of the samples of a whole search, for one leg, and at least
MIN_TRAVEL = 0.5  # [m] of a drive from which on a robot folds its arm, where the scene says how

Find = Callable[[Array, Array, Array, Array, bool], "Array | NoPath"]


def by_legs(robot: Robot, start: Array, goal: Array, find: Find, holds: Callable[[Array], bool]) -> list[Array]:
    """The paths (m, n) of the legs from start to goal (n,), planned values only; empty if they are not found.

    Args:
        robot: a robot that drives.
        start, goal: values of its planned joints.
        find: finds a path between two configurations within bounds; the last argument says whether only the base moves.
        holds: whether a configuration keeps the constraint of the motion.
    """
    for arm in _arms(robot, start, goal):
        corners = [
            start,
            np.concatenate([start[:BASE_VALUES], arm]),
            np.concatenate([goal[:BASE_VALUES], arm]),
            goal,
        ]
        if not all(holds(q) for q in corners[1:3]):
            continue
        ways: list[Array] = []
        for number, (here, there) in enumerate(pairwise(corners)):
            if np.array_equal(here, there):
                continue
            found = find(here, there, *_bounds(robot, here, number == 1), number == 1)
            if isinstance(found, NoPath):
                break
            ways.append(found)
        else:
            return ways
    return []


def travels(robot: Robot, start: Array, goal: Array) -> bool:
    """Whether the robot has a configuration to travel in, and the drive from start to goal is long enough for it."""
    drive = robot.drive
    far = float(np.linalg.norm((goal - start)[:2]))
    return drive is not None and drive.travel is not None and far >= MIN_TRAVEL


def _arms(robot: Robot, start: Array, goal: Array) -> Iterator[Array]:
    """Values of the arm while the base drives, in the order in which they are tried."""
    assert robot.drive is not None
    given = [] if robot.drive.travel is None else [np.array(robot.drive.travel)]
    home = robot.configurations.get("home")
    given += [start[BASE_VALUES:], goal[BASE_VALUES:]]
    given += [] if home is None else [np.array(home[BASE_VALUES:])]
    for number, arm in enumerate(given):
        if not any(np.array_equal(arm, other) for other in given[:number]):
            yield arm


def _bounds(robot: Robot, here: Array, drives: bool) -> tuple[Array, Array]:
    """The limits of the planned joints, of which the arm's, or the base's, stand."""
    n = robot.planned
    low, high = robot.tree.lower[:n].copy(), robot.tree.upper[:n].copy()
    still = slice(BASE_VALUES, n) if drives else slice(0, BASE_VALUES)
    low[still], high[still] = here[still], here[still]
    return low, high
