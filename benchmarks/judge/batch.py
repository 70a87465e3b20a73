"""Judges many results in one process: a JSON job a line comes in, its verdict goes out as a line.

    python batch.py < jobs.jsonl

A job has `original` (OFF), `epsilon` [m] and either `result` (OFF) and `side`, or `parts` (NPZ, an (V, 3) array for
each convex part). It runs in the environment of requirements.txt and shares no code with kabo.
"""

import json
import sys
from functools import cache

import igl
import numpy as np
import trimesh
from evaluate import directed_hausdorff, evaluate, nearest, protrusion, read, soup
from exact import winding
from scipy.spatial import ConvexHull

SAMPLES = 40_000
read = cache(read)


@cache
def crossings(path):
    """How many faces of a mesh cross others, counted by MeshLab."""
    return soup(*read(path))["self_intersecting_faces"]


def closedness(vertices, faces):
    """Edges without an opposite twin, and vertices whose faces form more than one fan: zero both on a 2-manifold."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    key, back = edges[:, 0] * len(vertices) + edges[:, 1], edges[:, 1] * len(vertices) + edges[:, 0]
    names, counts = np.unique(key, return_counts=True)
    lonely = int((counts > 1).sum() + np.setxor1d(names, back).size)
    after, fans = {}, {}
    for a, b, c in faces.tolist():
        for p, q, r in ((a, b, c), (b, c, a), (c, a, b)):
            after.setdefault(p, {})[q] = r
    for vertex, ring in after.items():
        start = at = next(iter(ring))
        visited = 1
        while (at := ring.get(at)) not in (None, start) and visited < len(ring):
            visited += 1
        fans[vertex] = at == start and visited == len(ring)
    return {"unmatched_edges": lonely, "pinched_vertices": sum(not whole for whole in fans.values())}


def confirmed(inner, outer, epsilon, samples):
    """The greatest distance, in epsilon, of a point that sticks out also by exact arithmetic; 0 if there is none.

    Floating winding numbers and distances are wrong about needles and plates that are a hundred thousand times longer
    than thick; and where a mesh crosses itself, some of its surface bounds no solid, but pockets of winding -1. So a
    point counts if, a tenth of its distance behind one of its faces, the solid is inside and the other one is not.
    """
    out, points = protrusion(*inner, *outer, samples=samples)
    vertices, faces = inner
    for i in np.argsort(-out)[: int((out > 1e-9 * np.linalg.norm(np.ptp(vertices, axis=0))).sum())]:
        at = points[i]
        around = np.flatnonzero((faces == i).any(axis=1)) if i < len(vertices) else nearest(at[None], *inner)[1]
        for a, b, c in vertices[faces[around]]:
            normal = np.cross(b - a, c - a)
            length = np.linalg.norm(normal)
            if length == 0.0:
                continue
            within = at + 1e-3 * ((a + b + c) / 3 - at) - 0.1 * out[i] * normal / length
            if (winding(within, *inner) or 0) > 0 and winding(within, *outer) == 0:
                return float(out[i]) / epsilon
    return 0.0


def bounding(job):
    """The verdict of evaluate.py; an interval of the distance that contains epsilon is made narrower."""
    original, result, epsilon = read(job["original"]), read.__wrapped__(job["result"]), job["epsilon"]
    verdict = evaluate(*original, *result, job["side"], epsilon, samples=job.get("samples", SAMPLES))
    for rel in (1e-3, 1e-4):
        if not verdict.get("h_lo", 0.0) <= 1.0 < verdict.get("h_hi", 0.0):
            break
        ways = [directed_hausdorff(*a, *b, rel=rel) for a, b in ((original, result), (result, original))]
        verdict["h_lo"], verdict["h_hi"] = (max(way[i] for way in ways) / epsilon for i in (0, 1))
    if verdict.get("stick_max", 0.0) > 1e-9 * np.linalg.norm(np.ptp(original[0], axis=0)):
        pair = (original, result) if job["side"] == "outer" else (result, original)
        verdict["stick_exact_over_eps"] = confirmed(*pair, epsilon, job.get("samples", SAMPLES))
    return verdict | closedness(*result) | {"self_intersecting_faces_in": crossings(job["original"])}


def decomposition(job):
    """How far the original sticks out of the union of hulls, and the union's points from the solid: by samples."""
    vertices, faces = read(job["original"])
    epsilon, samples = job["epsilon"], job.get("samples", SAMPLES)
    with np.load(job["parts"]) as file:
        hulls = [ConvexHull(file[name]) for name in file.files]
    surface, _ = trimesh.sample.sample_surface(trimesh.Trimesh(vertices, faces, process=False), samples, seed=0)
    uncovered = outside(np.concatenate([vertices, vertices[faces].mean(1), surface]), hulls)
    probes = np.concatenate([skin(hull, max(500, samples // len(hulls)), k) for k, hull in enumerate(hulls)])
    away, _ = nearest(probes, vertices, faces)
    beyond = igl.winding_number(vertices, faces, np.ascontiguousarray(probes)) < 0.5
    return {
        "parts": len(hulls),
        "vertices": sum(len(hull.vertices) for hull in hulls),
        "vertices_max": max(len(hull.vertices) for hull in hulls),
        "uncovered_over_eps": float(uncovered.max()) / epsilon,
        "uncovered_share": float((uncovered > 1e-9 * np.linalg.norm(np.ptp(vertices, axis=0))).mean()),
        "far_over_eps": float((away * beyond).max()) / epsilon,
    }


def outside(points, hulls):
    """At least how far each point lies outside all hulls; 0 within."""
    least = np.full(len(points), np.inf)
    for hull in hulls:
        beyond = np.full(len(points), -np.inf)
        for plane in hull.equations:
            np.maximum(beyond, points @ plane[:3] + plane[3], out=beyond)
        np.minimum(least, beyond, out=least)
    return np.maximum(least, 0.0)


def skin(hull, samples, seed):
    """The corners of a hull and samples of its surface."""
    surface = trimesh.Trimesh(hull.points, hull.simplices, process=False)
    return np.concatenate(
        [hull.points[hull.vertices], trimesh.sample.sample_surface(surface, samples, seed=seed)[0]]
    )


if __name__ == "__main__":
    for line in sys.stdin:
        job = json.loads(line)
        print(json.dumps(decomposition(job) if "parts" in job else bounding(job)), flush=True)
