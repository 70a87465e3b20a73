"""Are proofs as generous as they could be, and do they refuse what is wrong?

    python benchmarks/margins.py [distances clearance mutants] [--only WORD ...] [--mutants N] [--output FILE]

`distances`: the clearance that is proven of each segment, beside the least distance of the original meshes that
`judge/motion_batch.py` measures at 1 kHz, which shares no code with kabo. `clearance`: problems that are solved with a
clearance that is asked for, what is then proven and measured; what is asked in vain says why. `mutants`: plans with one
coefficient of a polynomial changed by 1e-7 rad or m and more, none of which may be verified.
"""

import argparse
import json
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from motion import judged, made, problems
from table import Table, percentile, write

import kabo
from kabo.plan import Plan

CLEARANCES: dict[str, tuple[tuple[float, float | None], ...]] = {  # with an epsilon [m], or with the problem's
    "bartender/four_bottles": ((0.003, None),),
    "stacked/n2": ((0.003, None), (0.005, None)),
    "stacked/n4": ((0.003, None),),
    "assembly/gearbox": ((0.003, None), (0.005, 0.01)),  # the scene's 20 mm leave no grasp 5 mm
    "examples/two_cans": ((0.003, None),),
}
SURE = 1e-7  # [rad or m] by which a mutant's piece is off at its end: a hundred times what is accepted
ROUNDED = 2e-3  # proven distances have whole micrometres, measured ones the precision of coal
MUTATED = ("stacked/n2", "force_sensing/n2", "assembly/gearbox", "two_cans")


def distances(options: argparse.Namespace) -> Table:
    """Proven and measured distances of all problems that are chosen."""
    table = Table("Proven distances beside measured ones")
    with tempfile.TemporaryDirectory() as folder:
        for name, path in chosen(options):
            file, costs = made(name, path, "fast", 0, Path(folder))
            if file is None:
                table.add(name, segments=0, worst=costs["verified"])
                continue
            verdict = judged({"problem": str(path), "plan": str(file), "collisions": True})
            if "error" in verdict:
                table.add(name, segments=0, worst=verdict["error"])
                continue
            pairs = measured_clearances(json.loads(file.read_text()), verdict)
            counts = sum(verdict["violations"].values())
            row = distance_row(pairs) if pairs else {"segments": 0}
            table.add(name, **row, verified=costs["verified"], violations=counts)
    return table


def distance_row(pairs: list[tuple[float, float, str]]) -> dict[str, Any]:
    """What a certificate proves beside what is measured."""
    shares = [proven / measured for proven, measured, _ in pairs]
    worst = min(pairs, key=lambda pair: pair[0] / pair[1])
    return {
        "segments": len(pairs),
        "least proven mm": 1000 * min(pairs)[0],
        "least measured mm": 1000 * min(pair[1] for pair in pairs),
        "proven / measured, least": min(shares),
        "median": percentile(shares, 0.5),
        "at least 0.8 %": 100 * sum(share >= 0.8 for share in shares) / len(shares),
        "above 1": sum(share > 1.0 + ROUNDED for share in shares),
        "worst": worst[2],
    }


def measured_clearances(plan: dict[str, Any], verdict: dict[str, Any]) -> list[tuple[float, float, str]]:
    """Proven and measured least distance [m] of each segment for which both are told, and which one it is.

    Args:
        plan: the content of its file. verdict: what the judge said about it.
    """
    measured: dict[tuple[str, int], float] = {}
    for row in verdict.get("segments") or ():
        for number in row["segments"]:
            if row["least"] is not None and row["least"] > 0.0:
                key = row["node"], number
                measured[key] = min(measured.get(key, row["least"]), row["least"])
    certificate = plan.get("certificate") or {}
    return [
        (
            row["clearance"],
            measured[row["node"], row["segment"]],
            f"{row['node']} {row['segment']} {row['between']}",
        )
        for row in certificate.get("segments") or ()
        if row.get("clearance") is not None and (row["node"], row["segment"]) in measured
    ]


def clearance(options: argparse.Namespace) -> Table:
    """Problems with a clearance that is asked for."""
    table = Table("Plans with a clearance")
    for name, wanted in CLEARANCES.items():
        path = dict(problems()).get(name.removeprefix("examples/"))
        if path is None or (options.only and not any(word in name for word in options.only)):
            continue
        problem = kabo.load_problem(path)
        for size, epsilon in wanted:
            began = process_time()
            result = kabo.solve(problem, clearance=size, epsilon=epsilon, workers=1)
            seconds, title = process_time() - began, f"{name}, {1000 * size:g} mm"
            title += "" if epsilon is None else f", epsilon {1000 * epsilon:g} mm"
            if result.plan is None:
                why = result.reason.message if result.reason is not None else result.status
                table.add(title, verified="no plan", why=why, **{"solve s": seconds})
                continue
            report = kabo.verify(problem, result.plan)
            table.add(title, **asked_row(result.plan, report, size), **{"solve s": seconds})
    return table


def asked_row(plan: Plan, report: kabo.Report, size: float) -> dict[str, Any]:
    """What is proven of a plan with a clearance: of bodies, and of pairs that are to keep it."""
    told = report.certificate
    if told is None:
        return {"verified": "yes" if report.ok else "no", "why": "; ".join(plan.certificate_gaps)}
    own = [1000 * each.distance for each in told.objects if each.distance is not None]
    # Links of one hand keep no clearance from each other.
    pairs = [gap.least for gap in told.gaps if gap.hands[0] is None or gap.hands[0] != gap.hands[1]]
    least = min(pairs, default=told.near)
    return {
        "verified": "yes" if report.ok else str(report.findings[0].message),
        "least object's δ mm": min(own, default=1000 * told.near),
        "least of all pairs mm": 1000 * least,
        "measured mm": None if report.least is None else 1000 * report.least.distance,
        "pairs below": sum(each < size for each in pairs),
    }


def mutants(options: argparse.Namespace) -> Table:
    """Plans with a coefficient that is wrong, without certificates, which would be wrong for another reason, too."""
    names = [name for name in MUTATED if not options.only or any(word in name for word in options.only)]
    table, each = Table("Mutants of coefficients"), -(-options.mutants // max(1, len(names)))
    for name in names:
        problem = kabo.load_problem(dict(problems())[name])
        scene, plan = kabo.load_scene(problem.scene), kabo.solve(problem, workers=1).plan
        assert plan is not None and kabo.verify(problem, plan, scene=scene).ok
        counts = {"mutants": 0, "refused": 0}
        least, accepted = np.inf, []
        for number, (mutant, off) in enumerate(spoilt(plan, each)):
            counts["mutants"] += 1
            alone = kabo.verify(problem, replace(mutant, certificate=None), scene=scene)
            counts["refused"] += not alone.ok
            least = min(least, off)
            accepted += [str(number)] if alone.ok else []
        table.add(name, **counts, **{"least change": float(least), "accepted": " ".join(accepted) or "none"})
    return table


def spoilt(plan: Plan, count: int) -> Iterator[tuple[Plan, float]]:
    """Plans, each with one coefficient changed, and by how much its piece is then off at its end [rad or m]."""
    segments = [
        (name, i)
        for name, node in plan.nodes.items()
        for i, segment in enumerate(node.motion)
        if segment.trajectory is not None and np.ptp(segment.waypoints, axis=0).any()
    ]
    for number in range(count):
        rng = np.random.default_rng((0, number))
        name, i = segments[int(rng.integers(len(segments)))]
        node = plan.nodes[name]
        own = node.motion[i].trajectory
        assert own is not None
        k, j = int(rng.integers(len(own.coefficients))), int(rng.integers(len(own.joints)))
        powers = [*own.coefficients[k][j], *[0.0] * 6][:6]
        power, off = number % 6, SURE * 10.0 ** rng.uniform(0.0, 5.0)
        length = own.times[k + 1] - own.times[k]
        powers[power] += float(rng.choice([-1.0, 1.0])) * off / length**power
        pieces = [list(piece) for piece in own.coefficients]
        pieces[k][j] = tuple(powers)
        changed = replace(own, coefficients=tuple(map(tuple, pieces)))
        motion = tuple(replace(s, trajectory=changed) if n == i else s for n, s in enumerate(node.motion))
        yield replace(plan, nodes={**plan.nodes, name: replace(node, motion=motion)}), off


def chosen(options: argparse.Namespace) -> list[tuple[str, Path]]:
    """The problems, of which a word is in the name, if words are given."""
    return [
        (name, path)
        for name, path in problems().items()
        if not options.only or any(word in name for word in options.only)
    ]


SECTIONS = {"distances": distances, "clearance": clearance, "mutants": mutants}


def main() -> None:
    """Runs the sections that are asked for, prints tables and writes JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=f"{', '.join(SECTIONS)}; default: all")
    parser.add_argument("--only", nargs="*", default=[], metavar="WORD", help="problems with one in the name")
    parser.add_argument("--mutants", type=int, default=200, help="of all problems together")
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    if unknown := set(options.sections) - set(SECTIONS):
        parser.error(f"there is no section {min(unknown)}; choose from {', '.join(SECTIONS)}")
    tables = [SECTIONS[name](options) for name in options.sections or SECTIONS]
    for table in tables:
        print(table, end="\n\n")
    if options.output:
        write(tables, options.output, mutants=options.mutants)


if __name__ == "__main__":
    sys.exit(main())
