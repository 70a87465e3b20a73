"""Distances of many points to many triangles at once, in numpy: a judge for the kernels of distances."""

import numpy as np


def distances_to_surface(points, vertices, faces):
    """The distance of every point (P, 3) to the nearest triangle, every pair looked at."""
    p, (a, b, c) = points[:, None, :], (vertices[faces[:, k]][None] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = np.maximum((normal**2).sum(axis=2), 1e-300)
    inside, nearest = np.broadcast_to(area > 1e-290, (len(points), len(faces))).copy(), np.inf
    for u, v in ((a, b), (b, c), (c, a)):
        along, away = v - u, p - u
        inside &= (np.cross(along, away) * normal).sum(axis=2) >= 0
        part = np.clip((away * along).sum(axis=2) / np.maximum((along**2).sum(axis=2), 1e-300), 0, 1)
        nearest = np.minimum(nearest, ((away - part[..., None] * along) ** 2).sum(axis=2))
    above = ((p - a) * normal).sum(axis=2) ** 2 / area
    return np.sqrt(np.where(inside, np.minimum(above, nearest), nearest).min(axis=1))
