"""The tables of `motion.py`, made of what its judge said about plans.

*Motions*: `violations` of any kind, of which `collisions`; of each limit the greatest share that is reached (`speed`,
`acceleration`, `jerk` by the polynomials' own extremes; `kHz` by differences of positions at a millisecond; `grip`: of
what friction holds); `joins` and `rests`: the greatest jump of position, velocity or acceleration at a border;
`off path` how far a sample is from the way points, `stated` what the plan says about that; `least` the least distance
of bodies on the original meshes.

*Durations*, all nodes together: `phases` is the time-optimal time of each segment's path from rest to rest, `motions`
that of all paths between rests, `lines` that of straight lines between these (no strokes, no detours: nothing goes
faster), all with jerk limited; `phases, no jerk` without that limit. Corners cost these bounds nothing.

*Proven distances*: for segments whose certificate tells a clearance, that beside the measured least distance.
"""

from dataclasses import dataclass
from typing import Any

from table import Table, percentile


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
        names = ("lasts", "phases", "phases_without_jerk", "motions", "lines")
        return {name: sum(row[name] for row in rows) for name in names}


def tables_of(found: list[Judged]) -> list[Table]:
    """All tables."""
    return [motions(found), durations(found), sizes(found), distances(found)]


def motions(found: list[Judged]) -> Table:
    """What sampling finds wrong."""
    table = Table("Motions, sampled at 1 kHz by another program")
    for each in found:
        verdict = each.verdict
        if "error" in verdict:
            table.add(each.title, violations=verdict["error"])
            continue
        worst, counts = verdict["worst"], verdict["violations"]
        table.add(
            each.title,
            **{
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
            },
        )
    return table


def durations(found: list[Judged]) -> Table:
    """How long plans last beside bounds; a good plan beside those of the fast one."""
    table = Table("Durations of all nodes beside time-optimal bounds, seconds")
    fast = {each.name: each.whole for each in found if each.quality == "fast" and each.verdict.get("durations")}
    for each in found:
        if not each.verdict.get("durations"):
            continue
        own, base = each.whole, fast.get(each.name, each.whole)
        table.add(
            each.title,
            **{
                "lasts": own["lasts"],
                "longest branch": each.verdict["longest_s"],
                "phases": own["phases"],
                "phases, no jerk": own["phases_without_jerk"],
                "motions": own["motions"],
                "lines": own["lines"],
                "/ phases": own["lasts"] / own["phases"],
                "/ fast phases": own["lasts"] / base["phases"],
                "/ motions": own["lasts"] / own["motions"],
                "/ fast lines": own["lasts"] / base["lines"],
            },
        )
    return table


def sizes(found: list[Judged]) -> Table:
    """How large files are, and what solving, proofs and verifying cost."""
    table = Table("Files, and seconds of the processor")
    for each in found:
        if "error" not in each.verdict:
            verdict = each.verdict
            certificate, solving = each.costs.get("certificate s"), each.costs.get("solve s")
            table.add(
                each.title,
                **{
                    "kB": verdict["bytes"] / 1000,
                    "trajectories kB": verdict["trajectory_bytes"] / 1000,
                    "certificate kB": verdict["certificate_bytes"] / 1000,
                    "pieces": _pieces(each.plan),
                    **each.costs,
                    "certificate %": 100 * certificate / solving if certificate and solving else None,
                },
            )
    return table


def distances(found: list[Judged]) -> Table:
    """What certificates prove beside what is measured."""
    table = Table("Proven distances beside measured ones")
    for each in found:
        pairs = _clearances(each)
        if not pairs:
            continue
        shares = [proven / measured for proven, measured, _ in pairs]
        worst = min(pairs, key=lambda pair: pair[0] / pair[1])
        least = min(pairs)
        table.add(
            each.title,
            **{
                "segments": len(pairs),
                "least proven mm": 1000 * least[0],
                "least measured mm": 1000 * min(pair[1] for pair in pairs),
                "proven / measured, least": min(shares),
                "median": percentile(shares, 0.5),
                "at least 0.8 %": 100 * sum(share >= 0.8 for share in shares) / len(shares),
                "above 1": sum(share > 1.0 + 1e-6 for share in shares),
                "worst": worst[2],
            },
        )
    return table


def _clearances(each: Judged) -> list[tuple[float, float, str]]:
    """Proven and measured least distance [m] of each segment for which both are told, and which one it is."""
    measured: dict[tuple[str, int], float] = {}
    for row in each.verdict.get("segments") or ():
        for number in row["segments"]:
            if row["least"] is not None and row["least"] > 0.0:
                key = row["node"], number
                measured[key] = min(measured.get(key, row["least"]), row["least"])
    certificate = each.plan.get("certificate") or {}
    return [
        (
            row["clearance"],
            measured[row["node"], row["segment"]],
            f"{row['node']} {row['segment']} {row['between']}",
        )
        for row in certificate.get("segments") or ()
        if row.get("clearance") is not None and (row["node"], row["segment"]) in measured
    ]


def _least(verdict: dict[str, Any]) -> float | None:
    found = [row["least"] for row in verdict["segments"] if row["least"] is not None]
    return 1000 * min(found) if found else None


def _stated(plan: dict[str, Any]) -> float | None:
    segments = [segment for node in plan["nodes"].values() for segment in node.get("motion") or ()]
    return max((each["trajectory"]["deviation"] for each in segments if each.get("trajectory")), default=None)


def _pieces(plan: dict[str, Any]) -> int:
    segments = [segment for node in plan["nodes"].values() for segment in node.get("motion") or ()]
    return sum(len(each["trajectory"]["coefficients"]) for each in segments if each.get("trajectory"))
