"""Tighter parts, and more of them, for the pairs that decide how much clearance a stretch or an object has.

What the distance of parts is short of that of the meshes is what they stick out. So it is found where along the path
the parts of such a pair are nearest to each other, and at which points; the part whose point is farther from the mesh
is drawn tight, or halved, until the distance of the parts tells the truth. Then all pairs are proven, with these parts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry.collision.kernels.bundles import Hulls
from kabo.geometry.collision.kernels.nearest_places import (
    Between,
    Lists,
    least_along,
    nearest_points,
)
from kabo.geometry.collision.kernels.tight_parts import distance_to
from kabo.geometry.collision.near_pairs import NearPairs
from kabo.geometry.collision.separation_proofs import Course, Parts, between_parts, in_order
from kabo.geometry.collision.tight_parts import TightPart, tight_part
from kabo.geometry.collision.view_arrays import offset_for, search_for
from kabo.geometry.parts import COLUMNS, LANE, Packed, with_columns
from kabo.planner.certify.certified_bodies import CertifiedBodies
from kabo.scene import Mesh

TRUE = 0.1  # of a distance of parts: so much less than that of meshes it may be
MAX_STEPS = 48  # of drawing parts of a pair tight, or halving them
MAX_PARTS = 160  # of a body, after which none is halved


@dataclass(eq=False)
class Leaves:
    """The parts of one mesh as they are now: each of one of the parts that they were at first."""

    mesh: Mesh | None  # None: they stay as they are
    first: Parts
    names: list[tuple[int, str | None]]  # of each the part that it was, and which half of a half; None: that part
    hulls: Hulls  # of so many parts at most
    boxes: Array  # (B, 6) middles and half sides
    tight: list[TightPart | None]  # what each is drawn from; None if it is as it was
    halved: bool = False  # since the last proofs
    changed: bool = False

    @classmethod
    def of(cls, parts: Parts, mesh: Mesh | None) -> "Leaves":
        """The parts as they are at first."""
        count, packed = len(parts.vertices), parts.packed
        rows = count if mesh is None else max(count, MAX_PARTS)
        hulls = Hulls(np.zeros((rows, 3, COLUMNS)), np.zeros(rows, np.int64), np.zeros((rows, 5)))
        hulls.blocks[:count] = with_columns(packed.blocks, COLUMNS)
        hulls.sizes[:count], hulls.rounds[:count] = packed.sizes, packed.rounds
        low, high, boxes = parts.boxes[:, :3], parts.boxes[:, 3:], np.zeros((rows, 6))
        boxes[:count] = np.hstack([0.5 * (low + high), 0.5 * (high - low)])
        return cls(mesh, parts, [(i, None) for i in range(count)], hulls, boxes, [None] * count)

    def __len__(self) -> int:
        return len(self.names)

    def _put(self, i: int, corners: Array) -> None:
        """Writes the corners of a part that is not round."""
        self.hulls.blocks[i, :, : len(corners)] = corners.T
        self.hulls.blocks[i, :, len(corners) :] = corners[:1].T
        self.hulls.sizes[i] = -(-len(corners) // LANE) * LANE
        low, high = corners.min(axis=0), corners.max(axis=0)
        self.boxes[i, :3], self.boxes[i, 3:] = 0.5 * (low + high), 0.5 * (high - low)

    def corners(self, i: int) -> Array:
        """The corners of a part (V, 3)."""
        tight = self.tight[i]
        return self.first.vertices[self.names[i][0]] if tight is None else tight.corners

    def held(self, i: int) -> Array | None:
        """What a part holds (T, 3, 3); None if it can neither be drawn tight nor halved."""
        if self.mesh is None or len(self) >= MAX_PARTS:
            return None
        part, path = self.names[i]
        found = self.tight[i] or self._tight(part, "")
        return found.triangles if path is None or found.can_be_halved(len(path)) else None

    def _tight(self, part: int, path: str) -> TightPart:
        assert self.mesh is not None
        return tight_part(self.mesh, self.first.vertices[part], path)

    def refine(self, i: int) -> list[int]:
        """Draws a part tight, or puts its halves in its place; the numbers of what is there instead."""
        part, path = self.names[i]
        after = [""] if path is None else [path + "0", path + "1"]
        made = [self._tight(part, each) for each in after]
        kept = [k for k, each in enumerate(made) if len(each.triangles)] or [0]
        self.changed, self.halved = True, self.halved or len(kept) > 1
        for n, k in enumerate(kept):
            if n:
                self.names.append((part, after[k]))
                self.tight.append(made[k])
            else:
                self.names[i], self.tight[i] = (part, after[k]), made[k]
            self._put(len(self) - 1 if n else i, made[k].corners)
        return [i, *range(len(self) - len(kept) + 1, len(self))]

    def made(self) -> Parts:
        """The parts as they are now, in the order in which they are numbered from now on."""
        count = len(self)
        if self.halved:
            order = in_order(self.boxes[:count, :3])
            self.names, self.tight = [self.names[i] for i in order], [self.tight[i] for i in order]
            for own in (*self.hulls, self.boxes):
                own[:count] = own[order]
        self.halved = self.changed = False
        middles, halves = self.boxes[:count, :3], self.boxes[:count, 3:]
        hulls, unknown = self.hulls, np.full(count, np.nan)  # nobody asks for diameters
        blocks, sizes, rounds = hulls.blocks[:count], hulls.sizes[:count], hulls.rounds[:count]
        packed = Packed(blocks.copy(), sizes.copy(), unknown, rounds.copy())
        boxes = np.hstack([middles - halves, middles + halves])
        return Parts(tuple(self.corners(i) for i in range(count)), packed, boxes)


class _Nearest:
    """The parts of two bodies in arrays, those of one mesh once; they are refined where the bodies are nearest."""

    def __init__(self, leaves: tuple[Leaves, Leaves], poses: Array, far: float, between: Between) -> None:
        """`poses` (2, K, 12) of both bodies; no coordinate is farther from the origin than `far`."""
        self.leaves, self.poses = leaves, poses
        self.own = leaves[:1] if leaves[0] is leaves[1] else leaves
        self.which = [(each, i) for each in self.own for i in range(len(each))]
        rows = len(self.which) + MAX_STEPS
        self.hulls = Hulls(np.empty((rows, 3, COLUMNS)), np.zeros(rows, np.int64), np.zeros((rows, 5)))
        self.boxes = np.zeros((rows + 2, 6))  # the last two are room for those of whole bodies
        self.lists = Lists(np.zeros((2, rows), np.int64), np.zeros(2, np.int64))
        end = 0
        for each in self.own:
            begin, end = end, end + len(each)
            for own, theirs in zip((*self.hulls, self.boxes), (*each.hulls, each.boxes), strict=True):
                own[begin:end] = theirs[: len(each)]
            for e in range(2):
                if self.leaves[e] is each:
                    self._list(e, range(begin, end))
        self.search, self.ends = search_for(offset_for(far)), np.zeros((2, 4), np.int64)
        self.lower, self.nearest = np.full(poses.shape[1], -np.inf), np.full((poses.shape[1], 2), -1, np.int64)
        self.chosen = np.array([0, *self.lists.numbers[:, 0]])
        self.between = between
        self.points, self.room = np.zeros((2, 3)), np.zeros((2, 3, 40))

    def _put(self, leaves: Leaves, i: int, row: int | None = None) -> int:
        """Writes a part into a row of the arrays."""
        if row is None:
            row = len(self.which)
            self.which.append((leaves, i))
        for own, theirs in zip((*self.hulls, self.boxes), (*leaves.hulls, leaves.boxes), strict=True):
            own[row] = theirs[i]
        return row

    def _list(self, e: int, rows: Sequence[int]) -> None:
        count = int(self.lists.counts[e])
        self.lists.numbers[e, count : count + len(rows)] = rows
        self.lists.counts[e] = count + len(rows)

    def refined(self, near: float) -> float:
        """The least distance after the parts were refined that make it less than that of the meshes [m]."""
        for _ in range(MAX_STEPS):
            distance = self._least()
            if distance >= near or not self._refine(distance):
                return distance
        return self._least()

    def _least(self) -> float:
        return float(
            least_along(
                self.hulls,
                self.boxes,
                self.lists,
                self.poses,
                self.lower,
                self.nearest,
                self.ends,
                self.search,
                self.between,
                self.chosen,
            )
        )

    def _refine(self, distance: float) -> bool:
        """Refines one of the two parts that are nearest to each other, if they are nearer than what they hold."""
        nearest_points(self.hulls, self.poses, self.chosen, self.ends, self.search, self.points, self.room)
        away = [0.0, 0.0]
        for e in range(2):
            leaves, i = self.which[int(self.chosen[1 + e])]
            held = leaves.held(i)
            if held is not None:
                away[e] = float(distance_to(held, self.points[e], self.search.simplex))
        if sum(away) <= TRUE * max(distance, 0.0):
            return False
        row = int(self.chosen[1 + int(away[1] > away[0])])
        leaves, i = self.which[row]
        _, *new = leaves.refine(i)
        self._put(leaves, i, row)
        self.nearest[(self.nearest == row).any(axis=1)] = -1
        rows = [self._put(leaves, k) for k in new]
        for e, each in enumerate(self.leaves):
            if each is leaves:
                self._list(e, rows)
        return True


class Refinement:
    """The parts of all meshes while they are refined where bodies come nearest."""

    def __init__(self, bodies: CertifiedBodies, meshes: Mapping[str, Mesh]) -> None:
        """`meshes` has what parts may be refined of, by the hashes of meshes."""
        self._bodies, self._meshes = bodies, meshes
        self._leaves: dict[str, Leaves] = {}
        self._between = between_parts()

    def distance(self, course: Course, pair: int, measured: NearPairs) -> float:
        """The distance [m] of a pair that was measured: where its parts made it too small, these are refined."""
        first, second = (self._of(course.bodies[k].mesh) for k in course.pairs[pair, :2].tolist())
        if first.mesh is None and second.mesh is None:
            return measured.distance(pair)
        poses = measured.poses(pair)
        far = 2.0 * float(np.abs(poses[:, :, 9:]).max() + 4.0)
        return _Nearest((first, second), poses, far, self._between).refined(measured.cap(pair))

    def _of(self, mesh: str) -> Leaves:
        if mesh not in self._leaves:
            self._leaves[mesh] = Leaves.of(self._bodies.parts[mesh], self._meshes.get(mesh))
        return self._leaves[mesh]

    def finish(self) -> None:
        """Gives the parts that have changed to the bodies."""
        changed = {mesh: own for mesh, own in sorted(self._leaves.items()) if own.changed}
        if changed:
            parts = {mesh: own.made() for mesh, own in changed.items()}
            self._bodies.replace_parts(parts, {mesh: [i for i, _ in own.names] for mesh, own in changed.items()})
