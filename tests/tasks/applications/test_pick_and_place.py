"""Pick and place [T 3.9.1] on the generated arm, and on the Panda where the extra `robots` is installed."""

from functools import cache
from itertools import accumulate
from pathlib import Path

import numpy as np
import pytest

from kabo.language import load_scene_description
from kabo.language.recorded_paths import installed_folder
from kabo.scene import Scene, load_scene
from kabo.tasks import Solution, Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import stretches
from tests.tasks.robots.judge import Judge

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "pick_and_place"
WANTED = 4
no_public = installed_folder("example-robot-data") is None
public = pytest.param(
    "panda.yaml", marks=pytest.mark.skipif(no_public, reason="the extra `robots` is not installed")
)
both = pytest.mark.parametrize("name", ["scene.yaml", public])


@cache
def scene(name: str) -> Scene:
    return load_scene(load_scene_description(EXAMPLE / name))


def planned(name: str, seed: int = 0, wanted: int = WANTED) -> Task:
    task = load_task_file(EXAMPLE / "task.yaml").task({}, seed=seed)
    task.plan(first_scene(scene(name), seed, lambda: False), wanted, jobs=2000)
    return task


@cache
def solved(name: str) -> tuple[Solution, ...]:
    return tuple(planned(name).solutions)


@pytest.mark.slow
@both
def test_as_many_solutions_are_found_as_are_asked_for(name: str) -> None:
    assert len(solved(name)) == WANTED


@both
def test_nothing_touches_what_it_may_not_and_no_joint_jumps(name: str) -> None:
    """Judged by pinocchio and fcl on the original meshes; for every solution, and for its end."""
    judge = Judge(scene(name))
    assert [judge.findings(solution) for solution in solved(name)] == [[]] * WANTED


@both
def test_the_object_stands_upright_at_its_place_within_a_millimetre(name: str) -> None:
    for solution in solved(name):
        assert solution.end is not None
        pose = solution.end.scene.pose("object")
        assert np.linalg.norm(pose[:3, 3] - (0.6, -0.15, 0.125)) < 1e-3
        assert pose[2, 2] > np.cos(1e-3)


def test_more_solutions_never_make_the_best_worse() -> None:
    task = load_task_file(EXAMPLE / "task.yaml").task({}, seed=3)
    start, best = first_scene(scene("scene.yaml"), 3, lambda: False), []
    for wanted in range(1, WANTED + 1):
        found = task.plan(start, wanted)
        assert task.best is not None
        best.append(task.best.cost)
    assert best == list(accumulate((each.cost for each in found), min))


def test_the_grasp_of_a_solution_can_be_asked_for() -> None:
    grasp = solved("scene.yaml")[0]["pick/grasp pose IK"].properties
    assert grasp["grasp"] == "side"
    assert grasp["target_pose"][2, 0] == pytest.approx(1.0)  # the tool's x points upward


def test_the_same_seed_gives_the_same_motion_and_another_one_another() -> None:
    def motion(seed: int) -> list[object]:
        return [each.waypoints for _, each in stretches(planned("scene.yaml", seed, 1).solutions[0])]

    assert motion(0) == motion(0) != motion(1)


def test_a_thing_in_the_hand_is_told_before_anything_is_planned() -> None:
    task = load_task_file(EXAMPLE / "task.yaml").task({}, seed=0)
    end = solved("scene.yaml")[0]["pick"].end
    assert end is not None
    assert task.plan(end.scene, 1, jobs=500) == []
    assert "arm holds object" in task.explain().text or task.explain().failures["constraint"] == 1
