"""The shortest displacement of a robot's base that brings a target within reach.

Three prismatic joints are put before the robot's first joint, so that projection finds displacements of the base
together with configurations that fulfil all constraints, joint limits included. The shortest displacements of many
are then shortened as far as possible. The result is an upper bound, rarely off by more than a millimetre.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.driving.floor_shortfall import floor_growth
from kabo.kinematics import project, sample
from kabo.kinematics.kernels.rows import FIRST, SECOND
from kabo.scene import PRISMATIC, Drive, KinematicTree
from kabo.streams import stream_key

BASE_SLIDES = 3
# [m] of the base's displacement along each axis, tried in this order.
BASE_RANGES = (0.03, 0.1, 0.3, 1.0, 3.0, 9.0)
RANGE_SAMPLES, SOLUTIONS_KEPT = 64, 6  # in each range, and how many of these are shortened
REFINEMENT_ROUNDS, PULL_STEPS = 3, 16  # rounds of sampling again within the best, and steps of shortening
MIN_STEP_SHARE = 1e-3  # of the displacement: smaller steps gain nothing
FIRST_SHARE = 0.9  # of the displacement, which fresh samples try first
NEGLIGIBLE_SHARE = 2e-3  # of the displacement, not worth another round


@dataclass(frozen=True)
class Shortfall:
    """The displacement `by` (x, y, z) of a robot's base in the world that brings a target within reach; its length [m]."""

    metres: float
    by: tuple[float, float, float]


def shortfall_of(stream: Stream, *, level: bool = False) -> Shortfall | None:
    """The shortest displacement found of a robot's base that makes the constraints of a stream feasible.

    Args:
        stream: the robot, the constraint rows, the gripper's values and the key of random seeds.
        level: whether the base keeps its height.

    Returns:
        A length of zero if the constraints are feasible as they are; None if no displacement was found. For a base
        that drives, the length is by how much every edge of its floor would have to move outwards.
    """
    if stream.robot.drive is not None:
        return _floor_shortfall(stream, stream.robot.drive)
    if stream.samples(0, RANGE_SAMPLES):
        return Shortfall(0.0, (0.0, 0.0, 0.0))
    base = _Base(stream, level)
    span = next((span for span in BASE_RANGES if base.look(span)), None)
    if span is None:
        return None
    for _ in range(REFINEMENT_ROUNDS):  # what was found anew, within less, may be pulled in farther
        before = base.way
        base.pull_in()
        base.look(0.9 * base.way)
        base.push_on()
        if base.way > (1.0 - NEGLIGIBLE_SHARE) * before:
            break
    x, y, z = (round(float(v), 6) + 0.0 for v in base.best[:BASE_SLIDES])
    return Shortfall(round(base.way, 6), (x, y, z))


def _floor_shortfall(stream: Stream, drive: Drive) -> Shortfall | None:
    found = floor_growth(stream, drive)
    if found is None:
        return None
    metres, pose = found
    shift = drive.world_T_floor[:3, :2] @ (pose[:2] - 0.5 * np.add(*drive.box()))
    x, y, _ = (round(float(v), 6) + 0.0 for v in shift * metres / max(float(np.linalg.norm(shift)), 1e-9))
    return Shortfall(round(metres, 6), (x, y, 0.0))


class _Base:
    """A robot on a movable base, and the solutions (N, 3 + n) found with the shortest displacements."""

    def __init__(self, stream: Stream, level: bool) -> None:
        self.tree, self.rows, self.key = gliding(stream.robot.tree), glided(stream.rows), int(stream.key)
        self.arm = np.arange(self.tree.size) < BASE_SLIDES + stream.robot.planned
        self.arm[:BASE_SLIDES] = False
        self.all = self.arm.copy()
        self.all[:BASE_SLIDES] = (True, True, not level)
        self.hand = np.concatenate([np.zeros(stream.robot.planned), stream.hand])
        self.found, self.drawn = np.empty((0, self.tree.size)), 0

    @property
    def best(self) -> Array:
        """The solution with the shortest displacement."""
        return np.asarray(self.found[0])

    @property
    def way(self) -> float:
        """The length of the shortest displacement [m]."""
        return float(np.linalg.norm(self.best[:BASE_SLIDES]))

    def look(self, span: float) -> bool:
        """Whether a sample is a solution with the base displaced by up to `span` [m] along each axis."""
        return self._sampled(self.all, np.zeros(BASE_SLIDES), span) > 0

    def push_on(self) -> None:
        """Bisects the displacement of the best solution, with fresh samples of the arm alone."""
        by, low, high = self.best[:BASE_SLIDES].copy(), 0.0, 1.0
        share = FIRST_SHARE
        while high - low > NEGLIGIBLE_SHARE:
            low, high = (low, share) if self._reaches(share * by) else (share, high)
            share = 0.5 * (low + high)

    def pull_in(self) -> None:
        """Shortens the displacement of every solution, as far as projection succeeds."""
        Q = self.found
        step = np.full(len(Q), 0.5)
        for _ in range(PULL_STEPS):
            seeds, nearer = Q.copy(), np.zeros(len(Q), dtype=np.bool_)
            seeds[:, :BASE_SLIDES] *= 1.0 - step[:, None]
            for moving in (self.arm, self.all):  # the base stays where it is pulled to, or slides aside
                pulled, valid = project(
                    self.tree, self.rows, seeds, self.tree.lower, self.tree.upper, moving, hold_limits=True
                )
                better = valid & (_ways(pulled) < _ways(Q))
                Q[better] = pulled[better]
                nearer |= better
            step = np.where(nearer, np.minimum(1.6 * step, 1.0), 0.5 * step)
            if np.all(step < MIN_STEP_SHARE):
                break
        self._keep(Q)

    def _reaches(self, by: Array) -> bool:
        """Whether a sample of the arm alone is a solution with the base displaced."""
        return self._sampled(self.arm, by, BASE_RANGES[-1]) > 0

    def _sampled(self, moving: npt.NDArray[np.bool_], by: Array, span: float) -> int:
        lower, upper = self.tree.lower.copy(), self.tree.upper.copy()
        lower[:BASE_SLIDES], upper[:BASE_SLIDES] = -span, span
        start, key = np.concatenate([by, self.hand]), stream_key("shortfall", self.key)
        Q, valid = sample(self.tree, self.rows, key, self.drawn, RANGE_SAMPLES, lower, upper, moving, base=start)
        self.drawn += RANGE_SAMPLES
        self._keep(np.concatenate([self.found, Q[valid]]))
        return int(np.count_nonzero(valid))

    def _keep(self, Q: Array) -> None:
        self.found = Q[np.argsort(_ways(Q), kind="stable")[:SOLUTIONS_KEPT]]


def gliding(tree: KinematicTree) -> KinematicTree:
    """The tree preceded by prismatic joints along x, y and z of the world, whose values come first in a configuration."""
    turns = [np.eye(3)[:, [1, 2, 0]], np.eye(3)[:, [2, 0, 1]], np.eye(3)]  # rotations that take z to x, to y, to z
    slides, before = np.zeros((BASE_SLIDES, 12)), np.eye(3)
    for row, turn in zip(slides, turns, strict=True):
        row[:9], before = (before.T @ turn).ravel(), turn
    first, rest = (
        slice(0, 1),
        slice(1, None),
    )  # joint 0 is the world; the last slide stands upright as the world does
    return KinematicTree(
        np.concatenate([[0, 0, 1, 2], tree.parent[rest] + BASE_SLIDES]),
        np.concatenate([tree.kind[first], [PRISMATIC] * BASE_SLIDES, tree.kind[rest]]),
        np.concatenate([[0, 0, 1, 2], tree.source[rest] + BASE_SLIDES]),
        np.concatenate([tree.ratio[first], np.ones(BASE_SLIDES), tree.ratio[rest]]),
        np.concatenate([tree.shift[first], np.zeros(BASE_SLIDES), tree.shift[rest]]),
        np.concatenate([tree.placement[first], slides, tree.placement[rest]]),
        np.concatenate([np.full(BASE_SLIDES, -BASE_RANGES[-1]), tree.lower]),
        np.concatenate([np.full(BASE_SLIDES, BASE_RANGES[-1]), tree.upper]),
        np.concatenate([np.ones(BASE_SLIDES), tree.velocity]),
    )


def glided(rows: Array) -> Array:
    """The rows with their joint numbers adapted to the tree of `gliding`; features fixed in the world stay fixed."""
    moved: Array = rows.copy()
    for column in (FIRST, SECOND):
        moved[:, column] += BASE_SLIDES * (rows[:, column] > 0)
    return moved


def _ways(Q: Array) -> Array:
    return np.asarray(np.linalg.norm(Q[:, :BASE_SLIDES], axis=1))
