"""Safe repairs: each keeps the shape within the welding tolerance or says what it added, and all are reported.

Repairs that would guess about the shape, such as closing a wide hole or untangling a surface, are not made;
`kabo.meshes.require_solid` then says what is still wrong.
"""

from dataclasses import replace

import numpy as np

from kabo.displays import counted
from kabo.meshes.flattening import without_flat_faces
from kabo.meshes.holes import fill_small_holes
from kabo.meshes.mesh import Faces, Mesh, Vertices
from kabo.meshes.soundness import turned_components
from kabo.meshes.topology import components, edges_of, labels, neighbours, repeating
from kabo.meshes.touching_surfaces import separated

WELD_SHARE = 1e-7  # share of the diagonal: vertices nearer than this are merged


def repaired(mesh: Mesh) -> tuple[Mesh, list[str]]:
    """The mesh after all safe repairs, and a sentence for each repair; no sentences if nothing was wrong.

    Vertices within 1e-7 diagonals are merged; faces that name a vertex twice, repeat another face or have no area
    are removed; neighbours are oriented alike; holes of three edges, and flat ones of four, are filled; surfaces
    that only touch get vertices of their own; components that are inside out are turned.

    Args:
        mesh: finite vertices [m]; faces name existing vertices only.
    """
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    if not len(faces) or not np.isfinite(vertices).all() or faces.min() < 0 or faces.max() >= len(vertices):
        return mesh, []
    tolerance = WELD_SHARE * mesh.diagonal
    done: list[str] = []
    unused = len(vertices) - len(np.unique(faces))
    if unused:
        done.append(f"dropped {counted(unused, 'vertex', 'vertices')} of no triangle")
    vertices, faces = _welded(vertices, faces, tolerance, done)
    faces = _single(faces, done)
    faces = without_flat_faces(vertices, faces, done)
    faces = _agreeing(faces, done)
    faces = fill_small_holes(vertices, faces, tolerance, done)
    vertices, faces = separated(vertices, faces, done)
    faces = _outwards(vertices, faces, done)
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = np.ascontiguousarray(vertices[used]), index.reshape(-1, 3).astype(np.int64)
    return (replace(mesh, vertices=vertices, faces=faces), done) if done else (mesh, done)


def _welded(vertices: Vertices, faces: Faces, tolerance: float, done: list[str]) -> tuple[Vertices, Faces]:
    """The mesh with each vertex replaced by the first kept vertex within the tolerance; none moves farther than that."""
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(tolerance, output_type="ndarray")
    if not len(pairs):
        return vertices, faces
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]  # each has the lower vertex first
    target = np.arange(len(vertices))
    for low, high in pairs.tolist():
        if target[low] == low and target[high] == high:
            target[high] = low
    moved = np.flatnonzero(target != np.arange(len(vertices)))
    farthest = float(np.linalg.norm(vertices[moved] - vertices[target[moved]], axis=1).max())
    done.append(f"welded {counted(len(moved), 'vertex', 'vertices')} to others up to {farthest:.1e} m away")
    return vertices, target[faces]


def _single(faces: Faces, done: list[str]) -> Faces:
    """The faces without those that name a vertex twice and without copies."""
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    if not proper.all():
        done.append(f"dropped {counted(int((~proper).sum()), 'triangle')} with fewer than three vertices")
        faces = faces[proper]
    turned = np.take_along_axis(faces, (np.argmin(faces, axis=1)[:, None] + np.arange(3)) % 3, axis=1)
    again = repeating(turned)
    if again.any():
        done.append(f"dropped {counted(int(again.sum()), 'triangle')} that repeated another one")
        faces = faces[~again]
    return faces


def _agreeing(faces: Faces, done: list[str]) -> Faces:
    """The faces turned so that neighbours agree on the outside; a one-sided surface stays as it is."""
    edges = edges_of(faces)
    if not edges.turned.any():
        return faces
    size = len(faces)
    first, second = neighbours(edges, edges.count == 2)
    against = edges.forward[first] == edges.forward[second]
    first, second = first // 3, second // 3
    # Every face stands twice, as it is and turned; what hangs together is one way to turn them all.
    ends = np.where(against, second + size, second), np.where(against, second, second + size)
    side = labels(2 * size, np.concatenate([first, first + size]), np.concatenate(ends))
    group = np.minimum(side[:size], side[size:])
    one_sided = side[:size] == side[size:]
    turned = (side[:size] != group) & ~one_sided
    for number in np.unique(group[turned]):
        members = group == number
        if 2 * turned[members].sum() > members.sum():  # the fewer are the wrong ones
            turned[members] = ~turned[members]
    if not turned.any():
        return faces
    done.append(f"turned {counted(int(turned.sum()), 'triangle')} the way of their neighbours")
    return np.where(turned[:, None], faces[:, ::-1], faces)


def outwards(mesh: Mesh) -> tuple[Mesh, str | None]:
    """The mesh with inside-out components turned, and a sentence about it; the mesh itself and None if there are none.

    A mesh that is open, or whose faces name missing vertices, is returned as it is: `require_closed` refuses it.
    """
    vertices, faces = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    if not len(faces) or not np.isfinite(vertices).all() or faces.min() < 0 or faces.max() >= len(vertices):
        return mesh, None
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    done: list[str] = []
    turned = _outwards(vertices, faces[proper], done)
    return (replace(mesh, faces=turned), done[0]) if done else (mesh, None)


def _outwards(vertices: Vertices, faces: Faces, done: list[str]) -> Faces:
    """The faces turned so that closed components point outwards and cavities inwards."""
    if not len(faces):
        return faces
    edges = edges_of(faces)
    component = components(edges, len(faces))
    wrong = turned_components(vertices, faces, edges, component)
    if not wrong:
        return faces
    done.append(
        f"turned {counted(len(wrong), 'component')} that {'was' if len(wrong) == 1 else 'were'} inside out"
    )
    return np.where(np.isin(component, wrong)[:, None], faces[:, ::-1], faces)
