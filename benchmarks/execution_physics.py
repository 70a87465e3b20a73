"""Do plans work? Every problem with a scene is carried out in physics on all branches, by friction alone.

    python benchmarks/execution_physics.py [--only WORD ...] [--not WORD ...] [--branches N] [--hasty] [--output FILE]

A plan is carried out by the executor in MuJoCo, without recovery, on each of its branches, or on `--branches` drawn ones if
it has more. What branches share is simulated once: where they part, the process forks. Judged is the simulator's own state:

- `goal`: branches that end at a goal which is true there: each body rests on what the plan puts it on, is in the same
  regions, and is touched by the hand that should hold it.
- `mm`, `degrees`: the greatest distance and angle of any body from where the plan puts it, at the end.
- `contacts`: pairs that touch deeper than 0.1 mm though no segment permits it, looked at 200 times a second.
- `median`, `p99`, `most mrad`: the joint of an arm that is farthest from its setpoint, 1,000 times a second while it moves
  (mm for joints that slide).
- `near`: the least proven clearance less the error of the tool, over all looks [mm]; `beyond` is the share of looks at
  which a tool is farther from its path than the clearance of its segment. It has to be 0.
- `samples`: setpoints that were sent; `violations`: those that exceed a limit of position, velocity, acceleration or jerk.

`--hasty` sends the same motions in 1 / sqrt(2) of their time, so everything is accelerated twice as much as planned, and
tells whether grasps hold: proven clearances do not count then.

A part that was run anew replaces its rows in the file of `--output`; all others stay. `code` is the commit that made a row.
"""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from execution_physics_run import HASTY, Branch, Measured, Outcomes, branches_of, carried_out
from motion import problems
from table import Table, surroundings, write

import kabo
from kabo.plan import Plan
from kabo.streams import stream_key, uniforms

PLACED, TURNED = 3.0, 1.0  # [mm], [degrees] from where the plan puts a body
TITLE, HASTY_TITLE = "Plans in physics", "Twice the planned acceleration"
REASONS = "What did not work"


def chosen(options: argparse.Namespace) -> Iterator[tuple[str, Path]]:
    """The problems that are asked for."""
    for name, path in problems().items():
        if (not options.only or any(word in name for word in options.only)) and not any(
            word in name for word in options.skip
        ):
            yield name, path


def plan_of(name: str, path: Path, folder: Path | None) -> Plan | None:
    """The plan of a problem; one that lies in the folder is taken, and a new one is put there."""
    file = None if folder is None else folder / f"{name.replace('/', '__')}.json"
    if file is not None and file.exists():
        return kabo.load_plan(file)
    plan = kabo.solve(kabo.load_problem(path), workers=1).plan
    if plan is not None and file is not None:
        plan.save(file)
    return plan


def drawn(plan: Plan, most: int) -> tuple[list[Outcomes], int]:
    """The branches that are carried out, and how many there are."""
    found = branches_of(plan)
    if len(found) <= most:
        return found, len(found)
    order = np.argsort(uniforms(stream_key("branches", plan.problem), 0, len(found), 1)[:, 0])
    return [found[k] for k in sorted(order[:most])], len(found)


def figures(branches: list[Branch], measured: Measured, total: int) -> dict[str, Any]:
    """The row of a problem."""
    errors = np.concatenate(measured.errors) if measured.errors else np.zeros(1, np.float32)
    median, p99, most = (1000.0 * float(np.percentile(errors, q)) for q in (50, 99, 100))
    return {
        "branches": total,
        "run": len(branches),
        "goal": sum(each.goal for each in branches),
        "mm": max(each.off for each in branches),
        "degrees": max(each.turned for each in branches),
        "contacts": len({pair for each in branches for pair in each.contacts}),
        "median mrad": median,
        "p99 mrad": p99,
        "most mrad": most,
        "near mm": None if measured.nearest == np.inf else 1000.0 * measured.nearest,
        "beyond": measured.beyond / max(1, measured.looks),
        "samples": measured.samples,
        "violations": measured.violations,
        "simulated s": measured.simulated,
    }


def tables(options: argparse.Namespace, kept: dict[str, Table]) -> Iterator[None]:
    """Fills the tables, problem by problem."""
    title = HASTY_TITLE if options.hasty else TITLE
    for name, path in chosen(options):
        plan = plan_of(name, path, options.plans)
        for table in (kept[title], kept[REASONS]):
            table.rows = [
                row
                for row in table.rows
                if row[""] not in (name, f"{name}, hasty"[: 9999 if options.hasty else 0])
            ]
        if plan is None:
            kept[REASONS].add(name, reason="no plan")
            continue
        began = process_time()
        outcomes, total = drawn(plan, options.branches)
        scene = kabo.load_scene(kabo.load_problem(path).scene)
        branches, measured = carried_out(
            plan, scene, outcomes, HASTY if options.hasty else 1.0, weld=options.welds
        )
        row = figures(branches, measured, total)
        code = (surroundings()["commit"] or "")[:8]
        kept[title].add(name, **row, **{"processor s": process_time() - began, "code": code})
        failed = [each for each in branches if each.reason]
        if failed:
            told = f"{name}, hasty" if options.hasty else name
            kept[REASONS].add(told, branches=len(failed), reason=failed[0].reason)
        yield


def kept_from(output: Path | None) -> dict[str, Table]:
    """The tables as a former run left them."""
    found = {title: Table(title) for title in (TITLE, HASTY_TITLE, REASONS)}
    if output is not None and output.exists():
        for each in json.loads(output.read_text())["tables"]:
            if each["title"] in found:
                found[each["title"]].rows = each["rows"]
    return found


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="WORD", help="problems with one of these in the name"
    )
    parser.add_argument("--not", nargs="*", default=[], dest="skip", metavar="WORD", help="none with one of these")
    parser.add_argument("--branches", type=int, default=100, help="that are carried out at most")
    parser.add_argument("--hasty", action="store_true", help="at twice the planned acceleration")
    parser.add_argument("--welds", action="store_true", help="hands that lock in place of friction")
    parser.add_argument("--plans", type=Path, metavar="DIR", help="where plans are kept")
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    kept = kept_from(options.output)
    for _ in tables(options, kept):
        if options.output is not None:
            _write(kept, options)
    for table in kept.values():
        if table.rows:
            print(table, end="\n\n")


def _write(kept: dict[str, Table], options: argparse.Namespace) -> None:
    order = list(problems())
    for table in kept.values():
        table.rows.sort(key=lambda row: order.index(row[""].partition(",")[0]))
    write([table for table in kept.values() if table.rows], options.output, branches=options.branches)


if __name__ == "__main__":
    main()
