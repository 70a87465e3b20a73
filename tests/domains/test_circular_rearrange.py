"""CIRCULAR REARRANGE is not a toy: who reaches what, by sampling the scene's own grasps; and it is solved."""

from functools import cache

import numpy as np
import pytest

import kabo
from kabo.plan import plan_statistics
from kabo.planner.result import Result
from kabo.scene import world_T
from tests.domains.families import rule
from tests.domains.reach import grasps_in, spot
from tests.domains.scenes import DOMAINS, scene_of

FOLDER = DOMAINS / "circular_rearrange"
FAR_TRIES, TRIES = 5_000, 1_000


def grasps(n: int, robot: str, name: str, tries: int) -> int:
    scene = scene_of(FOLDER / f"n{n}.yaml")
    x, y, z = world_T(scene, scene.start, name)[:3, 3]
    body = scene.bodies[name]
    return grasps_in(scene.robots[robot], body.grasps["side"], body.features, spot(x, y), z, tries)


@pytest.mark.parametrize(("robot", "near", "far"), [("left", "o1", "o3"), ("right", "o3", "o1")])
def test_each_arm_reaches_its_own_end_and_the_middle_only(robot: str, near: str, far: str) -> None:
    assert grasps(3, robot, near, TRIES) > 50
    assert grasps(3, robot, "o2", TRIES) > 50
    assert grasps(3, robot, far, FAR_TRIES) == 0


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_every_object_stands_in_the_middle_of_the_place_that_another_one_is_to_take(n: int) -> None:
    scene = scene_of(FOLDER / f"n{n}.yaml")
    for k in range(1, n + 1):
        place = scene.regions[f"loc_{k}"].world_T_region[:2, 3]
        assert np.allclose(world_T(scene, scene.start, f"o{k}")[:2, 3], place, atol=1e-9)


def test_problems_that_the_table_has_no_room_for_come_without_a_scene() -> None:
    assert "scene:" in rule("circular_rearrange")(6)
    assert "scene:" not in rule("circular_rearrange")(7)
    with pytest.raises(kabo.InputError, match="2 objects or more"):
        rule("circular_rearrange")(1)


@cache
def solved() -> Result:
    return kabo.solve(kabo.load_problem(FOLDER / "n3.yaml"))


def test_three_objects_are_rearranged_in_few_actions_with_few_checks_and_proven_motion() -> None:
    result = solved()
    assert result.plan is not None
    assert plan_statistics(result.plan).plan_actions <= 11  # [K Table 6.2]: 10.66 in the mean
    assert result.statistics["collision_checks"] <= 2000
    assert kabo.verify(kabo.load_problem(FOLDER / "n3.yaml"), result.plan).ok


def test_somebody_puts_down_in_the_middle_what_has_to_cross_the_table() -> None:
    plan = solved().plan
    assert plan is not None
    places = [node.arguments["l"] for node in plan.nodes.values() if node.action == "put_down"]
    assert "anywhere" in places
