"""Definition 4 of [K]: what the sampler calls right fulfils the constraints; proofs of motions are one-sided."""

import numpy as np
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.kinematics import (
    FrameFeature,
    OffLine,
    keeps,
    rows_of,
    sample,
    satisfied,
    seeds,
    stacked,
    straight_line,
    values,
)
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.kernels.motion_bounds import curvature
from kabo.streams import stream_key
from tests.kinematics.trees import placement, seven_axes, twin, violation, world_feature

KINDS = [
    ("coincident", "point", "point", False),
    ("coincident", "point", "line", False),
    ("coincident", "line", "line", False),
    ("coincident", "plane", "plane", False),
    ("parallel", "line", "plane", False),
    ("parallel", "line", "line", False),
    ("aligned", "line", "plane", False),
    ("opposed", "plane", "plane", False),
    ("perpendicular", "line", "line", False),
    ("distance", "point", "point", True),
    ("distance", "point", "line", True),
    ("distance", "point", "plane", True),
    ("height", "point", "plane", True),
    ("angle", "line", "line", True),
]
INTERVALS = st.tuples(st.floats(0.0, 0.6), st.one_of(st.just(0.0), st.floats(0.0, 0.4), st.just(np.inf)))


@st.composite
def trees(draw):
    """A tree of 1 to 10 joints, branched, some sliding, some mimicking another."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    joints = []
    for j in range(draw(st.integers(1, 10))):
        parent = draw(st.sampled_from([j, j, j, max(j - 1, 0), 0]))
        kind = draw(st.sampled_from([0, 0, 0, 1]))
        source, ratio, shift = len({p[3] for p in joints}), 1.0, 0.0
        if j and draw(st.booleans()) and draw(st.booleans()):
            source, ratio, shift = draw(st.integers(0, source - 1)), draw(st.sampled_from([1.0, -1.0, 0.5])), 0.3
        joints.append((parent, kind, placement(rng), source, ratio, shift))
    return twin(joints)


@st.composite
def features(draw, joints, kind, place):
    """A feature on any joint, or on the world; `place` tells the first of a constraint from the second."""
    rng = np.random.default_rng([draw(st.integers(0, 2**32 - 1)), place])
    direction = rng.normal(size=3)
    unit = None if kind == "point" else tuple(direction / np.linalg.norm(direction))
    return FrameFeature(draw(st.integers(0, joints)), kind, tuple(rng.uniform(-0.3, 0.3, 3)), unit)


@st.composite
def constraints(draw, joints, kinds=KINDS):
    """A constraint of any kind as (kind, first, second, lower, upper)."""
    kind, one, other, bounded = draw(st.sampled_from(kinds))
    lower, upper = None, None
    if bounded:
        lower, width = draw(INTERVALS)
        upper = None if width == np.inf else lower + width
        if kind == "height":
            lower -= 0.3
            upper = None if upper is None else upper - 0.3
    return kind, draw(features(joints, one, 1)), draw(features(joints, other, 2)), lower, upper


def number_of_joints(arm):
    return len(arm.tree.parent) - 1


@given(data=st.data(), arm=trees())
def test_what_is_called_right_fulfils_every_constraint_and_the_limits(data, arm):
    chosen = data.draw(st.lists(constraints(number_of_joints(arm)), min_size=1, max_size=3))
    tree = arm.tree
    rows = stacked([rows_of(*c) for c in chosen])
    active = np.ones(tree.size, bool)
    Q, right = sample(tree, rows, stream_key("law"), 0, 8, tree.lower, tree.upper, active)
    event(f"right: {'none' if not right.any() else 'some'}")
    for q in Q[right]:
        assert np.all((tree.lower <= q) & (q <= tree.upper))
        assert max(violation(*c, arm.poses(q)) for c in chosen) <= 2.5e-6


@given(data=st.data(), arm=trees())
def test_satisfied_says_what_plain_geometry_says(data, arm):
    constraint = data.draw(constraints(number_of_joints(arm)))
    for q in seeds(arm.tree.lower, arm.tree.upper, stream_key("any"), 0, 5):
        error = violation(*constraint, arm.poses(q))
        if abs(error - 1e-3) > 1e-5 * (1 + error):  # cosines and sines of small angles differ by the square
            assert satisfied(rows_of(*constraint), q, arm.tree, 1e-3) == (error <= 1e-3)


def excess(rows, q, tree):
    """By how much each row is outside its bounds at q (negative: inside), in its own unit."""
    v = values(rows, q, tree)
    return np.maximum(rows[:, columns.LOWER] - v, v - rows[:, columns.UPPER])


@given(data=st.data(), arm=trees(), length=st.sampled_from([0.03, 0.3, 1.0, 3.0]), slack=st.floats(-0.01, 0.05))
def test_what_is_proven_is_kept_and_what_is_kept_with_room_is_proven(data, arm, length, slack):
    """Bounds are set from dense samples of the motion, so that proofs are asked just where they are hard."""
    kind, first, second, *_ = data.draw(constraints(number_of_joints(arm)))
    tree, tolerance = arm.tree, 1e-3
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    q0 = rng.uniform(tree.lower, tree.upper)
    q1 = q0 + rng.uniform(-length, length, tree.size)
    bounded = kind in ("distance", "height", "angle")
    rows = rows_of(kind, first, second, 0.0 if bounded else None, 0.4 if bounded else None)
    shares = np.linspace(0.0, 1.0, 400)
    seen = np.array([values(rows, q0 + t * (q1 - q0), tree) for t in shares])
    if kind not in ("aligned", "opposed"):
        rows[:, columns.LOWER] = seen.min(axis=0) - slack
        rows[:, columns.UPPER] = seen.max(axis=0) + slack
    kept = keeps(tree, rows, q0, q1, tolerance)
    worst = max(excess(rows, q0 + t * (q1 - q0), tree).max() for t in shares)
    event(f"{kind}: {'kept' if kept else 'not kept'}")
    assert not kept or worst <= tolerance
    if kind not in ("aligned", "opposed") and slack > (1e-2 if kind == "angle" else 1e-3):
        assert kept, f"not proven with {slack:.4f} to spare"


@given(data=st.data(), arm=trees(), length=st.sampled_from([0.1, 0.5, 2.0]))
def test_no_relative_motion_leaves_its_chord_by_more_than_its_bound(data, arm, length):
    """The lemma behind the proof, for every tree: |y - chord| <= max |y''| / 8; poses from pinocchio."""
    kind = data.draw(st.sampled_from([KINDS[9], KINDS[13]]))
    _, first, second, *_ = data.draw(constraints(number_of_joints(arm), [kind]))
    row = rows_of(kind[0], first, second, 0.0, 1.0)[0]
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    q0 = rng.uniform(arm.tree.lower, arm.tree.upper)
    q1 = q0 + length * rng.uniform(-1, 1, arm.tree.size)
    bound = curvature(row, arm.tree, q0, q1) / 8.0

    def seen(t):
        poses = arm.poses(q0 + t * (q1 - q0))
        origin, direction = world_feature(first, poses)
        M = poses[second.joint]
        return M.actInv(origin) if kind[0] == "distance" else M.rotation.T @ direction

    start, end = seen(0.0), seen(1.0)
    away = max(np.linalg.norm(seen(t) - (1 - t) * start - t * end) for t in np.linspace(0, 1, 21))
    event(f"{kind[0]}: bound used by {'nothing' if bound == 0 else 10 * round(10 * away / bound)} %")
    assert away <= bound + 1e-12


ARM = seven_axes()


@given(
    seed=st.integers(0, 10_000),
    direction=st.tuples(*[st.floats(-1, 1)] * 3).map(lambda v: np.array(v) + [0.0, 0.0, 1e-3]),
    length=st.sampled_from([0.01, 0.1, 0.4]),
)
def test_a_straight_line_is_straight_everywhere_or_refused(seed, direction, length):
    tree = ARM.tree
    q = seeds(tree.lower, tree.upper, stream_key("line", seed), 0, 1)[0]
    shift = length * direction / np.linalg.norm(direction)
    tool = np.eye(4)
    tool[2, 3] = 0.2
    way = straight_line(tree, q, 7, tool, shift)
    if isinstance(way, OffLine):
        event(way.reason)
        assert 0.0 <= way.travelled <= length
        return
    event("found")
    start = ARM.poses(q)[7].homogeneous @ tool
    for a, b in zip(way, way[1:], strict=False):
        assert np.abs(b - a).max() <= 0.5
        for t in np.linspace(0.0, 1.0, 15):
            pose = ARM.poses(a + t * (b - a))[7].homogeneous @ tool
            e = pose[:3, 3] - start[:3, 3]
            share = np.clip(e @ shift / length**2, 0.0, 1.0)
            assert np.linalg.norm(e - share * shift) <= 1e-3
            cosine = (np.trace(start[:3, :3].T @ pose[:3, :3]) - 1.0) / 2.0
            assert np.arccos(np.clip(cosine, -1, 1)) <= 5e-3
    end = ARM.poses(way[-1])[7].homogeneous @ tool
    assert np.allclose(end[:3, 3], start[:3, 3] + shift, atol=1e-6)
    assert np.all((tree.lower <= way[1:]) & (way[1:] <= tree.upper))
