"""Robots that are all as late are on their path; otherwise they are compared with the time at which they agree best."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import Motion, RobotState
from kabo.execution.motions import Stretch
from kabo.execution.off_path import LATE_FROM, OffPath, off_path
from kabo.motion import Trajectory
from kabo.scene import Scene, link_poses

ROOT = Path(__file__).parents[2]
SCENES = ("domains/circular_rearrange/n3.yaml", "examples/two_cans/problem.yaml")
LATEST, PROVEN = 0.1, 0.004  # [s]; [m]
FINE = 5e-4  # [m]: as near as times are found


class Proven:
    """As much as is proven of each segment."""

    def of_segment(self, node: str, segment: int) -> float:
        return PROVEN


@pytest.fixture(scope="module", params=SCENES)
def scene(request: pytest.FixtureRequest) -> Scene:
    return kabo.load_scene(kabo.load_problem(ROOT / request.param).scene)


def random_motion(draw: np.random.Generator, scene: Scene) -> Motion:
    """All arms move at once, each by a path of its own with corners, and rest before and after it."""
    stretches = []
    for number, (name, robot) in enumerate(scene.robots.items()):
        start = np.array(scene.start.robots[name][: robot.planned])
        rows = start + np.cumsum(draw.normal(size=(5, len(start))) * 0.15, axis=0)
        times = draw.uniform(0.0, 0.3) + np.cumsum(draw.uniform(0.2, 0.4, size=6))
        path = Trajectory.linear(robot.joint_names[: robot.planned], [start, *rows], times)
        stretches.append(Stretch("n1", number, name, path))
    return Motion(tuple(stretches), (), ("n1",), 0.0, max(each.end for each in stretches))


def rows_at(motion: Motion, scene: Scene, time: float) -> dict[str, np.ndarray]:
    at = np.array([time])
    return {name: motion.rows(own, scene.start.robots[name], at)[0] for name, own in scene.robots.items()}


def late(motion: Motion, scene: Scene, now: float, by: dict[str, float]) -> RobotState:
    rows = {name: tuple(rows_at(motion, scene, now - by[name])[name]) for name in scene.robots}
    return RobotState(now, now, True, rows, {name: (0.0,) * len(row) for name, row in rows.items()})


def compared(motion: Motion, scene: Scene, state: RobotState, since: float) -> OffPath:
    return off_path(scene, Proven(), motion, scene.start.robots, state, since)  # type: ignore[arg-type]


def distance(scene: Scene, name: str, first: object, second: object) -> float:
    """How far any origin of a link is from where it should be, by the poses of all links."""
    one, other = (link_poses(scene.robots[name], values) for values in (first, second))
    return max(float(np.linalg.norm(one[k][:3, 3] - other[k][:3, 3])) for k in one)


@pytest.mark.parametrize("seed", range(25))
def test_robots_that_are_all_as_late_are_on_their_path(seed: int, scene: Scene) -> None:
    draw = np.random.default_rng(seed)
    motion = random_motion(draw, scene)
    now, by = draw.uniform(0.2, motion.end), draw.uniform(0.0, LATEST)
    found = compared(motion, scene, late(motion, scene, now, dict.fromkeys(scene.robots, by)), now - LATEST)
    assert all(own.off <= max(FINE, LATE_FROM * PROVEN) for own in found.robots.values())
    assert now - LATEST <= found.time <= now


@pytest.mark.parametrize("seed", range(25))
def test_what_is_off_is_measured_where_robots_agree_best(seed: int, scene: Scene) -> None:
    """Each distance is the one at the time that is found, and at no other time they are much nearer together."""
    draw = np.random.default_rng(100 + seed)
    motion = random_motion(draw, scene)
    now = draw.uniform(0.3, motion.end)
    state = late(motion, scene, now, {name: draw.uniform(0.0, 0.25) for name in scene.robots})
    since = now - draw.uniform(0.0, LATEST)
    found = compared(motion, scene, state, since)
    assert since - 1e-9 <= found.time <= now
    for name, own in found.robots.items():
        there = distance(scene, name, state.positions[name], rows_at(motion, scene, found.time)[name])
        assert own.off == pytest.approx(there, abs=1e-9)
    squares = [
        sum(distance(scene, n, state.positions[n], rows_at(motion, scene, time)[n]) ** 2 for n in scene.robots)
        for time in np.linspace(since, now, 60)
    ]
    asked = any(
        distance(scene, name, state.positions[name], rows_at(motion, scene, now)[name]) > LATE_FROM * PROVEN
        for name in scene.robots
    )
    reached = sum(own.off**2 for own in found.robots.values())
    assert np.sqrt(reached) <= np.sqrt(min(squares)) + FINE if asked else found.time == now


def test_a_robot_that_was_to_have_begun_is_not_free_to_be_anywhere(scene: Scene) -> None:
    """Before it begins nothing is proven of a robot that rests; it is late all the same, or off its path."""
    motion = random_motion(np.random.default_rng(7), scene)
    first = min(motion.stretches, key=lambda each: each.begin)
    now = first.begin + 0.05
    state = late(motion, scene, now, dict.fromkeys(scene.robots, 0.0))
    values = list(state.positions[first.robot])
    values[1] -= 0.3
    pushed = RobotState(now, now, True, {**state.positions, first.robot: tuple(values)}, state.velocities)
    own = compared(motion, scene, pushed, now - LATEST).robots[first.robot]
    assert own.permitted == PROVEN < own.off


def test_nothing_counts_from_before_a_hand_has_acted(scene: Scene) -> None:
    motion = random_motion(np.random.default_rng(3), scene)
    now = 0.6 * motion.end
    state = late(motion, scene, now, dict.fromkeys(scene.robots, 0.08))
    assert max(own.off for own in compared(motion, scene, state, now - 0.02).robots.values()) > FINE
    assert max(own.off for own in compared(motion, scene, state, now - 0.09).robots.values()) <= FINE
