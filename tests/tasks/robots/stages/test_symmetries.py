"""Poses all around an axis, and the ways in which something looks the same."""

from pathlib import Path

import numpy as np
import pytest

from kabo.geometry_server import Refusal
from kabo.language import load_scene_description
from kabo.language.scene_description import Shape
from kabo.scene import Body, Scene, load_scene
from kabo.scene.shapes import primitive
from kabo.tasks.core import Result, Solution, State
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import STAGES, TaskScene
from kabo.tasks.robots.stages.symmetries import symmetry, turned

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "pick_and_place"
GRASP = {"rpy": [np.pi, -np.pi / 2, 0.0]}


@pytest.fixture(scope="module")
def start() -> TaskScene:
    made: Scene = load_scene(load_scene_description(EXAMPLE / "scene.yaml"))
    scene: TaskScene = first_scene(made, 0, lambda: False)
    return scene


def offered(scene: TaskScene, stage: str, **properties: object) -> list[Result]:
    made = STAGES[stage]("offer", "open", robot="arm", object="object", **properties)
    values = {name: made.properties.value(name) for name in made.properties.declared}
    found = list(made.generate(scene, values, 0))
    assert all(isinstance(each, Result) for each in found)
    return found


@pytest.mark.parametrize(
    ("kind", "size", "ways"),
    [
        ("box", (0.1, 0.1, 0.3), 4),
        ("box", (0.1, 0.2, 0.3), 2),
        ("cylinder", (0.1, 0.1, 0.2), None),
        ("sphere", (0.1, 0.1, 0.1), None),
    ],
)
def test_the_shape_says_in_how_many_ways_a_thing_looks_the_same(
    kind: str, size: tuple[float, float, float], ways: int | None
) -> None:
    shape = Shape(kind, size=size)  # type: ignore[arg-type]
    assert symmetry(Body("thing", primitive(shape), shape, True, {}, {}, {})) == ways


def test_grasps_lie_evenly_around_the_axis(start: TaskScene) -> None:
    found = offered(start, "GraspPoses", grasp=GRASP, of="tool.tcp", count=6)
    approaches = [each.properties["target_pose"][:3, 2] for each in found]
    angles = sorted(np.arctan2(a[1], a[0]) for a in approaches)
    assert np.diff(angles) == pytest.approx(np.full(5, np.pi / 3))
    assert all(a[2] == pytest.approx(0.0) for a in approaches)
    assert all(each.properties["target_pose"][:3, 3] == pytest.approx((0.5, -0.25, 0.125)) for each in found)


def test_the_order_of_grasps_is_drawn_once_for_a_seed(start: TaskScene) -> None:
    orders = [[e.comment for e in offered(start, "GraspPoses", grasp=GRASP, count=24)] for _ in range(2)]
    straight = [e.comment for e in offered(start, "GraspPoses", grasp=GRASP, count=24, shuffled=False)]
    assert orders[0] == orders[1] != straight
    assert sorted(orders[0]) == sorted(straight)


def test_a_grasp_family_tells_its_fingers_and_strokes(start: TaskScene) -> None:
    (found,) = offered(start, "GraspPoses", grasp=GRASP, family="side")
    assert found.properties["fingers"] == {"finger_joint": 0.02}
    assert found.properties["approach"].stroke.maximum == pytest.approx(0.15)


def test_an_object_has_to_be_held_to_be_placed(start: TaskScene) -> None:
    stage = STAGES["PlacePoses"]("place", "pick", robot="arm", object="object", pose={"position": [0.6, 0, 0.1]})
    values = {name: stage.properties.value(name) for name in stage.properties.declared}
    (refused,) = stage.generate(start, values, 0)
    assert isinstance(refused, Refusal)
    assert refused.comment == "arm does not hold object"


def test_a_turn_about_a_line_leaves_its_points(start: TaskScene) -> None:
    motion = turned((0.1, 0.2, 0.3), (0.0, 0.0, 2.0), np.pi / 2)
    assert motion @ (0.1, 0.2, 5.0, 1.0) == pytest.approx((0.1, 0.2, 5.0, 1.0))
    assert motion @ (1.1, 0.2, 0.0, 1.0) == pytest.approx((0.1, 1.2, 0.0, 1.0))


def test_inverse_kinematics_starts_from_where_the_robot_stands(start: TaskScene) -> None:
    """The first candidate is near, and those that are near cost less where that is asked for."""
    target = offered(start, "GraspPoses", grasp=GRASP, of="tool.tcp")[0].properties["target"]
    batches = target.batches()
    near, few = next(batches), next(batches)
    assert len(near) <= 1
    here = start.configuration("arm")
    ways = [float(np.abs(each.q - here).sum()) for each in few]
    assert ways == sorted(ways)
    inverse = STAGES["ComputeIK"]("reach", STAGES["NoOp"]("nothing"), robot="arm", target=target, near=True)
    state = State(start, {}, 0)
    values = {name: inverse.properties.value(name) for name in inverse.properties.declared}
    for found in inverse.transform(Solution(inverse.children[0], state, state, 0.0), values, 0):
        if isinstance(found, Result):
            q = found.scene.configuration("arm")
            assert found.cost == pytest.approx(float(np.abs(q[:7] - here[:7]).sum()))
            return
    raise AssertionError("nothing was found")
