"""Bottle pouring [T 3.9.2] on the generated arm: every kind of choice among configurations finds a whole solution."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from kabo.language import load_scene_description
from kabo.scene import Scene, link_pose, load_scene
from kabo.scene.transforms import inverse
from kabo.tasks import Solution, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import stretches

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "bottle_pouring"
JOBS = 4000
CLOSEST, ALL = (1, 1), (16, 16)


@cache
def scene(name: str) -> Scene:
    return load_scene(load_scene_description(EXAMPLE / name))


@cache
def solved(name: str, towards: float, most: tuple[int, int]) -> Solution | None:
    arguments = {"towards": towards, "grasp_solutions": most[0], "other_solutions": most[1]}
    task = load_task_file(EXAMPLE / "task.yaml").task(arguments, seed=0)
    task.plan(first_scene(scene(name), 0, lambda: False), 1, jobs=JOBS)
    return task.best


@pytest.mark.parametrize(
    ("name", "towards", "most"),
    [
        ("scene.yaml", np.pi / 2, CLOSEST),
        ("scene.yaml", -np.pi / 2, ALL),
        ("with_obstacle.yaml", -np.pi / 2, ALL),
    ],
)
def test_it_is_solved(name: str, towards: float, most: tuple[int, int]) -> None:
    assert solved(name, towards, most) is not None


def test_the_bottle_leans_no_more_than_45_degrees_while_it_is_carried() -> None:
    found = solved("scene.yaml", np.pi / 2, CLOSEST)
    assert found is not None
    robot, axis, carried = scene("scene.yaml").robots["arm"], None, 0
    for path, each in stretches(found):
        if axis is not None and each.group == "arm" and path != "pour":
            for a, b in zip(each.path, each.path[1:], strict=False):
                for share in np.linspace(0.0, 1.0, 20):
                    up = link_pose(robot, tuple(a + (b - a) * share), "tool0")[:3, :3] @ axis
                    assert np.arccos(np.clip(up[2], -1.0, 1.0)) <= np.pi / 4 + 1e-3
                    carried += 1
        if each.attach:
            axis = inverse(link_pose(robot, each.end, "tool0"))[:3, :3] @ (0.0, 0.0, 1.0)
        if each.detach:
            axis = None
    assert carried > 100


def test_each_stretch_begins_where_the_last_one_ended() -> None:
    found = solved("scene.yaml", np.pi / 2, CLOSEST)
    assert found is not None
    motion = [each for _, each in stretches(found)]
    assert all(np.abs(a.path[-1] - b.path[0]).max() <= 1e-6 for a, b in zip(motion, motion[1:], strict=False))


def test_the_bottle_ends_where_it_is_to_go() -> None:
    found = solved("scene.yaml", np.pi / 2, CLOSEST)
    assert found is not None
    assert found.end is not None
    assert found.end.scene.pose("bottle")[:3, 3] == pytest.approx((0.55, -0.30, 0.0), abs=1e-3)
