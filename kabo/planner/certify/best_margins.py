"""Better proofs for the pairs that decide how much clearance a stretch has: their parts are cut closer to their meshes.

What the least margin of a stretch is short of the distance of the meshes is mostly what convex parts stick out. Where
an axis of such a pair ends at a part, this part is cut across the axis, up to its mesh; then the pair is proven again. In
each of a few rounds the pairs with the least margins get this work, until it gains nothing.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.geometry.collision.kernels.witness import POSITIONS_PER_PIECE
from kabo.geometry.collision.separation_proofs import Course, Witness
from kabo.planner.certify.certified_bodies import CertifiedBodies
from kabo.planner.certify.cut_parts import CutParts
from kabo.planner.certify.proven_stretches import ProvenStretch
from kabo.scene import Mesh
from kabo.scene.kernels.poses import forward_kinematics

ROUNDS = 4
NEXT = 1.05  # of the least margin of a stretch: pairs up to this one get the same work
ENOUGH = 1.03  # of its margin: a pair that gains less is settled
WORTH = 0.08  # of its margin: less is not worth a cut
MAX_NODES = 8  # of a proof, of which axes are looked at
MAX_CUTS = 1  # across one axis of one body


class Node(NamedTuple):
    """An axis of a proof: the stretch, the parts of both bodies, and the axis from the second to the first."""

    begin: int
    end: int
    parts: tuple[tuple[int, int], tuple[int, int]]
    axis: Array  # (3,)


def sharpen(
    proven: Sequence[ProvenStretch],
    bodies: CertifiedBodies,
    meshes: Mapping[str, Mesh],
    near: float,
    look: Callable[[], None],
) -> None:
    """Cuts parts and proves pairs again until the least margin of every stretch is the best that is found.

    Args:
        proven: all stretches with their proofs, which are replaced.
        bodies: the parts, which are replaced.
        meshes: what parts may be cut to, by the hashes of meshes.
        near: margins from this on [m] do not count.
        look: called before each stretch.
    """
    cut: dict[str, CutParts] = {}
    settled: list[set[int]] = [set() for _ in proven]
    for _ in range(ROUNDS):
        chosen = [
            _least_pairs(each.proofs.margins, done, near) for each, done in zip(proven, settled, strict=True)
        ]
        changed: set[str] = set()
        for each, pairs in zip(proven, chosen, strict=True):
            if pairs:
                look()
                poses = _Poses(each.course)
                for pair in pairs:
                    changed |= _cut_pair(each, pair, poses, bodies, meshes, cut)
        if not changed:
            return
        bodies.replace_parts({mesh: cut[mesh].made() for mesh in sorted(changed)})
        for each, pairs, done in zip(proven, chosen, settled, strict=True):
            if pairs:
                look()
                done |= _prove_again(each, pairs, bodies)


def _least_pairs(margins: Array, settled: set[int], near: float) -> list[int]:
    """The pairs with the least margins of a stretch; none if the least one is settled, or `near`."""
    if not len(margins) or margins.min() >= near or int(margins.argmin()) in settled:
        return []
    below = np.flatnonzero(margins < min(near, NEXT * margins.min())).tolist()
    return [pair for pair in below if pair not in settled]


def _prove_again(each: ProvenStretch, pairs: list[int], bodies: CertifiedBodies) -> set[int]:
    """Proves pairs with the parts as they are, keeps what is better; the pairs that gained too little."""
    course, numbers = each.course, np.array(pairs)
    kept = None if course.kept is None else course.kept[numbers]
    made = bodies.prove_again(replace(course, pairs=np.ascontiguousarray(course.pairs[numbers]), kept=kept))
    if made is None:
        return set(pairs)
    before = each.proofs.margins[numbers]
    better = np.flatnonzero(made.margins > before)
    rest = np.setdiff1d(np.arange(len(each.proofs.margins)), numbers[better])
    each.proofs = each.proofs.only(rest).joined(made.only(better), rest, numbers[better])
    return {pairs[k] for k in np.flatnonzero(made.margins < ENOUGH * before).tolist()}


def _cut_pair(
    each: ProvenStretch,
    pair: int,
    poses: "_Poses",
    bodies: CertifiedBodies,
    meshes: Mapping[str, Mesh],
    cut: dict[str, CutParts],
) -> set[str]:
    """Cuts the parts at which axes of a pair end; the meshes whose parts are others now."""
    witness, course = each.proofs.witness(pair), each.course
    first, second, frame = course.pairs[pair].tolist()
    own = [course.bodies[first].mesh, course.bodies[second].mesh]
    if witness is None or not any(mesh in meshes for mesh in own):
        return set()
    changed: set[str] = set()
    counts = [len(bodies.parts[mesh].vertices) for mesh in own]
    worth = WORTH * witness.margin
    for node in _axes_of(witness, len(course.waypoints), counts[0], counts[1]):
        for e, (mesh, number) in enumerate(zip(own, (first, second), strict=True)):
            if mesh in meshes:
                made = cut.get(mesh) or CutParts(bodies.parts[mesh], meshes[mesh].vertices, meshes[mesh].faces)
                cut[mesh] = made
                axis = node.axis / np.linalg.norm(node.axis)
                direction = axis if e else -axis
                if _cut_across(made, node, e, direction, poses.of(number, frame, node), worth):
                    changed.add(mesh)
    return changed


def _cut_across(made: CutParts, node: Node, e: int, direction: Array, poses: Array, worth: float) -> bool:
    """Cuts those parts of a body that reach farthest along a direction, at the pose at which it does."""
    turned, along = direction @ poses[:, :3, :3], poses[:, :3, 3] @ direction
    low, high = node.parts[e]
    reaches = np.array([(made.parts[part] @ turned.T).max(axis=0) + along for part in range(low, high)])
    at = int(reaches.max(axis=0).argmax())
    own, any_cut = reaches[:, at] - along[at], False
    for _ in range(MAX_CUTS):
        part = int(own.argmax())
        height = made.needed(low + part, turned[at], own[part] - worth)
        if own[part] - height <= worth or not made.cut(low + part, turned[at]):
            break
        own[part], any_cut = height, True
    return any_cut


def _axes_of(witness: Witness, rows: int, first: int, second: int) -> Iterator[Node]:
    """Some axes of a proof along a path of so many way points, of bodies of so many parts: each k-th, at most MAX_NODES."""
    count, places = {letter: witness.walk.count(letter) for letter in "ae"}, {"a": 0, "e": 0}
    own = {
        "a": np.frombuffer(witness.axes, "<i2", 3 * count["a"]).reshape(-1, 3),
        "e": np.frombuffer(witness.axes, "<f8", offset=6 * count["a"]).reshape(-1, 3),
    }
    stride = max(1, -(-sum(count.values()) // MAX_NODES))
    ahead = [(0, (rows - 1) * POSITIONS_PER_PIECE, (0, first), (0, second))]
    for letter in witness.walk:
        begin, end, a, b = ahead.pop()
        if letter in "ae":
            if sum(places.values()) % stride == 0:
                yield Node(begin, end, (a, b), own[letter][places[letter]])
            places[letter] += 1
        elif letter == "t":
            middle = (begin + end) >> 1
            if end - begin > POSITIONS_PER_PIECE:
                middle = (begin // POSITIONS_PER_PIECE + end // POSITIONS_PER_PIECE) // 2 * POSITIONS_PER_PIECE
            ahead += [(middle, end, a, b), (begin, middle, a, b)]
        elif letter == "f":
            middle = sum(a) // 2
            ahead += [(begin, end, (middle, a[1]), b), (begin, end, (a[0], middle), b)]
        elif letter == "s":
            middle = sum(b) // 2
            ahead += [(begin, end, a, (middle, b[1])), (begin, end, a, (b[0], middle))]


class _Poses:
    """The poses of bodies along a course, each position computed once."""

    def __init__(self, course: Course) -> None:
        self._course = course
        self._known: dict[int, Array] = {}

    def of(self, body: int, frame: int, node: Node) -> Array:
        """The poses (P, 4, 4) of a body at the ends of a node and at way points between, with the frame held."""
        step = POSITIONS_PER_PIECE if node.end - node.begin >= POSITIONS_PER_PIECE else node.end - node.begin
        placed = self._course.bodies[body]
        if placed.joint == 0:
            return _whole(placed.joint_T_body)[None]
        positions: Integers = np.arange(node.begin, node.end + 1, step)
        joints = np.array([self._at(int(s)) for s in positions])
        poses = joints[:, placed.joint] @ _whole(placed.joint_T_body)
        if frame:
            poses = self._at(0)[frame] @ np.linalg.inv(joints[:, frame]) @ poses
        return np.asarray(poses)

    def _at(self, s: int) -> Array:
        """The poses (J, 4, 4) of all joints at a position."""
        if s not in self._known:
            piece, share = divmod(s, POSITIONS_PER_PIECE)
            rows, tree = self._course.waypoints, self._course.tree
            q = rows[piece] + (share / POSITIONS_PER_PIECE * (rows[piece + 1] - rows[piece]) if share else 0.0)
            world_T = np.zeros((len(tree.parent), 12))
            world_T[0, [0, 4, 8]] = 1.0
            forward_kinematics(
                q, tree.parent, tree.kind, tree.source, tree.ratio, tree.shift, tree.placement, world_T
            )
            whole = np.tile(np.eye(4), (len(world_T), 1, 1))
            whole[:, :3, :3], whole[:, :3, 3] = world_T[:, :9].reshape(-1, 3, 3), world_T[:, 9:]
            self._known[s] = whole
        return self._known[s]


def _whole(flat: Array) -> Array:
    """A pose (12,) as a matrix (4, 4)."""
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = flat[:9].reshape(3, 3), flat[9:]
    return found
