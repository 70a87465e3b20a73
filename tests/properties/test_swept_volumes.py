"""What chains sweep, turning and sliding joints mixed: two motions at all their times, and volumes as polyhedra.

The judges are pinocchio's kinematics and coal's distances, asked where they could contradict: best first over the
times of both motions, between which a distance changes no faster than the chains move.
"""

import heapq

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from kabo.geometry import Budget, Enclosure, Motion, MovingGroup, sweep_collides, swept_volume
from kabo.scene import PRISMATIC
from tests.conftest import PROPERTY_SCALE
from tests.geometry.worlds import box
from tests.kinematics.trees import placement, twin
from tests.properties.test_bounded_predicates import body, matrix, row_of
from tests.support.oracles import COAL_TOLERANCE, coal_distance, healthy_hull, least_on_segment

COUNT = max(20, round(1000 * PROPERTY_SCALE))


class Chain:
    """A random chain with bodies on two of its joints and a bar, half a metre long, held by the last."""

    def __init__(self, rng, count, sliding, base, spare):
        joints = [(j, int(sliding[j]), placement(rng, 0.25), j, 1.0, 0.0) for j in range(count)]
        joints[0][2].translation[:] = base
        self.made, self.limits = joints, np.where(sliding, 0.3, 2.5)
        self.twin = twin(joints, self.limits)
        long = box([0.02, 0.25, 0.02])
        made = [([long], Enclosure((long,), 0.0)), body(rng, 0.1, spare), body(rng, 0.1, spare)]
        self.joints = [count, *(int(j) for j in rng.integers(1, count + 1, 2))]
        self.poses = [row_of(placement(rng, s)) for s in (0.25, 0.1, 0.1)]
        self.parts, self.enclosures = zip(*made, strict=True)
        self.hulls = [[healthy_hull(part) for part in parts] for parts in self.parts]
        self.segment = rng.uniform(-self.limits, self.limits, (2, count))

    def shortened(self, factor):
        """The same chain with a shorter way to go."""
        self.segment[1] = self.segment[0] + factor * (self.segment[1] - self.segment[0])
        return self

    def pushed(self, shift):
        """The same chain with its base elsewhere."""
        joints = [list(joint) for joint in self.made]
        joints[0][2] = pin.SE3(joints[0][2].rotation, joints[0][2].translation + shift)
        self.twin = twin([tuple(joint) for joint in joints], self.limits)
        return self

    @property
    def motion(self):
        groups = zip(self.joints, self.poses, self.enclosures, strict=True)
        return Motion(self.twin.tree, tuple(MovingGroup(*group) for group in groups), self.segment)

    def placed(self, t):
        """4x4 poses of the bodies at a time in [0, 1], by pinocchio."""
        frames = [
            M.homogeneous for M in self.twin.poses(self.segment[0] + t * (self.segment[1] - self.segment[0]))
        ]
        return [frames[j] @ matrix(pose) for j, pose in zip(self.joints, self.poses, strict=True)]

    @property
    def speed(self):
        """A bound of how fast any point of a body moves [m] per unit of time."""
        tree, step = self.twin.tree, np.abs(self.segment[1] - self.segment[0])
        slides = tree.kind[1:] == PRISMATIC
        reach = np.linalg.norm(tree.placement[2:, 9:], axis=1).sum() + tree.upper[slides].sum()
        bodies = zip(self.poses, self.parts, strict=True)
        reach += max(np.linalg.norm(p[9:]) + max(np.linalg.norm(v, axis=1).max() for v in b) for p, b in bodies)
        return float(step[~slides].sum() * reach + step[slides].sum())


def chain(rng, draw, base, spare):
    count = draw(st.integers(1, 5))
    sliding = draw(st.lists(st.integers(0, 9).map(lambda i: i < 3), min_size=count, max_size=count))
    return Chain(rng, count, np.array(sliding), base, spare).shortened(draw(st.sampled_from([1.0, 0.3, 0.1, 0.0])))


@st.composite
def two_chains(draw, epsilon, spare):
    """Two chains, the second one moved so that a pose of each is about as far apart as matters."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    first = chain(rng, draw, np.zeros(3), spare)
    base = np.array([draw(st.sampled_from([0.7, 1.1, 1.5])), 0.0, 0.0])
    second = chain(rng, draw, base, spare)
    if draw(st.booleans()):
        result, X, Y = coal.DistanceResult(), first.placed(rng.uniform())[0], second.placed(rng.uniform())[0]
        poses = [coal.Transform3s(T[:3, :3], T[:3, 3]) for T in (X, Y)]
        gap = coal.distance(
            first.hulls[0][0], poses[0], second.hulls[0][0], poses[1], coal.DistanceRequest(), result
        )
        way = result.getNearestPoint2() - result.getNearestPoint1()
        wanted = rng.uniform(-0.2, 2.0) * epsilon
        second = second.pushed((wanted - gap) * way / max(1e-9, np.linalg.norm(way)))
    return first, second


def least_of_two(first, second, *, enough, floor, samples):
    """The least distance over both times, with a bound below it; stops where it is less than `enough`."""

    def distance(s, t):
        ours, theirs = first.placed(s), second.placed(t)
        return min(
            coal_distance(a, X, b, Y)
            for X, mine in zip(ours, first.hulls, strict=True)
            for Y, others in zip(theirs, second.hulls, strict=True)
            for a in mine
            for b in others
        )

    def square(s, t, wide, far):
        value = distance(s + 0.5 * wide, t + 0.5 * far)
        return value - 0.5 * (first.speed * wide + second.speed * far), value, s, t, wide, far

    heap = [square(0.25 * i, 0.25 * k, 0.25, 0.25) for i in range(4) for k in range(4)]
    heapq.heapify(heap)
    value, count = min(entry[1] for entry in heap), len(heap)
    while value >= enough and heap[0][0] < floor and count < samples:
        _, _, s, t, wide, far = heapq.heappop(heap)
        halves = [(s, t, 0.5 * wide, far), (s + 0.5 * wide, t, 0.5 * wide, far)]
        if second.speed * far > first.speed * wide:
            halves = [(s, t, wide, 0.5 * far), (s, t + 0.5 * far, wide, 0.5 * far)]
        for half in halves:
            entry = square(*half)
            value, count = min(value, entry[1]), count + 1
            heapq.heappush(heap, entry)
    return value, heap[0][0]


@settings(max_examples=COUNT)
@given(data=st.data(), epsilon=st.sampled_from([5e-3, 0.02, 0.1]), share=st.sampled_from([0.0, 0.4]))
def test_two_motions_are_free_only_if_their_volumes_are_apart_and_refused_only_within_epsilon(
    data, epsilon, share
):
    first, second = data.draw(two_chains(epsilon, share * epsilon * (1 - 1e-9)))
    hit = sweep_collides(first.motion, second.motion, Budget.share(epsilon))
    event("hit" if hit else "free")
    if hit:
        value, bound = least_of_two(first, second, enough=epsilon, floor=epsilon, samples=3000)
        assert value < epsilon + COAL_TOLERANCE, (value, bound)
    else:
        value, bound = least_of_two(first, second, enough=0.0, floor=0.0, samples=150)
        assert value > Budget.share(epsilon).clearance - COAL_TOLERANCE
        event("free, proven by the judge" if bound >= 0 else "free, sampled")


@pytest.mark.slow
@settings(max_examples=COUNT)
@given(data=st.data(), tolerance=st.sampled_from([0.05, 0.02]), share=st.sampled_from([0.0, 0.4]))
def test_polyhedra_contain_all_that_is_swept_and_stick_out_no_farther_than_they_say(data, tolerance, share):
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    moved = chain(rng, data.draw, np.zeros(3), share * tolerance)
    volume = swept_volume(moved.motion, tolerance)
    assert volume.deviation <= tolerance * (1 + share) + 1e-12
    planes = [ConvexHull(part).equations for part in volume.parts]
    for t in np.concatenate([np.linspace(0, 1, 17), rng.uniform(0, 1, 8)]):
        for T, enclosure in zip(moved.placed(t), moved.enclosures, strict=True):
            for part in enclosure.parts:
                weights = rng.dirichlet(np.full(len(part), 0.3), 4)
                points = np.concatenate([part, weights @ part]) @ T[:3, :3].T + T[:3, 3]
                outside = np.min([(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes], axis=0)
                assert outside.max() <= 1e-10
    sticks_out(moved, volume, rng)


def sticks_out(moved, volume, rng):
    """Corners of polyhedra, and points between them, are near to a pose of the true bodies."""
    ball = coal.Sphere(1e-9)
    for number in rng.integers(0, len(volume.parts), 3):
        part = volume.parts[number]
        for point in (part[rng.integers(len(part))], rng.dirichlet(np.full(len(part), 0.2)) @ part):
            at = np.eye(4)
            at[:3, 3] = point

            def distance(t, at=at):
                return min(
                    coal_distance(hull, T, ball, at)
                    for T, hulls in zip(moved.placed(t), moved.hulls, strict=True)
                    for hull in hulls
                )

            limit = volume.deviation + COAL_TOLERANCE
            found = least_on_segment(distance, moved.speed, enough=limit, floor=limit, samples=600)
            assert found.value < limit or found.bound < limit, (found, volume.deviation)
            event("at a corner within the half" if found.value < 0.5 * limit else "far out")
