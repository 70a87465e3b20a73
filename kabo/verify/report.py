"""The report of a verification: whether everything holds, what was checked, and every finding with its place."""

from dataclasses import dataclass
from typing import Any

from kabo.displays import bullets, counted, display, shortened
from kabo.verify.certificate_report import CertificateReport
from kabo.verify.trajectory_report import TrajectoryReport


@dataclass(frozen=True)
class Finding:
    """One fault of a plan that verification found.

    `time` counts from the start of the node's motion [s]. `depth` is the amount of the fault: how deep bodies
    overlap [m] (0 if they only touch or the depth is unknown), or by how much a limit is exceeded.
    """

    node: str | None
    message: str
    time: float | None = None
    bodies: tuple[str, ...] = ()
    depth: float | None = None

    def __str__(self) -> str:
        """`n3 at 1.250 s: left.finger and crate collide (2.1 mm deep)`."""
        place = [] if self.node is None else [self.node]
        if self.time is not None:
            place.append(f"at {self.time:.3f} s")
        return f"{' '.join(place)}: {self.message}" if place else self.message

    def to_dict(self) -> dict[str, Any]:
        """The finding as JSON values."""
        return {
            "node": self.node,
            "time": self.time,
            "bodies": list(self.bodies),
            "depth": self.depth,
            "message": self.message,
        }


@dataclass(frozen=True)
class Least:
    """The least distance that was measured between a moving body and any other body [m], and where; no bound elsewhere."""

    distance: float
    bodies: tuple[str, str]
    node: str
    time: float

    def to_dict(self) -> dict[str, Any]:
        """The distance as JSON values."""
        return {"distance": self.distance, "bodies": list(self.bodies), "node": self.node, "time": self.time}


@dataclass(frozen=True)
class WorldReport:
    """The outcome of following a plan through possible worlds.

    Attributes:
        findings: the faults, each with a world that shows it.
        worlds: the number of initial worlds that were tried; if the plan begins in the state of a run, of those that
            agree with what was done and observed.
        exhaustive: whether the runs cover all initial worlds and every value that actions leave open.
        shortest, mean, longest: the numbers of actions from a world's start to the goal.
        ruled_out: the number of runs that ended because an action adds an entry that is false in the run's world.
    """

    findings: tuple[Finding, ...] = ()
    worlds: int = 0
    exhaustive: bool = True
    shortest: int = 0
    mean: float = 0.0
    longest: int = 0
    ruled_out: int = 0

    def __str__(self) -> str:
        """`16 worlds, all of them: every one reaches the goal in 3 to 5 actions (mean 4.25)`."""
        number = f"{self.worlds}" if self.worlds < 10**6 else f"about {float(self.worlds):.1e}"
        worlds = f"{number} world{'' if self.worlds == 1 else 's'}"
        which = "all of them" if self.exhaustive else "not all of them"
        if self.findings:
            return f"{worlds}, {which}: not every one reaches the goal"
        if self.shortest == self.longest:
            length = f"{self.longest} action{'' if self.longest == 1 else 's'}"
        else:
            length = f"{self.shortest} to {self.longest} actions (mean {self.mean:.2f})"
        out = f"; {self.ruled_out} runs ruled out by what an action says" if self.ruled_out else ""
        return f"{worlds}, {which}: every one reaches the goal in {length}{out}"

    def to_dict(self) -> dict[str, Any]:
        """The figures as JSON values, without findings, which the whole verification report lists."""
        return {
            "worlds": self.worlds,
            "exhaustive": self.exhaustive,
            "shortest": self.shortest,
            "mean": self.mean,
            "longest": self.longest,
            "ruled_out": self.ruled_out,
        }


@dataclass(frozen=True)
class Report:
    """The outcome of verification.

    Attributes:
        findings: the faults.
        notes: what was *not* verified.
        knowledge_only: whether the check of motions was left out.
        branches: the number of nodes that branch.
        leaves: the number of paths from the root to the goal.
        states: the number of examined states of knowledge.
        worlds: the report of the run through all possible worlds; None if worlds could not judge the plan.
        why_replay: why worlds could not judge the plan; None if they could.
        motions: the number of nodes whose motion was checked.
        pairs: the number of pairs of bodies that were proven apart along a motion.
        distances: the number of these pairs for which distances between meshes were needed.
        least: the least distance that was measured between a moving body and any other body, and where. Elsewhere they may
            come nearer, though they never touch: distances are measured only where a proof needs them.
        certificate: the result of checking the plan's certificate; None without one.
        certificate_gaps: why the plan has no certificate, although one was requested.
        trajectories: how much of each limit the trajectories use, and how far they deviate; None if there are none.
    """

    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()
    knowledge_only: bool = False
    branches: int = 0
    leaves: int = 0
    states: int = 0
    worlds: WorldReport | None = None
    why_replay: str | None = None
    motions: int = 0
    pairs: int = 0
    distances: int = 0
    least: Least | None = None
    certificate: CertificateReport | None = None
    certificate_gaps: tuple[str, ...] = ()
    trajectories: TrajectoryReport | None = None

    @property
    def ok(self) -> bool:
        """Whether there are no findings."""
        return not self.findings

    @property
    def judge(self) -> str | None:
        """The judge of knowledge: `worlds` or `replay`; None if the plan is not well formed."""
        if self.worlds is not None:
            return "worlds"
        return None if self.why_replay is None else "replay"

    def __repr__(self) -> str:
        return f"<Report {self.verdict}: {self._judged()}>"

    def _repr_html_(self) -> str:
        lines = [line for line in str(self).splitlines()[1:] if not line.startswith(("- ", "note: "))]
        figures = {name: value for name, _, value in (line.partition(": ") for line in lines)}
        return display(f"Report: {self.verdict}", figures | {"note": " ".join(self.notes)}) + bullets(
            map(str, self.findings)
        )

    @property
    def verdict(self) -> str:
        """`verified`, or `NOT verified: 2 findings`."""
        return "verified" if self.ok else f"NOT verified: {counted(len(self.findings), 'finding')}"

    def _judged(self) -> str:
        """The first finding; without one, what was verified."""
        if self.findings:
            return shortened(str(self.findings[0]))
        parts = [counted(self.leaves, "outcome")]
        if self.motions:
            parts.append(counted(self.motions, "motion"))
        if self.least is not None:
            parts.append(f"least distance {1000 * self.least.distance:.2f} mm")
        return ", ".join(parts)

    def to_dict(self) -> dict[str, Any]:
        """The report as JSON values."""
        return {
            "ok": self.ok,
            "knowledge_only": self.knowledge_only,
            "knowledge": {
                "judge": self.judge,
                "why_replay": self.why_replay,
                "branches": self.branches,
                "leaves": self.leaves,
                "states": self.states,
            },
            "worlds": None if self.worlds is None else self.worlds.to_dict(),
            "motions": self.motions,
            "pairs": self.pairs,
            "distances": self.distances,
            "trajectories": None if self.trajectories is None else self.trajectories.to_dict(),
            "least_distance": None if self.least is None else self.least.to_dict(),
            "certificate": None if self.certificate is None else self.certificate.to_dict(),
            "certificate_gaps": list(self.certificate_gaps),
            "findings": [finding.to_dict() for finding in self.findings],
            "notes": list(self.notes),
        }

    def __str__(self) -> str:
        """The report as text: the verdict, what was checked, every finding on a line of its own."""
        lines = [
            self.verdict,
            f"knowledge: {self.leaves} leaves, {self.branches} branching nodes, {self.states} states",
        ]
        if self.worlds is not None:
            lines.append(f"judged by worlds: {self.worlds}")
        elif self.why_replay is not None:
            lines.append(f"judged by replay of what kabo infers, because {self.why_replay}")
        if not self.knowledge_only:
            lines.append(f"geometry: {self.motions} motions, {self.pairs} pairs of bodies along them")
        if self.least is not None:
            first, second = self.least.bodies
            where = f"({first} and {second}, {self.least.node} at {self.least.time:.3f} s); elsewhere they may come nearer"
            lines.append(f"least distance measured: {1000 * self.least.distance:.2f} mm {where}")
        if self.trajectories is not None:
            lines.extend(self.trajectories.lines())
        if self.certificate is not None:
            lines.extend(self.certificate.lines())
        elif self.certificate_gaps:
            more = f" (and {len(self.certificate_gaps) - 1} more)" if len(self.certificate_gaps) > 1 else ""
            why = f"none could be made: {self.certificate_gaps[0]}{more}"
            lines.append(f"certificate: {why}; the motions were checked against the meshes alone")
        elif self.motions:
            lines.append("certificate: none; the motions were checked against the meshes alone")
        lines.extend(f"note: {note}" for note in self.notes)
        lines.extend(f"- {finding}" for finding in self.findings)
        return "\n".join(lines) + "\n"
