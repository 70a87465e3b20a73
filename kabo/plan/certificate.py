"""The certificate of a plan as data: proofs that its motions are free of collision, and the clearances they leave.

[docs/certificates.md] says what each number means. A proof refers to convex parts, kept once for each mesh, and to axes
that separate them; its checker derives poses, bounds and margins independently.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Clearance:
    """The least distance of one segment [m], and its two bodies; None where no body is near."""

    node: str
    segment: int
    clearance: float | None = None
    between: tuple[str, str] | None = None
    permitted: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class PairProof:
    """The proof that two bodies stay apart during a stretch of motion.

    `first` moves. `place` is the number of the pose of `second` that is meant, 0 if it has only one. `walk` are the
    letters of the proof's tree in depth-first order; `axes` are the numbers of its axes: first those of every `a`, three
    little-endian int16 each, then those of every `e`, three float64 each.
    """

    first: str
    second: str
    place: int
    walk: str
    axes: bytes


@dataclass(frozen=True)
class StretchProof:
    """The proofs of one stretch of a node's motion, in which the same segments are under way.

    If the node begins before the preceding one has ended, there are also proofs that the two motions never meet: then
    `before` are the segments of the preceding motion, and every piece of both paths is cut into `cut` parts.
    """

    node: str
    segments: tuple[int, ...]
    pairs: tuple[PairProof, ...] = ()
    before: tuple[int, ...] = ()
    cut: int = 0


@dataclass(frozen=True)
class BodyParts:
    """Convex parts that enclose a mesh: the number of vertices of each, and all vertices as little-endian float64."""

    sizes: tuple[int, ...]
    vertices: bytes


@dataclass(frozen=True)
class Certificate:
    """The proofs that a plan's motions are free of collision, none of which `verify` takes on trust.

    Pairs without a proof are more than `near` [m] apart, along an axis of the world's frame or of the link that carries
    both. `bodies` are the parts of every mesh, by its hash. Without `proofs` it only reports clearances.
    """

    epsilon: float
    segments: tuple[Clearance, ...] = ()
    near: float | None = None
    bodies: Mapping[str, BodyParts] = field(default_factory=dict)
    proofs: tuple[StretchProof, ...] = ()
