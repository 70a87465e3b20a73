"""Parts of a motion: a stretch with the scene in which it is proven."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kabo.arrays import Array, Booleans, Integers
from kabo.geometry_server import Keep, Workspace
from kabo.motion import Held
from kabo.scene import Configuration
from kabo.tasks.robots.motion.constraints import keep_of
from kabo.tasks.robots.motion.held_bodies import held_by
from kabo.tasks.robots.scenes import Stretch, TaskScene, configuration
from kabo.tasks.robots.timed_paths import TimedPath

MAX_SPLITS = 3  # how often a piece whose proof fails is halved
MOVING = 1e-6  # rad or m: less is no motion
JOINT_DECIMALS = 9  # of joint values in plans
KEPT_DEVIATION = 2.5e-4  # rad or m: how far joints may be from a path that keeps a constraint


@dataclass(frozen=True)
class MotionPart:
    """A stretch, the scene in which it begins and is proven, and the path of the stage that made it."""

    stretch: Stretch
    scene: TaskScene
    stage: str

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """The names of the joints that move: the arm's, or the gripper's."""
        robot = self.scene.robot(self.stretch.robot)
        gripper = self.stretch.group == "gripper" and bool(robot.gripper_joints)
        return robot.gripper_joints if gripper else robot.planned_joints

    @cached_property
    def columns(self) -> slice:
        """Where these joints are in a configuration of the robot."""
        robot = self.scene.robot(self.stretch.robot)
        return slice(0, robot.planned) if self.joints == robot.planned_joints else slice(robot.planned, None)

    @cached_property
    def rows(self) -> tuple[Configuration, ...]:
        """The way points over these joints, each different from the one before."""
        way = [q[self.columns] for q in self.stretch.waypoints]
        return (way[0], *(b for a, b in zip(way, way[1:], strict=False) if a != b))

    def along(self, timed: TimedPath) -> Stretch:
        """The stretch with a motion of its joints, in which it has its times."""
        found = np.tile(self.stretch.path[0], (len(timed.waypoints), 1))
        found[:, self.columns] = timed.waypoints
        return replace(self.stretch, waypoints=tuple(map(configuration, found)), timed=timed, stage=self.stage)

    @cached_property
    def moves(self) -> bool:
        """Whether any joint moves."""
        return bool(np.ptp(np.array(self.rows), axis=0).max() > MOVING)

    @cached_property
    def drives(self) -> bool:
        """Whether the base of the robot moves."""
        base = 0 if self.columns.start else self.scene.robot(self.stretch.robot).base_values
        return base > 0 and bool(np.ptp(np.array(self.rows)[:, :base], axis=0).max() > MOVING)

    @cached_property
    def held(self) -> Held | None:
        """What the arm carries, if that limits its acceleration; None for motion of the gripper."""
        return held_by(self.scene, self.stretch.robot) if self.columns.start == 0 else None

    @cached_property
    def touches(self) -> bool:
        """Whether bodies may touch during the stretch, as where one is lifted; such a stroke keeps its shape."""
        return any(not any("." in name for name in pair) for pair in self.stretch.permitted)

    @cached_property
    def _keep(self) -> Keep | None:
        return keep_of(self.scene, self.stretch.robot, self.stretch.constraint)

    @cached_property
    def _apart(self) -> TaskScene:
        """The scene without contacts between bodies, which are permitted where one is lifted from another."""
        pairs = [tuple(sorted(pair)) for pair in self.scene.permitted if not any("." in name for name in pair)]
        return self.scene.forbidding((first, second) for first, second in pairs)

    @cached_property
    def _workspaces(self) -> tuple[Workspace, Workspace]:
        robot = self.stretch.robot
        return self.scene.workspace(robot), self._apart.workspace(robot)

    def proven(self, a: Array, b: Array, *, apart: bool = False) -> bool:
        """Whether a straight segment of joint space is proven collision-free and to keep the constraint.

        If the proof fails, both halves are tried, up to `MAX_SPLITS` times.

        Args:
            a, b: the ends of the segment, configurations of the robot.
            apart: whether contacts between bodies, permitted by the stretch, are forbidden here.
        """
        if self._keep is not None and not self._keep.keeps(a, b):
            return False
        return self._free(self._workspaces[apart], a, b, MAX_SPLITS)

    def _free(self, workspace: Workspace, a: Array, b: Array, splits: int) -> bool:
        if workspace.segment_hit(a, b) < 0:
            return True
        middle = (a + b) / 2
        return (
            splits > 0
            and self._free(workspace, a, middle, splits - 1)
            and self._free(workspace, middle, b, splits - 1)
        )

    def proven_near(self, starts: Array, ends: Array, deviations: Array, *, apart: bool, early: bool) -> Booleans:
        """Whether all that is near straight segments of joint space is proven collision-free, and each to be kept.

        Args:
            starts, ends: the ends (N, n) of the segments, configurations of the robot.
            deviations: (N, n) how far each joint may be from each segment [rad or m].
            apart: as of `proven`.
            early: whether what takes finer parts of bodies counts as not proven: to make them takes seconds.
        """
        workspace = self._workspaces[apart]

        def free(rows: Integers | slice) -> Booleans:
            asked = starts[rows], ends[rows], deviations[rows]
            return workspace.segments_free_early(*asked) if early else workspace.segments_hit(*asked) < 0

        if self._keep is None:
            return np.asarray(free(slice(None)))
        proven = deviations.max(axis=1, initial=0.0) <= KEPT_DEVIATION
        for i in np.flatnonzero(proven):
            proven[i] = self._keep.keeps(starts[i], ends[i])
        rows = np.flatnonzero(proven)
        if len(rows):
            proven[rows] = free(rows)
        return np.asarray(proven)
