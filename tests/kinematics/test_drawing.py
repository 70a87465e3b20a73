"""Samples drawn pose first: valid by pinocchio, even, the same however they are cut, and as brute force has them."""

import numpy as np
import pytest

from kabo.kinematics import (
    ClosedArm,
    FrameFeature,
    drawn,
    drawn_together,
    joined,
    project,
    rows_of,
    stacked,
    values,
)
from kabo.kinematics.drawing import _family_in_world
from kabo.kinematics.inverse import pose_rows
from kabo.kinematics.kernels import drawing as kernels
from kabo.kinematics.kernels.families import poses_drawn
from kabo.scene.structure import Structure, structure_of
from kabo.scene.transforms import unflat
from kabo.streams import stream_key, uniforms
from tests.kinematics.arms import FORMS, arm, narrowed
from tests.kinematics.trees import Twin, seven_axes, violation

KEY = stream_key("drawing", 3)
FLOOR = FrameFeature(0, "plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
NORTH = FrameFeature(0, "plane", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
EAST = FrameFeature(0, "plane", (0.45, 0.0, 0.0), (1.0, 0.0, 0.0))
POST = FrameFeature(0, "line", (0.5, 0.1, 0.2), (0.0, 0.0, 1.0))


def features(joint):
    """A point and three directions of a tool on a joint."""
    tip = (0.02, 0.0, 0.1)
    axes = [FrameFeature(joint, "line", tip, tuple(axis)) for axis in np.eye(3)]
    return FrameFeature(joint, "point", tip), *axes


def closed(made: Twin, tree=None):
    """The arm of a twin, with its closed form."""
    tree = made.tree if tree is None else tree
    form = structure_of(tree, tree.size)
    assert isinstance(form, Structure)
    return ClosedArm(tree, form, np.zeros(tree.size))


SEVEN = seven_axes()
ARM = closed(SEVEN)
TIP, X, Y, Z = features(7)
PLACE = [("height", TIP, FLOOR, 0.1, 0.1), ("opposed", Z, FLOOR, None, None)]
SIDE = [
    ("coincident", TIP, POST, None, None),
    ("perpendicular", Z, POST, None, None),
    ("perpendicular", Y, POST, None, None),
    ("height", TIP, FLOOR, 0.25, 0.35),
]
TURN = rows_of("azimuth", Z, POST)


def rows(constraints):
    """The rows of constraints in the form of `violation`."""
    return stacked([rows_of(*each) for each in constraints])


def worst(constraints, Q, twin):
    """The greatest violation of constraints, by plain geometry at pinocchio's poses."""
    return max(violation(*each, twin.poses(q)) for q in Q for each in constraints)


@pytest.mark.parametrize("form", [form for form in FORMS if form != "five axes"])
@pytest.mark.parametrize("seed", range(3))
def test_samples_of_any_arm_with_a_closed_form_are_valid_by_pinocchio(form, seed):
    rng = np.random.default_rng(seed)
    made = arm(rng, form)
    tree = narrowed(made.tree, rng)
    given = closed(made, tree)
    tip, across, closing, approach = features(len(tree.parent) - 1)
    hand = made.poses(rng.uniform(tree.lower, tree.upper))[-1]  # the families contain a pose that the arm reaches
    at, down, up = hand.act(np.array(tip.origin)), -hand.rotation[:, 2], hand.rotation[:, 0]
    table, post = FrameFeature(0, "plane", tuple(at), tuple(down)), FrameFeature(0, "line", tuple(at), tuple(up))
    top = FrameFeature(0, "plane", tuple(at), tuple(up))
    cases = [
        [("height", tip, table, 0.0, 0.0), ("opposed", approach, table, None, None)],
        [
            ("coincident", tip, post, None, None),
            ("perpendicular", approach, post, None, None),
            ("aligned", across, post, None, None),
            ("height", tip, top, -0.1, 0.1),
        ],
    ]
    found = 0
    for constraints in cases:
        Q, owner = drawn(given, rows(constraints), KEY, 0, 40, every_branch=True)
        assert np.all((tree.lower <= Q) & (tree.upper >= Q))
        assert np.all(np.diff(owner) >= 0)
        assert not len(Q) or worst(constraints, Q, made) < 1e-8
        found += len(Q)
    assert found > 0


def test_a_sample_alone_is_the_same_as_in_a_batch():
    Q, owner = drawn(ARM, rows(SIDE), KEY, 0, 60, free=TURN)
    assert len(Q) > 50
    for i in (0, 17, 59):
        alone, _ = drawn(ARM, rows(SIDE), KEY, i, 1, free=TURN)
        assert np.array_equal(alone, Q[owner == i])
    other, _ = drawn(ARM, rows(SIDE), stream_key("other"), 0, 60, free=TURN)
    assert not np.array_equal(other[:10], Q[:10])


def test_all_branches_hold_the_hand_at_one_pose():
    one, _ = drawn(ARM, rows(SIDE), KEY, 0, 30)
    every, owner = drawn(ARM, rows(SIDE), KEY, 0, 30, every_branch=True)
    assert len(every) > len(one)
    for i in set(owner.tolist()):
        poses = [SEVEN.poses(q)[7].homogeneous for q in every[owner == i]]
        assert np.abs(np.array(poses) - poses[0]).max() < 1e-8
    assert all(np.abs(every - q).max(axis=1).min() < 1e-9 for q in one)


def test_what_is_aimed_at_is_even():
    """36 bins of the height and of the turn, and of places on a table: each within 1 of 20 of the mean."""
    Q, _ = drawn(ARM, rows(SIDE), KEY, 0, 7200, free=TURN)
    table = rows([*PLACE, ("height", TIP, NORTH, -0.3, 0.3), ("height", TIP, EAST, -0.1, 0.1)])
    P, _ = drawn(ARM, table, KEY, 0, 7200)
    for found, coordinate, end in ((Q, TURN, np.pi), (P, table[-2:-1], 0.3), (P, table[-1:], 0.1)):
        assert len(found) > 7190
        at = [values(coordinate, q, ARM.tree)[0] for q in found]
        counts, _ = np.histogram(at, bins=36, range=(-end, end))
        assert counts.max() < 1.05 * 200 and counts.min() > 0.95 * 200


def test_places_lie_as_brute_force_finds_them():
    """Poses on a table, drawn evenly and kept if projection from many seeds reaches them: the same histogram."""
    rng = np.random.default_rng(4)
    made = arm(rng, "wrist and two parallel axes", limits=2.0)
    given = closed(made)
    tip, _, _, approach = features(6)
    at = made.poses(np.full(6, 0.5))[6].act(np.array(tip.origin))
    table = FrameFeature(0, "plane", tuple(at), (0.0, 0.0, 1.0))
    constraints = [("height", tip, table, 0.0, 0.0), ("opposed", approach, table, None, None)]
    family = _family_in_world(given, rows(constraints), None)
    assert family is not None
    Q, _ = drawn(given, rows(constraints), KEY, 0, 4000)
    there = np.array([made.poses(q)[6].translation for q in Q])

    shares = uniforms(stream_key("brute"), 0, 6000, 6)
    centre, reach = given.arrays.centre, given.arrays.reach
    poses, near = poses_drawn(family, np.zeros(6000, np.int64), shares, centre, reach)
    seeds = made.tree.lower + uniforms(stream_key("seeds"), 0, 40, 6) * (made.tree.upper - made.tree.lower)
    active = np.ones(6, bool)

    def reached(pose):
        goal = pose_rows(6, np.eye(4), unflat(pose))
        return project(made.tree, goal, seeds, made.tree.lower, made.tree.upper, active)[1].any()

    kept = np.array([pose[9:] for pose in poses[near] if reached(pose)])
    assert len(kept) > 300
    for axis in range(2):
        span = np.quantile(kept[:, axis], [0.0, 0.2, 0.4, 0.6, 0.8, 1.0])
        span[0], span[-1] = -np.inf, np.inf
        expected, _ = np.histogram(kept[:, axis], span)
        seen, _ = np.histogram(there[:, axis], span)
        p, q = expected / len(kept), seen / len(there)
        # the difference of two shares, with a standard deviation from both samples
        deviation = np.sqrt(p * (1 - p) / len(kept) + q * (1 - q) / len(there))
        assert np.all(np.abs(p - q) < 4.0 * deviation), (axis, p, q)


def two_arms():
    """Two seven-axis arms, 0.9 m apart, that hold one thing."""
    tree = ARM.tree
    moved = tree.placement.copy()
    moved[1, 10] += 0.9
    second = tree._replace(placement=moved)
    form = structure_of(second, 7)
    assert isinstance(form, Structure)
    both = joined([tree, second])
    held = FrameFeature(7, "point", (0.0, 0.0, 0.2))
    constraints = [
        rows_of("coincident", held, both.feature(1, held)),
        rows_of("opposed", Z, both.feature(1, Z)),
        rows_of("perpendicular", Y, both.feature(1, X)),
    ]
    return [ARM, ClosedArm(second, form, np.zeros(7))], both, stacked(constraints), held


def test_two_arms_hold_one_thing_evenly_in_a_box():
    arms, both, wanted, held = two_arms()
    sides = [
        rows_of("height", held, FrameFeature(0, "plane", (0.4, 0.45, 0.4), tuple(n)), -0.1, 0.1) for n in np.eye(3)
    ]
    free = stacked(sides)
    Q, right = drawn_together(arms, both, wanted, KEY, 0, 1000, free=free)
    assert right.mean() > 0.99
    ahead = 0.2
    for q in Q[right][:50]:
        first, second = SEVEN.poses(q[:7])[7], SEVEN.poses(q[7:])[7]
        shift = np.array([0.0, 0.9, 0.0])
        a, b = first.act(np.array([0, 0, ahead])), second.act(np.array([0, 0, ahead])) + shift
        assert np.abs(a - b).max() < 1e-8
        assert first.rotation[:, 2] @ second.rotation[:, 2] < -1 + 1e-12
        assert abs(first.rotation[:, 1] @ second.rotation[:, 0]) < 1e-8
    for axis in range(3):
        at = [values(free[axis : axis + 1], q, both.tree)[0] for q in Q[right]]
        counts, _ = np.histogram(at, bins=10, range=(-0.1, 0.1))
        assert counts.max() < 1.1 * len(at) / 10 and counts.min() > 0.9 * len(at) / 10


def test_the_arm_that_is_tied_to_the_world_leads():
    arms, both, wanted, held = two_arms()
    for part in (0, 1):
        floor = rows_of("height", both.feature(part, held), FLOOR, 0.35, 0.45)
        made = drawn_together(arms, both, stacked([wanted, floor]), KEY, 0, 100)
        assert made is not None and made[1].mean() > 0.9
        for q in made[0][made[1]][:20]:
            height = SEVEN.poses(q[7 * part : 7 * part + 7])[7].act(np.array([0, 0, 0.2]))[2]
            assert 0.35 - 1e-8 <= height <= 0.45 + 1e-8


def test_what_has_no_family_is_left_to_projection():
    around = [("coincident", TIP, POST, None, None), ("perpendicular", Z, POST, None, None)]
    assert drawn(ARM, rows(around), KEY, 0, 3) is None
    assert drawn(ARM, rows([("height", FrameFeature(3, "point", (0, 0, 0)), FLOOR, 0.1, 0.2)]), KEY, 0, 3) is None
    arms, both, wanted, held = two_arms()
    floor = [rows_of("height", both.feature(part, held), FLOOR, 0.3, 0.5) for part in (0, 1)]
    assert drawn_together(arms, both, stacked([wanted, *floor]), KEY, 0, 3) is None
    five = closed(arm(np.random.default_rng(0), "five axes"))
    tip = FrameFeature(5, "point", (0, 0, 0))
    assert drawn(five, rows([("height", tip, FLOOR, 0.1, 0.2)]), KEY, 0, 3) is None


def test_kernels_run_as_plain_python_with_the_same_result():
    family = _family_in_world(ARM, rows(SIDE), TURN)
    found, counts = np.zeros((3, 8, 7)), np.zeros(3, np.int64)
    same, too = found.copy(), counts.copy()
    draws = kernels.Draws(np.uint64(KEY), 0, 2, 8, 16)
    kernels.draw_arm(family, ARM.arrays, draws, found, counts)
    kernels.draw_arm.py_func(family, ARM.arrays, draws, same, too)
    assert np.array_equal(counts, too) and counts.sum() > 0
    for i, count in enumerate(counts):
        assert np.allclose(found[i, :count], same[i, :count], atol=1e-9)
