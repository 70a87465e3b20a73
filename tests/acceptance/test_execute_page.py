"""docs/how-to/execute.md: its program runs, and its goals say exactly what the plan's polynomials are."""

import numpy as np
import pytest
from scipy.interpolate import BPoly

from tests.support.page_steps import REPOSITORY, steps

PAGE = REPOSITORY / "docs" / "how-to" / "execute.md"


@pytest.fixture(scope="module")
def made() -> dict:
    """The names that the page's program has defined at its end."""
    found: dict = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(REPOSITORY)
        exec("\n".join(step.text for step in steps(PAGE) if step.verb == "python"), found)  # noqa: S102
    return found


def test_samples_have_the_rate_the_page_says_and_its_derivatives(made):
    samples, arm = made["samples"], made["arm"]
    assert np.diff(samples.times)[:-1] == pytest.approx(0.001, abs=1e-12)
    assert (samples.times[0], samples.times[-1]) == (arm.times[0], arm.times[-1])
    change = np.gradient(samples.positions[:-1], 0.001, axis=0)[1:-1]
    assert change == pytest.approx(samples.velocities[1:-2], abs=1e-3)
    change = np.gradient(samples.velocities[:-1], 0.001, axis=0)[1:-1]
    assert change == pytest.approx(samples.accelerations[1:-2], abs=0.1)


def test_a_controller_that_joins_the_points_of_a_goal_by_quintics_follows_the_plan(made):
    """scipy makes the quintics through positions, velocities and accelerations, as ros2_control does."""
    segments = [segment for node in made["plan"].nodes.values() for segment in node.motion]
    assert len(segments) == len(made["goals"]) > 4
    for segment, (robot, goal) in zip(segments, made["goals"], strict=True):
        own = segment.trajectory
        assert (robot, goal["joint_names"]) == (segment.robot, list(segment.joints))
        times = np.array([point["time_from_start"] for point in goal["points"]])
        at = np.linspace(0.0, times[-1], 2000)
        for joint in range(len(own.joints)):
            ends = [
                [point[key][joint] for key in ("positions", "velocities", "accelerations")]
                for point in goal["points"]
            ]
            joined = BPoly.from_derivatives(times, ends)
            assert np.abs(joined(at) - own.at(own.times[0] + at)[:, joint]).max() < 1e-8


def test_every_motion_of_the_plan_begins_and_ends_at_rest(made):
    for node in made["plan"].nodes.values():
        if node.motion:
            for own, at in ((node.motion[0].trajectory, 0), (node.motion[-1].trajectory, -1)):
                for order in (1, 2):
                    assert own.at(own.times[at], order) == pytest.approx(0.0, abs=1e-8)
