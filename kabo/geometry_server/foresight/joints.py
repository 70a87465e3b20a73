"""Joint limits that keep a robot from a target: how far one joint would have to turn beyond its limit.

Each planned joint is freed by itself, for a whole turn or a metre beyond its limits, and constraints are projected anew.
Where that finds a configuration, the value of the joint is pulled back towards its limit as far as projection follows.
"""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.candidates import Stream
from kabo.geometry_server.foresight.measures import Measure, value
from kabo.kinematics import project, sample
from kabo.scene import PRISMATIC
from kabo.streams import stream_key

SAMPLES = 64  # for each joint
FREED_TURN, FREED_STROKE = np.pi, 1.0  # [rad], [m] beyond either limit
HALVINGS = 10  # of the way beyond a limit
LEAST = 1e-4  # [rad or m] beyond a limit that is worth telling


def limiting_joint(stream: Stream) -> Measure | None:
    """The joint whose limit alone keeps a stream of candidates empty, and the value nearest to it that would do.

    Of several such joints it is the one that lacks the smallest share of what it may move now. None if the stream is
    not empty, or if no single joint would do. It is found by sampling: another value might be nearer, so it proves nothing.
    """
    if stream.samples(0, SAMPLES):
        return None
    found = [short for joint in range(stream.robot.planned) if (short := _short(stream, joint)) is not None]
    best = min(found, key=lambda short: short.share, default=None)
    return None if best is None else best.measure(stream)


@dataclass(frozen=True)
class _Short:
    """A joint that would have to go beyond a limit: the limit, and the value that would do."""

    joint: int
    limit: float
    value: float
    share: float  # of its range that it lacks

    def measure(self, stream: Stream) -> Measure:
        """The numbers for users."""
        robot = stream.robot
        name = robot.joint_names[self.joint]
        unit = "m" if _is_prismatic(stream, self.joint) else "rad"
        low, high = float(robot.tree.lower[self.joint]), float(robot.tree.upper[self.joint])
        said = (
            f"{name} of {robot.name} would have to be at {value(self.value, unit)}, its limits are "
            f"{value(low, unit)} to {value(high, unit)}: {value(abs(self.value - self.limit), unit)} too little"
        )
        return Measure(f"{robot.name}.{name}", said, self.limit, self.value, unit)  # type: ignore[arg-type]


def _short(stream: Stream, joint: int) -> _Short | None:
    """How far a joint has to go beyond its limits if all others keep theirs; None if that is of no use."""
    tree = stream.robot.tree
    low, high = float(tree.lower[joint]), float(tree.upper[joint])
    beyond = FREED_STROKE if _is_prismatic(stream, joint) else FREED_TURN
    found = _freed(stream, joint, low - beyond, high + beyond)
    if not len(found):
        return None
    away = np.maximum(low - found[:, joint], found[:, joint] - high)
    best = found[int(away.argmin())]
    limit = low if best[joint] < low else high
    nearest = _pulled_back(stream, joint, best, limit)
    if abs(nearest - limit) < LEAST:
        return None
    return _Short(joint, limit, nearest, abs(nearest - limit) / max(high - low, LEAST))


def _freed(stream: Stream, joint: int, low: float, high: float) -> Array:
    """Configurations (N, n) that fulfil the stream's constraints with other limits of one joint."""
    tree, robot = stream.robot.tree, stream.robot
    lower, upper = tree.lower.copy(), tree.upper.copy()
    lower[joint], upper[joint] = low, high
    base = np.concatenate([np.zeros(robot.planned), stream.hand])
    key, active = stream_key("limit", int(stream.key), joint), np.arange(tree.size) < robot.planned
    found, valid = sample(tree, stream.rows, key, 0, SAMPLES, lower, upper, active, base=base)
    return np.asarray(found[valid])


def _pulled_back(stream: Stream, joint: int, q: Array, limit: float) -> float:
    """The value of a joint nearest to its limit that projection reaches from a configuration (n,)."""
    tree, best = stream.robot.tree, q
    active = np.arange(tree.size) < stream.robot.planned
    near, far = limit, float(q[joint])
    for _ in range(HALVINGS):
        middle = 0.5 * (near + far)
        lower, upper, seed = tree.lower.copy(), tree.upper.copy(), best.copy()
        lower[joint], upper[joint] = min(limit, middle), max(limit, middle)
        seed[joint] = middle
        pulled, valid = project(tree, stream.rows, seed, lower, upper, active, hold_limits=True)
        if valid.any():
            best = pulled[0] if pulled.ndim == 2 else pulled
            far = float(best[joint])
        else:
            near = middle
        if abs(far - near) < LEAST:
            break
    return far


def _is_prismatic(stream: Stream, joint: int) -> bool:
    tree = stream.robot.tree
    moved = np.flatnonzero((tree.source == joint) & (tree.ratio != 0.0))
    return bool(len(moved)) and int(tree.kind[moved[0]]) == PRISMATIC
