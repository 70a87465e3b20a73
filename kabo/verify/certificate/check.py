"""Checks the certificate of a plan: every stretch of every motion, every pair that could meet, without searching.

What a certificate says is believed of nothing: parts must cover the meshes, poses and bounds are derived here, boxes
and axes evaluated again. It is checked beside the measuring of distances between the meshes, not instead of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.plan import Certificate, PairProof, Plan, StretchProof
from kabo.scene import Mesh
from kabo.verify.certificate.clearance import Margins, of_branches, of_objects
from kabo.verify.certificate.couples import course_of
from kabo.verify.certificate.exact import ExactFrames, ExactSide
from kabo.verify.certificate.parts import Parts
from kabo.verify.certificate.walk import ONE, Couple, Frames, Margin, Refuted, Side, SideOf
from kabo.verify.certificate_report import CertificateReport
from kabo.verify.motion.courses import Course
from kabo.verify.motion.overlaps import Meeting
from kabo.verify.motion.surfaces import encloses
from kabo.verify.motion.sweep import Path, Thing
from kabo.verify.motion.world import World
from kabo.verify.report import Finding

Name = tuple[str, tuple[int, ...], tuple[int, ...]]  # node, segments, segments of the node before
SAME = 1e-9  # [m] by which a told clearance may be larger than what is found


def check_certificate(
    plan: Plan,
    world: World,
    order: Sequence[str],
    courses: Sequence[Course],
    meetings: Sequence[Meeting] = (),
    *,
    paranoid: bool = False,
) -> tuple[list[Finding], CertificateReport | None]:
    """What is wrong with the certificate: at most one finding, the first; and what it proves. None without proofs.

    Args:
        plan: the plan with its certificate.
        world: the scene.
        order: its nodes.
        courses: all stretches of its motions.
        meetings: stretches that may be under way at once, where motions overlap.
        paranoid: evaluate poses and axes in exact arithmetic.
    """
    certificate = plan.certificate
    if certificate is None or certificate.near is None:
        return [], None
    checker = _Checker(plan, world, certificate, certificate.near, paranoid)
    failed: list[tuple[str | None, str]] = []
    try:
        checker.check_epsilon()
        checker.take_parts(courses)
        courses = [*courses, *checker.take_proofs(courses, meetings)]
    except Refuted as error:
        failed.append((None, str(error)))
    for course in courses if not failed else ():
        try:
            checker.check(course)
        except Refuted as error:
            failed.append((course.node, str(error)))
    if not failed:
        failed.extend(checker.told_too_much())
    if failed:
        node, text = failed[0]
        more = f" (and {len(failed) - 1} more)" if len(failed) > 1 else ""
        return [Finding(node, f"the certificate does not hold: {text}{more}")], CertificateReport(
            False, checker.near
        )
    return [], CertificateReport(
        True,
        checker.near,
        len(courses),
        checker.pairs,
        checker.axes,
        len(checker.parts),
        paranoid,
        of_objects(world.scene, checker.margins, order),
        of_branches(plan, world.scene, checker.margins),
    )


@dataclass
class _Checker:
    plan: Plan
    world: World
    certificate: Certificate
    near: float
    paranoid: bool
    parts: dict[str, Parts] = field(default_factory=dict)
    proofs: dict[Name, StretchProof] = field(default_factory=dict)
    pairs: int = 0
    axes: int = 0

    def __post_init__(self) -> None:
        self.margins = Margins(self.near)
        self._standing: dict[tuple[str, bytes], tuple[Any, Any, Any]] = {}

    # ---------------------------------------------------------------------------------------------- what it brings
    def check_epsilon(self) -> None:
        """It was made with the epsilon that the plan was made with; else with the scene's.

        Raises:
            Refuted: it tells another one.
        """
        made = self.plan.options.get("epsilon")
        wanted = self.world.scene.epsilon if made is None else made
        if self.certificate.epsilon != wanted:
            raise Refuted(
                f"it tells an epsilon of {self.certificate.epsilon:g} m, the plan was made with {wanted:g} m"
            )

    def take_parts(self, courses: Sequence[Course]) -> None:
        """Proves that the parts of every body that takes part enclose it.

        Raises:
            Refuted: a body has no parts, or they do not enclose it.
        """
        scene = self.world.scene
        meshes: dict[str, tuple[str, Mesh]] = {}
        for robot in scene.robots.values():
            for link in robot.links.values():
                if link.mesh is not None:
                    meshes.setdefault(link.mesh.digest, (f"{robot.name}.{link.name}", link.mesh))
        for name, body in scene.bodies.items():
            meshes.setdefault(body.mesh.digest, (name, body.mesh))
        used = {thing.surface.digest for c in courses for thing in (*c.moving, *c.standing)}
        for digest in [each for each in meshes if each in used]:
            name, mesh = meshes[digest]
            given = self.certificate.bodies.get(f"sha256:{digest}")
            if given is None:
                raise Refuted(f"it has no parts for {name}")
            try:
                self.parts[digest] = Parts(given)
            except ValueError as error:
                raise Refuted(f"the parts of {name}: {error}") from None
            if (missing := self.parts[digest].missing(mesh)) is not None:
                raise Refuted(f"the parts of {name} do not enclose it: triangle {missing} sticks out")

    def take_proofs(self, courses: Sequence[Course], meetings: Sequence[Meeting]) -> list[Course]:
        """Finds the proofs of every stretch; the courses of meetings, as their proofs cut them.

        Raises:
            Refuted: a stretch has none or two, or proofs are about what is not there.
        """
        for proof in self.certificate.proofs:
            name = proof.node, proof.segments, proof.before
            if name in self.proofs:
                raise Refuted(f"it proves {_which(*name)} twice")
            self.proofs[name] = proof
        early = {(m.node, m.second.segments, m.first.segments): m for m in meetings}
        there = [*(course.name for course in courses), *early]
        foreign = sorted(self.proofs.keys() - set(there))
        if foreign:
            raise Refuted(f"it speaks of {_which(*foreign[0])}, which is no stretch of the plan")
        for name in there:
            if name not in self.proofs:
                raise Refuted(f"it says nothing of {_which(*name)}")
        made = [course_of(meeting, self.proofs[name].cut) for name, meeting in early.items()]
        for name, course in zip(early, made, strict=True):
            if course is None:
                raise Refuted(f"it cuts {_which(*name)} into too many parts")
        return [course for course in made if course is not None]

    # ------------------------------------------------------------------------------------------------- one stretch
    def check(self, course: Course) -> None:
        """Checks all pairs of a stretch.

        Raises:
            Refuted: a pair is not proven apart.
        """
        proofs: dict[tuple[str, str], list[PairProof]] = {}
        for proof in self.proofs[course.name].pairs:
            proofs.setdefault((proof.first, proof.second), []).append(proof)
        things, frames = [*course.moving, *course.standing], self._frames(course.path)
        side = self._sides()
        gaps = self._box_gaps(things, len(course.moving), frames, side)
        for i, k in np.argwhere(gaps <= self.near).tolist():
            first, second = things[i], things[k]
            names = first.name, second.name
            if k <= i or not self.world.may_meet(*names) or frozenset(names) in course.permitted:
                continue
            if course.before and not i < course.divide <= k:
                continue
            couple = Couple(frames, first, second, self._parts, side)
            if couple.moves:
                own = proofs.get(names) or proofs.get(names[::-1], [])
                finest = ONE if course.before else 1
                margin = self._margin(couple, first, second, own, float(gaps[i, k]), frames, finest)
                self.margins.add(course.node, course.segments, names, margin)

    def _frames(self, path: Path) -> Frames:
        return ExactFrames(path) if self.paranoid else Frames(path)

    def _sides(self) -> SideOf:
        """Makes each side of a stretch once: many pairs share it."""
        made: dict[tuple[int, str | None, int], Side] = {}
        kind = ExactSide if self.paranoid else Side

        def side(frames: Frames, thing: Thing, parts: Parts, robot: str | None, joint: int) -> Side:
            key = id(thing), robot if joint else None, joint
            if key not in made:
                made[key] = kind(frames, thing, parts, robot, joint)  # type: ignore[arg-type]
            return made[key]

        return side

    def _parts(self, thing: Thing) -> Parts:
        return self.parts[thing.surface.digest]

    def _box_gaps(self, things: Sequence[Thing], moving: int, frames: Frames, side: SideOf) -> Array:
        """How far the boxes of what moving things (M) and all (T) sweep are apart (M, T) [m]."""
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
        couple: Couple,
        first: Thing,
        second: Thing,
        proofs: Sequence[PairProof],
        gap: float,
        frames: Frames,
        finest: int,
    ) -> float:
        """What keeps two things apart, at least [m]; one of several proofs may be about another place of the second."""
        told: Refuted | None = None
        held: list[Margin] = []
        for proof in proofs:
            turned = proof.first != first.name
            try:
                held.append((couple.turned() if turned else couple).check(proof, self.near, finest))
            except Refuted as error:
                told = told or error
                continue
            if ("f" in proof.walk or "s" in proof.walk) and _contained(first, second, frames):
                raise Refuted(f"{first.name} and {second.name}: one lies inside the other")
        if held:
            self.pairs += 1
            best = max(held, key=lambda margin: margin.least)
            self.axes += best.axes
            return best.least
        gap = max(gap, couple.apart())
        if gap > 0.0:
            return gap
        names = f"{first.name} and {second.name}"
        raise Refuted(f"{names}: {told}" if told else f"{names}: their boxes meet, but no proof is given")

    def told_too_much(self) -> list[tuple[str | None, str]]:
        """Where it tells a larger clearance than is proven."""
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
            if told > (self.near if found is None else found[0]) + SAME * (1.0 + self.near):
                least = "nothing" if found is None else f"{1000 * found[0]:.4g} mm"
                wrong.append((entry.node, f"it tells a clearance of {1000 * told:.4g} mm, but leaves {least}"))
        return wrong


def _which(node: str, segments: tuple[int, ...], before: tuple[int, ...] = ()) -> str:
    text = f"{node}, segment{'s' if len(segments) > 1 else ''} {', '.join(map(str, segments))}"
    return f"{text}, beside {', '.join(map(str, before))} of the node before" if before else text


def _contained(first: Thing, second: Thing, frames: Frames) -> bool:
    """Whether one body begins inside the other; if not, and if they never touch, it never is."""
    start = frames.at(0)
    a, b = first.pose(start), second.pose(start)
    return encloses(first.surface, a, second.surface, b) or encloses(second.surface, b, first.surface, a)
