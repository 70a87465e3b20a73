"""Projection arrives on the constraint, within limits, and moves only what may move [K Algorithm 3]."""

import numpy as np
import pytest

from kabo.kinematics import FrameFeature, project, rows_of, satisfied, seeds, stacked, values
from kabo.kinematics.kernels import projection as kernels
from kabo.streams import stream_key
from tests.kinematics.trees import planar, seven_axes, two_arms

ARM = seven_axes()
TOOL, AXIS = FrameFeature(7, "point", (0, 0, 0.2)), FrameFeature(7, "line", (0, 0, 0.2), (0, 0, 1))
UP, TABLE = FrameFeature(0, "line", (0.4, 0.1, 0), (0, 0, 1)), FrameFeature(0, "plane", (0, 0, 0.1), (0, 0, 1))
ALL = np.ones(7, bool)
ON_TABLE = stacked([rows_of("height", TOOL, TABLE, 0.05, 0.05), rows_of("opposed", AXIS, TABLE)])


def drawn(tree, count, name="seeds"):
    return seeds(tree.lower, tree.upper, stream_key(name), 0, count)


def test_every_answer_is_within_limits_and_on_the_constraint():
    tree = ARM.tree
    Q, right = project(tree, ON_TABLE, drawn(tree, 300), tree.lower, tree.upper, ALL)
    assert right.mean() > 0.2
    assert np.all((tree.lower <= Q[right]) & (Q[right] <= tree.upper))
    assert all(satisfied(ON_TABLE, q, tree, 1e-6) for q in Q[right])


def test_narrower_limits_than_those_of_the_tree_are_kept():
    tree = ARM.tree
    low, high = tree.lower.copy(), tree.upper.copy()
    low[0], high[0] = 0.1, 0.6
    Q, right = project(tree, ON_TABLE, drawn(tree, 300), low, high, ALL)
    assert right.any()
    assert np.all((Q[right, 0] >= 0.1) & (Q[right, 0] <= 0.6))


def test_whole_turns_lead_back_into_the_limits():
    chain = planar(2, limits=np.pi + 0.01)
    tip = FrameFeature(2, "point", (1.0, 0, 0))
    rows = rows_of("coincident", tip, FrameFeature(0, "point", (1.0, 1.0, 0)))
    near = np.array([[0.1 + 4 * np.pi, np.pi / 2 - 6 * np.pi]])
    Q, right = project(chain.tree, rows[:2], near, chain.tree.lower, chain.tree.upper, [True, True])
    assert right[0]
    assert np.all(np.abs(Q[0]) <= np.pi + 0.01)


def test_a_mimic_joint_at_another_ratio_is_not_turned_round():
    arms = two_arms(1)
    turning = kernels.find_turning(arms.tree.size, arms.tree.kind, arms.tree.source, arms.tree.ratio)
    halved = set(arms.tree.source[arms.tree.ratio == -0.5])
    sliding = set(arms.tree.source[arms.tree.kind == 1])
    assert halved
    assert sliding
    assert {j for j in range(arms.tree.size) if not turning[j]} == halved | sliding


def test_only_active_joints_move():
    tree = ARM.tree
    active = np.array([True, True, False, True, False, True, True])
    start = drawn(tree, 200)
    Q, right = project(tree, ON_TABLE, start, tree.lower, tree.upper, active)
    assert right.any()
    assert np.array_equal(Q[:, ~active], start[:, ~active])


def test_a_violated_interval_is_entered_and_not_only_touched():
    tree, inset = ARM.tree, 0.01
    tilt = rows_of("angle", AXIS, UP, upper=0.2)
    start = drawn(tree, 100)
    Q, right = project(tree, tilt, start, tree.lower, tree.upper, ALL, inset=inset)
    angles = np.array([values(tilt, q, tree)[0] for q in Q[right]])
    assert right.sum() > 20
    assert np.all(angles <= 0.2)
    assert np.median(angles) <= 0.2 - 0.9 * inset


def test_what_fulfils_the_rows_is_left_alone():
    tree = ARM.tree
    tilt = rows_of("angle", AXIS, UP, upper=0.2)
    Q, right = project(tree, tilt, drawn(tree, 100), tree.lower, tree.upper, ALL, inset=0.05)
    again, still = project(tree, tilt, Q[right], tree.lower, tree.upper, ALL, inset=0.05)
    assert still.all()
    assert np.array_equal(again, Q[right])


def test_joints_held_at_their_limits_find_what_free_ones_would_miss():
    """Freezing finds solutions with joints exactly at a limit; all are within, and none is lost."""
    tree = ARM.tree
    start = drawn(tree, 300)
    _, without = project(tree, ON_TABLE, start, tree.lower, tree.upper, ALL)
    Q, held = project(tree, ON_TABLE, start, tree.lower, tree.upper, ALL, hold_limits=True)
    assert held.sum() > without.sum()
    assert np.all(held[without])
    assert np.all((tree.lower <= Q[held]) & (Q[held] <= tree.upper))
    assert all(satisfied(ON_TABLE, q, tree) for q in Q[held])


def test_rows_that_say_the_same_twice_do_not_disturb():
    tree = ARM.tree
    twice = stacked([ON_TABLE, ON_TABLE, rows_of("parallel", AXIS, UP), rows_of("aligned", UP, TABLE)])
    _, right = project(tree, twice, drawn(tree, 100), tree.lower, tree.upper, ALL)
    assert right.mean() > 0.2


def test_what_is_out_of_reach_is_not_reached():
    far = rows_of("height", TOOL, TABLE, 5.0, 5.0)
    _, right = project(ARM.tree, far, drawn(ARM.tree, 50), ARM.tree.lower, ARM.tree.upper, ALL)
    assert not right.any()


def test_no_rows_and_no_seeds_are_fine():
    tree = ARM.tree
    nothing = stacked([])
    _, right = project(tree, nothing, drawn(tree, 5), tree.lower, tree.upper, ALL)
    assert right.all()
    Q, right = project(tree, ON_TABLE, np.empty((0, 7)), tree.lower, tree.upper, ALL)
    assert Q.shape == (0, 7)
    assert right.shape == (0,)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"seeds": np.zeros((1, 6))}, "seeds must be finite"),
        ({"seeds": np.full((1, 7), np.nan)}, "seeds must be finite"),
        ({"lower": np.zeros(6)}, "limits and mask"),
        ({"active": np.ones(8, bool)}, "limits and mask"),
        ({"rows": np.zeros((1, 5))}, "rows must be float64"),
        ({"rows": rows_of("height", FrameFeature(9, "point", (0, 0, 0)), TABLE, 0.0)}, "outside the tree"),
    ],
)
def test_what_does_not_fit_is_refused(change, message):
    tree = ARM.tree
    arguments = {
        "rows": ON_TABLE,
        "seeds": np.zeros((1, 7)),
        "lower": tree.lower,
        "upper": tree.upper,
        "active": ALL,
    } | change
    with pytest.raises(ValueError, match=message):
        project(tree, **arguments)


def test_kernels_run_as_plain_python_with_the_same_result():
    tree, rows = ARM.tree, ON_TABLE
    start = drawn(tree, 5)
    q = start[0]
    for kernel in (kernels.row_values, kernels.row_jacobian):
        assert np.allclose(kernel(q, rows, tree), kernel.py_func(q, rows, tree), atol=1e-14)
    answers = []
    for run in (kernels.project_seeds, kernels.project_seeds.py_func):
        Q, right = start.copy(), np.zeros(5, bool)
        wanted = kernels.Wanted(rows, len(rows), np.full((5, len(rows)), np.nan), 1e-6)
        run(Q, right, wanted, tree, ALL, kernels.Rule(50, 1, np.uint64(0), 0, 0))
        answers.append((Q, right))
    assert np.array_equal(answers[0][0], answers[1][0])
    assert np.array_equal(answers[0][1], answers[1][1])


def test_the_descent_runs_as_plain_python_with_the_same_result():
    tree, rows = ARM.tree, ON_TABLE
    less, part = kernels.restricted(rows, tree)
    signs = np.zeros((len(less), len(part.parent)))
    kernels.find_signs(less, part.parent, part.ratio, signs)
    target = kernels.Target(less, less[:, kernels.LOWER].copy(), less[:, kernels.UPPER].copy(), signs)
    turning = kernels.find_turning(7, tree.kind, tree.source, tree.ratio)
    for q in drawn(tree, 4):
        compiled, plain = q.copy(), q.copy()
        answers = [
            run(way, q, ALL.copy(), turning, target, part, scratch, 50, 1)
            for run, way, scratch in (
                (kernels.descend, compiled, kernels.scratch(len(less), len(part.parent), 7)),
                (kernels.descend.py_func, plain, kernels.scratch.py_func(len(less), len(part.parent), 7)),
            )
        ]
        assert answers[0] == answers[1]
        assert np.allclose(compiled, plain, atol=1e-9)
