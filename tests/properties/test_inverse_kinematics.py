"""Closed-form inverse kinematics: complete up to whole turns, exact by pinocchio, and silent about nothing [K A.3]."""

import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.kinematics import with_the_same_pose, with_turns
from kabo.kinematics.closed_form import POSE_TOLERANCE, OutOfReach, Reached, branches, end_poses
from kabo.scene.structure import Structure, structure_of
from tests.kinematics.arms import FORMS, arm, narrowed

SEEDS = st.integers(0, 2**32 - 1)
POSES = 20  # of one arm


def structure(tree) -> Structure:
    """The structure that an arm was built with."""
    found = structure_of(tree, tree.size)
    assert isinstance(found, Structure), found
    return found


def apart(q, other):
    """How far two configurations are apart, whole turns aside."""
    return np.abs((q - other + np.pi) % (2.0 * np.pi) - np.pi).max(axis=-1)


@given(form=st.sampled_from(FORMS), seed=SEEDS)
def test_every_configuration_is_a_branch_of_its_own_pose(form, seed):
    rng = np.random.default_rng(seed)
    made = arm(rng, form)
    tree, known = made.tree, structure(made.tree)
    Q = rng.uniform(tree.lower, tree.upper, (POSES, tree.size))
    found, owner = with_the_same_pose(tree, known, Q)
    event(f"{form}: {len(found) // POSES} branches")
    for i, q in enumerate(Q):
        mine = found[owner == i]
        assert len(mine) and apart(mine, q).min() < 1e-5
        goal = made.poses(q)[tree.size]
        for each in mine:
            reached = made.poses(each)[tree.size]
            assert np.abs(reached.homogeneous - goal.homogeneous).max() <= 2 * POSE_TOLERANCE
            assert np.all((tree.lower <= each) & (each <= tree.upper))


@given(form=st.sampled_from(FORMS), seed=SEEDS)
def test_narrow_limits_leave_just_the_branches_that_are_within_them_by_whole_turns(form, seed):
    rng = np.random.default_rng(seed)
    made = arm(rng, form)
    wide, narrow = made.tree, narrowed(made.tree, rng)
    known = structure(wide)
    Q = rng.uniform(wide.lower, wide.upper, (POSES, wide.size))
    every, owner = with_the_same_pose(wide, known, Q)
    kept, kept_owner = with_the_same_pose(narrow, known, Q)
    turned = every + 2 * np.pi * np.round(((narrow.lower + narrow.upper) / 2 - every) / (2 * np.pi))
    depth = np.minimum(turned - narrow.lower, narrow.upper - turned).min(axis=1)
    for i in range(POSES):
        inside = turned[(owner == i) & (depth > 1e-5)]
        mine = kept[kept_owner == i]
        assert np.all((narrow.lower <= mine) & (mine <= narrow.upper))
        if known.lock < 0:  # of seven axes the held one may be outside by itself
            assert all(apart(mine, q).min(initial=9.0) < 1e-5 for q in inside)
        assert len(mine) <= np.sum((owner == i) & (depth > -1e-5))
    for q in kept[:3]:
        turns = with_turns(narrow, known, q)
        assert np.all((narrow.lower <= turns) & (turns <= narrow.upper))
        assert len({tuple(np.round(each, 6)) for each in turns}) == len(turns)
        expected = np.prod(
            np.floor((narrow.upper - q) / (2 * np.pi)) + np.floor((q - narrow.lower) / (2 * np.pi)) + 1
        )
        assert len(turns) == min(64, int(expected))


@given(form=st.sampled_from(FORMS), seed=SEEDS, distance=st.sampled_from([0.0, 0.01, 0.3, 3.0, 100.0]))
def test_any_pose_gets_solutions_that_reach_it_or_a_reason_in_numbers(form, seed, distance):
    rng = np.random.default_rng(seed)
    made = arm(rng, form)
    tree, known = made.tree, structure(made.tree)
    q = rng.uniform(tree.lower, tree.upper)
    goal = end_poses(tree, known, q)[0]
    goal[9:] += distance * rng.normal(size=3)
    locked = None if known.lock < 0 else q[[known.lock]]
    answer = branches(tree, known, goal[None, :], q, locked).answer(0, tree, known)
    if isinstance(answer, OutOfReach):
        numbers = np.array([answer.missing, answer.tilt, answer.beyond])
        event(f"{form}: {'missing' if answer.missing else 'tilted' if answer.tilt else 'limits'}")
        assert np.all(np.isfinite(numbers)) and np.all(numbers >= 0.0)
        assert numbers.max() > 0.0 or distance == 0.0
        assert distance > 0.0
    else:
        assert np.abs(end_poses(tree, known, answer.configurations) - goal).max() <= POSE_TOLERANCE


@given(form=st.sampled_from(FORMS), seed=SEEDS, exponent=st.integers(-16, -3), places=st.integers(1, 3))
def test_near_singular_configurations_no_number_is_lost(form, seed, exponent, places):
    """Joints at or near multiples of a right angle; what is given out is exact however near they are."""
    rng = np.random.default_rng(seed)
    made = arm(rng, form)
    tree, known = made.tree, structure(made.tree)
    Q = rng.uniform(tree.lower, tree.upper, (POSES, tree.size))
    for q in Q:
        at = rng.permutation(tree.size)[:places]
        theta = rng.choice([-np.pi / 2, 0.0, np.pi / 2], size=places) + 10.0**exponent * rng.normal(size=places)
        q[at] = np.clip((theta - tree.shift[1 + at]) / tree.ratio[1 + at], tree.lower[at], tree.upper[at])
    found, owner = with_the_same_pose(tree, known, Q)
    assert np.all(np.isfinite(found))
    assert (
        np.abs(end_poses(tree, known, found) - end_poses(tree, known, Q)[owner]).max(initial=0.0) <= POSE_TOLERANCE
    )
    assert len(set(owner.tolist())) == POSES


@pytest.mark.parametrize("form", FORMS)
def test_a_structure_is_found_by_its_axes_and_lost_when_one_is_moved(form):
    rng = np.random.default_rng(3)
    made = arm(rng, form)
    known = structure(made.tree)
    assert (known.lock >= 0) == (form == "seven axes")
    bent = made.tree.placement.copy()
    for j in range(1, len(bent)):
        bent[j, 9:] += rng.uniform(-0.05, 0.05, 3)
        turn = np.linalg.qr(bent[j, :9].reshape(3, 3) + 0.05 * rng.normal(size=(3, 3)))[0]
        bent[j, :9] = (turn * np.sign(np.linalg.det(turn))).ravel()
    assert not isinstance(structure_of(made.tree._replace(placement=bent), made.tree.size), Structure)


@given(seed=SEEDS)
def test_the_order_of_solutions_does_not_depend_on_what_else_is_asked(seed):
    rng = np.random.default_rng(seed)
    made = arm(rng, "wrist and two parallel axes")
    tree, known = made.tree, structure(made.tree)
    Q = rng.uniform(tree.lower, tree.upper, (5, tree.size))
    together, owner = with_the_same_pose(tree, known, Q)
    for i, q in enumerate(Q):
        alone, _ = with_the_same_pose(tree, known, q)
        assert alone.tobytes() == together[owner == i].tobytes()
        answer = branches(tree, known, end_poses(tree, known, q), q).answer(0, tree, known)
        assert isinstance(answer, Reached) and answer.configurations.tobytes() == alone.tobytes()
