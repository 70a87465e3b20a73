"""What does the certificate of a plan cost to make, to keep and to check, beside the plan itself?

    python benchmarks/certificates.py [PROBLEM …] [--quality good] [--output FILE]

Processor time of one process, kernels compiled before: of solving without a certificate, of making it, of checking it,
of measuring distances between the meshes; bytes of the plan's file with and without it.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

from table import Table, finish

import kabo
from kabo.geometry_server import GeometryServer
from kabo.plan import Certificate, Plan, plan_to_json, topological_order
from kabo.planner.certify.certifying import certify
from kabo.verify import verify_plan
from kabo.verify.certificate_report import CertificateReport

DOMAINS = Path(__file__).resolve().parents[1] / "domains"
PROBLEMS = (
    "bartender/four_bottles",
    "force_sensing/n10",
    "stacked/n8",
    "circular_rearrange/n3",
    "assembly/gearbox",
)


def row(name: str, quality: str) -> dict[str, Any]:
    """The figures of one problem; only why there are none, if it has no plan."""
    problem = kabo.load_problem(DOMAINS / f"{name}.yaml")
    assert problem.scene is not None
    kabo.solve(problem, quality=quality)  # compiles what it needs, and decomposes meshes
    began = process_time()
    result = kabo.solve(problem, quality=quality, certificate=False)
    solved = process_time() - began
    if result.plan is None:
        return {"status": result.status}
    scene = kabo.load_scene(problem.scene)
    surroundings = GeometryServer(scene, problem.scene.epsilon, 0).surroundings
    certify(result.plan, surroundings)
    began = process_time()
    made = certify(result.plan, surroundings)
    making = process_time() - began
    if not isinstance(made, Certificate):
        return {"status": f"not proven: {made[0]}", "solve s": solved, "make s": making}
    return {
        "status": "proven",
        "solve s": solved,
        "make s": making,
        "share": making / solved,
        **_size(result.plan, made),
    } | (_checked(problem, result.plan, made))


def _size(plan: Plan, made: Certificate) -> dict[str, Any]:
    alone, whole = len(plan_to_json(plan)), len(plan_to_json(replace(plan, certificate=made)))
    parts = sum(len(body.vertices) for body in made.bodies.values()) * 4 // 3
    segments = sum(len(plan.nodes[name].motion) for name in topological_order(plan) or ())
    return {"segments": segments, "plan kB": alone / 1000, "with kB": whole / 1000, "parts kB": parts / 1000}


def _checked(problem: Any, plan: Plan, made: Certificate) -> dict[str, Any]:
    verify_plan(problem, plan)
    began = process_time()
    alone = verify_plan(problem, plan)
    middle = process_time()
    both = verify_plan(problem, replace(plan, certificate=made))
    ended = process_time()
    told = both.certificate
    assert isinstance(told, CertificateReport)
    least = min((each.distance for each in told.objects if each.distance is not None), default=None)
    return {
        "verified": f"{alone.ok}, {both.ok}",
        "pairs": told.pairs,
        "axes": told.axes,
        "verify s": middle - began,
        "check s": ended - middle - (middle - began),
        "least mm": None if least is None else 1000 * least,
    }


def main() -> None:
    """Prints a row for each problem, and writes the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("problems", nargs="*", default=PROBLEMS, metavar="PROBLEM")
    parser.add_argument("--quality", default="fast", choices=("fast", "good"))
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    table = Table(f"certificates, processor time, quality {options.quality}")
    for name in options.problems:
        table.add(name, **row(name, options.quality))
    finish([table], options.output, quality=options.quality)


if __name__ == "__main__":
    main()
