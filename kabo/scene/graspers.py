"""Which robots may use a grasp family: of grippers of several makes, each family says how one of them closes."""

from collections.abc import Mapping
from dataclasses import replace

from kabo.language.scene_description import GraspFamily
from kabo.scene.robots import Robot


def with_users(families: Mapping[str, GraspFamily], robots: Mapping[str, Robot]) -> dict[str, GraspFamily]:
    """Grasp families by name, for those robots only whose hand they tell how to close.

    One whose `fingers` name joints of other grippers alone would leave a hand open around the body.
    """
    found = dict(families)
    for name, family in families.items():
        if not family.fingers:
            continue
        closing = {
            each
            for each, robot in robots.items()
            if not robot.gripper_joints or {*robot.gripper_joints} & {*family.fingers}
        }
        named = robots if family.robots is None else family.robots
        if not closing.issuperset(named):
            found[name] = replace(family, robots=tuple(each for each in named if each in closing))
    return found
