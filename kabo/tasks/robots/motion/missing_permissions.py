"""Collisions that are contacts: an object rests on what it is refused with, or a hand closes on what it is to take."""

from collections.abc import Iterator

import numpy as np

from kabo.geometry_server import Pair, Refusal, Situation, pair_text, rests_on
from kabo.tasks.robots.motion.questions import MotionQuestion


def missing_permission(refusal: Refusal) -> str | None:
    """The text of a refused collision with the contact that a stage before it may permit; None if it is no contact."""
    asked = refusal.question
    if refusal.reason != "collision" or not refusal.pairs or not isinstance(asked, MotionQuestion):
        return None
    pair = refusal.pairs[0][0]
    why = _resting(asked, pair) or _closing(asked, pair)
    return None if why is None else f"{pair_text(pair)}: {why}"


def _resting(asked: MotionQuestion, pair: Pair) -> str | None:
    scene = asked.scene
    bodies = scene.context.scene.bodies
    if not all(name in bodies for name in pair):
        return None
    for situation in _situations(asked):
        for name, other in (pair, pair[::-1]):
            if name in situation.objects and other in rests_on(scene.context.surroundings, situation, name):
                return (
                    f"{name} rests on {other} there; if it may, AllowContact of both is missing before this stage"
                )
    return None


def _situations(asked: MotionQuestion) -> Iterator[Situation]:
    """Where the way is refused, begins and ends."""
    yield asked.sample()
    for q in dict.fromkeys((asked.waypoints[0], asked.waypoints[-1]) if asked.waypoints else ()):
        yield asked.scene.at(asked.robot, q).situation


def _closing(asked: MotionQuestion, pair: Pair) -> str | None:
    """Why a motion of the gripper alone meets what it takes."""
    robot = asked.scene.robot(asked.robot)
    if robot.gripper is None or len(asked.waypoints) < 2:  # the latter: it is not asked about a motion
        return None
    arm = np.array(asked.waypoints)[:, : robot.planned]
    if np.any(arm != arm[0]):
        return None
    for link, name in (pair, pair[::-1]):
        if link in robot.gripper.touch_links and name in asked.scene.situation.objects:
            permit = f"AllowContact of {robot.name} and {name} is missing before this stage"
            return f"if the hand is to take it, {permit}"
    return None
