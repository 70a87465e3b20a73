"""Costs of motion, of solutions that are put together by hand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, candidate, tool_frame
from kabo.motion import Trajectory
from kabo.tasks.core import Serial, Solution, State
from kabo.tasks.robots import (
    NoOp,
    Stretch,
    TaskScene,
    clearance,
    distance_to_reference,
    duration,
    path_length,
    segments,
    stretch,
    tool_distance,
)
from kabo.tasks.robots.timed_paths import TimedPath

BARTENDER = "bartender/four_bottles.yaml"
First = Callable[..., TaskScene]
UP = np.array([0.3, -0.2, 0.1, 0.0, 0.0, 0.0, 0.0])  # of the arm, and nothing of the gripper


def moved(scene: TaskScene, *ways: list[Any]) -> Solution:
    """A serial solution of one part for each way of `left`."""
    parts, here = [], scene
    for k, way in enumerate(ways):
        there = here.at("left", way[-1])
        motion = (stretch(here, "left", "arm", way),)
        parts.append(Solution(NoOp(f"part {k}"), State(here, {}, k), State(there, {}, k + 1), 0.0, "", motion))
        here = there
    return Solution(Serial("all"), State(scene, {}, 0), State(here, {}, 9), 0.0, parts=tuple(parts))


def home(scene: TaskScene) -> np.ndarray:
    return scene.configuration("left")


def test_path_length_adds_all_joints_and_parts(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = home(scene)
    assert path_length(moved(scene, [q, q + UP, q], [q, q - UP])) == pytest.approx(3 * 0.6)


def test_what_does_not_move_costs_nothing(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    still = Solution(NoOp("still"), State(scene, {}, 0), State(scene, {}, 1), 0.0, motion=())
    assert [term(still) for term in (path_length, duration, tool_distance)] == [0.0, 0.0, 0.0]
    assert clearance()(still) == (0.0, "")


def test_the_tool_goes_as_far_as_its_frame(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = home(scene)
    frame = tool_frame(scene.robot("left"))
    a, b = (candidate(scene.robot("left"), each).pose(frame)[:3, 3] for each in (q, q + UP))
    assert tool_distance(moved(scene, [q, q + UP])) == pytest.approx(float(np.linalg.norm(b - a)), abs=1e-6)


def test_duration_is_that_of_the_segments(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = home(scene)
    robot = scene.robot("left")
    slowest = float((np.abs(UP[:6]) / robot.tree.velocity[:6]).max())
    solution = moved(scene, [q, q + UP])
    assert duration(solution) > slowest
    assert duration(solution) == segments(solution, scene.context.scene, "x")[-1].times[-1]


def test_the_accelerations_of_the_scene_hold_in_tasks(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q, robot = home(scene), scene.robot("left")
    slow = replace(robot, acceleration={robot.planned_joints[0]: 0.2})
    given = replace(scene.context.scene, robots={**scene.context.scene.robots, "left": slow})
    slowed = TaskScene.of(GeometryServer(given).context(), given.start)
    (fast,) = segments(moved(scene, [q, q + UP]), scene.context.scene, "x")
    (made,) = segments(moved(slowed, [q, q + UP]), given, "x")
    assert made.trajectory is not None and fast.trajectory is not None
    assert np.abs(made.trajectory.sampled(1000.0).accelerations[:, 0]).max() == pytest.approx(0.2, abs=1e-3)
    assert np.abs(fast.trajectory.sampled(1000.0).accelerations[:, 0]).max() > 1.0


def test_clearance_falls_with_distance_and_says_it(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = home(scene)
    near, far = q.copy(), q.copy()
    near[1] += 0.5  # forward and down
    far[1] -= 0.3
    (cost_near, text), (cost_far, _) = (clearance(1.0, step=0.2)(moved(scene, [q, each])) for each in (near, far))
    assert cost_near > cost_far > 0.0
    assert text == f"clearance {1.0 / cost_near:.4f} m"
    along, _ = clearance(1.0, along=True, step=0.2)(moved(scene, [q, near]))
    assert along < cost_near


def test_the_distance_to_a_reference_is_of_the_end_or_along_the_way(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = home(scene)
    there = moved(scene, [q, q + UP])
    assert distance_to_reference("left", "home")(there) == pytest.approx(0.6)
    assert distance_to_reference("left", "home", along=True)(there) == pytest.approx(0.3)
    first = scene.robot("left").planned_joints[0]
    assert distance_to_reference("left", "home", {first: 3.0})(there) == pytest.approx(0.6 + 2 * 0.3)


def test_a_stretch_with_times_of_its_own_takes_them(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    q = scene.situation.configuration("left")
    end = tuple(round(v, 9) for v in np.array(q) + UP)
    names, times = scene.robot("left").planned_joints, (0.0, 4.25)
    timed = TimedPath(times, Trajectory.linear(names, [q[:6], end[:6]], times))
    each = Stretch("left", "arm", (q, end), timed=timed)
    made = Solution(NoOp("slow"), State(scene, {}, 0), State(scene.at("left", end), {}, 1), 0.0, motion=(each,))
    assert duration(made) == pytest.approx(4.25)
    assert each.reversed().timed is not None
    assert each.reversed().timed.times == (0.0, 4.25)
