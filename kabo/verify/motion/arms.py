"""A robot as the verifier sees it: poses by pinocchio, and bounds of how far its parts move, derived here independently.

When coordinates change by dq, a point attached to joint k moves at most by the sum over the joints j from the base to k
of |dq_j| times the greatest distance of the point from joint j (1 for a prismatic joint).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.scene import Robot


@dataclass(frozen=True)
class Mount:
    """The attachment of a body to a robot: pinocchio's joint (0: the base) and the body's pose in the joint's frame."""

    joint: int
    joint_T_body: Array  # (4, 4)
    robot: str = ""

    def carrying(self, body_T_other: Array) -> "Mount":
        """The mount of a second body, given its pose (4, 4) in the frame of the body mounted here."""
        return Mount(self.joint, self.joint_T_body @ body_T_other, self.robot)


class Arm:
    """Poses and motion bounds of one robot of the scene."""

    def __init__(self, robot: Robot) -> None:
        import pinocchio

        self.robot = robot
        self._pinocchio = pinocchio
        self._model, self._data = robot.model, robot.model.createData()
        self.mounts = {
            frame.name: Mount(int(frame.parentJoint), np.array(frame.placement.homogeneous), robot.name)
            for frame in self._model.frames
            if frame.type == pinocchio.FrameType.BODY and frame.name in robot.links
        }
        count = self._model.njoints
        self.parents = [int(self._model.parents[j]) for j in range(count)]
        self.revolute = [not self._model.joints[j].shortname().startswith("JointModelP") for j in range(count)]
        self.chains = [self._chain(j) for j in range(count)]
        self._offsets = [self._offset(j) for j in range(count)]
        self._reaches: dict[tuple[int, float, frozenset[int]], Array] = {}
        # The indices of coordinates in pinocchio's configuration, which has cosine and sine of continuous joints.
        joints = [self._model.joints[j] for j in range(1, count)]
        self._endless = [(j.idx_q, k) for k, j in enumerate(joints) if j.nq == 2]
        self._simple = np.array([(j.idx_q, k) for k, j in enumerate(joints) if j.nq == 1], dtype=int).reshape(
            -1, 2
        )

    def _chain(self, joint: int) -> frozenset[int]:
        """The joints from the base to this one, which all move a body attached to it."""
        result = set()
        while joint > 0:
            if self.robot.actuation.ratio[joint] != 0.0:
                result.add(joint)
            joint = self.parents[joint]
        return frozenset(result)

    def _offset(self, joint: int) -> float:
        """The greatest distance of a joint's origin from that of its parent [m]."""
        if joint == 0:
            return 0.0
        offset = float(np.linalg.norm(self._model.jointPlacements[joint].translation))
        if self.revolute[joint]:
            return offset
        actuation, i = self.robot.actuation, self.robot.actuation.source[joint]
        ends = np.array([self.robot.tree.lower[i], self.robot.tree.upper[i]])
        travel = np.abs(actuation.ratio[joint] * ends + actuation.shift[joint]).max()
        return offset + float(travel)

    @property
    def extent(self) -> float:
        """The greatest distance of any joint from the world's origin [m]."""
        return sum(self._offsets)

    def joint_poses(self, q: Sequence[float]) -> Array:
        """The poses world_T_joint (J, 4, 4) of pinocchio's joints; joint 0 is the world."""
        self._pinocchio.forwardKinematics(self._model, self._data, self._expanded(np.asarray(q)))
        return np.array([placement.homogeneous for placement in self._data.oMi])

    def _expanded(self, q: Array) -> Array:
        """Pinocchio's configuration for the coordinates q."""
        actuation = self.robot.actuation
        values = np.asarray(actuation.ratio)[1:] * q[list(actuation.source[1:])] + np.asarray(actuation.shift)[1:]
        result = np.zeros(self._model.nq)
        result[self._simple[:, 0]] = values[self._simple[:, 1]]
        for place, k in self._endless:
            result[place : place + 2] = np.cos(values[k]), np.sin(values[k])
        return result

    def pose(self, q: Sequence[float], mount: Mount) -> Array:
        """The pose (4, 4) of a mounted body in the world."""
        result: Array = self.joint_poses(q)[mount.joint] @ mount.joint_T_body
        return result

    def reach(self, joint: int, radius: float, joints: frozenset[int]) -> Array:
        """For each coordinate (n,), the most that a point moves when the coordinate changes by 1 [m/rad or m/m].

        Args:
            joint: the joint to which the point is attached.
            radius: the point's distance from that joint's origin [m].
            joints: the joints that may move; the other joints are assumed to stand still.
        """
        key = joint, radius, joints
        if key not in self._reaches:
            self._reaches[key] = self._reach(joint, radius, joints)
        return self._reaches[key]

    def _reach(self, joint: int, lever: float, joints: frozenset[int]) -> Array:
        result = np.zeros(len(self.robot.joint_names))
        while joint > 0:
            if joint in joints:
                actuation = self.robot.actuation
                share = abs(actuation.ratio[joint]) * (lever if self.revolute[joint] else 1.0)
                result[actuation.source[joint]] += share
            lever += self._offsets[joint]
            joint = self.parents[joint]
        return result

    def levers(self, joint: int, radius: float) -> list[tuple[int, float]]:
        """The moving joints that carry a point, from the base on, and how far it may be from each [m].

        `radius`: the distance of the point from the joint to which it is attached [m].
        """
        found = []
        while joint > 0:
            if self.robot.actuation.ratio[joint] != 0.0:
                found.append((joint, radius))
            radius += self._offsets[joint]
            joint = self.parents[joint]
        return found[::-1]

    def accelerations(self, mount: Mount, q: Array, speed: Array, rate: Array) -> Array:
        """The acceleration (3,) in the world of a mounted body's origin [m/s2], at velocities and accelerations (n,)."""
        actuation, count = self.robot.actuation, self._model.njoints
        ratios, sources = np.asarray(actuation.ratio)[1:count], list(actuation.source[1:count])
        own = [(np.asarray(ratios * values[sources])) for values in (speed, rate)]
        rows = np.zeros((2, self._model.nv))
        rows[:, [self._model.joints[j].idx_v for j in range(1, count)]] = own
        self._pinocchio.forwardKinematics(self._model, self._data, self._expanded(q), *rows)
        velocity, change = self._data.v[mount.joint], self._data.a[mount.joint]
        place, turn = mount.joint_T_body[:3, 3], velocity.angular
        there = velocity.linear + np.cross(turn, place)
        local = change.linear + np.cross(change.angular, place) + np.cross(turn, there)
        return np.asarray(self._data.oMi[mount.joint].rotation @ local)

    def turning(self, joint: int) -> Array:
        """For each coordinate (n,), the most that a body at a joint rotates per unit [rad/rad or rad/m]."""
        result = np.zeros(len(self.robot.joint_names))
        for j in self.chains[joint]:
            if self.revolute[j]:
                result[self.robot.actuation.source[j]] += abs(self.robot.actuation.ratio[j])
        return result
