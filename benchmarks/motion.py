"""Are motions such that a controller follows them: within limits, smooth, free, near their paths; how long, how large?

    python benchmarks/motion.py [--only WORD ...] [--not WORD ...] [--quality fast good] [--plans DIR] [--output FILE]

All problems of domains/ and examples/ with a scene are solved and verified, and another program judges each plan:
`judge/motion_batch.py` shares no code with kabo. It samples polynomials at 1 kHz and at their borders with numpy, moves
robots with pinocchio, and asks coal for distances of the original meshes. `motion_tables.py` says what columns mean.
"""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from time import process_time
from typing import Any

from motion_tables import Judged, Tables
from table import Table, write

import kabo

ROOT = Path(__file__).resolve().parent.parent
JUDGE = Path(__file__).resolve().parent / "judge" / "motion_batch.py"
SPEED = {
    "assembly/gearbox": 0.1,
    "circular_rearrange/n3": 0.25,
    "bartender/four_bottles": 0.4,
}  # seconds that are to do


def problems() -> dict[str, Path]:
    """All problems with a scene, by their names: `stacked/n2`, `examples/two_cans`."""
    found = {}
    for folder in ("domains", "examples"):
        for path in sorted((ROOT / folder).glob("*/*.yaml")):
            text = path.read_text()
            if re.search(r"^problem:", text, re.MULTILINE) and re.search(r"^scene:", text, re.MULTILINE):
                found[path.parent.name if folder == "examples" else f"{path.parent.name}/{path.stem}"] = path
    return found


def judged(job: dict[str, Any]) -> dict[str, Any]:
    """What the judge says of a plan."""
    asked = subprocess.run(
        [sys.executable, JUDGE], input=json.dumps(job), capture_output=True, text=True, check=False
    )
    found: dict[str, Any] = json.loads(asked.stdout or '{"error": "the judge ended"}')
    return found


def made(name: str, path: Path, quality: str, seed: int, folder: Path) -> tuple[Path | None, dict[str, Any]]:
    """A plan file and what making it cost: processor seconds of solving, of proofs, and of verifying."""
    problem = kabo.load_problem(path)
    began = process_time()
    result = kabo.solve(problem, seed=seed, quality=quality, workers=1)
    solving = process_time() - began
    if result.plan is None:
        return None, {"solve s": solving, "verified": "no plan"}
    file = folder / f"{name.replace('/', '__')}.{quality}.s{seed}.json"
    result.plan.save(file)
    began = process_time()
    report = kabo.verify(problem, result.plan)
    figures = {
        "solve s": solving,
        "certificate s": result.statistics.get("certificate_s"),
        "verify s": process_time() - began,
        "verified": "yes" if report.ok else "no",
    }
    return file, figures


def found_in(folder: Path, name: str, path: Path) -> Path | None:
    """The plan of a problem in a folder of plans that were made before."""
    stem = str(path.relative_to(ROOT)).replace("/", "__")
    return next(
        iter([*sorted(folder.glob(f"{stem}*.json")), *sorted(folder.glob(f"{name.replace('/', '__')}.*.json"))]),
        None,
    )


class Loading:
    """Counts the processor seconds in which solving loads scenes: they are not of solving."""

    def __init__(self) -> None:
        from kabo.planner.refine import with_geometry  # noqa: PLC0415 - it loads kernels

        self.seconds, self._load = 0.0, with_geometry.load_procedures
        with_geometry.load_procedures = self._loaded  # type: ignore[assignment]

    def _loaded(self, *arguments: Any, **options: Any) -> Any:
        began = process_time()
        found = self._load(*arguments, **options)
        self.seconds += process_time() - began
        return found


def speed(rounds: int) -> Table:
    """Processor seconds of solving three scenarios, warm, without loading: the median of some runs after the first."""
    table, loading = Table("Solving, processor seconds"), Loading()
    for name, bound in SPEED.items():
        problem = kabo.load_problem(problems()[name])
        kabo.solve(problem, seed=0, workers=1)
        runs = []
        for seed in range(rounds):
            loading.seconds, began = 0.0, process_time()
            kabo.solve(problem, seed=seed, workers=1)
            runs.append((process_time() - began - loading.seconds, loading.seconds))
        seconds, loads = zip(*runs, strict=True)
        figures = {"median s": median(seconds), "least s": min(seconds), "at most": bound}
        table.add(name, **figures, **{"loading s": median(loads), "runs": rounds})
    return table


def looked_at(options: argparse.Namespace, folder: Path) -> Iterator[Judged]:
    """All chosen plans, made and judged one by one."""
    for name, path in problems().items():
        if (options.only and not any(word in name for word in options.only)) or any(
            w in name for w in options.skip
        ):
            continue
        for quality in options.quality:
            if options.plans:
                file, figures = found_in(options.plans, name, path), {}
            else:
                file, figures = made(name, path, quality, options.seed, folder)
            job = {
                "problem": str(path),
                "plan": str(file),
                "durations": True,
                "collisions": not options.no_collisions,
            }
            verdict = judged(job) if file else {"error": figures.get("verified", "no plan")}
            yield Judged(name, quality, figures, verdict, json.loads(file.read_text()) if file else {})


def main() -> None:
    """Prints the tables, writes JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="WORD", help="problems with one of these in the name"
    )
    parser.add_argument("--not", nargs="*", default=[], dest="skip", metavar="WORD", help="none with one of these")
    parser.add_argument("--quality", nargs="*", default=["fast", "good"], choices=["fast", "good"])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--plans", type=Path, metavar="DIR", help="judge the plan files there, solve nothing")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep plans and the judge's whole verdicts here")
    parser.add_argument(
        "--no-collisions", action="store_true", help="ask for no distances: they take most of the time"
    )
    parser.add_argument(
        "--rounds", type=int, default=0, help="runs of the three scenarios that are timed; 0 for none"
    )
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    if options.plans:
        options.quality = ["fast"]
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        tables = Tables()
        for each in looked_at(options, folder):
            tables.add(each)
            if options.keep:
                name = f"{each.name.replace('/', '__')}.{each.quality}.verdict"
                (folder / name).write_text(json.dumps(each.verdict, indent=1))
    found = tables.all
    if options.rounds:
        found.append(speed(options.rounds))
    for table in found:
        print(table, end="\n\n")
    if options.output:
        write(found, options.output, seed=options.seed, quality=options.quality)


if __name__ == "__main__":
    main()
