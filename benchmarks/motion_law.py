"""The time law of motions beside toppra: durations, processor time, pieces; and how it scales.

Random corners of a robot of seven joints, rounded by 0.05 rad. toppra knows no jerk, so it is compared twice: with the
usual limit of jerk, where its duration is a lower bound, and with one so great that both must agree.

    python benchmarks/motion_law.py [--motions 40] [--rounds 5] [--output law.json]
"""

import argparse
from collections.abc import Callable
from pathlib import Path
from time import process_time

import numpy as np
from table import Table, finish
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from kabo.motion import Blended, MotionLimits, Timed, blended, timed_path

JOINTS = 7
VELOCITY, ACCELERATION = 2.0, 8.0  # [rad/s, rad/s²]
JERKS = {"usual jerk": 160.0, "huge jerk": 2e4}  # [rad/s³]
DEVIATION = 0.05  # [rad, L2]
GRID = 60  # points of toppra's grid on each piece of the path


def main() -> None:
    """Prints a table for each limit of jerk, and one of larger problems."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motions", type=int, default=40, help="motions of each kind")
    parser.add_argument("--rounds", type=int, default=5, help="times each is computed; the least counts")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, help="a JSON file for the tables")
    options = parser.parse_args()
    tables = [_compared(name, jerk, options) for name, jerk in JERKS.items()] + [_larger(options)]
    finish(tables, options.output, motions=options.motions, rounds=options.rounds, seed=options.seed)


def _limits(jerk: float, joints: int = JOINTS) -> MotionLimits:
    return MotionLimits.of(*(np.full(joints, limit) for limit in (VELOCITY, ACCELERATION, jerk)))


def _motion(corners: np.ndarray, limits: MotionLimits, deviation: float = DEVIATION) -> Timed:
    return timed_path(corners, limits, deviation=deviation, shares=[1.0] * len(corners))


def _compared(name: str, jerk: float, options: argparse.Namespace) -> Table:
    table = Table(f"{JOINTS} joints, corners rounded by {DEVIATION} rad, {name} ({jerk:g} rad/s³); medians")
    limits = _limits(jerk)
    for count in (3, 4, 6):
        rng = np.random.default_rng([options.seed, count])
        rows = []
        for _ in range(options.motions):
            corners = rng.uniform(-1.0, 1.0, (count, JOINTS))
            path = blended(corners, DEVIATION)
            made = _motion(corners, limits)
            best = _toppra(path, limits)
            stopping = timed_path(corners, limits).duration
            own = _least(lambda corners=corners: _motion(corners, limits), options.rounds)
            peer = _least(lambda path=path: _toppra(path, limits), options.rounds)
            cells = len(made.times) - 1
            rows.append([made.duration, stopping, made.duration / best, cells, 1e3 * own, 1e3 * peer])
        middle, worst = np.median(rows, axis=0), np.max(rows, axis=0)
        table.add(
            f"{count} corners",
            seconds=middle[0],
            with_stops=middle[1],
            to_toppra=middle[2],
            to_toppra_most=worst[2],
            pieces=middle[3],
            ms=middle[4],
            toppra_ms=middle[5],
        )
    return table


def _larger(options: argparse.Namespace) -> Table:
    table = Table("larger: a spiral of a driven base, and robots of more joints; usual jerk")
    angles = np.linspace(0.0, 60.0, 2000)
    spiral = np.stack([np.cos(angles), np.sin(angles), 0.05 * angles], axis=1)
    cases = {"2,000 way points": (spiral, 1e-3)}
    for joints in (1, 14, 20):
        cases[f"{joints} joints, 6 corners"] = (
            np.random.default_rng([options.seed, joints]).uniform(-1.0, 1.0, (6, joints)),
            DEVIATION,
        )
    for name, (corners, deviation) in cases.items():
        limits = _limits(JERKS["usual jerk"], corners.shape[1])
        made = _motion(corners, limits, deviation)
        seconds = _least(lambda c=corners, d=deviation, own=limits: _motion(c, own, d), options.rounds)
        stopping = timed_path(corners, limits).duration
        pieces = len(made.times) - 1
        table.add(name, seconds=made.duration, with_stops=stopping, pieces=pieces, ms=1e3 * seconds)
    return table


def _least(run: Callable[[], object], rounds: int) -> float:
    found = []
    for _ in range(rounds):
        start = process_time()
        run()
        found.append(process_time() - start)
    return min(found)


def _toppra(path: Blended, limits: MotionLimits) -> float:
    """The duration that toppra finds for velocity and acceleration [s]."""

    class Path:
        """The path in toppra's interface."""

        dof, path_interval = path.corners.shape[1], (0.0, path.length)

        def __call__(self, places: np.ndarray, order: int = 0) -> np.ndarray:
            return path.at(places, order)

    bounds = [np.stack([-row, row], axis=1) for row in limits.rows[:2]]
    constraints = [JointVelocityConstraint(bounds[0]), JointAccelerationConstraint(bounds[1])]
    grid = np.unique([np.linspace(a, b, GRID) for a, b in zip(path.borders, path.borders[1:], strict=False)])
    speeds = TOPPRA(constraints, Path(), gridpoints=grid).compute_parameterization(0, 0)[1]
    return float((2.0 * np.diff(grid) / (speeds[1:] + speeds[:-1])).sum())


if __name__ == "__main__":
    main()
