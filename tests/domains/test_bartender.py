"""BARTENDER is not a toy: who reaches what, by sampling the scene's own grasps [K 6.2.1]."""

import numpy as np
import pytest

from kabo.scene import world_T
from tests.domains.reach import around, grasps_in, spot
from tests.domains.scenes import DOMAINS, scene_of

SCENE = scene_of(DOMAINS / "bartender" / "four_bottles.yaml")
BOTTLES = ("bottle_1", "bottle_2", "bottle_3", "bottle_4")
FAR_TRIES, TRIES = 20_000, 2_000


def _grasps(robot: str, name: str, tries: int) -> int:
    x, y, z = world_T(SCENE, SCENE.start, name)[:3, 3]
    body = SCENE.bodies[name]
    return grasps_in(SCENE.robots[robot], body.grasps["side"], body.features, spot(x, y), z, tries)


def _grasps_in_dishwasher(robot: str, tries: int) -> int:
    region, body = SCENE.regions["dishwasher"], SCENE.bodies["bottle_1"]
    inset = np.array(region.size[:2]) - 0.03  # where the axis of a bottle can stand
    middle = region.world_T_region[:2, 3]
    area = around([tuple(middle - inset), tuple(middle + inset)])
    return grasps_in(SCENE.robots[robot], body.grasps["side"], body.features, area, 0.01, tries)


@pytest.mark.parametrize("bottle", BOTTLES[:2])
def test_two_bottles_are_out_of_reach_of_the_right_arm_and_within_that_of_the_left(bottle: str) -> None:
    assert _grasps("right", bottle, FAR_TRIES) == 0
    assert _grasps("left", bottle, TRIES) > 100


@pytest.mark.parametrize("bottle", BOTTLES[2:])
def test_the_other_two_are_within_reach_of_the_right_arm(bottle: str) -> None:
    assert _grasps("right", bottle, TRIES) > 100


def test_the_dishwasher_is_out_of_reach_of_the_left_arm_and_within_that_of_the_right() -> None:
    assert _grasps_in_dishwasher("left", FAR_TRIES) == 0
    assert _grasps_in_dishwasher("right", TRIES) > 100


def test_the_arms_meet_in_the_middle_of_the_table_only() -> None:
    body = SCENE.bodies["bottle_1"]
    rows = np.linspace(-0.9, 0.8, 18)

    def reached(robot: str) -> np.ndarray:
        return (
            np.array(
                [
                    grasps_in(SCENE.robots[robot], body.grasps["side"], body.features, spot(0.2, y), 0.0, 300)
                    for y in rows
                ]
            )
            > 0
        )

    both = rows[reached("left") & reached("right")]
    assert len(both) > 0
    assert np.abs(both).max() < 0.4


def test_the_dishwasher_has_room_for_four_bottles_and_the_hand() -> None:
    region = SCENE.regions["dishwasher"]
    spacing = 2.0 * (region.size[0] - 0.03 - SCENE.epsilon)  # two by two, in the corners
    fingers = 0.055 + 0.016
    assert spacing >= fingers + 0.03 + SCENE.epsilon
    assert spacing < 2.5 * (fingers + 0.03 + SCENE.epsilon)
