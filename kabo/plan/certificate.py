"""The certificate of a plan as data: what proves its motions free, and the distances that this leaves.

[docs/certificates.md] says what each number means. A proof speaks of convex parts, kept once for each mesh, and of
axes that separate them; whoever checks it derives poses, bounds and margins alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Clearance:
    """What a certificate says of one segment: least distance [m] and between which; None where nothing is near."""

    node: str
    segment: int
    clearance: float | None = None
    between: tuple[str, str] | None = None
    permitted: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class PairProof:
    """Why two things stay apart during a stretch of motion.

    `first` moves. `place` says which of the places that `second` may have is meant, 0 if there is one. `walk` are
    the letters of a tree in the order of a walk; `axes` the numbers of its axes: first those of every `a`, three
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

    If the node begins before the one before it has ended, there are also proofs that the two motions never meet: then
    `before` are the segments of that other motion, and every piece of both paths is cut into `cut` parts.
    """

    node: str
    segments: tuple[int, ...]
    pairs: tuple[PairProof, ...] = ()
    before: tuple[int, ...] = ()
    cut: int = 0


@dataclass(frozen=True)
class BodyParts:
    """Convex parts that enclose a mesh: how many vertices each has, and all of them as little-endian float64."""

    sizes: tuple[int, ...]
    vertices: bytes


@dataclass(frozen=True)
class Certificate:
    """What proves a plan's motions free; `verify` trusts none of it.

    `near` [m]: pairs without a proof are apart by more, along an axis of the world's frame or of what carries both.
    `bodies` are the parts of every mesh, by its hash. Without `proofs` it only says distances, for people.
    """

    epsilon: float
    segments: tuple[Clearance, ...] = ()
    near: float | None = None
    bodies: Mapping[str, BodyParts] = field(default_factory=dict)
    proofs: tuple[StretchProof, ...] = ()
