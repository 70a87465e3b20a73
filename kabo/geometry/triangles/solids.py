"""A closed mesh as a solid: distances to it, and winding numbers."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.triangles.component_groups import uniting_groups
from kabo.geometry.triangles.convexity import convexity_error, is_convex
from kabo.geometry.triangles.kernels.solids import insides, surface_distances, winding_number
from kabo.geometry.triangles.triangle_trees import tree_of

MAX_GROUPS = 64  # of components, the largest, whose depths are asked one by one
MAX_OCTREE_NODES = 1_000_000  # of the depth octree


class SolidArrays(NamedTuple):
    """What kernels ask of a solid: its box tree, its depth octree, a stack, and box trees of groups of components.

    The solid is the union of its groups. A group is its first node, its first triangle, and the end of its triangles.
    There are none if the whole solid is one group.
    """

    boxes: Array  # (N, 6) [m]
    children: Integers  # (N, 2)
    triangles: Array  # (T, 3, 3) [m] in the order of leaves
    frame: Array  # (5,) of the octree: centre, half its side, number of nodes
    depths: Array  # (M,) [m], NaN where not computed yet
    firsts: Integers  # (M,) first child of a node
    stack: Integers  # (64,)
    groups: Integers  # (G, 3)
    group_errors: Array  # (G,) [m] how far points of a group's hull may be from it; inf if that is not known
    group_boxes: Array  # (N, 6) [m]
    group_children: Integers  # (N, 2), each group's from 0 on
    group_triangles: Array  # (T, 3, 3) [m]


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed triangle mesh; the solid is the set of points with a non-zero winding number, and the surface."""

    vertices: Array  # (V, 3) [m]
    faces: Integers  # (F, 3)

    def __getstate__(self) -> dict[str, object]:
        """What is sent to another process: the mesh, but not what was computed from it."""
        return {"vertices": self.vertices, "faces": self.faces}

    @cached_property
    def tree(self) -> tuple[Array, Integers, Array]:
        """The box tree of the triangles: boxes (N, 6), children (N, 2), and triangles (F, 3, 3) in leaf order."""
        return tree_of(self.vertices, self.faces)[:3]

    @cached_property
    def depths(self) -> tuple[Array, Array, Integers]:
        """The depth octree: its frame (5,), depths (N,), children (N,); kernels refine it on demand."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        frame = np.r_[0.5 * (low + high), 0.55 * float((high - low).max()), 1.0]
        return frame, np.full(MAX_OCTREE_NODES, np.nan), np.zeros(MAX_OCTREE_NODES, np.int64)

    @property
    def arrays(self) -> SolidArrays:
        """The arrays that kernels ask, with a stack of their own."""
        groups, errors, boxes, children, triangles = self._group_trees
        own, stack = (*self.tree, *self.depths), np.zeros(64, np.int64)
        return SolidArrays(*own, stack, groups, errors, boxes, children, triangles)

    @cached_property
    def groups(self) -> list["SolidGroup"]:
        """Groups of components whose union is the solid, the largest first."""
        found = [SolidGroup(own, self._alone(own)) for own in uniting_groups(self.vertices, self.faces)]
        return sorted(found, key=lambda group: -round(group.solid.diagonal, 9))

    def _alone(self, own: Integers) -> "Solid":
        """The solid inside some of the faces."""
        used, index = np.unique(self.faces[own], return_inverse=True)
        return Solid(self.vertices[used], index.reshape(-1, 3).astype(np.int64))

    @cached_property
    def _group_trees(self) -> tuple[Integers, Array, Array, Integers, Array]:
        """The largest groups (G, 3) with their errors and box trees, as in `SolidArrays`."""
        solids = [group.solid for group in self.groups[:MAX_GROUPS]] if len(self.groups) > 1 else []
        errors = np.array([solid.convexity_error for solid in solids])
        rows, nodes, triangles = np.zeros((len(solids), 3), np.int64), 0, 0
        for row, solid in zip(rows, solids, strict=True):
            row[:] = nodes, triangles, triangles + len(solid.faces)
            nodes, triangles = nodes + len(solid.tree[0]), triangles + len(solid.faces)
        trees = [solid.tree for solid in solids] or [self.tree]
        boxes = np.concatenate([tree[0] for tree in trees])
        children = np.concatenate([tree[1] for tree in trees])
        return rows, errors, boxes, children, np.concatenate([tree[2] for tree in trees])

    def outside_distances(self, points: Array) -> Array:
        """The distance of each point (N, 3) from the solid (N,) [m]; 0 inside."""
        boxes, children, triangles = self.tree
        points = np.ascontiguousarray(points, np.float64)
        distances, within, stack = np.empty(len(points)), np.empty(len(points), np.bool_), np.zeros(64, np.int64)
        surface_distances(points, boxes, children, triangles, stack, distances)
        insides(points, boxes, children, triangles, stack, within)
        return np.where(within, 0.0, distances)

    def insides(self, points: Array) -> NDArray[np.bool_]:
        """A mask (N,) of the points (N, 3), none of them on the surface, around which the mesh winds."""
        points, within = np.ascontiguousarray(points, np.float64), np.empty(len(points), np.bool_)
        insides(points, *self.tree, np.zeros(64, np.int64), within)
        return within

    def surface_distances(self, points: Array) -> Array:
        """The distance of each point (N, 3) from the surface (N,) [m]."""
        distances = np.empty(len(points))
        surface_distances(np.ascontiguousarray(points, np.float64), *self.tree, np.zeros(64, np.int64), distances)
        return distances

    def winding_number(self, point: Array) -> float:
        """The winding number of the mesh around a point (3,)."""
        return float(winding_number(self.tree[2], float(point[0]), float(point[1]), float(point[2])))

    @property
    def diagonal(self) -> float:
        """The length of the bounding box's diagonal [m]."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))

    @cached_property
    def planes(self) -> tuple[Array, Array]:
        """The planes (F, 4) of the faces, n·x = d, and their areas (F,) [m2]; zeros for faces without area."""
        corners = self.vertices[self.faces]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        normals = normals / np.maximum(lengths, 1e-300)[:, None]
        return np.column_stack([normals, np.einsum("ij,ij->i", normals, corners[:, 0])]), 0.5 * lengths

    @cached_property
    def is_convex(self) -> bool:
        """Whether the solid is convex: no vertex lies in front of any face by more than `PLANE_TOLERANCE`."""
        return is_convex(self.vertices, self.faces)

    @cached_property
    def convexity_error(self) -> float:
        """A proven bound [m] of how far points of the convex hull may be from the solid; inf if none is known."""
        return convexity_error(self.vertices, self.faces)


class SolidGroup(NamedTuple):
    """A group of a solid's components: the indices of its faces in the solid (F,), and what they enclose."""

    faces: Integers
    solid: Solid
