"""Judges of collision predicates that share nothing with the kernel: coal, fcl, and gaps known by construction.

coal and fcl are trusted on healthy parts only, those with a volume; degenerate ones need constructed gaps.
"""

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import coal
import fcl
import numpy as np
from scipy.spatial import ConvexHull

COAL_TOLERANCE = 1e-5  # metres: what coal's distances of healthy parts of about a metre are good for


def healthy_hull(vertices: np.ndarray) -> coal.Convex:
    """A convex part for coal; fails for a flat part, which coal cannot judge."""
    points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
    hull = ConvexHull(vertices)
    assert hull.volume > 1e-9
    for point in vertices:
        points.append(point)
    for a, b, c in hull.simplices:
        triangles.append(coal.Triangle(int(a), int(b), int(c)))
    return coal.Convex(points, triangles)


def coal_distance(first: coal.Convex, first_T: np.ndarray, second: coal.Convex, second_T: np.ndarray) -> float:
    """The distance [m] of two parts under 4x4 poses; 0 or less where they touch."""
    poses = [coal.Transform3s(T[:3, :3], T[:3, 3]) for T in (first_T, second_T)]
    return coal.distance(first, poses[0], second, poses[1], coal.DistanceRequest(), coal.DistanceResult())


def fcl_distance(first: np.ndarray, first_T: np.ndarray, second: np.ndarray, second_T: np.ndarray) -> float:
    """The distance [m] of the surfaces of two healthy parts (V, 3) under 4x4 poses, by meshes and python-fcl."""
    bodies = []
    for vertices, T in ((first, first_T), (second, second_T)):
        faces = ConvexHull(vertices).simplices.astype(np.int64)
        model = fcl.BVHModel()
        model.beginModel(len(vertices), len(faces))
        model.addSubModel(vertices, faces)
        model.endModel()
        bodies.append(fcl.CollisionObject(model, fcl.Transform(T[:3, :3], T[:3, 3])))
    if fcl.collide(*bodies, fcl.CollisionRequest(), fcl.CollisionResult()) > 0:
        return 0.0
    return fcl.distance(*bodies, fcl.DistanceRequest(), fcl.DistanceResult())


@dataclass(frozen=True)
class Least:
    """What is known of a function's minimum on [0, 1]: it lies between `bound` and `value`."""

    value: float
    bound: float
    samples: int


def least_on_segment(
    distance: Callable[[float], float], speed: float, *, enough: float, floor: float, samples: int = 4000
) -> Least:
    """Looks for a value below `enough`, or proves that none is below `floor`: densest where it matters.

    Between samples at t0 and t1 a function of Lipschitz constant `speed` stays above the mean of both values less
    half of what it may travel. The search ends undecided after `samples`.
    """

    def interval(t0, t1, d0, d1):
        return 0.5 * (d0 + d1 - speed * (t1 - t0)), t0, t1, d0, d1

    times = np.linspace(0.0, 1.0, 17).tolist()
    values = [distance(t) for t in times]
    heap = [interval(times[i], times[i + 1], values[i], values[i + 1]) for i in range(len(times) - 1)]
    heapq.heapify(heap)
    value, count = min(values), len(values)
    while value >= enough and heap[0][0] < floor and count < samples:
        _, t0, t1, d0, d1 = heapq.heappop(heap)
        middle = 0.5 * (t0 + t1)
        between, count = distance(middle), count + 1
        value = min(value, between)
        heapq.heappush(heap, interval(t0, middle, d0, between))
        heapq.heappush(heap, interval(middle, t1, between, d1))
    return Least(value, heap[0][0], count)
