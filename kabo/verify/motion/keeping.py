"""Whether a motion constraint holds along a whole path: bisection, with a bound of how fast measures change."""

from collections.abc import Iterator, Sequence

import numpy as np

from kabo.language.scene_description import Constraint
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.constraints import Measure, Role, measures
from kabo.verify.motion.sweep import Path

DEPTH = 24  # halvings of one straight piece; a measure that then still is not proven is at its bound


class Lapse(Exception):
    """Where a constraint is not kept: time [s], which one, by how much, and whether that is only not decided."""

    def __init__(self, time: float, constraint: Constraint, measure: Measure, undecided: bool) -> None:
        self.time, self.constraint, self.measure, self.undecided = time, constraint, measure, undecided
        super().__init__(str(constraint))


Owners = dict[str, tuple[Role, Mount | None]]  # role -> its features, and where it hangs if the robot carries it


def check_kept(path: Path, constraints: Sequence[Constraint], owners: Owners) -> None:
    """Proves that constraints hold along the path of one robot to their tolerance.

    Raises:
        Lapse: one does not.
        UnknownFeatureError: one names what nobody has.
    """
    (arm,) = path.arms.values()
    for constraint in constraints:
        rates = _rates(arm, constraint, owners)
        for piece in range(len(path.steps)):
            bound = {kind: float(path.steps[piece] @ rate) for kind, rate in rates.items()}
            _prove(path, piece, constraint, owners, bound)


def _prove(path: Path, piece: int, constraint: Constraint, owners: Owners, bound: dict[str, float]) -> None:
    for end in (0.0, 1.0):
        for measure in _measured(path, piece, end, constraint, owners):
            if measure.excess > measure.tolerance:
                raise Lapse(path.time(piece, end), constraint, measure, False)
    stack = [(0.0, 1.0)]
    while stack:
        start, end = stack.pop()
        middle, half = (start + end) / 2, (end - start) / 2
        found = list(_measured(path, piece, middle, constraint, owners))
        for measure in found:
            if measure.excess > measure.tolerance:
                raise Lapse(path.time(piece, middle), constraint, measure, False)
        open_ = [m for m in found if m.excess + bound[m.kind] * half > m.tolerance]
        if open_ and half < 0.5**DEPTH:
            raise Lapse(path.time(piece, middle), constraint, open_[0], True)
        if open_:
            stack += [(middle, end), (start, middle)]


def _measured(path: Path, piece: int, share: float, constraint: Constraint, owners: Owners) -> Iterator[Measure]:
    joints = path.poses(piece, share)
    roles = {}
    for name, (role, mount) in owners.items():
        pose = role.world_T if mount is None else joints[mount.robot][mount.joint] @ mount.joint_T_body
        roles[name] = Role(role.features, pose)
    return measures(constraint, roles)


def _rates(arm: Arm, constraint: Constraint, owners: Owners) -> dict[str, np.ndarray]:
    """By how much each coordinate changes the measures at most: lengths [m/rad or m/m], angles [rad/rad or rad/m].

    A point moves with its lever arm. A moving line or plane reaches far: seen from it, the other feature moves, so
    the lever arm is the distance to that other one, which the arm's reach and its own place bound.
    """
    n = len(arm.robot.joint_names)
    length, angle = np.zeros(n), np.zeros(n)
    reaches = [_radius(arm, name.owner, name.feature, owners) for name in (constraint.first, constraint.second)]
    for name in (constraint.first, constraint.second):
        mount = owners[name.owner][1] if name.owner in owners else None
        if mount is not None:
            angle += arm.turning(mount.joint)
            length += arm.reach(mount.joint, sum(reaches), arm.chains[mount.joint])
    return {"length": length, "angle": angle}


def _radius(arm: Arm, owner: str, feature: str | None, owners: Owners) -> float:
    """How far a feature's origin can be from the joint that carries it, or from any joint if it stands [m]."""
    if owner not in owners:
        role, mount = Role({}, np.eye(4)), None
    else:
        role, mount = owners[owner]
    found = role.features.get(feature or "")
    origin = np.zeros(3) if found is None else np.asarray(found.origin)
    pose = role.world_T if mount is None else mount.joint_T_body
    place = pose[:3, :3] @ origin + pose[:3, 3]
    return float(np.linalg.norm(place)) + (arm.extent if mount is None else 0.0)
