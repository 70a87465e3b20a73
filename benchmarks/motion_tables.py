"""The tables of `motion.py`, made of what its judge said about plans.

*Motions*: `violations` of any kind, of which `collisions`; of each limit the greatest share that is reached (`speed`,
`acceleration`, `jerk` by the polynomials' own extremes; `kHz` by differences of positions at a millisecond; `grip`: of
what friction holds); `joins` and `rests`: the greatest jump of position, velocity or acceleration at a border;
`off path` how far a sample is from the way points, `stated` what the plan says about that; `least` the least distance
of bodies on the original meshes.

*Durations*, all nodes together: what a node that begins `early` shares with the one before is not counted in `lasts`;
`phases` is the time-optimal time of each segment's path from rest to rest, `motions` that of all paths between rests,
`lines` that of straight lines between these (no strokes, no detours: nothing goes faster), all with jerk limited;
`phases, no jerk` without that limit. Corners cost these bounds nothing.
"""

from dataclasses import dataclass
from typing import Any

from table import Table


@dataclass
class Judged:
    """A plan: of which problem and quality, what it cost, what the judge said, the file's content."""

    name: str
    quality: str
    costs: dict[str, Any]
    verdict: dict[str, Any]
    plan: dict[str, Any]

    @property
    def title(self) -> str:
        """Its row."""
        return f"{self.name}, {self.quality}"

    @property
    def whole(self) -> dict[str, float]:
        """The sums of all nodes' durations and bounds."""
        rows = self.verdict.get("durations") or []
        names = ("lasts", "early", "phases", "phases_without_jerk", "motions", "lines")
        return {name: sum(row.get(name, 0.0) for row in rows) for name in names}


class Tables:
    """The three tables; each plan adds a row to them as soon as it is judged."""

    def __init__(self) -> None:
        self.motions = Table("Motions, sampled at 1 kHz by another program")
        self.durations = Table("Durations of all nodes beside time-optimal bounds, seconds")
        self.sizes = Table("Files, and seconds of the processor")
        self.fast: dict[str, dict[str, float]] = {}  # bounds of the fast plan by problem

    @property
    def all(self) -> list[Table]:
        """Those that have rows."""
        return [each for each in (self.motions, self.durations, self.sizes) if each.rows]

    def add(self, each: Judged) -> None:
        """Adds the rows of a plan."""
        if "error" in each.verdict:
            self.motions.add(each.title, violations=each.verdict["error"])
            return
        self.motions.add(each.title, **motion_row(each))
        self.sizes.add(each.title, **size_row(each))
        if each.verdict.get("durations"):
            if each.quality == "fast":
                self.fast[each.name] = each.whole
            self.durations.add(each.title, **duration_row(each, self.fast.get(each.name, each.whole)))


def motion_row(each: Judged) -> dict[str, Any]:
    """What sampling finds wrong."""
    verdict = each.verdict
    worst, counts = verdict["worst"], verdict["violations"]
    return {
        "format": verdict["format"],
        "violations": sum(counts.values()),
        "collisions": counts.get("collision", 0),
        "speed": worst.get("velocity_exact"),
        "acceleration": worst.get("acceleration_exact"),
        "jerk": worst.get("jerk_exact"),
        "acceleration kHz": worst.get("acceleration_by_differences"),
        "grip": worst.get("tool"),
        "joins": max((value for name, value in worst.items() if name.startswith("join_")), default=None),
        "rests": max((value for name, value in worst.items() if name.startswith("rest_")), default=None),
        "off path": worst.get("off_path"),
        "stated": _stated(each.plan),
        "least mm": _least(verdict),
        "samples": verdict["samples"],
        "kinds": ", ".join(f"{n} {kind}" for kind, n in sorted(counts.items())) or "none",
    }


def duration_row(each: Judged, base: dict[str, float]) -> dict[str, Any]:
    """How long a plan lasts beside bounds, and beside those of the fast plan."""
    own = each.whole
    return {
        "lasts": own["lasts"],
        "early": own["early"],
        "longest branch": each.verdict["longest_s"],
        "phases": own["phases"],
        "phases, no jerk": own["phases_without_jerk"],
        "motions": own["motions"],
        "lines": own["lines"],
        "/ phases": own["lasts"] / own["phases"],
        "/ fast phases": own["lasts"] / base["phases"],
        "/ motions": own["lasts"] / own["motions"],
        "/ fast lines": own["lasts"] / base["lines"],
    }


def size_row(each: Judged) -> dict[str, Any]:
    """How large a file is, and what solving, proofs and verifying cost."""
    verdict = each.verdict
    certificate, solving = each.costs.get("certificate s"), each.costs.get("solve s")
    return {
        "kB": verdict["bytes"] / 1000,
        "trajectories kB": verdict["trajectory_bytes"] / 1000,
        "certificate kB": verdict["certificate_bytes"] / 1000,
        "pieces": _pieces(each.plan),
        **each.costs,
        "certificate %": 100 * certificate / solving if certificate and solving else None,
    }


def _least(verdict: dict[str, Any]) -> float | None:
    found = [row["least"] for row in verdict["segments"] if row["least"] is not None]
    return 1000 * min(found) if found else None


def _stated(plan: dict[str, Any]) -> float | None:
    segments = [segment for node in plan["nodes"].values() for segment in node.get("motion") or ()]
    return max((each["trajectory"]["deviation"] for each in segments if each.get("trajectory")), default=None)


def _pieces(plan: dict[str, Any]) -> int:
    segments = [segment for node in plan["nodes"].values() for segment in node.get("motion") or ()]
    return sum(len(each["trajectory"]["coefficients"]) for each in segments if each.get("trajectory"))
