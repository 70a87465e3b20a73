"""What a camera sees is checked on the original meshes: plans whose looks do not see are refused, with the reason."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

import kabo
from kabo.language.problem import Problem
from kabo.plan import Plan
from kabo.verify.motion.views import _among, _distance
from tests.domains.families import generated


@cache
def one_box() -> tuple[Problem, Plan]:
    """INSPECTION with a single box, and its plan."""
    with TemporaryDirectory() as folder:
        problem = generated(Path(folder), "inspection", n=1)
        plan = kabo.solve(problem).plan
    assert plan is not None
    return problem, plan


def with_sensor(**changes: object) -> Problem:
    """The problem with another camera."""
    problem = one_box()[0]
    assert problem.scene is not None
    arm = problem.scene.robots["arm"]
    eye = replace(arm.sensors["eye"], **changes)
    robots = {"arm": replace(arm, sensors={"eye": eye})}
    return replace(problem, scene=replace(problem.scene, robots=robots))


def unseen(problem: Problem) -> list[str]:
    found = kabo.verify(problem, one_box()[1]).findings
    return [finding.message for finding in found if "is not seen" in finding.message]


def test_the_plan_of_the_planner_is_accepted() -> None:
    problem, plan = one_box()
    assert kabo.verify(problem, plan).findings == ()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"range": (0.1, 0.15)}, "too far for eye"),
        ({"range": (0.5, 0.9)}, "too near for eye"),
        ({"field_of_view": (math.radians(2),)}, "outside of the field of view of eye"),
        ({"field_of_view": (math.radians(60), math.radians(2))}, "outside of the field of view of eye"),
        ({"quaternion": (1.0, 0.0, 0.0, 0.0)}, "outside of the field of view of eye"),
        ({"position": (0.0, 0.0, -0.02)}, "is in the way"),
    ],
)
def test_a_camera_that_does_not_see_the_object_refutes_the_plan(changes: dict[str, object], text: str) -> None:
    (message,) = unseen(with_sensor(**changes))
    assert message.startswith("sense(arm, box_1): box_1 is not seen: ")
    assert text in message


def test_something_small_among_the_sight_lines_is_found_although_it_touches_nothing() -> None:
    problem, plan = one_box()
    assert problem.scene is not None
    crumb = replace(
        problem.scene.bodies["panel"],
        name="crumb",
        movable=False,
        shape=replace(problem.scene.bodies["box_1"].shape, size=(0.004, 0.004, 0.004)),
        pose=replace(problem.scene.bodies["panel"].pose, frame="table", position=(-0.1, 0.22, 0.09)),
        grasps={},
        placements={},
    )
    scene = replace(problem.scene, bodies={**problem.scene.bodies, "crumb": crumb})
    assert any("crumb is in the way" in message for message in unseen(replace(problem, scene=scene)))


def test_the_distance_of_a_triangle_is_that_of_its_nearest_point() -> None:
    rng = np.random.default_rng(5)
    shares = rng.dirichlet((1, 1, 1), 20000)
    for _ in range(40):
        corners = rng.uniform(-1, 1, (3, 3)) + rng.uniform(-1, 1, 3)
        sampled = np.linalg.norm(shares @ corners, axis=1).min()
        assert _distance(corners) <= sampled + 1e-12
        assert sampled - _distance(corners) < 0.05


def test_a_point_is_among_sight_lines_where_it_is_between_apex_and_triangle() -> None:
    triangle = np.array([[[1.0, 0, 1], [0, 1, 1], [-1, -1, 1]]])
    assert _among(np.array([0.0, 0.0, 0.5]), np.zeros(3), triangle)
    assert not _among(np.array([0.0, 0.0, 1.01]), np.zeros(3), triangle)
    assert not _among(np.array([0.5, 0.5, 0.5]), np.zeros(3), triangle)
    assert not _among(np.array([0.0, 0.0, -0.1]), np.zeros(3), triangle)
