"""Straight lines: bounded deviation, no jumps, within limits, and a reason where there is none."""

import numpy as np
import pinocchio as pin
import pytest

from kabo.kinematics import FrameFeature, OffLine, rows_of, sample, satisfied, stacked, straight_line, tool_lines
from kabo.streams import stream_key
from tests.kinematics.trees import planar, seven_axes, twin

ARM = seven_axes()
TREE = ARM.tree
TOOL = pin.SE3(pin.exp3(np.array([0.1, 0.3, -0.2])), np.array([0.02, 0.01, 0.2])).homogeneous
READY = np.array([0.0, 0.2, 0.1, -1.9, 0.1, 2.2, 0.5])


def tool_pose(q, joint=7, arm=ARM, tool=TOOL):
    return arm.poses(q)[joint].homogeneous @ tool


def worst(way, translation, joint=7, arm=ARM, tool=TOOL):
    """The largest distance from the segment, and the largest turn, of densely sampled poses; from pinocchio."""
    start, shift = tool_pose(way[0], joint, arm, tool), np.asarray(translation, float)
    away, turn = 0.0, 0.0
    for a, b in zip(way, way[1:], strict=False):
        for t in np.linspace(0, 1, 25):
            pose = tool_pose(a + t * (b - a), joint, arm, tool)
            e = pose[:3, 3] - start[:3, 3]
            share = np.clip(e @ shift / (shift @ shift), 0, 1)
            away = max(away, np.linalg.norm(e - share * shift))
            turn = max(turn, np.linalg.norm(pin.log3(start[:3, :3].T @ pose[:3, :3])))
    return away, turn


@pytest.mark.parametrize("translation", [(0, 0, 0.1), (0, 0, -0.15), (0.1, -0.1, 0.02), (0, 0.3, 0), (1e-5, 0, 0)])
def test_the_tool_stays_on_the_line_and_turned_as_it_was(translation):
    way = straight_line(TREE, READY, 7, TOOL, translation)
    assert not isinstance(way, OffLine)
    away, turn = worst(way, translation)
    assert away <= 1e-3
    assert turn <= 5e-3
    assert np.allclose(tool_pose(way[-1])[:3, 3], tool_pose(READY)[:3, 3] + translation, atol=1e-6)


def test_a_tighter_deviation_takes_more_way_points_and_is_kept():
    coarse = straight_line(TREE, READY, 7, TOOL, (0, 0, 0.2))
    fine = straight_line(TREE, READY, 7, TOOL, (0, 0, 0.2), deviation=1e-4, tilt=5e-4)
    away, turn = worst(fine, (0, 0, 0.2))
    assert len(fine) > len(coarse)
    assert away <= 1e-4
    assert turn <= 5e-4


def test_joints_move_little_between_way_points_and_stay_within_limits():
    way = straight_line(TREE, READY, 7, TOOL, (0.1, 0.2, 0.1))
    assert np.abs(np.diff(way, axis=0)).max() <= 0.5
    assert np.all((TREE.lower <= way) & (way <= TREE.upper))


def test_way_points_are_rounded_as_plans_store_them():
    way = straight_line(TREE, READY, 7, TOOL, (0, 0, 0.1))
    assert np.array_equal(way, np.round(way, 9))


def test_a_redundant_arm_passes_by_a_limit_of_one_joint():
    """Held joint by joint, the rest makes up for it; the joint stands exactly at what a plan can store."""
    free = straight_line(TREE, READY, 7, TOOL, (-0.3, 0, 0))
    joint = int(np.argmax(np.abs(free[-1] - READY)[[0, 2, 4, 6]])) * 2
    end, high, low = free[-1][joint], TREE.upper.copy(), TREE.lower.copy()
    middle = 0.5 * (READY[joint] + end) + 1e-10 / 3
    (high if end > READY[joint] else low)[joint] = middle
    way = straight_line(TREE._replace(lower=low, upper=high), READY, 7, TOOL, (-0.3, 0, 0))
    assert not isinstance(way, OffLine)
    assert np.all((low <= way) & (way <= high))
    assert abs(way[-1][joint] - middle) <= 1e-9
    away, turn = worst(way, (-0.3, 0, 0))
    assert away <= 1e-3
    assert turn <= 5e-3


def test_a_joint_at_its_limit_is_named():
    low, active = TREE.lower.copy(), np.array([True, True, False, True, True, True, True])
    low[3] = READY[3] - 0.02
    found = straight_line(TREE._replace(lower=low), READY, 7, TOOL, (-0.3, 0, 0), active=active)
    assert isinstance(found, OffLine)
    assert (found.reason, found.joint) == ("limit", 3)
    assert 0.0 <= found.travelled < 0.3


def test_a_line_out_of_reach_is_refused_where_reach_ends():
    found = straight_line(TREE, READY, 7, TOOL, (3.0, 0, 0))
    assert isinstance(found, OffLine)
    assert found.travelled < 1.0


def test_a_line_through_a_singularity_is_not_jumped_over():
    """The elbow of a planar arm stretches; beyond there is nothing, and no flip is taken for it."""
    arm = planar(3, limits=10.0)
    q = np.array([0.6, -1.2, 0.6])
    found = straight_line(arm.tree, q, 3, np.eye(4), (0.7, 0, 0))
    assert isinstance(found, OffLine)
    assert found.reason in ("singular", "out_of_reach")
    reached = 2.0 - np.linalg.norm(arm.poses(q)[3].translation)
    assert found.travelled <= reached + 1e-6


def test_a_redundant_arm_keeps_what_it_is_told_to_keep():
    """Five axes cannot hold an orientation: the tool keeps pointing down, and may turn about itself."""
    steps = [(0, 0, 0.2), (0.3, 0, 0), (0.3, 0, 0), (0.1, 0, 0), (0, 0, 0)]
    tilts = [(0, 0, 0), (np.pi / 2, 0, 0), (0, 0, 0), (0, 0, 0), (0, np.pi / 2, 0)]
    chain = [
        (j, 0, pin.SE3(pin.exp3(np.array(r, float)), np.array(t, float)), j, 1.0, 0.0)
        for j, (t, r) in enumerate(zip(steps, tilts, strict=True))
    ]
    arm = twin(chain)
    tip = FrameFeature(5, "line", (0, 0, 0.1), (0, 0, 1))
    down = rows_of("opposed", tip, FrameFeature(0, "line", (0, 0, 0), (0, 0, 1)))
    high = rows_of(
        "height", FrameFeature(5, "point", (0, 0, 0.1)), FrameFeature(0, "plane", (0, 0, 0), (0, 0, 1)), 0.2, 0.3
    )
    free = np.ones(5, bool)
    Q, right = sample(
        arm.tree, stacked([down, high]), stream_key("down"), 0, 40, arm.tree.lower, arm.tree.upper, free
    )
    tool = pin.SE3(np.eye(3), np.array([0, 0, 0.1])).homogeneous
    found = 0
    for q in Q[right][:10]:
        q = exact(arm.tree, stacked([down]), q)
        way = straight_line(arm.tree, q, 5, tool, (0, 0, 0.05), keep=down)
        if isinstance(way, OffLine):
            continue
        found += 1
        assert worst(way, (0, 0, 0.05), 5, arm, tool)[0] <= 1e-3
        for a, b in zip(way, way[1:], strict=False):
            for t in np.linspace(0, 1, 10):
                assert satisfied(down, a + t * (b - a), arm.tree, 5e-3)
    assert found >= 3


def exact(tree, rows, q):
    from kabo.kinematics import project

    rows = rows.copy()
    rows[:, 18] = 1e-9
    Q, right = project(tree, rows, q, tree.lower, tree.upper, np.ones(tree.size, bool))
    assert right[0]
    return Q[0]


def test_only_active_joints_move_along_the_line():
    active = np.ones(7, bool)
    active[2] = False
    way = straight_line(TREE, READY, 7, TOOL, (0, 0, 0.1), active=active)
    assert np.all(way[:, 2] == READY[2])


def test_no_translation_is_no_motion():
    assert np.array_equal(straight_line(TREE, READY, 7, TOOL, (0, 0, 0)), READY[None])


def test_what_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="q must be finite"):
        straight_line(TREE, READY[:6], 7, TOOL, (0, 0, 0.1))
    with pytest.raises(ValueError, match="do not hold"):
        keep = rows_of(
            "opposed", FrameFeature(7, "line", (0, 0, 0), (0, 0, 1)), FrameFeature(0, "line", (0, 0, 0), (1, 0, 0))
        )
        straight_line(TREE, READY, 7, TOOL, (0, 0, 0.1), keep=keep)


@pytest.mark.parametrize("seed", range(12))
def test_a_line_that_is_followed_in_a_kernel_is_the_one_of_single_steps(seed):
    """Projections and proofs of single steps, as they are asked when a line fails."""
    rng = np.random.default_rng(seed)
    start, shift = READY + rng.uniform(-0.3, 0.3, 7), rng.normal(size=3)
    length = float(np.linalg.norm(shift) * 0.25)
    shift *= length / np.linalg.norm(shift)
    rows = tool_lines._line_rows(TREE, start, 7, TOOL, shift / length, None)
    tolerances = tool_lines._tolerances(rows, 1e-3, 5e-3)
    steps = tool_lines._Follower(TREE, rows, np.ones(7, bool), tolerances)
    way, here, share, fault = [start], 0.0, 1.0, None
    while here < 1.0 and fault is None:
        there = min(1.0, here + share)
        q = steps.configuration_at(way[-1], there * length)
        failed = steps.fault(way[-1], q, here * length, there * length)
        if failed is None:
            way.append(q)
            share, here = 2.0 * (there - here), there
        else:
            share = 0.5 * (there - here)
            fault = failed if share < tool_lines.MIN_LINE_SHARE else None
    found = straight_line(TREE, start, 7, TOOL, shift)
    assert found == fault if isinstance(found, OffLine) else np.array_equal(found, way)
