"""Proofs that pairs of bodies stay apart along a path, as data that a verifier can check without a search.

Proofs are defined in [docs/explanation/certificates.md] and found by `kernels.witness`.
The parts of a mesh are sorted so that
adjacent parts in the order are close in space, and halves of a range have small boxes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.bundles import DISC, RADIUS, Hulls, Proofs, Things, Trail, Work
from kabo.geometry.collision.kernels.witness import AXIS, EXACT_AXIS, POSITIONS_PER_PIECE, SMALL_SHARE, prove_pairs
from kabo.geometry.collision.view_arrays import chain_of, offset_for, search_for, way_of
from kabo.geometry.collision.view_arrays import reach as reach_of
from kabo.geometry.parts import Enclosure, Packed, stacked
from kabo.scene import KinematicTree

CODE_LETTERS = "baetfs!"  # letters of the codes: boxes, axis, exact axis, time, first, second, failed
_LETTERS = bytes.maketrans(bytes(range(len(CODE_LETTERS))), CODE_LETTERS.encode())
MAX_PROOF_NODES = 200_000  # in all proofs of one path; far more than any path needs
STACK_DEPTH = 4096  # rows of the stack
SHARE_OF_CLEARANCE = 0.9  # of the clearance in the planner's proofs: the margin tried first
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
    middles = np.array([part.mean(axis=0) for part in enclosure.parts])
    return _halved(middles, list(range(len(middles))))


def ordered(enclosure: Enclosure) -> Parts:
    """The parts of an enclosure without a tree, in the order of `order_of`."""
    order, packed = order_of(enclosure), enclosure.packed
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
        self._reaches: dict[tuple[str, bytes], tuple[float, float]] = {}
        self._codes, self._axes = np.zeros(MAX_PROOF_NODES, np.uint8), np.zeros((MAX_PROOF_NODES, 3))
        self._stack = np.zeros((STACK_DEPTH, 6), np.int64)

    def reach(self, body: PlacedBody) -> tuple[float, float]:
        """How far a body's corners and discs, and all of its points, are from the joint that carries it [m]."""
        key = body.mesh, body.joint_T_body.tobytes()
        if key not in self._reaches:
            own = slice(*self.ranges[body.mesh])
            turn, at = body.joint_T_body[:9].reshape(3, 3), body.joint_T_body[9:]
            placed = np.einsum("rc,bci->bri", turn, self.hulls.blocks[own]) + at[None, :, None]
            far = np.linalg.norm(placed, axis=1).max(axis=1, initial=0.0) * (1.0 + 1e-12)
            far += self.hulls.rounds[own, DISC]
            balls = self.hulls.rounds[own, RADIUS]
            self._reaches[key] = float(far.max(initial=0.0)), float((far + balls).max(initial=0.0))
        return self._reaches[key]

    def prove(self, course: Course, wanted: Array | None = None) -> list[Witness | None] | Unproven:
        """The proof of every pair, or None for a pair that needs no proof; or the first pair that cannot be proven apart.

        A pair needs no proof if it does not move, or if the boxes around both swept volumes are apart. Proofs leave
        `wanted` (P,) [m] where they can, else as much as is found with a stated effort; by default 0.9 of the planner's
        clearance.
        """
        chain = chain_of(course.tree)
        rows, count = len(course.waypoints), len(course.pairs)
        things = np.array([[b.joint, *self.ranges[b.mesh]] for b in course.bodies], np.int64).T.copy()
        reaches = np.array([self.reach(body) for body in course.bodies])
        joint_T = np.array([body.joint_T_body for body in course.bodies])
        search = search_for(offset_for(2.0 * float((reach_of(chain)[things[0]] + reaches[:, 1]).max())))
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
        bodies = Things(things, reaches[:, 0].copy(), joint_T, self.hulls, self.boxes)
        proofs = Proofs(self._codes, self._axes, where, margins, targets)
        proven = prove_pairs(course.pairs, limits, chain, trail, bodies, self._work(), search, proofs)
        if proven < count:
            return self._unproven(course, int(proven), int(where[proven]))
        return self._witnesses(where, margins)

    def _work(self) -> Work:
        return Work(
            ends=np.zeros((2, 4), np.int64),
            over=np.zeros((2, 3)),
            still=np.zeros(2, np.bool_),
            box=np.zeros(6),
            swept=np.zeros((2, 6)),
            size=np.zeros(2),
            scratch=np.zeros((2, 12)),
            stack=self._stack,
        )

    def _witnesses(self, where: Integers, margins: Array) -> list[Witness | None]:
        """The output of the kernel, split into proofs."""
        count = int(where[-1]) if len(where) else 0
        codes, axes = self._codes[:count], self._axes[:count]
        letters = codes.tobytes().translate(_LETTERS).decode("ascii")
        short, exact = codes == AXIS, codes == EXACT_AXIS
        shorts, exacts = axes[short].astype("<i2").tobytes(), axes[exact].astype("<f8").tobytes()
        starts = np.concatenate([np.zeros(1, np.int64), where])
        before = 6 * np.concatenate([[0], np.cumsum(short)])[starts]
        before_exact = 24 * np.concatenate([[0], np.cumsum(exact)])[starts]
        found: list[Witness | None] = [None] * len(where)
        for p in np.flatnonzero(np.diff(starts)).tolist():
            own = shorts[before[p] : before[p + 1]] + exacts[before_exact[p] : before_exact[p + 1]]
            found[p] = Witness(letters[starts[p] : starts[p + 1]], own, float(margins[p]))
        return found

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
