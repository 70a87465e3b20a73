"""Retract, transit, approach [T 3.9.3] on the generated arm: all pairs, and air around the thing on the way only."""

from functools import cache
from pathlib import Path

import numpy as np

from kabo.language import load_scene_description
from kabo.scene import Scene, link_poses, load_scene
from kabo.tasks import Solution, Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import Stretch, stretches
from tests.tasks.robots.judge import Judge, samples

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "retract_transit_approach"
TRANSIT = "padded transit/transit"
AIR = 0.05


@cache
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


@cache
def planned(*padded: str) -> Task:
    file = load_task_file(EXAMPLE / "task.yaml")
    task = file.task({"padded": list(padded)}, seed=0)
    for name, most in (("first pose IK", 3), ("second pose IK", 2)):
        found = task.find(name)
        assert found is not None
        found.properties.set("max_ik_solutions", most)
    task.plan(first_scene(scene(), 0, lambda: False), jobs=2000)
    return task


def transit(solution: Solution) -> Stretch:
    (way,) = (each for path, each in stretches(solution) if path == TRANSIT)
    return way


def clearance(way: Stretch) -> float:
    """The least distance of any corner of the arm from the cylinder around the thing, every 0.06 rad [m]."""
    robot, body = scene().robots["arm"], scene().bodies["object"]
    foot = scene().fixed_poses["object"][:3, 3]
    radius, height = float(np.linalg.norm(body.mesh.vertices[:, :2], axis=1).max()), body.mesh.vertices[:, 2].max()
    least = np.inf
    for q in samples(way, 0.06):
        for name, pose in link_poses(robot, q).items():
            mesh = robot.links[name].mesh
            if mesh is not None:
                points = mesh.vertices @ pose[:3, :3].T + pose[:3, 3] - foot
                aside = np.maximum(np.hypot(points[:, 0], points[:, 1]) - radius, 0.0)
                above = np.maximum(np.maximum(points[:, 2] - height, -points[:, 2]), 0.0)
                least = min(least, float(np.hypot(aside, above).min()))
    return least


def test_every_pair_of_configurations_is_connected() -> None:
    for task in (planned("object"), planned()):
        starts, ends = (task.statistics[name].successes for name in ("retract", "approach"))
        assert task.exhausted
        assert len(task.solutions) == starts * ends >= 4


def test_padding_keeps_five_centimetres_of_air_on_the_way_and_without_it_there_is_less() -> None:
    assert min(clearance(transit(each)) for each in planned("object").solutions) >= AIR
    assert min(clearance(transit(each)) for each in planned().solutions) < AIR


def test_there_is_no_padding_before_and_after() -> None:
    for solution in planned("object").solutions:
        retract, approach = solution["retract"], solution["approach"]
        states = (solution.start, retract.end, approach.start, solution.end)
        assert [state.scene.extras for state in states if state is not None] == [()] * 4
        inside = solution[TRANSIT]
        assert inside.start is not None
        assert [extra.parent for extra in inside.start.scene.extras] == ["object"]


def test_the_motion_leads_from_the_one_configuration_to_the_other_and_touches_nothing() -> None:
    for solution in planned("object").solutions[:2]:
        assert solution.start is not None
        assert solution.end is not None
        first, second = solution.start.scene, solution.end.scene
        assert not np.array_equal(first.configuration("arm"), second.configuration("arm"))
        assert Judge(scene()).findings(solution) == []
