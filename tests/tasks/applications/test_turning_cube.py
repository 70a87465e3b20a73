"""A cube that is turned until a face is up, in the spirit of [T Appendix B]."""

import runpy
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from kabo.language import load_scene_description
from kabo.scene import Scene, load_scene
from kabo.tasks import Solution, Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import stretches

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "turning_cube"
NORMALS = {"red": (0, 0, 1), "orange": (0, 0, -1), "green": (1, 0, 0), "white": (0, 1, 0)}
JOBS = 30_000


@cache
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


def turning(face: str) -> Task:
    runpy.run_path(str(EXAMPLE / "stages.py"))
    return load_task_file(EXAMPLE / "task.yaml").task({"face": face}, seed=0)


def planned(task: Task) -> Solution:
    task.plan(first_scene(scene(), 0, lambda: False), 1, jobs=JOBS)
    assert task.best is not None, task.explain().text
    return task.best


def up(solution: Solution, face: str) -> float:
    assert solution.end is not None
    pose = solution.end.scene.pose("cube")
    assert pose[:3, 3] == pytest.approx((0.5, 0.0, 0.035), abs=1e-3)
    return float((pose[:3, :3] @ np.array(NORMALS[face], float))[2])


def grips(solution: Solution) -> int:
    return sum(len(each.attach) for _, each in stretches(solution))


def test_nothing_moves_if_the_face_is_up_already() -> None:
    found = planned(turning("red"))
    assert grips(found) == 0
    assert up(found, "red") == pytest.approx(1.0)


@pytest.mark.parametrize("face", ["green", "white"])
def test_a_face_at_a_side_comes_up_by_one_turn(face: str) -> None:
    found = planned(turning(face))
    assert grips(found) == 1
    assert up(found, face) == pytest.approx(1.0, abs=1e-6)


def test_the_face_below_comes_up_by_two_turns_when_one_has_been_tried_in_vain() -> None:
    task = turning("orange")
    found = planned(task)
    assert grips(found) == 2
    assert up(found, "orange") == pytest.approx(1.0, abs=1e-6)
    assert not task.statistics["turns/turn once"].successes


def test_the_anchor_is_an_instance_of_its_own_wherever_it_stands() -> None:
    task = turning("green")
    names = (
        "turns/turn once/turn",
        "turns/turn twice/turn first time/turn",
        "turns/turn twice/turn second time/turn",
    )
    stages = [task.find(name) for name in names]
    assert len({id(stage) for stage in stages}) == 3
    assert None not in stages
