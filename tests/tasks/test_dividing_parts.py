"""What lies between a coarse cover and epsilon is found: refused at effort 0, and possible where parts are divided."""

from pathlib import Path

import pytest
import trimesh

from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language import load_problem
from kabo.language.formulas import GroundCall
from kabo.language.problem import Problem
from kabo.planner.solve import solve
from kabo.scene import load_scene
from kabo.tasks.procedures import GeometricProcedures
from kabo.verify.verification import verify
from tests.planner.gantry import gantry

EPSILON, GAP, RADIUS = 0.001, 0.0013, 0.1  # [m]
TAKE = GroundCall("pick", ("gantry", "cube"), ())


@pytest.fixture
def problem(tmp_path: Path) -> Problem:
    """A cube between two balls, given as meshes, each a little more than epsilon away from it."""
    trimesh.creation.icosphere(4, RADIUS).export(tmp_path / "ball.stl")
    path = gantry(tmp_path, epsilon=EPSILON)
    away = 0.02 + GAP + RADIUS
    balls = "".join(
        f"ball_{i}: {{mesh: ball.stl, pose: {{position: [0.2, {y}, 0.1]}}}}, " for i, y in enumerate((away, -away))
    )
    text = path.read_text().replace("bodies: {", "bodies: {" + balls)
    path.write_text(text.replace("position: [0.2, 0.0, 0.02]", "position: [0.2, 0.0, 0.1]"))
    return load_problem(path)


def test_a_way_narrower_than_a_coarse_cover_takes_more_effort(problem: Problem, tmp_path: Path) -> None:
    assert problem.scene is not None
    server = GeometryServer(load_scene(problem.scene))
    asked, start = GeometricProcedures(server, tmp_path), Situation.of(server.scene.start)
    refused = asked.call(TAKE, start)
    assert isinstance(refused, Refusal) and not refused.proof
    assert isinstance(asked.call(TAKE, start, effort=1), Success)


def test_a_plan_through_it_is_found_and_proven(problem: Problem) -> None:
    result = solve(problem, timeout=200.0)
    assert result.plan is not None, result.reason
    assert verify(problem, result.plan).ok
