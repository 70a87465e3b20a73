"""Bounding meshes at 1 % of the diagonal, outer and inner: vertices, certificates, speed; judged from outside.

Speeds are contractions in a second of the processor's time, all that the call takes included, so that other programs
on the machine count little; `seconds` are by the clock.
"""

from dataclasses import dataclass
from math import exp, log
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

import numpy as np
from geometry_figures import CHECKED_BAR, KNOWN, MEAN_BAR, MEDIAN_BAR, PLAIN_BAR, QUICK, QUICK_BAR
from geometry_judge import read_off, verdicts, write_off
from table import Table

from kabo.errors import KaboError
from kabo.geometry import bounding_mesh

SHARE = 0.01  # of the diagonal
JUDGE_NOISE = 1e-6  # of epsilon: what the judge's distances of coinciding surfaces come to
ENOUGH_SECONDS, MOST_ROUNDS = 2.0, 5  # speeds are medians of so many rounds


@dataclass(frozen=True)
class Triangles:
    """A mesh as arrays."""

    vertices: Any
    faces: Any

    @property
    def diagonal(self) -> float:
        """Of the box around it [m]."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def measured(mesh: Triangles, side: str, certify: bool) -> tuple[Any, float, float]:
    """The result, its seconds, and contractions in a second of the processor: medians of some rounds.

    The contractions' own part of the time counts, with all proofs; checking the input and the result does not.
    """
    seconds: list[float] = []
    busy: list[float] = []
    while not seconds or (sum(busy) < ENOUGH_SECONDS and len(busy) < MOST_ROUNDS):
        began, worked = perf_counter(), process_time()
        result = bounding_mesh(mesh, SHARE * mesh.diagonal, side, certify=certify)
        seconds.append(perf_counter() - began)
        busy.append((process_time() - worked) * result.contraction_seconds / seconds[-1])
    return result, median(seconds), result.contractions / median(busy)


def warm_up() -> None:
    """Compiles, or loads, all that is measured."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    tetrahedron = Triangles(corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    for side in ("outer", "inner"):
        for certify in (True, False):
            bounding_mesh(tetrahedron, 0.01, side, certify=certify)


def bounding_tables(python: Path, meshes: Path, output: Path, names: list[str]) -> list[Table]:
    """A table for each side, and the bars."""
    warm_up()
    bars, tables = Table("Bounding meshes: what must be reached"), []
    for side in ("outer", "inner"):
        table = Table(f"Bounding meshes, {side}, epsilon = 1 % of the diagonal; distances in epsilon")
        rows = {}
        for name in names:
            try:
                rows[name] = _row(meshes / f"{name}.off", side, output)
            except KaboError as refusal:
                table.add(name, refused=str(refusal), fine=False)
        jobs = [
            {
                "original": meshes / f"{name}.off",
                "result": row.pop("file"),
                "side": side,
                "epsilon": row.pop("epsilon"),
            }
            for name, row in rows.items()
        ]
        for (name, row), verdict in zip(rows.items(), verdicts(python, jobs), strict=True):
            table.add(name, **row, **_judged(row, verdict))
        tables.append(table)
        _bars(bars, side, table.rows)
    return [*tables, bars]


def _row(path: Path, side: str, output: Path) -> dict[str, Any]:
    mesh, known = Triangles(*read_off(path)), KNOWN[path.stem][side]
    certified, seconds, rate = measured(mesh, side, certify=True)
    _, _, plain = measured(mesh, side, certify=False)
    file = output / f"{path.stem}.{side}.off"
    write_off(file, certified.vertices, certified.faces)
    count = len(certified.vertices)
    return {
        "V in": len(mesh.vertices),
        "V": count,
        "reference V": known.reference,
        "ratio": count / known.reference if known.reference else None,
        "checked V": known.checked,
        "to checked": count / known.checked if known.checked else None,
        "H kabo": certified.hausdorff_upper_bound / certified.epsilon,
        "contr./s": rate,
        "plain contr./s": plain,
        "seconds": seconds,
        "file": file,
        "epsilon": certified.epsilon,
    }


def _judged(row: dict[str, Any], verdict: dict[str, Any]) -> dict[str, Any]:
    low, high = verdict["h_lo"], verdict["h_hi"]
    out = verdict.get("stick_exact_over_eps", verdict["stick_over_eps"])
    faults = verdict["border"] + verdict["nonmanifold"] + verdict["unmatched_edges"] + verdict["pinched_vertices"]
    return {
        "H judge": f"{low:.4f}–{high:.4f}",
        "certificate": "holds" if low <= row["H kabo"] * (1 + 1e-9) + JUDGE_NOISE else "CONTRADICTED",
        "sticks out": out if out > JUDGE_NOISE else 0.0,
        "crossing faces": f"{verdict['self_intersecting_faces_in']}→{verdict['self_intersecting_faces']}",
        "faults": faults,
        "fine": bool(
            max(low, row["H kabo"]) <= 1.0
            and out <= JUDGE_NOISE
            and verdict["self_intersecting_faces"] <= verdict["self_intersecting_faces_in"]
            and faults == 0
        ),
    }


def geometric_mean(values: list[float]) -> float:
    """Of positive values."""
    return exp(sum(map(log, values)) / len(values)) if values else float("nan")


def _bars(bars: Table, side: str, rows: list[dict[str, Any]]) -> None:
    def add(name: str, bar: str, found: float | None, met: bool, failing: list[str] | None = None) -> None:
        bars.add(f"{side}: {name}", bar=bar, found=found, met="yes" if met else "NO", failing=failing or None)

    failing = [row[""] for row in rows if not row["fine"]]
    add(
        "within epsilon, one-sided, no new crossings, closed",
        "all",
        len(rows) - len(failing),
        not failing,
        failing,
    )
    rows = [row for row in rows if "V" in row]
    worst = [row["to checked"] for row in rows if row["to checked"] is not None]
    above = [row[""] for row in rows if (row["to checked"] or 0.0) > CHECKED_BAR]
    add("vertices to the checked column, worst", f"<= {CHECKED_BAR}", max(worst, default=None), not above, above)
    mean = geometric_mean([row["ratio"] for row in rows if row["ratio"] is not None])
    add("vertices to the reference, geometric mean", f"<= {MEAN_BAR}", mean, mean <= MEAN_BAR)
    slow = [row[""] for row in rows if row["plain contr./s"] < PLAIN_BAR]
    plain = median(row["plain contr./s"] for row in rows)
    add("contractions/s without certificate, median", f">= {PLAIN_BAR}", plain, plain >= PLAIN_BAR, slow)
    middle = median(row["contr./s"] for row in rows)
    add("contractions/s with certificate, median", f">= {MEDIAN_BAR}", middle, middle >= MEDIAN_BAR)
    for row in rows:
        if row[""] in QUICK:
            add(f"contractions/s on {row['']}", f">= {QUICK_BAR}", row["contr./s"], row["contr./s"] >= QUICK_BAR)
