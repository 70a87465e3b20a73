"""FORCE SENSING: every cup and every place in the largest target region is within reach, tool down [K 3.3.3]."""

import numpy as np
import pytest

from kabo.scene import link_poses, world_T
from tests.domains.reach import grasps_in, spot
from tests.domains.scenes import DOMAINS, scene_of

SCENE = scene_of(DOMAINS / "force_sensing" / "n10.yaml")
CUPS = [f"cup_{k}" for k in range(1, 11)]


def _grasps(x: float, y: float) -> int:
    body = SCENE.bodies["cup_1"]
    return grasps_in(SCENE.robots["arm"], body.grasps["above"], body.features, spot(x, y), 0.4, 500)


@pytest.mark.parametrize("cup", CUPS)
def test_every_cup_is_within_reach(cup: str) -> None:
    assert _grasps(*world_T(SCENE, SCENE.start, cup)[:2, 3]) > 20


def test_the_corners_of_the_target_region_are_within_reach() -> None:
    region = SCENE.regions["target"]
    for sides in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        corner = np.array([*(np.array(sides) * (np.array(region.size[:2]) - 0.034)), 0.0, 1.0])
        assert _grasps(*(region.world_T_region @ corner)[:2]) > 20


@pytest.mark.parametrize("name", ["home", "weigh"])
def test_a_cup_grasped_from_above_is_upright_at_home_and_while_it_is_weighed(name: str) -> None:
    arm = SCENE.robots["arm"]
    q = [*arm.configurations[name], *(SCENE.start.robots["arm"][arm.planned :])]
    assert np.allclose(link_poses(arm, q)["tool0"][:3, 2], [0.0, 0.0, -1.0])
