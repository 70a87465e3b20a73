"""What rests and what goes on between the segments of a node."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.motion import Trajectory
from kabo.plan import Segment
from kabo.scene import load_scene
from kabo.verify.motion.arms import Arm
from kabo.verify.motion.trajectories.borders import check_borders
from kabo.verify.motion.trajectories.judge import followed
from tests.verify import bench
from tests.verify.smooth import quintics

JOINTS = ("x", "y", "z", "tilt")
PATH = ((0.0, 0.0, -0.2, 0.0), (0.2, 0.0, -0.2, 0.0))


@pytest.fixture(scope="module")
def arms(tmp_path_factory) -> dict[str, Arm]:
    problem = bench.load(tmp_path_factory.mktemp("bench")).problem
    assert problem.scene is not None
    return {name: Arm(robot) for name, robot in load_scene(problem.scene).robots.items()}


def halves(**changes) -> list[Segment]:
    """One motion of 1 s in two segments, cut in its midst where x is fast."""
    whole = Segment("left", JOINTS, PATH, (0.0, 1.0), "move")
    powers = np.array(quintics(whole, (0.0, 1.0)).coefficients[0][0])
    later = np.polynomial.Polynomial(powers)(np.polynomial.Polynomial([0.5, 1.0])).coef
    middle = (0.1, 0.0, -0.2, 0.0)
    rest = ((0.0,), (-0.2,), (0.0,))
    first = Trajectory(JOINTS, (PATH[0], middle), (0.0, 0.5), ((tuple(powers), *rest),), 1e-9)
    second = Trajectory(JOINTS, (middle, PATH[1]), (0.5, 1.0), ((tuple(map(float, later)), *rest),), 1e-9)
    segments = [
        Segment("left", JOINTS, own.waypoints, own.times, "move", trajectory=own) for own in (first, second)
    ]
    return [replace(segments[0], **changes), segments[1]]


def texts(segments: list[Segment], arms: dict[str, Arm]) -> list[str]:
    return [f.message for f in check_borders("n0", segments, [followed(s) for s in segments], arms)]


def shifted(segment: Segment, by: float) -> Segment:
    times = tuple(t + by for t in segment.times)
    return replace(segment, times=times, trajectory=replace(segment.trajectory, times=times))


def test_a_motion_may_go_on_through_two_segments(arms):
    assert texts(halves(), arms) == []


def test_it_must_rest_where_something_is_attached(arms):
    (first, second) = texts(halves(attach=(("peg", "left.palm"),)), arms)
    assert first == (
        "segment 0: left.x has a velocity of 0.375 m/s where something is attached or detached, where it must rest"
    )
    assert second.startswith("segment 1: left.x has a velocity of 0.375 m/s")


def test_it_must_rest_before_a_pause(arms):
    first, second = halves()
    assert all("where its motion pauses" in t for t in texts([first, shifted(second, 0.1)], arms))
    assert len(texts([first, shifted(second, 0.1)], arms)) == 2


def test_it_must_rest_where_it_begins_and_ends(arms):
    first, second = halves()
    assert "where its motion ends" in texts([first], arms)[0]
    assert "where its motion begins" in texts([second], arms)[0]


def test_it_must_rest_before_its_hand_acts(arms):
    first, _ = halves()
    hand = Segment("left", ("finger",), ((0.045,), (0.02,)), (0.5, 2.0), "grasp")
    hand = replace(hand, trajectory=quintics(hand, hand.times))
    assert "between a motion of its arm and one of its hand" in texts([first, hand], arms)[0]


def test_another_robot_does_not_matter(arms):
    first, second = halves()
    other = replace(second, robot="right")
    found = texts([first, second, other], arms)
    assert len(found) == 1 and found[0].startswith("segment 2: right.x has a velocity")


@pytest.mark.parametrize(
    ("power", "what", "unit"), [(0, "position", "m"), (1, "velocity", "m/s"), (2, "acceleration", "m/s²")]
)
def test_a_jump_between_two_segments_is_told(power, what, unit, arms):
    first, second = halves()
    powers = [*second.trajectory.coefficients[0][0]]
    powers[power] += 1e-6
    own = replace(second.trajectory, coefficients=((tuple(powers), *second.trajectory.coefficients[0][1:]),))
    found = texts([first, replace(second, trajectory=own)], arms)
    size = "2e-06" if power == 2 else "1e-06"
    assert f"segment 1: the {what} of left.x jumps by {size} {unit} where it begins" in found
