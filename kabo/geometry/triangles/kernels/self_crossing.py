"""Finds the faces of a mesh that cross another face: compares each face with near faces of a lower index."""

from kabo.compilation import lean_kernel
from kabo.geometry.triangles.kernels.crossing import faces_cross
from kabo.geometry.triangles.kernels.octree import insert, query


@lean_kernel  # (V, 3) f8 [m], (F, 3) i8, Octree, (STACK,) i8, (F,) i8, (6, 3) f8, (SCRATCH,) f8 -> writes (F,) bool
def mark_crossing(vertices, faces, tree, stack, found, pair, scratch, crossing):
    """Marks the faces that meet another face elsewhere than in the vertices or the edge that both share."""
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        for c in range(3):
            scratch[c] = min(vertices[i, c], vertices[j, c], vertices[k, c])
            scratch[3 + c] = max(vertices[i, c], vertices[j, c], vertices[k, c])
        x, y, z, u, v, w = scratch[0], scratch[1], scratch[2], scratch[3], scratch[4], scratch[5]
        count = query(tree, x, y, z, u, v, w, stack, found)
        insert(tree, f, x, y, z, u, v, w)
        for n in range(count):
            g = found[n]
            if crossing[f] and crossing[g]:
                continue
            if faces_cross(vertices, i, j, k, faces[g, 0], faces[g, 1], faces[g, 2], pair, scratch):
                crossing[f] = crossing[g] = True
