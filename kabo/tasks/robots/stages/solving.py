"""Inverse kinematics as a wrapper: it solves each target of its child for robot configurations [T 3.4]."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Candidate, Measure, Refusal, owners, tool_frame
from kabo.tasks.core import INTERFACE, Property, Result, Solution, Wrapper
from kabo.tasks.core.model.results import Answer
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import ROBOT, RobotStage
from kabo.tasks.robots.motion.questions import along, hand_blocked, unreached
from kabo.tasks.robots.motion.targets import GraspTarget, PlacementTarget
from kabo.tasks.robots.scenes import TaskScene


class ComputeIK(RobotStage, Wrapper):
    """Configurations that reach the interface property `target` of its child, each proven free.

    They are projections of many seeds onto the constraints, in the order of the target's stream. If the target is one pose,
    the hand is checked first: if it collides there, no configuration helps.
    """

    MOVES = ("robot",)
    WRITES = ("target_pose",)
    PROPERTIES = {
        "robot": ROBOT,
        "target": Property(Any, INTERFACE, "the target, as a sampler writes it"),
        "max_ik_solutions": Property(
            (int, type(None)),
            None,
            "how many configurations for each target; none: all that are found",
            meanings.at_least(1),
        ),
        "min_distance": Property(
            float,
            0.0,
            "least distance between two configurations [rad, L1]; 0: any",
            meanings.at_least(0.0),
        ),
        "near": Property(bool, False, "whether the cost is the distance from the present configuration [rad, L1]"),
        "ignore_collisions": Property(bool, False, "whether configurations in collision are accepted"),
    }

    def transform(self, solution: Solution, properties: Values, seed: int) -> Iterator[Answer]:
        """The scene with the robot at each accepted configuration, and a refusal for each rejected one."""
        assert solution.end is not None
        scene, target = solution.end.scene, properties["target"]
        blocked = None if properties["ignore_collisions"] else hand_blocked(scene, properties["robot"], target)
        if blocked is not None:
            yield blocked
            return
        yield from self._reached(scene, target, properties, solution)

    def _reached(self, scene: TaskScene, target: Any, properties: Values, solution: Solution) -> Iterator[Answer]:
        name, most = properties["robot"], properties["max_ik_solutions"]
        robot, tried, blocked = scene.robot(name), 0, 0
        found: list[Array] = []
        known = isinstance(target, (GraspTarget, PlacementTarget))
        hopeless = (lambda: target.is_hopeless(scene)) if known else (lambda: False)
        for at in scene.context.candidates(target.batches(), hopeless):
            tried += 1
            refused = self._refused(scene, target, name, at, properties["ignore_collisions"])
            blocked = blocked + 1 if refused is not None and _is_movable(scene, name, refused) else 0
            if refused is not None:
                yield refused
                if blocked == scene.context.patience:
                    return
                continue
            if any(np.abs(at.q - other).sum() < properties["min_distance"] for other in found):
                continue
            found.append(at.q)
            own = {} if robot.tool is None else {"target_pose": at.pose(tool_frame(robot))}
            cost = solution.cost + (_away(scene, name, at) if properties["near"] else 0.0)
            yield Result(scene.at(name, at.q), cost=cost, comment=solution.comment, properties=own)
            if most is not None and len(found) >= most:
                return
        if not tried:
            yield unreached(scene, name, target)

    @staticmethod
    def _refused(scene: TaskScene, target: Any, name: str, at: Candidate, ignore: bool) -> Refusal | None:
        reason = target.refused(scene, at)
        if isinstance(reason, Measure):
            return Refusal("constraint", reason.text, measures=(reason,))
        if reason is not None:
            return Refusal("constraint", reason)
        hit = None if ignore else scene.workspace(name).first_hit(at.q)
        if hit is None:
            return None
        refusal = Refusal.collision(hit, question=along(scene, name, at.q))
        if not isinstance(target, GraspTarget) or target.object not in hit:
            return refusal
        cause = target.too_wide(scene) or target.touched(scene, hit, at)
        return refusal if cause is None else replace(refusal, measures=(cause,))


def _is_movable(scene: TaskScene, robot: str, refused: Refusal) -> bool:
    """Whether the obstacle is another robot, or an object that this robot does not hold."""
    met = {owner for pair, _ in refused.pairs for owner in owners(pair)}
    others = {*scene.situation.robots, *scene.situation.objects} - {robot, *scene.situation.carried(robot)}
    return not met.isdisjoint(others)


def _away(scene: TaskScene, name: str, at: Candidate) -> float:
    """The distance of the arm's joints from their present values [rad or m, L1]."""
    n = scene.robot(name).planned
    return float(np.abs(at.q[:n] - scene.configuration(name)[:n]).sum())
