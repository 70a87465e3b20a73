"""The certificate of a plan as data: proofs that its motions are free of collision, and the clearances they leave.

[docs/explanation/certificates.md] says what each number means.
A proof refers to convex parts, kept once for each mesh, and to axes
that separate them; its checker derives poses, bounds and margins independently.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from kabo.arrays import Array
from kabo.displays import counted


@dataclass(frozen=True)
class Clearance:
    """The least distance [m] between two bodies during one segment, with their names; None if no body is near."""

    node: str
    segment: int
    clearance: float | None = None
    between: tuple[str, str] | None = None
    permitted: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class ProvenGap:
    """What is proven of two bodies in one stretch of a node's motion, in which they come near each other.

    Attributes:
        node, segments, before: the stretch, as the certificate names it.
        names: the two bodies, objects or links.
        hands: of each the robot that moves it and the last of its planned joints that does; None: it stands.
        in_world: whether axes are directions of the world, not of a joint that carries both bodies.
        least: the least gap [m].
        claims: unit axes (3,), along which the first body is ahead of the second one, and gaps [m]; displacing the
            bodies by d and e changes such a gap by axis · (d - e). None: only the least gap is known.
    """

    node: str
    segments: tuple[int, ...]
    before: tuple[int, ...]
    names: tuple[str, str]
    hands: tuple[tuple[str, int] | None, tuple[str, int] | None]
    in_world: bool
    least: float
    claims: tuple[tuple[Array, float], ...] = field(repr=False)


@dataclass(frozen=True)
class PairProof:
    """The proof that two bodies stay apart during a stretch of motion.

    `first` is a moving body. `place` is the index of the pose of `second` in the proof, 0 if `second` has only one
    pose. `walk` has one letter for each node of the proof's tree, in depth-first order. `axes` are the components
    of the separating axes: first of all nodes `a`, three little-endian int16 each, then of all nodes `e`, three
    float64 each.
    """

    first: str
    second: str
    place: int
    walk: str
    axes: bytes


@dataclass(frozen=True)
class StretchProof:
    """The proofs for one stretch of a node's motion, during which the same segments are executed.

    If the node begins before the preceding node has ended, there are also proofs that the two motions do not
    collide: then `before` are the segments of the preceding motion, and every piece of both paths is divided into
    `cut` parts.
    """

    node: str
    segments: tuple[int, ...]
    pairs: tuple[PairProof, ...] = ()
    before: tuple[int, ...] = ()
    cut: int = 0


@dataclass(frozen=True)
class BodyParts:
    """Convex parts that enclose a mesh: the number of vertices of each, and all vertices as little-endian float64.

    `rounds` has five such numbers for each part, or none for all: the radius of a ball, the radius of a flat disc and
    the disc's axis, all of which are added to the hull of the vertices.
    """

    sizes: tuple[int, ...]
    vertices: bytes
    rounds: bytes = b""


@dataclass(frozen=True)
class Certificate:
    """The proofs that a plan's motions are free of collision; `verify` checks all of them.

    Pairs of bodies without a proof are more than `near` [m] apart, along an axis of the world's frame or of the
    link that carries both bodies. `bodies` are the convex parts of every mesh, by the mesh's hash. A certificate
    without `proofs` only reports clearances.
    """

    epsilon: float
    segments: tuple[Clearance, ...] = ()
    near: float | None = None
    bodies: Mapping[str, BodyParts] = field(default_factory=dict)
    proofs: tuple[StretchProof, ...] = ()

    def __repr__(self) -> str:
        stretches, meshes = (
            counted(len(self.proofs), "stretch", "stretches"),
            counted(len(self.bodies), "mesh", "meshes"),
        )
        return f"<Certificate: proofs of {stretches} of motion, parts of {meshes}, epsilon {1000 * self.epsilon:g} mm>"
