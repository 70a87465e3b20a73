"""Both sides of `visible`: nothing in the way is overlooked, and no view that is wider than epsilon is refused.

The judge is fcl's distance between an obstacle and the hull of the camera's point and the object.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import GeometryServer, ScenePredicates
from kabo.geometry_server.sight.views import CONTACT
from kabo.language import load_scene_description
from kabo.scene import Attachment, GeometricState, Scene, link_poses, load_scene
from kabo.scene.transforms import quaternion, rotation
from tests.conftest import PROPERTY_SCALE
from tests.support.oracles import fcl_distance
from tests.support.small_robots import ARM

TOLERANCE = 1e-6  # [m] of the judge
COUNT = max(30, round(600 * PROPERTY_SCALE))
EPSILON, HALF, NEAR, FAR = 0.01, np.radians(30), 0.15, 0.9
SCENE = f"""
scene: sight
epsilon: {EPSILON}
robots:
  arm:
    urdf: small.urdf
    sensors:
      eye: {{frame: base, pose: {{position: [0, 0, 0.2]}}, field_of_view: 60 deg, range: [{NEAR}, {FAR}],
            allowed: [upper, lower, left, right]}}
objects:
  cube: {{box: [0.06, 0.08, 0.05], movable: true}}
  tin: {{cylinder: {{radius: 0.03, height: 0.1}}, movable: true}}
  ball: {{sphere: {{radius: 0.04}}, movable: true}}
  plate: {{box: [0.2, 0.15, 0.004], movable: true}}
"""
OBJECTS = ("cube", "tin", "ball")
unit = st.floats(-1.0, 1.0)
turns = st.tuples(unit, unit, unit, unit).filter(lambda q: np.linalg.norm(q) > 0.1)
points = st.tuples(unit, unit, st.floats(0.0, 1.0))


@cache
def scene() -> Scene:
    with TemporaryDirectory() as folder:
        (Path(folder) / "small.urdf").write_text(ARM)
        (Path(folder) / "scene.yaml").write_text(SCENE)
        return load_scene(load_scene_description(Path(folder) / "scene.yaml"))


def placed(position, turn) -> Attachment:
    matrix = rotation(turn)
    x, y, z = (float(v) for v in position)
    return Attachment("world", (x, y, z), quaternion(matrix))


def pose_of(held: Attachment) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation(held.quaternion), held.position
    return pose


def asked(name: str, body: Attachment, plate: Attachment) -> ScenePredicates:
    """Predicates on a state with one object and a plate; the others are far behind the camera."""
    away = {other: placed((5.0 + i, 0.0, -5.0), (0, 0, 0, 1)) for i, other in enumerate(scene().bodies)}
    state = GeometricState(scene().start.robots, {**away, name: body, "plate": plate})
    return GeometryServer(scene()).predicates(state)


def world_points(name: str, held: Attachment) -> np.ndarray:
    pose = pose_of(held)
    return scene().bodies[name].mesh.vertices @ pose[:3, :3].T + pose[:3, 3]


def view(name: str, body: Attachment, shift: float = 0.0) -> float:
    """By how much the object is within angle and range [m], by its vertices; negative if it is not."""
    apex = link_poses(scene().robots["arm"], scene().start.robots["arm"])["base"][:3, 3] + (0.0, 0.0, 0.2)
    at = world_points(name, body) - apex
    aside = np.hypot(at[:, 0], at[:, 1])
    return float(
        min((at[:, 2] * np.sin(HALF) - aside * np.cos(HALF)).min(), FAR - np.linalg.norm(at, axis=1).max())
    )


APEX = np.array([0.0, 0.0, 0.2])


@settings(max_examples=COUNT)
@given(name=st.sampled_from(OBJECTS), turn=turns, at=points, share=st.floats(0.1, 1.1), aside=points, tilt=turns)
def test_a_plate_in_the_way_is_never_overlooked_and_one_out_of_the_way_by_epsilon_never_counts(
    name, turn, at, share, aside, tilt
):
    body = placed((0.15 * at[0], 0.15 * at[1], 0.4 + 0.5 * at[2]), turn)
    middle = APEX + share * (np.array(body.position) - APEX)
    plate = placed(middle + 0.25 * np.array(aside) * (1, 1, 0.2), tilt)
    cone = np.vstack([APEX, world_points(name, body)])
    other = scene().bodies["plate"].mesh.vertices
    distance = fcl_distance(cone, np.eye(4), other, pose_of(plate))
    touching = fcl_distance((world_points(name, body)), np.eye(4), other, pose_of(plate))
    predicates = asked(name, body, plate)
    unseen = predicates.unseen("arm.eye", name)
    hidden = unseen is not None and unseen.reason == "hidden"
    within = view(name, body)
    event("hidden" if hidden else "out of view" if unseen else "seen")
    if unseen is None:
        assert within > -1e-6
        assert distance > 0.0 or (touching < EPSILON and _shortened(name, body, plate) > 0.0)
    if hidden:
        assert unseen.by == "plate"
        assert distance < EPSILON + TOLERANCE
    if unseen is not None and not hidden:
        nearest = fcl_distance((world_points(name, body)), np.eye(4), _point(), np.eye(4))
        assert within < EPSILON or nearest < NEAR + EPSILON + 4e-3


def _shortened(name: str, body: Attachment, plate: Attachment) -> float:
    """The distance of the plate from the sight lines without their last two millimetres."""
    points = APEX + (1 - CONTACT / np.linalg.norm(world_points(name, body) - APEX, axis=1).max()) * (
        world_points(name, body) - APEX
    )
    cone = np.vstack([APEX, points])
    return fcl_distance(cone, np.eye(4), (scene().bodies["plate"].mesh.vertices), pose_of(plate))


def _point():
    return APEX + 4e-3 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.parametrize("height", [0.0, 0.001])
def test_a_plate_below_an_object_does_not_hide_it_and_one_that_lies_on_it_does(height: float) -> None:
    body = placed((0.0, 0.0, 0.6), (0, 0, 0, 1))
    below = asked("cube", body, placed((0, 0, 0.6 + 0.025 + 0.002 + height), (0, 0, 0, 1)))
    above = asked("cube", body, placed((0, 0, 0.6 - 0.025 - 0.002 - height), (0, 0, 0, 1)))
    assert below.visible("arm.eye", "cube")
    assert str(above.unseen("arm.eye", "cube")) == "hidden by plate"


@pytest.mark.parametrize(
    ("position", "text"),
    [
        ((0.0, 0.0, 0.36), "15 mm too near"),
        ((0.0, 0.0, 1.2), "126 mm too far"),
        ((0.4, 0.0, 0.6), "outside of the field of view by"),
    ],
)
def test_what_is_missing_is_told_in_numbers(position, text: str) -> None:
    asked_of = asked("cube", placed(position, (0, 0, 0, 1)), placed((5, 5, 5), (0, 0, 0, 1)))
    assert str(asked_of.unseen("arm.eye", "cube")).startswith(text)
