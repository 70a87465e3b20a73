"""Tables of figures: printed for people, written as JSON with everything needed to read them later."""

import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

PACKAGES = ("numpy", "scipy", "numba", "pin", "python-fcl", "trimesh", "coacd", "scikit-learn", "mujoco")


def percentile(values: Sequence[float], share: float) -> float:
    """The value below which a share of the values lies, by linear interpolation."""
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def interleave(
    contestants: Mapping[str, Callable[[Any], Any]], inputs: Sequence[Any], rounds: int = 1
) -> tuple[dict[str, list[float]], dict[str, list[Any]]]:
    """Seconds of every call, and the answers of the last round, for each contestant on each input.

    The contestants take turns on every input, so that a slow minute of the machine hits all alike.
    """
    seconds: dict[str, list[float]] = {name: [] for name in contestants}
    answers: dict[str, list[Any]] = {name: [] for name in contestants}
    for number in range(rounds):
        for value in inputs:
            for name, ask in contestants.items():
                began = perf_counter()
                answer = ask(value)
                seconds[name].append(perf_counter() - began)
                if number == rounds - 1:
                    answers[name].append(answer)
    return seconds, answers


ROOT = Path(__file__).resolve().parents[1]


@dataclass
class Table:
    """Rows of named figures under a title; a figure may be a number, a text or None."""

    title: str
    rows: list[dict[str, Any]] = field(default_factory=list)

    def add(self, name: str, **figures: Any) -> None:
        """Appends a row, and prints it on standard error: what an hour has measured is not lost with a later minute."""
        self.rows.append({"": name, **figures})
        row = ", ".join(f"{figure} {_cell(value)}" for figure, value in figures.items())
        print(f"{self.title} | {name}: {row}", file=sys.stderr, flush=True)

    def __str__(self) -> str:
        columns = list(dict.fromkeys(key for row in self.rows for key in row))
        cells = [[_cell(row.get(column)) for column in columns] for row in self.rows]
        widths = [max(len(c), *(len(row[i]) for row in cells)) for i, c in enumerate(columns)] if cells else []
        lines = [
            self.title,
            "  ".join(
                c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(columns, widths, strict=True))
            ),
        ]
        for row in cells:
            lines.append(
                "  ".join(
                    c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True))
                )
            )
        return "\n".join(lines)


def _cell(value: Any) -> str:
    if value is None:
        return "–"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def surroundings() -> dict[str, Any]:
    """What figures depend on: the command, the day, versions, commit, processor, load, and its pace now."""
    found: dict[str, str | None] = {}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = None
    commit = subprocess.run(
        ["git", "rev-parse", "HEAD"], capture_output=True, text=True, cwd=Path(__file__).parent, check=False
    )
    load = [round(value, 2) for value in os.getloadavg()]
    return {
        "command": " ".join(["python", os.path.relpath(sys.argv[0], ROOT), *map(_told, sys.argv[1:])]),
        "date": datetime.now(timezone.utc).date().isoformat(),
        "commit": commit.stdout.strip() or None,
        "python": platform.python_version(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": load,
        "pace": _pace(),
        "versions": found,
    }


def _pace() -> float:
    """Processor seconds of ten million additions in Python: a shared processor has not always the same pace."""
    began, total = process_time(), 0
    for number in range(10_000_000):
        total += number
    return round(process_time() - began, 3)


def _told(argument: str) -> str:
    """An argument of the command without the folders of this machine: relative to the repository, or only its name."""
    path = Path(argument)
    if not path.is_absolute():
        return argument
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else path.name


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")


def finish(tables: Sequence[Table], output: Path | None, **settings: Any) -> None:
    """Prints the tables, and writes them with their settings and surroundings as JSON."""
    for table in tables:
        print(table, end="\n\n")
    if output is not None:
        write(tables, output, **settings)


def write(tables: Sequence[Table], output: Path, **settings: Any) -> None:
    """Writes tables with their settings and surroundings as JSON."""
    content = {
        "settings": settings,
        "surroundings": surroundings(),
        "tables": [{"title": table.title, "rows": table.rows} for table in tables],
    }
    output.write_text(json.dumps(content, indent=1, default=str) + "\n")  # columns stay in their order
