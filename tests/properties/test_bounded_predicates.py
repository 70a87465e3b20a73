"""Both sides of the bounded predicates [K Def. 1, Table 4.1]: no collision overlooked, nothing refused beyond epsilon.

At a configuration distances are known by construction, also of needles, plates, slivers and points. Along a segment
the judges are pinocchio's kinematics and coal's distances, sampled where they could contradict (tests/support/oracles.py).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from hypothesis import event, given, settings
from hypothesis import strategies as st

from kabo.geometry import Budget, CollisionView, Enclosure, FixedGroup, MovingGroup
from kabo.geometry.collision.collision_view import FREE
from kabo.scene import PRISMATIC
from tests.conftest import PROPERTY_SCALE
from tests.geometry.worlds import one_joint, slide
from tests.kinematics.trees import placement, twin
from tests.support.oracles import COAL_TOLERANCE, coal_distance, fcl_distance, healthy_hull, least_on_segment
from tests.support.strategies import IDENTITY, gaps_about, healthy_part, rational_placements, touching_pairs

COUNT = max(20, round(1000 * PROPERTY_SCALE))
ROUNDING = 1e-12  # metres: of the construction of gaps, at a hundred metres

epsilons = st.sampled_from([1e-6, 1e-4, 2e-3, 5e-3, 0.02, 0.3])


def view_of(pair, budget):
    """The upper shape on a joint that slides along its frame's z, the lower shape fixed in the world."""
    moving = [MovingGroup(1, IDENTITY, Enclosure((pair.upper,), 0.0))]
    fixed = [FixedGroup(pair.placement, Enclosure((pair.lower,), 0.0))]
    return CollisionView(slide(pair.placement), moving, fixed, np.array([[0, 1]]), budget)


def judge(pairs, budget):
    """Asks about every pair at every gap of interest, and lays down the law."""
    gaps = gaps_about(budget.clearance, budget.epsilon)
    for pair in pairs:
        distances = pair.distances(gaps)
        known = ~np.isnan(distances)
        free = view_of(pair, budget).configurations_hit(gaps[known, None]) == FREE
        distances = distances[known]
        assert not free[distances <= 0].any()
        assert free[distances >= budget.epsilon].all()
        yield distances, free


@settings(max_examples=COUNT)
@given(pairs=touching_pairs(), epsilon=epsilons)
def test_a_configuration_is_never_free_at_distance_zero_and_never_refused_from_epsilon_on(pairs, epsilon):
    budget = Budget.share(epsilon)
    for distances, free in judge(pairs, budget):
        # More is kept than is promised: without deviations, epsilon's share for geometry and sweeps is not spent.
        assert (distances[free] > budget.clearance - ROUNDING).all()
        assert free[distances > budget.clearance + budget.numeric + ROUNDING].all()


@settings(max_examples=COUNT)
@given(pairs=touching_pairs())
def test_touching_is_seen_and_a_micrometre_is_free_where_nothing_is_kept_as_clearance(pairs):
    assert list(judge(pairs, Budget(geometry=0.0, sweep=1e-6, clearance=0.0)))


@settings(max_examples=COUNT // 2)
@given(seed=st.integers(0, 2**32 - 1), frame=rational_placements(), epsilon=epsilons)
def test_answers_at_configurations_agree_with_coal_and_fcl_on_healthy_parts(seed, frame, epsilon):
    rng, budget = np.random.default_rng(seed), Budget.share(epsilon)
    for _ in range(5):
        parts = [healthy_part(rng, 1.0) for _ in range(2)]
        poses = [placement(rng, 1.2), placement(rng, 1.2)]
        rows = [np.concatenate([T.rotation.ravel(), T.translation]) for T in poses]
        frame[9:] = rng.uniform(-3, 3, 3)
        tree = one_joint(frame)
        q = rng.uniform(-3, 3, 1)
        view = CollisionView(
            tree,
            [MovingGroup(1, rows[0], Enclosure((parts[0],), 0.0))],
            [FixedGroup(in_world(frame, q[0], rows[1]), Enclosure((parts[1],), 0.0))],
            np.array([[0, 1]]),
            budget,
        )
        matrices = [T.homogeneous for T in poses]
        first, second = map(healthy_hull, parts)
        distance = coal_distance(first, matrices[0], second, matrices[1])
        assert (
            abs(max(0.0, distance) - fcl_distance(parts[0], matrices[0], parts[1], matrices[1])) < COAL_TOLERANCE
        )
        answer = view.configuration_hit(q)
        event("free" if answer < 0 else "hit")
        assert answer == 0 or distance > budget.clearance - COAL_TOLERANCE
        assert answer == -1 or distance < budget.clearance + COAL_TOLERANCE


def in_world(frame, angle, row):
    """A pose in the frame that turned about its z, in the world."""
    R, c, s = frame[:9].reshape(3, 3), np.cos(angle), np.sin(angle)
    R = R @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.concatenate([(R @ row[:9].reshape(3, 3)).ravel(), R @ row[9:] + frame[9:]])


@dataclass
class World:
    """A chain whose bodies, a bar in its hand among them, move among obstacles; true bodies and enclosures."""

    twin: object
    joints: list  # of each body; 0 is the world
    poses: list  # of each body in its joint (12,)
    bodies: list  # true parts of each, each (V, 3)
    enclosures: list
    pairs: np.ndarray  # (P, 2)

    def view(self, budget, kept=(0.0,) * 6):
        groups = list(zip(self.joints, self.poses, self.enclosures, kept, strict=True))
        moving = [MovingGroup(j, p, e, kept=more) for j, p, e, more in groups if j]
        fixed = [FixedGroup(p, e, kept=more) for j, p, e, more in groups if not j]
        return CollisionView(self.twin.tree, moving, fixed, self.pairs, budget)

    @cached_property
    def hulls(self):
        return [[healthy_hull(part) for part in parts] for parts in self.bodies]

    @cached_property
    def matrices(self):
        return [matrix(pose) for pose in self.poses]

    def placed(self, q, bodies):
        """4x4 poses of some bodies, by pinocchio."""
        frames = [M.homogeneous for M in self.twin.poses(q)]
        return [frames[self.joints[i]] @ self.matrices[i] for i in bodies]

    def distances(self, start, end, pair):
        """The distance of a pair of true bodies as a function of the place on a segment."""
        a, b = self.pairs[pair]
        parts = [(x, y) for x in self.hulls[a] for y in self.hulls[b]]

        def distance(t):
            first, second = self.placed(start + t * (end - start), (a, b))
            return min(coal_distance(x, first, y, second) for x, y in parts)

        return distance

    def speed(self, start, end):
        """A bound of how fast the distance of any pair may change: two bodies at the chain's full reach."""
        tree, step = self.twin.tree, np.abs(end - start)
        slides = tree.kind[1:] == PRISMATIC
        reach = np.linalg.norm(tree.placement[:, 9:], axis=1).sum() + (tree.upper[slides]).sum()
        reach += max(np.linalg.norm(p[9:]) + np.linalg.norm(v, axis=1).max() for p, v in self._vertices())
        return 2.0 * float(step[~slides].sum() * reach + step[slides].sum())

    def _vertices(self):
        return [(p, v) for j, p, b in zip(self.joints, self.poses, self.bodies, strict=True) if j for v in b]


def matrix(row):
    """A pose of 12 numbers as 4x4."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = row[:9].reshape(3, 3), row[9:]
    return T


def row_of(M):
    """A pose of pinocchio as 12 numbers."""
    return np.concatenate([M.rotation.ravel(), M.translation])


def box(half):
    """The corners of a box about the origin."""
    return np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * np.asarray(half, float)


def body(rng, size, spare):
    """The parts of a body, and an enclosure of them that sticks out by as much as `spare`, or not at all."""
    if rng.random() < 0.5:
        half, grow = rng.uniform(0.1, 1.0, 3) * size, spare / np.sqrt(3.0)
        return [box(half)], Enclosure((box(half + grow),), spare)
    parts = [healthy_part(rng, size) + rng.uniform(-size, size, 3) for _ in range(int(rng.integers(1, 4)))]
    return parts, Enclosure(tuple(parts), 0.0)


def grazed(world, segment, obstacle, rng):
    """Where an obstacle is touched, or missed, by 3 mm at most: only on the outside of the way of the bar's corner."""
    (start, end), t = segment, rng.uniform(0.1, 0.9)
    bars = [world.placed(start + s * (end - start), [0])[0] for s in (t - 0.1, t, t + 0.1)]
    corners = [world.bodies[0][0] @ T[:3, :3].T + T[:3, 3] for T in bars]
    bulge = corners[1] - 0.5 * (corners[0] + corners[2])
    corner = int(np.argmax(np.linalg.norm(bulge, axis=1)))
    outward = bulge[corner] / max(1e-12, np.linalg.norm(bulge[corner]))
    foremost = int(np.argmax(corners[1] @ outward))
    R = world.poses[obstacle][:9].reshape(3, 3)
    low = min((part @ R.T @ outward).min() for part in world.enclosures[obstacle].parts)
    return corners[1][foremost] + (rng.uniform(-3e-3, 3e-3) - low) * outward


@st.composite
def worlds(draw, epsilon):
    """Chains of 2 to 7 joints, three in ten of which slide, with a metre-long bar in the hand, among obstacles."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, spare = draw(st.integers(2, 7)), draw(st.sampled_from([0.0, 0.4])) * epsilon * (1 - 1e-9)
    sliding = draw(st.lists(st.integers(0, 9).map(lambda i: i < 3), min_size=count, max_size=count))
    parents = [j if rng.random() < 0.9 else max(0, j - 1) for j in range(count)]
    joints = [(parents[j], int(sliding[j]), placement(rng, 0.3), j, 1.0, 0.0) for j in range(count)]
    hangs = [count, *(int(j) for j in rng.integers(1, count + 1, 2)), 0, 0, 0]
    long = box([0.02, 0.5, 0.02])
    made = [([long], Enclosure((long,), 0.0))] + [body(rng, 0.15, spare) for _ in range(2)]
    grazing = draw(st.booleans())
    made += [body(rng, 0.02 if grazing else 0.3, spare) for _ in range(3)]
    spread = [0.3] + [0.1] * 2 + [2.0] * 3
    poses = [row_of(placement(rng, s)) for s in spread]
    pairs = [(a, b) for a in range(3) for b in range(a + 1, 6) if hangs[a] != hangs[b]]
    limits = np.where(sliding, 0.4, 3.0)
    ends = rng.uniform(-limits, limits, (4, 2, count))
    ends[:, 1] = ends[:, 0] + draw(st.sampled_from([1.0, 0.3, 0.1, 0.03])) * (ends[:, 1] - ends[:, 0])
    bodies, enclosures = zip(*made, strict=True)
    world = World(twin(joints, limits), hangs, poses, bodies, enclosures, np.array(pairs))
    for i in range(3 if grazing else 0):
        poses[3 + i][9:] = grazed(world, ends[i], 3 + i, rng)
    return replace(world, poses=poses), ends  # nothing that the old one keeps


@settings(max_examples=COUNT)
@given(data=st.data(), epsilon=st.sampled_from([2e-3, 5e-3, 0.02, 0.1]))
def test_a_free_segment_is_free_everywhere_and_a_refused_one_comes_closer_than_epsilon(data, epsilon):
    world, segments = data.draw(worlds(epsilon))
    budget = Budget.share(epsilon)
    view = world.view(budget)
    for start, end in segments:
        hit, speed = view.segment_hit(start, end), world.speed(start, end)
        event("free" if hit < 0 else "hit")
        if hit >= 0:
            found = least_on_segment(
                world.distances(start, end, hit), speed, enough=epsilon, floor=epsilon, samples=1500
            )
            assert found.value < epsilon + COAL_TOLERANCE, (hit, found)
            continue
        for pair in range(len(world.pairs)):
            least = least_on_segment(world.distances(start, end, pair), speed, enough=0.0, floor=0.0, samples=60)
            assert least.value > budget.clearance - COAL_TOLERANCE, (pair, least)
            event("free, proven by the judge" if least.bound >= 0 else "free, sampled")


@settings(max_examples=COUNT // 2)
@given(data=st.data(), epsilon=st.sampled_from([2e-3, 5e-3, 0.02]))
def test_what_is_free_with_a_deviation_is_free_wherever_joints_are_within_it(data, epsilon):
    """Everywhere within the deviation bodies keep what they are to keep; coal judges corners and places inside."""
    world, segments = data.draw(worlds(epsilon))
    budget, rng = Budget.share(epsilon), np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    size = len(segments[0][0])
    kept = rng.choice([0.0, 2e-3, 8e-3], 6)
    view, plain = world.view(budget, kept), world.view(budget)
    for start, end in segments:
        deviation = rng.choice([0.0, 1e-3, 1e-2, 5e-2], size)
        if view.segment_hit(start, end, deviation) >= 0:
            event("hit, but free without" if plain.segment_hit(start, end) < 0 else "hit")
            continue
        event("free")
        assert plain.segment_hit(start, end) < 0, "more distance and deviation free nothing"
        for _ in range(12):
            off = deviation * (rng.choice([-1.0, 1.0], size) if rng.random() < 0.7 else rng.uniform(-1, 1, size))
            at = rng.uniform()
            for pair, (a, b) in enumerate(world.pairs):
                found = world.distances(start + off, end + off, pair)(at)
                assert found > budget.clearance + kept[a] + kept[b] - COAL_TOLERANCE, (pair, found)


@settings(max_examples=COUNT // 2)
@given(data=st.data(), epsilon=st.sampled_from([2e-3, 0.02]))
def test_bodies_that_keep_a_distance_are_refused_only_within_epsilon_of_it(data, epsilon):
    world, segments = data.draw(worlds(epsilon))
    kept = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1))).choice([0.0, 2e-3, 8e-3], 6)
    view, budget = world.view(Budget.share(epsilon), kept), Budget.share(epsilon)
    for start, end in segments:
        hit, asked = view.segment_hit(start, end), np.array([start, 0.5 * (start + end), end])
        for q, found in zip(asked, view.configurations_hit(asked).tolist(), strict=True):
            least = [
                world.distances(q, q, pair)(0.0) - kept[a] - kept[b] for pair, (a, b) in enumerate(world.pairs)
            ]
            assert found >= 0 or min(least) > budget.clearance - COAL_TOLERANCE
            assert found < 0 or least[found] < epsilon + COAL_TOLERANCE
            assert found < 0 or hit >= 0, "a segment is not free where a configuration is not"
        if hit >= 0:
            allowed = epsilon + kept[world.pairs[hit]].sum()
            distance, speed = world.distances(start, end, hit), world.speed(start, end)
            found = least_on_segment(distance, speed, enough=allowed, floor=allowed, samples=1500)
            assert found.value < allowed + COAL_TOLERANCE, (hit, found)


@settings(max_examples=COUNT // 10)
@given(data=st.data())
def test_zeros_and_no_deviation_give_the_same_answers(data):
    world, segments = data.draw(worlds(5e-3))
    first, second = world.view(Budget.share(5e-3)), world.view(Budget.share(5e-3))
    for start, end in segments:
        zeros = np.zeros(len(start))
        assert first.segment_hit(start, end) == second.segment_hit(start, end, zeros)
        assert first.segment_hit(start, end, zeros + 10.0) >= 0 or not len(world.pairs)
        assert first.segment_hit(start, end) == second.segment_hit(start, end), "nothing is left of a deviation"
