"""Checks the certificate of a plan: every stretch of every motion and every pair of bodies that could meet.

No claim of a certificate is assumed: its convex parts must cover the meshes, poses and bounds are derived here,
boxes and separating axes are evaluated again. Nothing is searched. The verifier also checks the distances between
the meshes, whether or not the plan has a certificate.
"""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.phases import phase
from kabo.plan import Certificate, PairProof, Plan, ProvenGap, StretchProof
from kabo.scene import Element
from kabo.verify.certificate.clearance import FAR, Margins, of_branches, of_objects
from kabo.verify.certificate.exact import ExactFrames, ExactSide
from kabo.verify.certificate.kept import KeptDistances
from kabo.verify.certificate.meeting_stretches import stretch_of
from kabo.verify.certificate.pair_proof import (
    POSITIONS_PER_PIECE,
    Frames,
    Margin,
    ProvenPair,
    Refuted,
    Side,
    SideOf,
)
from kabo.verify.certificate.parts import Parts
from kabo.verify.certificate_report import CertificateReport
from kabo.verify.motion.overlaps import Meeting
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.surfaces import encloses
from kabo.verify.motion.sweep import Path, SweptBody
from kabo.verify.report import Finding

Name = tuple[str, tuple[int, ...], tuple[int, ...]]  # node, segments, segments of the node before
_LOG = logging.getLogger("kabo.verify")
CLEARANCE_TOLERANCE = 1e-9  # [m] slack between claimed and recomputed clearance


def check_certificate(
    plan: Plan,
    world: SceneModel,
    order: Sequence[str],
    stretches: Sequence[MotionStretch],
    meetings: Sequence[Meeting] = (),
    *,
    paranoid: bool = False,
) -> tuple[list[Finding], CertificateReport | None]:
    """Checks a plan's certificate; returns at most one finding, and the report (None if the plan has no proofs).

    Args:
        plan: the plan with its certificate.
        world: the scene.
        order: the ids of the plan's reached nodes.
        stretches: all stretches of the plan's motions.
        meetings: pairs of sweeps that may run at the same time, as one motion begins before another ends.
        paranoid: whether to evaluate poses and axes in exact arithmetic.
    """
    certificate = plan.certificate
    if certificate is None or certificate.near is None:
        claimed = plan.options.get("clearance")
        if isinstance(claimed, int | float) and claimed > 0.0 and stretches:
            text = f"the plan claims a clearance of {1000 * claimed:.4g} mm, but has no certificate that proves it"
            return [Finding(None, text)], None
        return [], None
    checker = _Checker(plan, world, certificate, certificate.near, paranoid)
    failed: list[tuple[str | None, str]] = []
    try:
        checker.check_epsilon()
        checker.take_parts(stretches)
        stretches = [*stretches, *checker.take_proofs(stretches, meetings)]
    except Refuted as error:
        failed.append((None, str(error)))
    judged = stretches if not failed else ()
    with phase("checking the certificate", len(judged), "stretches", log=_LOG) as step:
        for stretch in judged:
            try:
                checker.check(stretch)
            except Refuted as error:
                failed.append((stretch.node, str(error)))
            step()
    if not failed:
        failed.extend(checker.overstated())
    if failed:
        node, text = failed[0]
        more = f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""
        return [Finding(node, f"the certificate does not hold: {text}{more}")], CertificateReport(
            False, checker.near
        )
    return [], CertificateReport(
        True,
        checker.near,
        len(stretches),
        checker.pairs,
        checker.axes,
        len(checker.parts),
        paranoid,
        of_objects(world.scene, checker.margins, order),
        of_branches(plan, world.scene, checker.margins),
        tuple(checker.margins.gaps),
    )


@dataclass
class _Checker:
    plan: Plan
    world: SceneModel
    certificate: Certificate
    near: float
    paranoid: bool
    parts: dict[str, Parts] = field(default_factory=dict)
    proofs: dict[Name, StretchProof] = field(default_factory=dict)
    pairs: int = 0
    axes: int = 0

    def __post_init__(self) -> None:
        self.margins, self.kept = Margins(self.near), KeptDistances.of(self.plan, self.world.scene)
        self._standing: dict[tuple[str, bytes], tuple[Any, Any, Any]] = {}

    # -------------------------------------------------------------------------------------------- what it contains
    def check_epsilon(self) -> None:
        """Checks that the certificate has the plan's epsilon, or the scene's if the plan names none.

        Raises:
            Refuted: it has another one.
        """
        made = self.plan.options.get("epsilon")
        wanted = self.world.scene.epsilon if made is None else made
        if self.certificate.epsilon != wanted:
            raise Refuted(
                f"it tells an epsilon of {self.certificate.epsilon:g} m, the plan was made with {wanted:g} m"
            )

    def take_parts(self, stretches: Sequence[MotionStretch]) -> None:
        """Proves for every body in the stretches that its convex parts enclose it.

        Raises:
            Refuted: a body has no parts, or they do not enclose it.
        """
        scene = self.world.scene
        # Bodies of equal meshes may consist of other elements: the parts are those of all.
        meshes: dict[str, dict[tuple[object, ...], tuple[str, Sequence[Element]]]] = {}
        for robot in scene.robots.values():
            for link in robot.links.values():
                if link.mesh is not None:
                    own = f"{robot.name}.{link.name}", link.elements
                    meshes.setdefault(link.mesh.digest, {}).setdefault(_kinds(link.elements), own)
        for name, body in scene.bodies.items():
            meshes.setdefault(body.mesh.digest, {}).setdefault(_kinds(body.elements), (name, body.elements))
        used = {thing.surface.digest for c in stretches for thing in (*c.moving, *c.standing)}
        for digest in [each for each in meshes if each in used]:
            name = next(iter(meshes[digest].values()))[0]
            given = self.certificate.bodies.get(f"sha256:{digest}")
            if given is None:
                raise Refuted(f"it has no parts for {name}")
            try:
                self.parts[digest] = Parts(given)
            except ValueError as error:
                raise Refuted(f"the parts of {name}: {error}") from None
            for owner, elements in meshes[digest].values():
                if (missing := self.parts[digest].missing(elements)) is not None:
                    raise Refuted(f"the parts of {owner} do not enclose it: {missing}")

    def take_proofs(self, stretches: Sequence[MotionStretch], meetings: Sequence[Meeting]) -> list[MotionStretch]:
        """Assigns the proofs to the stretches; returns the stretches of the meetings, cut as their proofs say.

        Raises:
            Refuted: a stretch has no proof or two, or a proof is about a stretch that does not exist.
        """
        for proof in self.certificate.proofs:
            name = proof.node, proof.segments, proof.before
            if name in self.proofs:
                raise Refuted(f"it proves {_which(*name)} twice")
            self.proofs[name] = proof
        early = {(m.node, m.second.segments, m.first.segments): m for m in meetings}
        there = [*(stretch.name for stretch in stretches), *early]
        foreign = sorted(self.proofs.keys() - set(there))
        if foreign:
            raise Refuted(f"it speaks of {_which(*foreign[0])}, which is no stretch of the plan")
        for name in there:
            if name not in self.proofs:
                raise Refuted(f"it says nothing of {_which(*name)}")
        made = [stretch_of(meeting, self.proofs[name].cut) for name, meeting in early.items()]
        for name, stretch in zip(early, made, strict=True):
            if stretch is None:
                raise Refuted(f"it cuts {_which(*name)} into too many parts")
        return [stretch for stretch in made if stretch is not None]

    # ------------------------------------------------------------------------------------------------- one stretch
    def check(self, stretch: MotionStretch) -> None:
        """Checks all pairs of bodies in a stretch.

        Raises:
            Refuted: a pair is not proven to stay apart.
        """
        proofs: dict[tuple[str, str], list[PairProof]] = {}
        for proof in self.proofs[stretch.name].pairs:
            proofs.setdefault((proof.first, proof.second), []).append(proof)
        things, frames = [*stretch.moving, *stretch.standing], self._frames(stretch.path)
        side = self._sides()
        gaps = self._box_gaps(things, len(stretch.moving), frames, side)
        spared = self.kept.spared(stretch) if self.kept.greatest else frozenset()
        for i, k in np.argwhere(gaps <= max(FAR * self.near, self.kept.greatest)).tolist():
            first, second = things[i], things[k]
            names = first.name, second.name
            if k <= i or not self.world.may_meet(*names) or frozenset(names) in stretch.permitted:
                continue
            if stretch.before and not i < stretch.divide <= k:
                continue
            pair = ProvenPair(frames, first, second, self._parts, side)
            if pair.moves:
                own = proofs.get(names) or proofs.get(names[::-1], [])
                finest = POSITIONS_PER_PIECE if stretch.before else 1
                proven = self._margin(pair, first, second, own, float(gaps[i, k]), frames, finest)
                least, hands = proven.least, (self.kept.hand(first), self.kept.hand(second))
                claims = pair.joint == 0, least, tuple(proven.claims)
                self.margins.add(ProvenGap(*stretch.name, names, hands, *claims))
                kept = self.kept.between(first, second, spared) if self.kept.greatest else 0.0
                if least < kept - CLEARANCE_TOLERANCE:
                    few = f"only {1000 * max(0.0, least):.4g} mm of the {1000 * kept:.4g} mm that they are to keep"
                    raise Refuted(f"{names[0]} and {names[1]}: {few} are proven")

    def _frames(self, path: Path) -> Frames:
        return ExactFrames(path) if self.paranoid else Frames(path)

    def _sides(self) -> SideOf:
        """A function that makes each side of a stretch once, since many pairs share it."""
        made: dict[tuple[int, str | None, int], Side] = {}
        kind = ExactSide if self.paranoid else Side

        def side(frames: Frames, thing: SweptBody, parts: Parts, robot: str | None, joint: int) -> Side:
            key = id(thing), robot if joint else None, joint
            if key not in made:
                made[key] = kind(frames, thing, parts, robot, joint)  # type: ignore[arg-type]
            return made[key]

        return side

    def _parts(self, thing: SweptBody) -> Parts:
        return self.parts[thing.surface.digest]

    def _box_gaps(self, things: Sequence[SweptBody], moving: int, frames: Frames, side: SideOf) -> Array:
        """The gaps (M, T) between the boxes of what the moving bodies (M) and all bodies (T) sweep [m]."""
        end = (len(frames.path.configurations) - 1) << 20
        boxes = []
        for thing in things:
            key = thing.surface.digest, b"" if thing.world_T is None else thing.world_T.tobytes()
            if thing.mount is not None or key not in self._standing:
                own = side(frames, thing, self._parts(thing), None, 0)
                box = own.box(0, end, *own.parts.all)
                if thing.mount is None:
                    self._standing[key] = box
            else:
                box = self._standing[key]
            boxes.append([*(float(v - box[2]) for v in box[0]), *(float(v + box[2]) for v in box[1])])
        rows = np.array(boxes)
        low, high = rows[:, :3], rows[:, 3:]
        return np.asarray(np.maximum(low[:moving, None] - high[None], low[None] - high[:moving, None]).max(axis=2))

    def _margin(
        self,
        pair: ProvenPair,
        first: SweptBody,
        second: SweptBody,
        proofs: Sequence[PairProof],
        gap: float,
        frames: Frames,
        finest: int,
    ) -> Margin:
        """The least distance that the proofs leave between two bodies [m].

        Several proofs are about several places that the second body may have.
        """
        told: Refuted | None = None
        held: list[Margin] = []
        for proof in proofs:
            turned = proof.first != first.name
            try:
                margin = (pair.turned() if turned else pair).check(proof, FAR * self.near, finest)
                held.append(replace(margin, claims=[(-u, gap) for u, gap in margin.claims]) if turned else margin)
            except Refuted as error:
                told = told or error
                continue
            if ("f" in proof.walk or "s" in proof.walk) and _contained(first, second, frames):
                raise Refuted(f"{first.name} and {second.name}: one lies inside the other")
        if held:
            self.pairs += 1
            best = max(held, key=lambda margin: margin.least)
            self.axes += best.axes
            return best
        gap = max(gap, pair.apart())
        if gap > 0.0:
            return Margin(gap)
        names = f"{first.name} and {second.name}"
        raise Refuted(f"{names}: {told}" if told else f"{names}: their boxes meet, but no proof is given")

    def overstated(self) -> list[tuple[str | None, str]]:
        """The segments for which the certificate claims a larger clearance than it proves."""
        wrong: list[tuple[str | None, str]] = []
        for entry in self.certificate.segments:
            node = self.plan.nodes.get(entry.node)
            if node is None or entry.segment >= len(node.motion):
                wrong.append(
                    (None, f"it speaks of {_which(entry.node, (entry.segment,))}, which is not in the plan")
                )
                continue
            if set(entry.permitted) != set(node.motion[entry.segment].allowed_contacts):
                text = f"it tells other contacts of {_which(entry.node, (entry.segment,))} than that permits"
                wrong.append((entry.node, text))
            found = self.margins.segments.get((entry.node, entry.segment))
            told = self.near if entry.clearance is None else entry.clearance
            if told > (self.near if found is None else found[0]) + CLEARANCE_TOLERANCE * (1.0 + self.near):
                least = "nothing" if found is None else f"{1000 * found[0]:.4g} mm"
                wrong.append((entry.node, f"it tells a clearance of {1000 * told:.4g} mm, but leaves {least}"))
        return wrong


def _kinds(elements: Sequence[Element]) -> tuple[object, ...]:
    """What tells bodies of equal meshes apart."""
    return tuple((each.kind, each.rounding) for each in elements)


def _which(node: str, segments: tuple[int, ...], before: tuple[int, ...] = ()) -> str:
    text = f"{node}, segment{'s' if len(segments) > 1 else ''} {', '.join(map(str, segments))}"
    return f"{text}, beside {', '.join(map(str, before))} of the node before" if before else text


def _contained(first: SweptBody, second: SweptBody, frames: Frames) -> bool:
    """Whether one body begins inside the other; if not, and if they never touch, it never gets inside."""
    start = frames.at(0)
    a, b = first.pose(start), second.pose(start)
    return encloses(first.surface, a, second.surface, b) or encloses(second.surface, b, first.surface, a)
