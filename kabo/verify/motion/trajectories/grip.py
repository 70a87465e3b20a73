"""Proves that what a hand holds does not slip: mass * |acceleration - gravity| <= friction * force, at all times.

The acceleration of the held body's origin is exact at stations (pinocchio). Between two of them it differs from the
chord by no more than h^2 / 8 times the fourth derivative of the position, which the derivatives of the joints bound: a
partial derivative by several joints is at most the distance of the origin from the last of them that turns, and
Faa di Bruno's formula counts the terms. Stations are added until every interval is decided.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.trajectories.curves import Curve, derived
from kabo.verify.motion.trajectories.extremes import LIMIT_TOLERANCE
from kabo.verify.motion.trajectories.figures import TrajectoryFigures
from kabo.verify.report import Finding
from kabo.verify.trajectory_report import LimitUse

GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s2]
FIRST_STEP = 0.05  # [s] at most between the first stations
MAX_HALVINGS, MAX_OPEN = (
    22,
    20_000,
)  # of the time between them, intervals at once; what is not decided then is too much
SHARE_ACCURACY = 1e-3  # within which the greatest share of the force is told


def check_grip(
    node: str,
    number: int,
    segment: Segment,
    curve: Curve,
    world: SceneModel,
    holding: AttachmentTree,
    figures: TrajectoryFigures,
) -> Iterator[Finding]:
    """A finding for each body that a segment's arm holds and that its gripper's force does not hold all the time."""
    arm = world.arms[segment.robot]
    gripper = arm.robot.gripper
    if gripper is None or gripper.force is None or segment.joints != arm.robot.planned_joints:
        return
    most = gripper.friction * gripper.force
    for name in holding.carried(segment.robot):
        mass = sum(world.scene.bodies[each].mass or 0.0 for each in holding.group(name))
        mount = holding.mount(name)
        if holding.root(name) != name or mass == 0.0 or mount is None:
            continue
        carried = _Carried(arm, mount, curve, holding.q[segment.robot], _columns(segment, arm))
        share, time, sure = carried.greatest(most / mass, figures.share("grip"))
        figures.use(LimitUse("grip", share, share * most, most, name, node, time))
        if share > 1.0 + LIMIT_TOLERANCE:
            text = f"segment {number}: {name} needs {share * most:.4g} N to be held"
            text += "" if sure else ", or cannot be decided"
            text += f", friction times force of {segment.robot}'s gripper is {most:.4g} N"
            yield Finding(node, text, time, (segment.robot, name), (share - 1.0) * most)


def _columns(segment: Segment, arm: Arm) -> list[int]:
    return [arm.robot.joint_names.index(joint) for joint in segment.joints]


@dataclass(frozen=True)
class _Carried:
    """A body on an arm that follows a curve; `still` (n,) are the values of the joints beside its `columns`."""

    arm: Arm
    mount: Mount
    curve: Curve
    still: Array
    columns: list[int]

    def greatest(self, limit: float, known: float) -> tuple[float, float, bool]:
        """The greatest of |acceleration - gravity| / limit, when, and whether it is reached (or only not excluded).

        It is exact within `SHARE_ACCURACY` if it exceeds `known`.
        """
        times = self._first_stations()
        starts, ends = times[:-1], times[1:]
        shares = self._shares(times, limit)
        at = shares[:-1], shares[1:]
        best, when = float(shares.max()), float(times[shares.argmax()])
        for _ in range(MAX_HALVINGS):
            bounds = np.maximum(*at) + (ends - starts) ** 2 / 8.0 * self._snaps(starts, ends) / limit
            open_ = bounds > max(best, known) * (1.0 + SHARE_ACCURACY)
            if best <= 1.0 + LIMIT_TOLERANCE:
                open_ |= bounds > 1.0 + LIMIT_TOLERANCE
            if not open_.any():
                return best, when, True
            if open_.sum() > MAX_OPEN:
                break
            middles = (starts[open_] + ends[open_]) / 2
            there = self._shares(middles, limit)
            if there.max() > best:
                best, when = float(there.max()), float(middles[there.argmax()])
            at = np.concatenate([at[0][open_], there]), np.concatenate([there, at[1][open_]])
            starts, ends = np.concatenate([starts[open_], middles]), np.concatenate([middles, ends[open_]])
        bounds = np.maximum(*at) + (ends - starts) ** 2 / 8.0 * self._snaps(starts, ends) / limit
        worst = int(bounds.argmax())
        if best > 1.0 + LIMIT_TOLERANCE or bounds[worst] <= 1.0 + LIMIT_TOLERANCE:
            return best, when, True
        return float(bounds[worst]), float(starts[worst]), False

    def _first_stations(self) -> Array:
        counts = np.maximum(1, np.ceil(np.diff(self.curve.times) / FIRST_STEP)).astype(int)
        cut = [
            a + np.arange(n) / n * (b - a)
            for a, b, n in zip(self.curve.times, self.curve.times[1:], counts, strict=False)
        ]
        return np.concatenate([*cut, self.curve.times[-1:]])

    def _shares(self, times: Array, limit: float) -> Array:
        """|acceleration - gravity| / limit at times (T,)."""
        rows = [np.zeros((len(times), len(self.still))) for _ in range(3)]
        rows[0][:] = self.still
        for order, row in enumerate(rows):
            row[:, self.columns] = self.curve.at(times, order)
        found = [self.arm.accelerations(self.mount, *each) - GRAVITY for each in zip(*rows, strict=True)]
        return np.asarray(np.linalg.norm(found, axis=1) / limit)

    def _snaps(self, starts: Array, ends: Array) -> Array:
        """Bounds of the fourth derivative of the body's position on intervals (T,) [m/s4]."""
        sizes = np.zeros((4, len(starts), len(self.still)))
        powers = self.curve.powers
        for own in sizes:
            powers = derived(powers)
            own[:, self.columns] = np.abs(Curve(self.curve.times, powers).between(starts, ends)).max(axis=2)
        actuation, total = self.arm.robot.actuation, np.zeros(len(starts))
        before = np.zeros((4, len(starts)))  # sums over the joints that turn, from the base on
        for joint, lever in self.arm.levers(
            self.mount.joint, float(np.linalg.norm(self.mount.joint_T_body[:3, 3]))
        ):
            own = abs(actuation.ratio[joint]) * sizes[:, :, actuation.source[joint]]
            if self.arm.revolute[joint]:
                total += lever * (_fourth(*(before + own)) - _fourth(*before))
                before = before + own
            else:
                total += _fourth_once(*before, *own)
        return total


def _fourth(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Faa di Bruno's sum for the fourth derivative, of first to fourth derivatives."""
    return np.asarray(d + 4.0 * a * c + 3.0 * b * b + 6.0 * a * a * b + a**4)


def _fourth_once(a, b, c, d, a1, b1, c1, d1) -> Array:  # type: ignore[no-untyped-def]
    """The part of this sum that is linear in another joint's derivatives a1 to d1."""
    return np.asarray(
        d1 + 4.0 * (a * c1 + a1 * c) + 6.0 * b * b1 + 12.0 * a * a1 * b + 6.0 * a * a * b1 + 4.0 * a**3 * a1
    )
