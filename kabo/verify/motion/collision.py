"""Checks one stretch of motion for collisions: finds the bodies that could meet, and proves them apart."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from kabo.verify.motion.contacts.granted import Permits
from kabo.verify.motion.motion_bounds import closer
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.surfaces import hull_depth
from kabo.verify.motion.sweep import Contact, Intervals, Pair, Path, Proof, SweptBody, open_intervals, weights
from kabo.verify.motion.trajectories.figures import TrajectoryFigures
from kabo.verify.report import Finding, Least


@dataclass
class Tally:
    """The figures of the check so far, and the proofs that were found."""

    pairs: int = 0
    distances: int = 0
    least: Least | None = None
    certified: bool = False  # a certificate has to prove apart what may not touch
    known: dict[bytes, Proof] = field(default_factory=dict)
    stretches: list[MotionStretch] = field(default_factory=list)  # all stretches checked, for the certificate
    trajectories: TrajectoryFigures = field(default_factory=TrajectoryFigures)

    def below(self, shift: np.ndarray | None) -> float:
        """Nearer than this [m] a pair has to come to be the nearest one; where contact is permitted, none is."""
        return 0.0 if shift is not None else np.inf if self.least is None else self.least.distance


def check_collision(
    node: str,
    paths: tuple[Path, Path],
    moving: Sequence[SweptBody],
    standing: Sequence[SweptBody],
    permits: Permits,
    world: SceneModel,
    tally: Tally,
) -> Iterator[Finding]:
    """Proves that bodies that move along a path touch only what they may; yields the contacts that are not permitted.

    Args:
        node: the id of the node.
        paths: the path of the robots that move, and one of the same motion with smaller deviations and more way
            points, for bodies that nearly touch.
        moving: the links of these robots, and all objects that they carry.
        standing: all other bodies; one name may occur in several poses.
        permits: the contacts that the segment permits.
        world: the scene.
        tally: the figures and earlier proofs, to which this check adds.
    """
    yield from check_pairs(node, paths, list(_pairs(moving, standing, permits, world, tally)), permits, tally)


def check_pairs(
    node: str,
    paths: tuple[Path, Path],
    pairs: Sequence[tuple[SweptBody, SweptBody]],
    permits: Permits,
    tally: Tally,
) -> Iterator[Finding]:
    """Proves the bodies of each pair apart, as `check_collision` does."""
    path, fine = paths
    count, open_ = open_intervals(path, pairs)
    tally.pairs += count
    for pair, intervals in open_:
        names = pair.first.name, pair.second.name
        shift = permits.shift(*names)
        proof = _known_proof(pair, intervals, shift, fine, tally)
        tally.distances += proof.distances
        if proof.least < min(proof.below, tally.below(shift)):
            tally.least = Least(max(0.0, proof.least), names, node, proof.time)
        if proof.contact is not None:
            yield _finding(node, names, proof)


def _pairs(
    moving: Sequence[SweptBody], standing: Sequence[SweptBody], permits: Permits, world: SceneModel, tally: Tally
) -> Iterator[tuple[SweptBody, SweptBody]]:
    for i, first in enumerate(moving):
        for second in (*moving[i + 1 :], *standing):
            names = first.name, second.name
            apart = tally.certified and permits.shift(*names) is None
            if not apart and world.may_meet(*names) and not (permits.loose and frozenset(names) in permits.loose):
                yield first, second


def _known_proof(pair: Pair, intervals: Intervals, shift: np.ndarray | None, fine: Path, tally: Tally) -> Proof:
    """The proof for a pair, or the one that was found before; beside the finer path where the first does not do."""
    key, below = _key(pair, shift), tally.below(shift)
    if key not in tally.known or not tally.known[key].tells(below):
        finer = fine is not pair.path and not pair.path.exact
        proof = Proof(Contact(0.0, 0.0, 0.0))
        if shift is None:
            proof = _prove(pair, intervals, shift, below)
        elif not finer:
            proof = _prove(*closer(pair, intervals), shift, below)  # bodies that nearly touch along the whole path
        if proof.contact is not None and finer:
            again = Pair(fine, pair.first, pair.second, weights(fine, pair.first, pair.second))
            whole = again, [(0.0, again.length)]
            proof = _prove(*(whole if shift is None else closer(*whole)), shift, below)
        tally.known[key] = proof
    return tally.known[key]


def _prove(pair: Pair, intervals: Intervals, shift: np.ndarray | None, below: float) -> Proof:
    if intervals[0][0] == 0.0 and pair.contained(shift):
        a, b = pair.poses(0.0)
        depth = hull_depth(pair.first.surface, a, pair.second.surface, b)
        return Proof(Contact(float(pair.path.times[0]), None, depth, True), 0.0, float(pair.path.times[0]))
    return pair.advance(intervals, shift, below)


def _key(pair: Pair, shift: np.ndarray | None) -> bytes:
    digest = hashlib.sha256(" ".join(pair.path.arms).encode())
    digest.update(pair.path.configurations.tobytes() + pair.path.times.tobytes())
    digest.update(b"" if pair.path.exact else pair.strays.tobytes())
    for thing in (pair.first, pair.second):
        digest.update(thing.surface.identity)
        if thing.mount is not None:
            digest.update(
                b"on %s %d" % (thing.mount.robot.encode(), thing.mount.joint) + thing.mount.joint_T_body.tobytes()
            )
        elif thing.world_T is not None:
            digest.update(b"at" + thing.world_T.tobytes())
    digest.update(b"" if shift is None else shift.tobytes())
    return digest.digest()


def _finding(node: str, names: tuple[str, str], proof: Proof) -> Finding:
    contact = proof.contact
    assert contact is not None
    first, second = names
    if contact.distance is not None:
        text = f"{first} and {second}: cannot be decided, closer than {contact.distance:.2g} m"
        if contact.stray > 0.0:
            text += f", and the trajectory may bring them {contact.stray:.2g} m nearer than its path"
        return Finding(node, text, contact.time, names, 0.0)
    if contact.inside:
        return Finding(
            node, f"{first} and {second}: one lies inside the other", contact.time, names, contact.depth
        )
    text = f"{first} and {second} collide"
    if contact.depth > 0:
        text += f" (about {1000 * contact.depth:.2g} mm deep)"
    return Finding(node, text, contact.time, names, contact.depth)
