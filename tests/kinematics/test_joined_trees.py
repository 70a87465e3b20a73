"""Trees as one: every row of [K Table 5.1] over the joints of two robots at once; poses and Jacobians by pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

from kabo.kinematics import FrameFeature, jacobian, joined, rows_of, sample, stacked, values
from kabo.streams import stream_key
from tests.kinematics.trees import planar, seven_axes, two_arms, violation, world_feature

ARM = seven_axes()
TABLE_5_1 = [
    ("coincident", "point", "point", None, 3),
    ("coincident", "point", "line", None, 2),
    ("coincident", "point", "plane", None, 1),
    ("coincident", "line", "line", None, 4),
    ("coincident", "plane", "plane", None, 3),
    ("parallel", "line", "line", None, 2),
    ("parallel", "plane", "plane", None, 2),
    ("parallel", "line", "plane", None, 1),
    ("perpendicular", "plane", "plane", None, 1),
    ("distance", "point", "point", 0.3, 1),
    ("distance", "point", "line", 0.15, 1),
    ("distance", "point", "plane", 0.1, 1),
]


def beside(arm, aside):
    """The same arm elsewhere: its first joint stands on another base."""
    placement = arm.tree.placement.copy()
    M = aside * pin.SE3(placement[1, :9].reshape(3, 3), placement[1, 9:])
    placement[1] = np.concatenate([M.rotation.ravel(), M.translation])
    return arm.tree._replace(placement=placement)


OTHER = beside(ARM, pin.SE3(pin.exp3(np.array([0, 0, 2.5])), np.array([0.9, 0.1, 0.0])))
BOTH = joined([ARM.tree, OTHER])


def poses(q):
    """The joints of both arms in the world, numbered as in the joined tree, by pinocchio."""
    moved = pin.SE3(pin.exp3(np.array([0, 0, 2.5])), np.array([0.9, 0.1, 0.0]))
    return ARM.poses(q[:7]) + [moved * M for M in ARM.poses(q[7:])[1:]]


def feature(joint, kind, seed):
    rng = np.random.default_rng(seed)
    direction = rng.normal(size=3)
    unit = None if kind == "point" else tuple(direction / np.linalg.norm(direction))
    return FrameFeature(joint, kind, tuple(rng.uniform(-0.1, 0.1, 3)), unit)


def test_a_joint_of_a_part_is_where_it_was():
    trees = [two_arms(3).tree, planar(2).tree, ARM.tree]
    whole = joined(trees)
    assert whole.tree.size == sum(tree.size for tree in trees)
    rng = np.random.default_rng(0)
    q = rng.uniform(-1, 1, whole.tree.size)
    for part, tree in enumerate(trees):
        for joint in range(len(tree.parent)):
            point = FrameFeature(joint, "point", (0.1, 0.2, 0.3))
            far = FrameFeature(0, "point", (3.0, 4.0, 5.0))
            alone = values(rows_of("distance", point, far, 0.0, 1.0), q[whole.values[part]], tree)
            rows = rows_of("distance", whole.feature(part, point), far, 0.0, 1.0)
            assert np.allclose(values(rows, q, whole.tree), alone, atol=1e-14)


def test_limits_and_mimic_joints_stay_with_their_part():
    arms = two_arms(1).tree
    whole = joined([ARM.tree, arms])
    assert np.array_equal(whole.tree.lower[whole.values[1]], arms.lower)
    assert np.array_equal(whole.tree.source[8:] - 7, arms.source[1:])
    assert np.array_equal(whole.tree.ratio[8:], arms.ratio[1:])
    with pytest.raises(ValueError, match="no trees"):
        joined([])


@pytest.mark.parametrize(("kind", "one", "other", "bound", "count"), TABLE_5_1)
def test_every_row_of_the_table_holds_between_the_tools_of_two_robots(kind, one, other, bound, count):
    first, second = feature(7, one, 1), BOTH.feature(1, feature(7, other, 2))
    rows = rows_of(kind, first, second, bound, bound)
    assert len(rows) == count
    tree = BOTH.tree
    Q, right = sample(tree, rows, stream_key(kind), 0, 60, tree.lower, tree.upper, np.ones(14, bool))
    assert right.sum() >= 10
    for q in Q[right]:
        assert np.all((tree.lower <= q) & (q <= tree.upper))
        assert violation(kind, first, second, bound, bound, poses(q)) <= 2e-6
    moved = np.abs(Q[right] - sample(tree, stacked([]), stream_key(kind), 0, 60, *limits(tree))[0][right])
    assert np.all(moved[:, :7].max(axis=1) > 0.0), "the first arm took no part"
    assert np.all(moved[:, 7:].max(axis=1) > 0.0), "the second arm took no part"


def limits(tree):
    return tree.lower, tree.upper, np.ones(tree.size, bool)


@pytest.mark.parametrize(("kind", "one", "other", "bound", "count"), TABLE_5_1)
def test_jacobians_over_both_robots_are_those_of_central_differences(kind, one, other, bound, count):
    rows = rows_of(kind, feature(7, one, 3), BOTH.feature(1, feature(6, other, 4)), bound, bound)
    for q in np.random.default_rng(1).uniform(-1.5, 1.5, (3, 14)):
        steps = 1e-6 * np.eye(14)
        ahead = [values(rows, q + s, BOTH.tree) - values(rows, q - s, BOTH.tree) for s in steps]
        assert np.allclose(jacobian(rows, q, BOTH.tree), np.stack(ahead, axis=1) / 2e-6, atol=2e-8)


def test_jacobians_over_both_robots_are_those_of_pinocchio():
    """The distance of the two tools changes by the velocity of one less that of the other."""
    first, second = feature(7, "point", 5), feature(7, "point", 6)
    rows = rows_of("distance", first, BOTH.feature(1, second), 0.0, 1.0)
    turn = pin.exp3(np.array([0, 0, 2.5]))
    for q in np.random.default_rng(2).uniform(-1.5, 1.5, (10, 14)):
        at = poses(q)
        p, r = (world_feature(f, at)[0] for f in (first, BOTH.feature(1, second)))
        unit = (p - r) / np.linalg.norm(p - r)
        J, K = ARM.jacobian(q[:7], 7), ARM.jacobian(q[7:], 7)
        one = J[:3] + np.cross(J[3:].T, p - at[7].translation).T
        other = turn @ K[:3] + np.cross((turn @ K[3:]).T, r - at[14].translation).T
        assert np.allclose(
            jacobian(rows, q, BOTH.tree)[0], np.concatenate([unit @ one, -unit @ other]), atol=1e-12
        )
