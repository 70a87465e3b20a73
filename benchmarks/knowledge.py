"""What the knowledge planner promises: how long, how large, how right, on every family of domains/.

    python benchmarks/knowledge.py                                # everything, with the peers that are there
    python benchmarks/knowledge.py --only unix-4 ctp-20 --repeat 5
    python benchmarks/knowledge.py --peers /path/to/python --output knowledge.json

Each instance has a process, a time-out and a memory limit of its own, and is solved four times: the first run, which
reads compiled code, is told apart, the others give a median. Seconds are grounding and search together. A row is
ok if the plan was found in time, is no larger than it may be, was accepted by `kabo.verify`, and if the instance is
no smaller than the published one of its name.
"""

import argparse
import json
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from knowledge_calls import calls
from knowledge_instances import INSTANCES, Instance
from knowledge_peers import peers
from table import Table, finish

HERE = Path(__file__).resolve().parent
COMPILED_BY = (
    "stacked-20",
    "stacked-8 breadth-first",
    "ctp-20",
)  # what is not compiled yet is, before anything counts


def measure(instance: Instance, repeat: int, timeout: float, memory: float, judges: float) -> dict[str, Any]:
    """What one instance told before it ended, and how it ended."""
    request = {"name": instance.name, "repeat": repeat, "timeout": timeout, "memory_gb": memory}
    command = [sys.executable, str(HERE / "knowledge_child.py"), json.dumps(request)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    ended = None
    try:
        said, failed = process.communicate(timeout=2.0 * timeout + judges)
    except subprocess.TimeoutExpired:
        process.kill()
        said, failed = process.communicate()
        ended = "stopped"
    figures: dict[str, Any] = {}
    for line in said.splitlines():
        figures |= json.loads(line)
    if process.returncode and ended is None:
        ended = (failed.strip().splitlines() or [f"exit {process.returncode}"])[-1]
    return figures | {"ended": ended}


def judged(instance: Instance, figures: Mapping[str, Any]) -> list[str]:
    """What is wrong with a row; nothing if it is ok."""
    wrong = []
    if figures["ended"] is not None:
        wrong.append(str(figures["ended"])[:60])
    if figures.get("status") != "solved":
        return [*wrong, figures.get("status") or "no answer"]
    if instance.seconds is not None and figures["s"] > instance.seconds:
        wrong.append("too slow")
    if instance.nodes is not None and figures["nodes"] > instance.nodes:
        wrong.append("too large")
    if instance.actions is not None and figures["actions"] != instance.actions:
        wrong.append("not optimal")
    if not figures.get("verified"):
        wrong.append("NOT VERIFIED" if "verified" in figures else "verification did not end")
    own = tuple(figures[name] for name in ("objects", "unknown", "sensing"))
    if instance.published is not None and any(a < b for a, b in zip(own, instance.published, strict=True)):
        wrong.append("smaller than published")
    return wrong


def row(instance: Instance, figures: Mapping[str, Any]) -> dict[str, Any]:
    """The row of the table."""
    grounding = figures.get("grounding_s")
    whole = figures.get("s")
    return {
        "s": whole,
        "bound": instance.seconds,
        "processor s": figures.get("processor_s"),
        "grounding s": grounding,
        "search s": None if grounding is None or whole is None else max(0.0, whole - grounding),
        "first s": figures.get("first_s"),
        "load s": figures.get("load_s"),
        "nodes": figures.get("nodes"),
        "at most": instance.nodes,
        "actions": figures.get("actions"),
        "leaves": _short(figures.get("leaves")),
        "expanded": figures.get("expanded"),
        "MB": None if "peak_mb" not in figures else int(figures["peak_mb"]),
        "verified": figures.get("verified"),
        "worlds": _worlds(figures),
        "ok": ", ".join(judged(instance, figures)) or "ok",
    }


def _worlds(figures: Mapping[str, Any]) -> str | None:
    """Who judged: all worlds, and how many these are, or the replay."""
    if "judge" not in figures:
        return None
    return figures["judge"] if figures["worlds"] is None else f"all {_short(figures['worlds'])}"


def _short(number: int | None) -> str | None:
    return None if number is None else str(number) if number < 10**6 else f"{number:.1e}"


def sizes_row(instance: Instance, figures: Mapping[str, Any]) -> dict[str, Any]:
    """What the instance consists of, and what the published one of its name has at least."""
    columns = {"objects": "objects", "unknown atoms": "unknown", "sensing actions": "sensing"}
    shown: dict[str, Any] = {}
    for place, (title, name) in enumerate(columns.items()):
        least = "" if instance.published is None else f" ({instance.published[place]})"
        shown[title] = f"{figures.get(name, '–')}{least}"
    return shown | {"ground actions": figures.get("ground_actions")}


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs what was selected, prints the tables and writes the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", metavar="NAME", help="instances, or the beginnings of their names")
    parser.add_argument("--must", action="store_true", help="only instances with a bound in seconds")
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="runs after the first (default: 3)")
    parser.add_argument("--timeout", type=float, default=120.0, metavar="S", help="of one run (default: 120)")
    parser.add_argument("--memory", type=float, default=6.0, metavar="GB", help="of one process (default: 6)")
    parser.add_argument(
        "--judges", type=float, default=180.0, metavar="S", help="for judging a plan (default: 180)"
    )
    parser.add_argument("--peers", metavar="PYTHON", help="an interpreter that has planners to compare with")
    parser.add_argument("--no-calls", action="store_true", help="leave out the series of external calls")
    parser.add_argument("--output", type=Path, default=Path("knowledge.json"))
    options = parser.parse_args(arguments)
    chosen = [
        each
        for each in INSTANCES
        if (not options.only or any(each.name.startswith(word) for word in options.only))
        and (not options.must or each.seconds is not None)
    ]
    for name in COMPILED_BY:
        measure(next(each for each in INSTANCES if each.name == name), 0, 600.0, options.memory, 60.0)
    speeds, counts = Table("Knowledge planner"), Table("Instances (the published ones at least)")
    measured = {}
    for instance in chosen:
        figures = measure(instance, options.repeat, options.timeout, options.memory, options.judges)
        speeds.add(instance.name, **row(instance, figures))
        counts.add(instance.name, **sizes_row(instance, figures))
        measured[instance.name] = figures
    tables = [speeds, counts]
    if not options.no_calls and not options.only:
        tables.append(calls())
    if options.peers:
        tables.append(peers(options.peers, chosen, options.timeout, options.memory))
    settings = {"repeat": options.repeat, "timeout": options.timeout, "memory_gb": options.memory}
    finish(tables, options.output, **settings, measured=measured)


if __name__ == "__main__":
    main()
