"""The certificate of a right plan, carried along into a spoilt one: what the second checker says of it.

Left as it is, it would often be refused for its form alone: no parts for a new obstacle, no proofs for a stretch that
was not there. So the form is mended (parts are added, and every proof of the node that could be meant is offered), and
what is told besides is dropped. What is still refused is refused for what it claims.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from scipy.spatial import ConvexHull

from kabo.plan import BodyParts, Certificate, PairProof, Plan, StretchProof
from kabo.scene import Mesh
from kabo.verify import Finding
from kabo.verify.certificate.check import check_certificate
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.stretches import MotionStretch


@dataclass(frozen=True)
class Verdict:
    """What the second checker says of the spoilt nodes, and of the pairs alone that are said to collide.

    Pairs whose contact is granted to a stretch (an object and what it stands on) are judged by measuring alone there.
    """

    refused: bool
    accepted_pairs: tuple[tuple[str, str], ...] = ()
    granted_pairs: tuple[tuple[str, str], ...] = ()  # accepted, too


class OnePair(SceneModel):
    """A world in which only two things may not touch; it shares what another has made."""

    def __init__(self, world: SceneModel, pair: Sequence[str]) -> None:
        self.__dict__.update(world.__dict__)
        self._meet, self.pair = {}, frozenset(pair)

    def may_meet(self, first: str, second: str) -> bool:
        """Whether contact of two things would be a collision, and is asked for."""
        return self.pair == {first, second} and super().may_meet(first, second)


def second_opinion(
    right: Plan,
    spoilt: Plan,
    nodes: Sequence[str],
    world: SceneModel,
    stretches: Sequence[MotionStretch],
    colliding: Sequence[tuple[str, str]],
) -> Verdict | None:
    """What the certificate of the right plan still proves; None if it has none.

    Args:
        right: the right plan, with its certificate.
        spoilt: the spoilt plan.
        nodes: what was spoilt of it.
        world: the spoilt scene.
        courses: the stretches of these nodes, as they were walked.
        colliding: pairs that somebody else says collide; each is also asked about alone.
    """
    if right.certificate is None or right.certificate.near is None:
        return None
    plan = replace(spoilt, certificate=_mended(right, spoilt, nodes, world, stretches))
    refused, _ = check_certificate(plan, world, list(nodes), stretches)
    accepted = [
        pair for pair in colliding if stretches and not _says(plan, OnePair(world, pair), list(nodes), stretches)
    ]
    granted = {pair for pair in accepted if any(frozenset(pair) in stretch.permitted for stretch in stretches)}
    return Verdict(bool(refused), tuple(pair for pair in accepted if pair not in granted), tuple(sorted(granted)))


def _says(plan: Plan, world: SceneModel, nodes: list[str], stretches: Sequence[MotionStretch]) -> list[Finding]:
    return check_certificate(plan, world, nodes, stretches)[0]


def _mended(
    right: Plan, spoilt: Plan, nodes: Sequence[str], world: SceneModel, stretches: Sequence[MotionStretch]
) -> Certificate:
    given = right.certificate
    assert given is not None
    own = [proof for proof in given.proofs if proof.node in nodes]
    proofs = [_offered(stretch, own, right, spoilt) for stretch in stretches] or own
    return replace(given, segments=(), proofs=tuple(proofs), bodies={**_hulls(world), **given.bodies})


def _offered(stretch: MotionStretch, own: Sequence[StretchProof], right: Plan, spoilt: Plan) -> StretchProof:
    """The proofs of the same stretch; where its segments were spoilt, those of the node's other stretches as well."""
    before, after = right.nodes[stretch.node].motion, spoilt.nodes[stretch.node].motion
    same = all(i < len(before) and before[i] == after[i] for i in stretch.segments)
    pairs: list[PairProof] = []
    for proof in own:
        if proof.node == stretch.node and (proof.segments == stretch.segments or not same):
            pairs += proof.pairs
    return StretchProof(stretch.node, stretch.segments, tuple(pairs))


def _hulls(world: SceneModel) -> dict[str, BodyParts]:
    """One part for each body of the scene: its hull."""
    return {f"sha256:{body.mesh.digest}": _hull(body.mesh) for body in world.scene.bodies.values()}


def _hull(mesh: Mesh) -> BodyParts:
    corners = mesh.vertices[ConvexHull(mesh.vertices).vertices]
    return BodyParts((len(corners),), corners.astype("<f8").tobytes())
