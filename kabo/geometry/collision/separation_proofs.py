"""Proofs that pairs of bodies stay apart along a path, as data that a verifier can check without a search.

Proofs are defined in [docs/explanation/certificates.md] and found by `kernels.witness`.
The parts of a mesh are sorted so that
adjacent parts in the order are close in space, and halves of a range have small boxes.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import (
    DISC,
    RADIUS,
    Chain,
    Hulls,
    Proofs,
    Search,
    Sides,
    Things,
    Trail,
    Work,
)
from kabo.geometry.collision.kernels.nearest_places import AXES, Between
from kabo.geometry.collision.kernels.witness import (
    AXIS,
    EXACT_AXIS,
    POSITIONS_PER_PIECE,
    SMALL_SHARE,
    prove_pairs,
)
from kabo.geometry.collision.view_arrays import chain_of, offset_for, search_for, way_of
from kabo.geometry.collision.view_arrays import reach as reach_of
from kabo.geometry.parts import Enclosure, Packed, stacked
from kabo.scene import KinematicTree

CODE_LETTERS = "baetfs!"  # letters of the codes: boxes, axis, exact axis, time, first, second, failed
_LETTERS = bytes.maketrans(bytes(range(len(CODE_LETTERS))), CODE_LETTERS.encode())
MAX_PROOF_NODES = 200_000  # in all proofs of one path; far more than any path needs
STACK_DEPTH = 4096  # rows of the stack
SHARE_OF_CLEARANCE = 0.9  # of the clearance in the planner's proofs: the margin tried first
FIRST_ROWS = 64  # of the arrays of bodies
MIN_MARGIN = 1e-9  # [m] of every proof
MAX_PAIR_NODES = 4000  # of one proof with a wanted margin, after which any proof does
QUICK_LOSS, BEST_LOSS = 0.1, 0.02  # share of a gap by which axes may be worse than the best ones


class Parts(NamedTuple):
    """The convex parts of one mesh, sorted so that adjacent parts in the order are close in space."""

    vertices: tuple[Array, ...]  # each (V, 3) [m], in the body's frame
    packed: Packed
    boxes: Array  # (B, 6) lower and upper


class PlacedBody(NamedTuple):
    """A body on a joint of the moving tree; joint 0 is the world."""

    mesh: str
    joint: int
    joint_T_body: Array  # (12,)


@dataclass(frozen=True, eq=False)
class Course:
    """Bodies on a chain that moves straight from way point to way point, and the pairs (P, 3) whose separation is claimed.

    A row of pairs is first body, second body and frame. With `at_any_times`, a pair is claimed to stay apart with
    the two bodies at any two times of a straight piece, not only at equal times. `deviations` are how far the values
    of a configuration may be from each piece; `kept` is what each pair keeps from each other, zeros if None.
    """

    tree: KinematicTree
    waypoints: Array  # (W, n), W >= 2
    bodies: Sequence[PlacedBody]
    pairs: Integers
    at_any_times: bool = False
    deviations: Array | None = None  # (W - 1, n) [rad or m]
    kept: Array | None = None  # (P,) [m]


@dataclass(frozen=True)
class Witness:
    """The proof that a pair stays apart: nodes as letters in walk order, axes, and the least margin of an axis [m].

    An axis `a` is three little-endian int16, an axis `e` three float64; `margin` is infinite if boxes suffice.
    """

    walk: str
    axes: bytes
    margin: float


@dataclass(frozen=True)
class Unproven:
    """A pair that could not be proven apart: its index, the place on the path, and the gap at this place [m]."""

    pair: int
    start: float  # in pieces of the path
    end: float
    gap: float
    parts: tuple[int, int] = (0, 0)  # of both bodies, in the order of `Parts`


def order_of(enclosure: Enclosure) -> list[int]:
    """The numbers of an enclosure's parts, sorted by recursive splits at the median of their centres."""
    return in_order(np.array([part.mean(axis=0) for part in enclosure.parts]))


def in_order(middles: Array) -> list[int]:
    """The numbers of parts with these middles (B, 3), sorted by recursive splits at the median."""
    return _halved(middles, list(range(len(middles))))


def ordered(enclosure: Enclosure) -> Parts:
    """The parts of an enclosure without a tree, in the order of `order_of`."""
    return arranged(enclosure, order_of(enclosure))


def arranged(enclosure: Enclosure, order: list[int]) -> Parts:
    """The parts of an enclosure without a tree, in an order of their numbers."""
    packed = enclosure.unmeasured
    vertices = tuple(enclosure.parts[i] for i in order)
    own = Packed(packed.blocks[order], packed.sizes[order], packed.diameters[order], packed.rounds[order])
    boxes = np.array([[*part.min(axis=0), *part.max(axis=0)] for part in vertices])
    reach = own.rounds[:, :1] + own.rounds[:, 1:2] * np.hypot(own.rounds[:, [3, 4, 2]], own.rounds[:, [4, 2, 3]])
    boxes[:, :3] -= reach
    boxes[:, 3:] += reach
    return Parts(vertices, own, boxes)


def _halved(middles: Array, members: list[int]) -> list[int]:
    if len(members) < 3:
        return members
    axis = int(np.argmax(np.ptp(middles[members], axis=0)))
    ranked = sorted(members, key=lambda i: (middles[i, axis], i))
    half = len(members) // 2
    return _halved(middles, ranked[:half]) + _halved(middles, ranked[half:])


@dataclass(frozen=True, eq=False)
class ProofArrays:
    """The proofs of a course as the kernel writes them; a `Witness` is made of those that are written."""

    codes: NDArray[np.uint8]  # (N,) nodes of all proofs
    axes: Array  # (N, 3)
    where: Integers  # (P + 1,) where the proof of each pair begins
    margins: Array  # (P,) least margin of each [m]; infinite where no proof is needed, or boxes suffice

    @property
    def sizes(self) -> Integers:
        """The number of nodes of each proof (P,); 0 where none is needed."""
        return np.diff(self.where)

    @cached_property
    def _written(self) -> tuple[str, Integers, bytes, bytes]:
        """All nodes as letters, the axes of each kind before each node, and both kinds of axes as bytes."""
        short, exact = self.codes == AXIS, self.codes == EXACT_AXIS
        before = np.zeros((2, len(self.codes) + 1), np.int64)
        np.cumsum([6 * short, 24 * exact], axis=1, out=before[:, 1:])
        letters = self.codes.tobytes().translate(_LETTERS).decode("ascii")
        return letters, before, self.axes[short].astype("<i2").tobytes(), self.axes[exact].astype("<f8").tobytes()

    @cached_property
    def _slices(self) -> list[list[int]]:
        """Of each pair where its letters and both kinds of its axes begin, and those of the next one."""
        _, before, _, _ = self._written
        found: list[list[int]] = np.concatenate([self.where[None], before[:, self.where]]).T.tolist()
        return found

    def witness(self, pair: int) -> Witness | None:
        """The proof of a pair; None if it needs none."""
        (begin, a, c), (end, b, d) = self._slices[pair : pair + 2]
        if begin == end:
            return None
        letters, _, short, exact = self._written
        axes = short[a:b] + exact[c:d] if c < d else short[a:b]
        return Witness(letters[begin:end], axes, float(self.margins[pair]))


class _Placed:
    """All bodies that proofs have been about, each in one row of growing arrays."""

    def __init__(self) -> None:
        self.numbers: dict[tuple[str, int, bytes], int] = {}
        self.rows = np.zeros((FIRST_ROWS, 3), np.int64)  # joint, first part, part after the last
        self.reaches, self.joint_T = np.zeros((FIRST_ROWS, 2)), np.zeros((FIRST_ROWS, 12))

    def add(self, key: tuple[str, int, bytes], rows: tuple[int, int, int], reach: Array, joint_T: Array) -> int:
        """The number of a new body."""
        number = len(self.numbers)
        if number == len(self.rows):
            for name in ("rows", "reaches", "joint_T"):
                setattr(self, name, np.concatenate([getattr(self, name)] * 2))
        self.rows[number], self.reaches[number], self.joint_T[number] = rows, reach, joint_T
        self.numbers[key] = number
        return number


class _Room:
    """Room for the sides of pairs, kept from course to course: new memory takes longer than most proofs."""

    def __init__(self) -> None:
        self._numbers, self._values = np.empty(0, np.int64), np.empty(0)

    def sides(self, count: int, bodies: int, joints: int, rows: int) -> Sides:
        """Arrays for so many sides, with whatever was in them."""
        whole, shapes = (bodies * joints, count * 2), (count * rows * 12, count * (rows - 1) * 3, count * 6)
        if len(self._numbers) < sum(whole):
            self._numbers = np.empty(sum(whole), np.int64)
        if len(self._values) < sum(shapes):
            self._values = np.empty(sum(shapes))
        numbers, (poses, bounds, _) = self._numbers, shapes
        return Sides(
            numbers=numbers[: whole[0]].reshape(bodies, joints),
            keys=numbers[whole[0] : sum(whole)].reshape(count, 2),
            poses=self._values[:poses].reshape(count, rows, 12),
            bounds=self._values[poses : poses + bounds].reshape(count, rows - 1, 3),
            boxes=self._values[poses + bounds : sum(shapes)].reshape(count, 6),
            still=np.empty(count, np.bool_),
            moves=np.empty(count, np.bool_),
        )


class Prover:
    """Finds proofs for the meshes of one scene; keeps the arrays that all proofs share."""

    def __init__(self, meshes: Mapping[str, Parts], near: float, clearance: float) -> None:
        """`near` [m]: boxes so far apart need no axis; `clearance` [m]: what the planner kept between parts."""
        self.near, self.margin = near, max(MIN_MARGIN, SHARE_OF_CLEARANCE * clearance)
        counts = [len(parts.vertices) for parts in meshes.values()]
        ends = np.cumsum([0, *counts])
        self.ranges = {name: (int(a), int(b)) for name, a, b in zip(meshes, ends, ends[1:], strict=False)}
        made = stacked([parts.packed for parts in meshes.values()])
        self.hulls = Hulls(made.blocks, made.sizes, made.rounds)
        self.boxes = np.concatenate([np.empty((0, 6)), *(parts.boxes for parts in meshes.values())])
        self.extents, self._balls = _extents(self.boxes, np.asarray(ends[:-1], np.int64))
        self._whole_rows = {name: len(self.boxes) + number for number, name in enumerate(("", *meshes))}
        self._settings: dict[tuple[int, int], tuple[Course, tuple[Chain, Things, Search]]] = {}
        self._placed, self._seen = _Placed(), dict[int, tuple[int, PlacedBody]]()
        self._last: tuple[Sequence[PlacedBody], Integers] = (), np.zeros(0, np.int64)
        self._trees: dict[int, tuple[KinematicTree, Chain, Array]] = {}
        self._codes, self._axes = np.zeros(MAX_PROOF_NODES, np.uint8), np.zeros((MAX_PROOF_NODES, 3))
        self._work, self._radii, self._room = _work(), dict[str, float](), _Room()
        self.between = between_parts()

    def number(self, body: PlacedBody) -> int:
        """The number of a body: equal bodies have equal ones."""
        known = self._seen.get(id(body))
        if known is None:
            key = body.mesh, body.joint, body.joint_T_body.tobytes()
            found = self._placed.numbers.get(key)
            if found is None:
                rows = body.joint, *self.ranges[body.mesh]
                found = self._placed.add(key, rows, self._reach(body), body.joint_T_body)
            self._seen[id(body)] = known = found, body  # which keeps the body, hence its id
        return known[0]

    def numbers(self, bodies: Sequence[PlacedBody]) -> Integers:
        """The numbers of bodies; of those of the last course at once."""
        if self._last[0] is not bodies:
            self._last = bodies, np.array([self.number(body) for body in bodies], np.int64)
        return self._last[1]

    def _reach(self, body: PlacedBody) -> Array:
        """How far a body's corners and discs, and all of its points, are from the joint that carries it (2,) [m]."""
        own = slice(*self.ranges[body.mesh])
        turn, at = body.joint_T_body[:9].reshape(3, 3), body.joint_T_body[9:]
        if body.joint == 0:  # it never moves: a bound is enough
            return np.full(2, self._radius(body.mesh) + math.sqrt(float(at @ at)))
        placed = np.einsum("rc,bci->bri", turn, self.hulls.blocks[own]) + at[None, :, None]
        far = np.linalg.norm(placed, axis=1).max(axis=1, initial=0.0) * (1.0 + 1e-12)
        far += self.hulls.rounds[own, DISC]
        balls = self.hulls.rounds[own, RADIUS]
        return np.array([far.max(initial=0.0), (far + balls).max(initial=0.0)])

    def _radius(self, mesh: str) -> float:
        """A bound of how far any point of a mesh's parts is from its origin [m]."""
        if mesh not in self._radii:
            own = self.boxes[slice(*self.ranges[mesh])]
            self._radii[mesh] = float(np.linalg.norm(np.abs(own).reshape(-1, 2, 3).max(axis=(0, 1), initial=0.0)))
        return self._radii[mesh]

    def _chain(self, tree: KinematicTree) -> tuple[Chain, Array]:
        """The arrays of a tree, and how far its joints may be from the world's origin."""
        if id(tree) not in self._trees:
            chain = chain_of(tree)
            self._trees[id(tree)] = tree, chain, reach_of(chain)
        return self._trees[id(tree)][1:]

    def setting(self, course: Course) -> tuple[Chain, Things, Search]:
        """The arrays of a course's chain and bodies, and those of a search for axes between them."""
        key = id(course.tree), id(course.bodies)
        if key not in self._settings:
            chain, reaches = self._chain(course.tree)
            numbers = self.numbers(course.bodies)
            rows, far = self._placed.rows[numbers].T.copy(), self._placed.reaches[numbers]
            search = search_for(offset_for(2.0 * float((reaches[rows[0]] + far[:, 1]).max())))
            things = Things(rows, far[:, 0].copy(), self._placed.joint_T[numbers], self.hulls, self.boxes)
            self._settings[key] = course, (chain, things, search)  # which keeps the bodies, hence their id
        return self._settings[key][1]

    def whole_bodies(self, course: Course) -> tuple[Integers, Array]:
        """The rows (T,) of `extents` for whole bodies, and balls (T, 4) around these, in their frames."""
        rows = np.array([self._whole_rows[body.mesh] for body in course.bodies], np.int64)
        return rows, self._balls[rows - self._whole_rows[""]]

    def prove(self, course: Course, wanted: Array | None = None) -> list[Witness | None] | Unproven:
        """The proof of every pair, or None for a pair that needs no proof; or the first pair that cannot be proven apart.

        Args:
            course: the bodies, their motion, and the pairs.
            wanted: as of `arrays`.
        """
        found = self.arrays(course, wanted)
        return found if isinstance(found, Unproven) else [found.witness(p) for p in range(len(found.margins))]

    def arrays(self, course: Course, wanted: Array | float | None = None) -> ProofArrays | Unproven:
        """The proofs of all pairs as arrays, or the first pair that cannot be proven apart.

        A pair needs no proof if it does not move, or if the boxes around both swept volumes are apart. Proofs leave
        `wanted` (P,) [m] where they can, else as much as is found with a stated effort; by default 0.9 of the planner's
        clearance.
        """
        chain, things, search = self.setting(course)
        rows, count = len(course.waypoints), len(course.pairs)
        finest, thorough = POSITIONS_PER_PIECE if course.at_any_times else 1.0, wanted is not None
        effort, loss = (MAX_PAIR_NODES, BEST_LOSS) if thorough else (MAX_PROOF_NODES, QUICK_LOSS)
        limits = np.array([self.near, SMALL_SHARE * self.margin, finest, effort, loss])
        needed = MIN_MARGIN + (np.zeros(count) if course.kept is None else course.kept)
        targets = np.array([needed + self.margin if wanted is None else np.maximum(needed, wanted), needed])
        strays = (
            np.zeros((rows - 1, course.waypoints.shape[1])) if course.deviations is None else course.deviations
        )
        where, margins = np.zeros(count, np.int64), np.full(count + 1, np.inf)
        way = way_of(chain, np.zeros((rows + 1, chain.joints.shape[1], 12)))
        trail = Trail(course.waypoints, strays, way, np.zeros((2, rows + 2, 12)), np.zeros((2, rows, 3)))
        proofs = Proofs(self._codes, self._axes, where, margins, targets)
        sides = self._room.sides(2 * count, len(things.radii), chain.joints.shape[1], rows)
        proven = prove_pairs(course.pairs, limits, chain, trail, things, sides, self._work, search, proofs)
        if proven < count:
            return self._unproven(course, int(proven), int(where[proven]))
        end = int(where[-1]) if count else 0
        starts = np.concatenate([np.zeros(1, np.int64), where])
        return ProofArrays(self._codes[:end].copy(), self._axes[:end].copy(), starts, margins[:count])

    def _unproven(self, course: Course, pair: int, start: int) -> Unproven:
        failed = start + np.flatnonzero(self._codes[start:] == CODE_LETTERS.index("!"))
        rows = self._axes[failed[0] : failed[0] + 2] if len(failed) else np.full((2, 3), np.nan)
        self._codes[start:] = 0
        parts = (0, 0)
        if len(failed):
            first, second = (self.ranges[course.bodies[k].mesh][0] for k in course.pairs[pair, :2])
            parts = int(rows[1, 0]) - first, int(rows[1, 1]) - second
        start_of, end_of, gap = rows[0].tolist()
        return Unproven(pair, start_of, end_of, gap, parts)


def _extents(boxes: Array, starts: Integers) -> tuple[Array, Array]:
    """Middles and half sides of boxes (B, 6), then those around each range of them; and balls (R, 4) around the latter.

    The first range, and the first ball, are room for none.
    """
    low, high, none = boxes[:, :3], boxes[:, 3:], np.zeros((1, 6))
    made = np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1)
    if not len(starts):
        return np.concatenate([made, none]), np.zeros((1, 4))
    low, high = np.minimum.reduceat(low, starts), np.maximum.reduceat(high, starts)
    whole = np.concatenate([none, np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1)])
    radii = np.sqrt((whole[:, 3:] ** 2).sum(axis=1))
    return np.concatenate([made, whole]), np.concatenate([whole[:, :3], radii[:, None]], axis=1)


def between_parts() -> Between:
    """Room for measuring how far parts are from each other."""
    return Between(np.zeros((3, 3)), np.zeros(3), np.zeros(3), np.zeros((AXES, 3)))


def _work() -> Work:
    return Work(
        ends=np.zeros((2, 4), np.int64),
        over=np.zeros((2, 3)),
        still=np.zeros(2, np.bool_),
        box=np.zeros(6),
        swept=np.zeros((2, 6)),
        size=np.zeros(2),
        scratch=np.zeros((2, 12)),
        stack=np.zeros((STACK_DEPTH, 6), np.int64),
    )
