"""What is left of a motion of two robots at a time: the planner and the verifier speak of the same path."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.planner.certify.motion_stretches import stretches
from kabo.planner.certify.overlapping_pairs import from_time_on
from kabo.scene import load_scene
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.trajectories.judge import followed
from kabo.verify.motion.windows import rest_of, window_path, windows
from tests.verify import bench as by_hand
from tests.verify.smooth import smooth_node


def slower(segment, factor):
    """The segment with all times multiplied."""
    times, own = tuple(factor * t for t in segment.times), segment.trajectory.scaled(factor)
    return replace(
        segment, times=times, trajectory=replace(own, times=tuple(factor * t for t in segment.trajectory.times))
    )


@pytest.mark.parametrize("which", ["with trajectories", "one without", "both without"])
@pytest.mark.parametrize("share", [0.0137, 0.5, 0.9871])
@pytest.mark.parametrize("factor", [1.0, 1000.0])
def test_the_rest_of_two_motions_at_once_is_the_same_for_planner_and_verifier(tmp_path, which, share, factor):
    scene = load_scene(by_hand.load(tmp_path).problem.scene)
    motion = [slower(each, factor) for each in smooth_node(by_hand.lift_both(delay=0.1), scene).motion]
    for i in range({"with trajectories": 0, "one without": 1, "both without": 2}[which]):
        motion[-1 - i] = replace(motion[-1 - i], trajectory=None)
    robots, start = dict(scene.robots), {name: np.array(q) for name, q in scene.start.robots.items()}
    (stretch,) = [each for each in stretches(motion, robots, start) if len(each.segments) == 2]
    (window,) = [each for each in windows(motion) if len(each.running) == 2]
    time = stretch.times[0] + share * (stretch.times[-1] - stretch.times[0])
    rows, deviations = from_time_on(stretch, motion, robots, time)
    before = {name: rows[0] for name, rows in stretch.waypoints.items()}
    path = window_path(window, motion, SceneModel(scene).arms, before, [followed(each) for each in motion])
    rest = rest_of(path, time)
    assert np.abs(stretch.together - path.deviations).max() < 1e-9
    assert np.abs(rows - rest.configurations).max() < 1e-9
    assert np.abs(deviations - rest.deviations).max() < 1e-9
    assert len(path.times) < 1000
    assert (deviations.max() > 1e-9) == (which != "both without")
