"""Stages with which a task begins: the current state, a given state, or configurations of a robot."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from kabo.geometry_server import Refusal, Situation
from kabo.kinematics import uniform
from kabo.scene import GeometricState, Scene
from kabo.streams import stream_key
from kabo.tasks.core import Generator, Property, Result
from kabo.tasks.core.model.results import Answer, Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import ROBOT, RobotStage
from kabo.tasks.robots.motion.configurations import CLOSED, OPEN, NoConfigurationError, goal_of
from kabo.tasks.robots.scenes import TaskScene


class CurrentState(RobotStage, Generator):
    """Writes the scene that the task was given."""

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result with the scene that the task was given."""
        return [Result(scene)]


class FixedState(RobotStage, Generator):
    """Writes a given scene: a `TaskScene`, a geometric state, or the task's first scene with other `configurations`."""

    PROPERTIES = {
        "scene": Property(Any, None, "a TaskScene or GeometricState; none: the task's first scene"),
        "configurations": Property(
            dict, {}, "robot: a named configuration, a list, or joints with values; empty: as in the scene"
        ),
    }

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result with the given scene, in which robots have the given `configurations`."""
        given = properties["scene"]
        if isinstance(given, GeometricState):
            given = TaskScene.of(scene.context, given)
        result = scene if given is None else given
        for robot, wanted in properties["configurations"].items():
            result = result.at(robot, goal_of(result, robot, wanted))
        return [Result(result)]


class SampleConfiguration(RobotStage, Generator):
    """Configurations of a robot's arm: named ones in their order, then random ones, each free in the present scene."""

    MOVES = ("robot",)
    PROPERTIES = {
        "robot": ROBOT,
        "configurations": Property(
            (list, tuple, Callable),
            ("home",),
            "names (unknown ones are skipped) or values, or a function of the scene; empty: only random ones",
        ),
        "random": Property(int, 0, "how many random configurations follow; 0: none", meanings.at_least(0)),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """A message if there are no configurations: none named that the robot has, and none at random."""
        given, robot = self.known("configurations"), self.known("robot")
        if (
            given is None
            or callable(given)
            or self.known("random")
            or self.undecided("random")
            or robot not in scene.robots
        ):
            return
        known = scene.robots[robot].configurations
        if not any(not isinstance(each, str) or each in known or each in (OPEN, CLOSED) for each in given):
            told = ", ".join(map(str, given)) or "none is named"
            yield f"there are no configurations: {robot} has none of them ({told}), and `random` is 0"

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Iterator[Answer]:
        """One answer for each configuration: the scene with the robot there, or the refusal."""
        name = properties["robot"]
        here = scene.configuration(name)
        for q in self._candidates(scene, name, properties):
            if np.array_equal(q, here):
                yield Refusal("constraint", f"{name} is there already", reads=frozenset({name}))
                continue
            there = scene.at(name, q)
            hit = there.hit(name)
            yield Result(there) if hit is None else Refusal.collision(hit)

    @staticmethod
    def _candidates(scene: TaskScene, name: str, properties: Values) -> Iterator[Any]:
        given = properties["configurations"]
        for wanted in given(scene) if callable(given) else given:
            try:
                yield goal_of(scene, name, wanted)
            except NoConfigurationError:
                continue
        robot, n = scene.robot(name), scene.robot(name).planned
        key = stream_key(scene.context.seed, "move", name)
        lower, upper = robot.tree.lower[:n], robot.tree.upper[:n]
        for number in range(properties["random"]):
            share = np.array([uniform(key, number, i) for i in range(n)])
            yield (
                np.round(np.concatenate([lower + share * (upper - lower), scene.configuration(name)[n:]]), 9) + 0.0
            )
