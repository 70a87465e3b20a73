"""Proves that a constraint holds along a whole path, by bisection with bounds of how fast its measures change."""

from collections.abc import Iterator, Sequence

import numpy as np

from kabo.language.scene_description import Constraint
from kabo.verify.motion.arms import Arm, Mount
from kabo.verify.motion.constraints import Measure, Role, measures
from kabo.verify.motion.sweep import Path

MAX_HALVINGS = 24  # of one straight piece; a measure that is not proven then is at its bound


class ConstraintViolation(Exception):
    """A constraint is violated, or could not be proven to hold (`undecided`), at a time [s] of the path."""

    def __init__(self, time: float, constraint: Constraint, measure: Measure, undecided: bool) -> None:
        self.time, self.constraint, self.measure, self.undecided = time, constraint, measure, undecided
        super().__init__(str(constraint))


Owners = dict[
    str, tuple[Role, Mount | None]
]  # role -> its body, and the mount of the body if the robot carries it


def check_path_constraints(path: Path, constraints: Sequence[Constraint], owners: Owners) -> None:
    """Proves that constraints hold, within their tolerance, along the whole path of one robot.

    Raises:
        ConstraintViolation: a constraint is violated, or its proof did not succeed.
        UnknownFeatureError: a constraint names a role or feature that does not exist.
    """
    (arm,) = path.arms.values()
    for constraint in constraints:
        rates = _rates(arm, constraint, owners)
        for piece in range(len(path.steps)):
            bound = {kind: float(path.steps[piece] @ rate) for kind, rate in rates.items()}
            stray = {kind: float(path.deviations[piece] @ rate) for kind, rate in rates.items()}
            _prove(path, piece, constraint, owners, bound, stray)


def _prove(
    path: Path,
    piece: int,
    constraint: Constraint,
    owners: Owners,
    bound: dict[str, float],
    stray: dict[str, float],
) -> None:
    """Proves a constraint on one piece, whose measures change by `bound`, and by `stray` beside the path."""
    for end in (0.0, 1.0):
        for measure in _measured(path, piece, end, constraint, owners):
            if measure.excess > measure.tolerance:
                raise ConstraintViolation(path.time(piece, end), constraint, measure, False)
    stack = [(0.0, 1.0)]
    while stack:
        start, end = stack.pop()
        middle, half = (start + end) / 2, (end - start) / 2
        found = list(_measured(path, piece, middle, constraint, owners))
        for measure in found:
            if measure.excess > measure.tolerance:
                raise ConstraintViolation(path.time(piece, middle), constraint, measure, False)
        open_ = [m for m in found if m.excess + bound[m.kind] * half + stray[m.kind] > m.tolerance]
        if open_ and half < 0.5**MAX_HALVINGS:
            raise ConstraintViolation(path.time(piece, middle), constraint, open_[0], True)
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
    """The most that each coordinate changes the measures: lengths [m/rad or m/m], angles [rad/rad or rad/m].

    A moving point has its own lever arm. For a moving line or plane, the other feature moves as seen from it, so the
    lever arm is the distance to that feature, which the arm's reach and the feature's position bound.
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
    """The greatest distance of a feature's origin from the joint that carries it, or from any joint if it stands [m]."""
    if owner not in owners:
        role, mount = Role({}, np.eye(4)), None
    else:
        role, mount = owners[owner]
    found = role.features.get(feature or "")
    origin = np.zeros(3) if found is None else np.asarray(found.origin)
    pose = role.world_T if mount is None else mount.joint_T_body
    place = pose[:3, :3] @ origin + pose[:3, 3]
    return float(np.linalg.norm(place)) + (arm.extent if mount is None else 0.0)
