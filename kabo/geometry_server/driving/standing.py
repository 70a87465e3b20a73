"""Where a robot's base may stand to reach a target: places from which the arm is known to reach such a pose.

A table of arm configurations, drawn once, says which poses the arm reaches from a base at zero. A pose of the hand
needs an entry of about the same height and tilt; the entry then tells where the base must be, and is the seed of the
arm's inverse kinematics [Zacharias et al. 2007; Vahrenkamp et al. 2013].
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.geometry import FixedGroup, MovingGroup
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.kinematics import FREE_BODY, joint_poses, sample, seeds
from kabo.kinematics.kernels import rows as columns
from kabo.scene import BASE_VALUES, Drive, Robot
from kabo.scene.transforms import flat
from kabo.streams import stream_key

ARMS_DRAWN = 32768  # of which those that do not collide with the robot itself are kept
NEAREST, TRIED = 32, 16  # entries most like a pose, and how many of them are tried for it, evenly spread
HEIGHT_SCALE = 0.1  # [m] of height that counts as much as TILT_SCALE [rad] of tilt
TILT_SCALE = 0.2


class Standing:
    """The places where the base of one robot may stand: on its floor, clear of everything that never moves."""

    def __init__(self, surroundings: SceneSurroundings, robot: Robot, drive: Drive) -> None:
        self.surroundings, self.robot, self.drive = surroundings, robot, drive
        self._obstacles = self._view()
        self._arms: Array | None = None
        self._tables: dict[int, tuple[Array, Array, Any]] = {}

    def free(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Which of the base's poses (N, 3) are on the floor and clear of all bodies that never move (N,)."""
        inside = self.drive.outside(poses) <= 0.0
        low, high = self.robot.tree.lower[:BASE_VALUES], self.robot.tree.upper[:BASE_VALUES]
        inside &= np.all((poses >= low) & (poses <= high), axis=1)
        chosen = np.flatnonzero(inside)
        if self._obstacles is not None and len(chosen):
            q = np.tile(np.clip(0.0, self.robot.tree.lower, self.robot.tree.upper), (len(chosen), 1))
            q[:, :BASE_VALUES] = poses[chosen]
            inside[chosen] = self._obstacles.configurations_hit(q) < 0
        return np.asarray(inside)

    def starts(
        self, rows: Array, along: Array | None, key: np.uint64, first: int, count: int, hand: tuple[float, ...]
    ) -> tuple[Array, npt.NDArray[np.bool_]] | None:
        """Configurations (count, n) to project the arm from, the base standing, and for which a place was found (count,).

        Row i depends on (key, first + i) only. None if the rows do not speak of one joint of the arm and the world.

        Args:
            rows, along: constraint rows, and rows that spread the samples, as for `sample`.
            key: the key of the stream.
            first, count: the index of the first sample, and how many.
            hand: the values of the gripper's joints.
        """
        joint = _only_joint(rows, along)
        if joint is None or not self._is_carried(joint):
            return None
        goals, valid = self._goals(rows, along, key, first, count)
        arms, entries, _ = self._table(joint)
        near = self._nearest(joint, goals)
        spread = np.argsort(
            seeds(np.zeros(NEAREST), np.ones(NEAREST), stream_key("stand", int(key)), first, count)
        )
        tried = np.take_along_axis(near, spread[:, :TRIED] % near.shape[1], axis=1)
        poses = _base_poses(self.drive, goals, entries[tried], self._turns())
        free = self.free(poses.reshape(-1, BASE_VALUES)).reshape(count, -1)
        chosen = free.argmax(axis=1)
        every = np.arange(count)
        found = np.empty((count, self.robot.tree.size))
        found[:, :BASE_VALUES] = poses[every, chosen]
        found[:, BASE_VALUES : self.robot.planned] = arms[tried[every, chosen]]
        found[:, self.robot.planned :] = hand
        return found, valid & free.any(axis=1)

    def _goals(
        self, rows: Array, along: Array | None, key: np.uint64, first: int, count: int
    ) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Poses (count, 12) of the hand's joint that fulfil the rows, as if the hand flew, and which are valid (count,)."""
        n = FREE_BODY.size
        flying = [_of_free_body(rows)] + ([] if along is None else [_of_free_body(along)])
        low, high = FREE_BODY.lower.copy(), FREE_BODY.upper.copy()
        corners = self._around()
        low[:3], high[:3] = np.maximum(low[:3], corners.min(axis=0)), np.minimum(high[:3], corners.max(axis=0))
        free = None if along is None else flying[1]
        found, valid = sample(FREE_BODY, flying[0], key, first, count, low, high, np.ones(n, np.bool_), free)
        return joint_poses(FREE_BODY, n, found), valid

    def _around(self) -> Array:
        """Two corners (2, 3) of a box about all that the robot may reach from its floor."""
        middle = self.drive.world_T_floor[:3, 3]
        size = np.abs(self.drive.offsets).max() + self.drive.radius + 3.0
        return np.array([middle - size, middle + size])

    def _turns(self) -> float:
        """The yaw that a base's turn is nearest to: that of home."""
        home = self.robot.configurations.get("home")
        return 0.0 if home is None else float(home[BASE_VALUES - 1])

    def _nearest(self, joint: int, goals: Array) -> npt.NDArray[np.int64]:
        """The entries (N, NEAREST) whose heights and tilts are most like those of poses (N, 12), by their number."""
        _, entries, tree = self._table(joint)
        near = tree.query(_features(goals), k=min(NEAREST, len(entries)))[1]
        return np.sort(np.asarray(near, np.int64), axis=1)

    def _table(self, joint: int) -> tuple[Array, Array, Any]:
        """Values of the arm (K, m), and the poses (K, 12) of a joint in the floor's frame at these, the base at zero.

        Besides, a tree of the features of these poses.
        """
        from scipy.spatial import cKDTree

        if joint not in self._tables:
            q = self._free_arms()
            poses = joint_poses(self.robot.tree, joint, q)
            turn, place = self.drive.world_T_floor[:3, :3], self.drive.world_T_floor[:3, 3]
            local = np.empty_like(poses)
            local[:, :9] = (turn.T @ poses[:, :9].reshape(-1, 3, 3)).reshape(-1, 9)
            local[:, 9:] = (poses[:, 9:] - place) @ turn
            self._tables[joint] = q[:, BASE_VALUES : self.robot.planned], local, cKDTree(_features(local))
        return self._tables[joint]

    def _free_arms(self) -> Array:
        """Configurations (K, n) with the base at zero and the hand open in which the robot does not collide with itself."""
        if self._arms is None:
            robot = self.robot
            low, high = robot.tree.lower.copy(), robot.tree.upper.copy()
            stand = np.clip(0.0, low, high)
            opened = {} if robot.gripper is None else robot.gripper.open
            for name, value in opened.items():
                stand[robot.joint_names.index(name)] = value
            low[~robot.arm], high[~robot.arm] = stand[~robot.arm], stand[~robot.arm]
            drawn = seeds(low, high, stream_key("arms", robot.name), 0, ARMS_DRAWN)
            drawn[:, :BASE_VALUES] = 0.0
            itself = self._itself()
            kept = drawn if itself is None else drawn[itself.configurations_hit(drawn) < 0]
            self._arms = kept if len(kept) >= NEAREST else drawn
        return self._arms

    def _is_carried(self, joint: int) -> bool:
        """Whether the arm carries a joint: the base's joints do not count."""
        while joint > self.drive.joint:
            joint = int(self.robot.tree.parent[joint])
        return joint == self.drive.joint

    # ------------------------------------------------------------------------------------------------ obstacles
    def _view(self) -> Any:
        links = [name for name in self.drive.links if self.robot.links[name].mesh is not None]
        moving = [self._group(name) for name in links]
        names = [f"{self.robot.name}.{name}" for name in links]
        fixed, others = [], []
        for name, pose in self.surroundings.scene.fixed_poses.items():
            body = self.surroundings.scene.bodies[name]
            arrays = body.mesh.vertices, body.mesh.faces
            enclosure = self.surroundings.enclosure(name)
            fixed.append(FixedGroup(flat(pose), enclosure, arrays, body.elements))
            others.append(name)
        apart = self.surroundings.never_collide
        pairs = [
            (i, len(moving) + k) for i, a in enumerate(names) for k, b in enumerate(others) if not apart(a, b)
        ]
        if not pairs:
            return None
        return self.surroundings.checker(self.robot.tree, moving, fixed, np.array(pairs, np.int64))

    def _itself(self) -> Any:
        names = [name for name, link in self.robot.links.items() if link.mesh is not None]
        moving = [self._group(name) for name in names]
        apart, own = self.surroundings.never_collide, self.robot.name
        pairs = [
            (i, k)
            for i, a in enumerate(names)
            for k, b in enumerate(names[i + 1 :], i + 1)
            if moving[i].joint != moving[k].joint and not apart(f"{own}.{a}", f"{own}.{b}")
        ]
        if not pairs:
            return None
        return self.surroundings.checker(self.robot.tree, moving, [], np.array(pairs, np.int64))

    def _group(self, link: str) -> MovingGroup:
        own = self.robot.links[link]
        assert own.mesh is not None
        enclosure = self.surroundings.enclosure(f"{self.robot.name}.{link}")
        arrays = own.mesh.vertices, own.mesh.faces
        return MovingGroup(own.joint, flat(own.joint_T_link), enclosure, arrays, own.elements)


def standing_of(surroundings: SceneSurroundings, robot: Robot) -> Standing | None:
    """The places where a robot's base may stand, made once; None if the base does not drive."""
    drive = robot.drive
    if drive is None:
        return None
    made: Standing = surroundings.remembered(
        ("standing", robot.name), lambda: Standing(surroundings, robot, drive)
    )
    return made


def _only_joint(rows: Array, along: Array | None) -> int | None:
    """The joint that all rows speak of, besides the world; None if there are several, or none."""
    every = rows if along is None else np.concatenate([rows, along])
    joints = {int(j) for j in every[:, (columns.FIRST, columns.SECOND)].ravel()} - {0}
    return joints.pop() if len(joints) == 1 else None


def _of_free_body(rows: Array) -> Array:
    made: Array = rows.copy()
    joints = rows[:, (columns.FIRST, columns.SECOND)]
    made[:, (columns.FIRST, columns.SECOND)] = np.where(joints == 0, 0, FREE_BODY.size)
    return made


def _features(poses: Array) -> Array:
    """What a pose of the hand has that driving does not change (N, 4): its height, and the vertical in its frame."""
    return np.column_stack([poses[:, 11] / HEIGHT_SCALE, poses[:, 6:9] / TILT_SCALE])


def _base_poses(drive: Drive, goals: Array, entries: Array, about: float) -> Array:
    """The base values (N, M, 3) that bring poses (N, M, 12) of entries to the goals (N, 12), but for height and tilt."""
    turn, place = drive.world_T_floor[:3, :3], drive.world_T_floor[:3, 3]
    wanted = np.einsum("ji,njk->nik", turn, goals[:, :9].reshape(-1, 3, 3))
    at = (goals[:, 9:] - place) @ turn
    own = entries[:, :, :9].reshape(*entries.shape[:2], 3, 3)
    between = np.einsum("nij,nmkj->nmik", wanted, own)
    yaw = np.arctan2(between[..., 1, 0] - between[..., 0, 1], between[..., 0, 0] + between[..., 1, 1])
    yaw = about + np.remainder(yaw - about + np.pi, 2.0 * np.pi) - np.pi
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = entries[:, :, 9], entries[:, :, 10]
    shift = np.stack([at[:, None, 0] - (c * x - s * y), at[:, None, 1] - (s * x + c * y)], axis=2)
    return np.round(np.concatenate([shift, yaw[:, :, None]], axis=2), 9)
