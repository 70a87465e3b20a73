"""What holds for every problem under domains/: files, sizes, regions, clearances at the start."""

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.scene import Mesh, Scene, world_T
from scripts.generate_problems import problems
from tests.domains.scenes import PROBLEMS, WITH_SCENE, problem_of, scene_of

SMALL = [path for path in WITH_SCENE if path.stem not in {f"n{n}" for n in range(7, 21)}]
NAMES = [f"{path.parent.name}/{path.stem}" for path in SMALL]
WHOLE_TABLES = {"anywhere", "work_area", "guests", "counter"}


def test_the_problem_files_are_those_that_their_generators_write() -> None:
    made = dict(problems())
    assert sorted(made) == PROBLEMS
    assert all(path.read_text() == text for path, text in made.items())


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_problem_loads_and_its_epsilon_is_at_most_two_centimetres(path: Path) -> None:
    problem = problem_of(path)
    assert (problem.scene is None) == (path not in WITH_SCENE)
    assert problem.scene is None or problem.scene.epsilon <= 0.02


@pytest.mark.parametrize("path", SMALL, ids=NAMES)
def test_regions_reach_below_their_support_and_end_above_what_they_hold(path: Path) -> None:
    scene = scene_of(path)
    for region in (each for name, each in scene.regions.items() if name not in _floors(scene)):
        top = _top(scene, region.support)
        low, high = region.world_T_region[2, 3] + np.array([-1.0, 1.0]) * region.size[2]
        tallest = max(np.ptp(scene.bodies[name].mesh.vertices[:, 2]) for name in scene.movable)
        assert low < top - scene.epsilon
        assert high > top + tallest + scene.epsilon


@pytest.mark.parametrize("path", SMALL, ids=NAMES)
def test_regions_for_one_are_at_most_twice_as_wide_and_for_several_have_little_more_than_room(path: Path) -> None:
    scene = scene_of(path)
    width = max(np.ptp(scene.bodies[name].mesh.vertices[:, 0]) for name in scene.movable)
    for name in set(scene.regions) - WHOLE_TABLES - _floors(scene):
        x, y = (2.0 * half for half in scene.regions[name].size[:2])
        if len(scene.movable) == 1:
            assert max(x, y) <= 2.0 * width
        else:  # the fingers of the hand need as much again on either side of what they put down
            assert x * y <= len(scene.movable) * (3.0 * width) ** 2


@pytest.mark.parametrize("path", SMALL, ids=NAMES)
def test_at_the_start_nothing_is_nearer_than_epsilon_but_what_may_touch(path: Path) -> None:
    scene = scene_of(path)
    links = {f"{r.name}.{name}": link.mesh for r in scene.robots.values() for name, link in r.links.items()}
    bodies = {name: body.mesh for name, body in scene.bodies.items()}
    solids = {name: _placed(scene, name, mesh) for name, mesh in {**links, **bodies}.items() if mesh is not None}
    for first, second in combinations(solids, 2):
        if not (
            scene.never_collide(first, second)
            or _stands_on(scene, first, second)
            or _fingers(scene, first, second)
        ):
            assert _clearance(solids[first], solids[second], scene.epsilon) >= scene.epsilon, (first, second)


def _floors(scene: Scene) -> set[str]:
    """The regions that robots drive in, which hold no objects."""
    return {robot.drive.floor for robot in scene.robots.values() if robot.drive is not None}


def _top(scene: Scene, support: str | None) -> float:
    assert support is not None
    origin = scene.bodies[support].features["top"].origin
    return float((world_T(scene, scene.start, support) @ np.array([*origin, 1.0]))[2])


def _fingers(scene: Scene, first: str, second: str) -> bool:
    """Whether both are fingers of one hand, which a hand without anything in it may close."""
    hands = [robot.gripper.touch_links for robot in scene.robots.values() if robot.gripper is not None]
    return any(first in hand and second in hand for hand in hands)


def _stands_on(scene: Scene, first: str, second: str) -> bool:
    """Whether one is a movable object whose lowest point touches the top of the other."""
    for upper, lower in ((first, second), (second, first)):
        if upper in scene.movable and lower in scene.bodies and "top" in scene.bodies[lower].features:
            lowest = _placed(scene, upper, scene.bodies[upper].mesh).vertices[:, 2].min()
            if abs(lowest - _top(scene, lower)) < 1e-6:
                return True
    return False


def _placed(scene: Scene, name: str, mesh: Mesh) -> trimesh.Trimesh:
    pose = world_T(scene, scene.start, name)
    return trimesh.Trimesh(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], mesh.faces, process=False)


def _clearance(first: trimesh.Trimesh, second: trimesh.Trimesh, enough: float) -> float:
    """The distance of two solids [m], or of their boxes if that is enough."""
    boxes = np.maximum(first.bounds[0] - second.bounds[1], second.bounds[0] - first.bounds[1])
    apart = float(np.linalg.norm(np.maximum(0.0, boxes)))
    if apart >= enough:
        return apart
    manager = trimesh.collision.CollisionManager()
    manager.add_object("first", first)
    return float(manager.min_distance_single(second))
