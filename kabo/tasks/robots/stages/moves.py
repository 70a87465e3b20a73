"""The stage `MoveTo`: motions of an arm or a gripper to a goal [T 3.2]."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refusal, Situation, candidate
from kabo.scene import Scene
from kabo.tasks.core import Propagator, Property, Result
from kabo.tasks.core.model.results import Answer
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import ATTEMPT_TIMEOUT, KEEP, PLANNER, ROBOT, RobotStage, is_optional, keep_faults
from kabo.tasks.robots.meanings import RRT_CONNECT, TOOL_LINE
from kabo.tasks.robots.motion.configurations import (
    CLOSED,
    OPEN,
    BeyondLimitsError,
    NoConfigurationError,
    configured,
    goal_of,
)
from kabo.tasks.robots.motion.paths import grip, length
from kabo.tasks.robots.motion.planners import planned_way
from kabo.tasks.robots.motion.questions import along, hand_blocked, unreached
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from kabo.tasks.robots.scenes import Stretch, TaskScene
from kabo.tasks.robots.stages.poses import pose_of


class MoveTo(RobotStage, Propagator):
    """Moves the arm or the gripper to a goal.

    `goal`: the name of a configuration, `open` or `closed`, {joint: value}, a list of joint values, or {pose: …} or
    {point: [x, y, z]} for the frame `of`. Backward, the motion comes from there. An arm whose next motion follows at
    once does not stop at the goal, and passes it within 0.2 rad (L2 over the joints), or what `Reparameterise` permits;
    a `straight` motion stops at both ends.
    """

    MOVES = ("robot",)
    READS = ()
    PROPERTIES = {
        "robot": ROBOT,
        "goal": Property(Any, doc="the goal of the motion", wrong=meanings.goal),
        "group": Property(
            (str, type(None)),
            None,
            "`arm` or `gripper`; none: the group whose joints the goal has",
            meanings.one_of("arm", "gripper"),
        ),
        "of": Property(
            (str, type(None)),
            None,
            "what a pose or point is for: the tool (none), a link, what is held, a feature",
            meanings.name,
        ),
        "keep": KEEP,
        "straight": Property(
            bool, False, "whether the frame of the tool moves on a straight line, and turns evenly"
        ),
        "planner": PLANNER,
        "attempt_timeout": ATTEMPT_TIMEOUT,
        "if_missing": Property(
            str,
            "fail",
            "`fail` or `stay`, if the robot has no configuration of the goal's name",
            meanings.one_of("fail", "stay"),
        ),
        "max_ik_solutions": Property(
            int, 8, "for poses and points: how many configurations to try", meanings.at_least(1)
        ),
    }

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> list[Answer]:
        """The scene with the robot at the goal.

        If the goal is a pose or a point, the first of its solutions to which a path is found is taken.
        """
        name = properties["robot"]
        answers: list[Answer] = []
        for goal in self._goals(scene, properties):
            moved = goal if isinstance(goal, Refusal) else self._moved(scene, name, goal, properties)
            if not isinstance(moved, Refusal):
                still = np.array_equal(goal, scene.configuration(name))
                motion = () if still else (moved,)
                return [*answers, Result(scene.at(name, goal), motion=motion, cost=length(motion))]
            answers.append(moved)
        return answers

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> list[Answer]:
        """The scene before the motion, with the robot at the goal.

        The motion is planned from `scene` and then reversed.
        """
        answers = self.forward(scene, properties, seed)
        return [replace(a, motion=_reversed(a.motion)) if isinstance(a, Result) else a for a in answers]

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a frame `of` without a pose, or a `keep` that applies to the gripper's motion or to nothing held."""
        goal, keep = self.known("goal"), self.known("keep")
        if self.known("of") is not None and goal is not None and not _is_pose(goal):
            yield "`of` says what is to be at a pose or a point, and the goal is neither"
        if self.known("straight") and (self.known("group") == "gripper" or goal in (OPEN, CLOSED)):
            yield "`straight` is for the arm, and only the gripper moves"
        if self.known("straight") and "planner" in self.properties.given:
            yield "`straight` leaves no choice of a planner: leave one of the two out"
        if keep and (self.known("group") or ("gripper" if goal in (OPEN, CLOSED) else "arm")) == "gripper":
            yield "`keep` is for the arm, and only the gripper moves"
        yield from keep_faults(self, start)
        yield from self._nowhere(scene)

    def reads(self) -> tuple[str, ...]:
        """The held object that the property `keep` names, as a tuple; empty if it names none."""
        keep = self.known("keep")
        return (str(keep["object"]),) if isinstance(keep, Mapping) and isinstance(keep.get("object"), str) else ()

    def _nowhere(self, scene: Scene) -> Iterator[str]:
        """A message for a goal that is no configuration of the robot, unless another stage may replace this one."""
        robot, goal = scene.robots.get(self.known("robot")), self.known("goal")
        if robot is None or goal is None or _is_pose(goal) or is_optional(self):
            return
        try:
            configured(robot, np.array(scene.start.robots[robot.name]), goal)
        except ValueError as error:
            missing = isinstance(error, NoConfigurationError) and not isinstance(error, BeyondLimitsError)
            if not (missing and self.known("if_missing") == "stay"):
                yield str(error)

    def _moved(self, scene: TaskScene, name: str, goal: Array, properties: Values) -> Any:
        n, start = scene.robot(name).planned, scene.configuration(name)
        group = properties["group"] or ("arm" if not np.array_equal(start[:n], goal[:n]) else "gripper")
        if group == "gripper":
            return grip(scene, name, goal)
        planner = TOOL_LINE if properties["straight"] else properties["planner"]
        found = arm_moved(scene, name, goal, self.name, properties["keep"], planner, properties["attempt_timeout"])
        # Rounded where it begins and ends, it would be no line, and miss its goal.
        return replace(found, exact=True) if properties["straight"] and isinstance(found, Stretch) else found

    def _goals(self, scene: TaskScene, properties: Values) -> Any:
        name, goal = properties["robot"], properties["goal"]
        if _is_pose(goal):
            yield from self._reaching(scene, properties)
            return
        try:
            wanted = goal_of(scene, name, goal)
        except NoConfigurationError as error:
            stays = properties["if_missing"] == "stay" and not isinstance(error, BeyondLimitsError)
            yield scene.configuration(name) if stays else Refusal("constraint", str(error), proof=True)
            return
        n, start = scene.robot(name).planned, scene.configuration(name)
        group = properties["group"] or ("gripper" if goal in (OPEN, CLOSED) else None)
        if group == "gripper":
            wanted = np.concatenate([start[:n], wanted[n:]])
        elif group == "arm":
            wanted = np.concatenate([wanted[:n], start[n:]])
        yield wanted

    @staticmethod
    def _reaching(scene: TaskScene, properties: Values) -> Any:
        name, goal = properties["robot"], properties["goal"]
        frame = frame_for(scene, name, properties["of"])
        if "point" in goal:
            here = scene.configuration(name)
            pose = candidate(scene.robot(name), here).pose(frame).copy()
            pose[:3, 3] = pose_of(scene, {"frame": goal.get("frame", "world"), "position": goal["point"]})[:3, 3]
        else:
            pose = pose_of(scene, goal["pose"])
        target, tried = pose_target(scene, name, frame, pose), 0
        blocked = hand_blocked(scene, name, target)
        if blocked is not None:
            yield blocked
            return
        for at in scene.context.candidates(target.batches()):
            tried += 1
            yield at.q
            if tried >= properties["max_ik_solutions"]:
                return
        if not tried:
            yield replace(unreached(scene, name, target), reads=frozenset({name}))


def arm_moved(
    scene: TaskScene,
    robot: str,
    goal: Array,
    what: str,
    keep: Any,
    planners: str | Sequence[str] = RRT_CONNECT,
    timeout: float | None = None,
) -> Stretch | Refusal:
    """The motion of a robot's arm to `goal` (n,), or the refusal: not free there, or no path is found.

    `what` the motion is for keys its random stream; `keep` is a motion constraint; planners as in `planned_way`.
    """
    hit = scene.at(robot, goal).hit(robot)
    if hit is not None:
        return Refusal.collision(hit, question=along(scene, robot, goal))
    return planned_way(scene, robot, goal, what, keep, planners, timeout)


def _is_pose(goal: Any) -> bool:
    """Whether a goal is a pose or a point, and not joint values."""
    return isinstance(goal, Mapping) and ("pose" in goal or "point" in goal)


def _reversed(motion: tuple[Stretch, ...]) -> tuple[Stretch, ...]:
    return tuple(each.reversed() for each in reversed(motion))
