"""Bodies that are displaced within what is proven, in physics: is anything planned anew, and does anything run unproven?

    python benchmarks/execution_displaced.py [--runs N] [--only WORD ...] [--largest] [--output FILE]

Before each run one body that the plan moves is pushed along the horizontal, in a direction and by a share of the least
proven clearance of the plan that are drawn from the run's number; `--largest` pushes by 97 to 99 % of it. The run has no
recovery, so a surprise ends it. `surprised` has to be 0. `kept` is how far the body is from the plan's place at the end as
a share of the push, `contacts` are those that no segment permits. Each run is a fork of the process that has loaded the
scene.
"""

import argparse
import os
import pickle
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from execution_physics import plan_of
from execution_physics_run import Branch, MeasuredRobot, _judge
from table import ROOT, Table, finish

import kabo
from kabo.execution import KnownTruth, Margins, execute
from kabo.plan import Plan
from kabo.simulation import PhysicsSettings
from kabo.streams import stream_key, uniforms
from kabo.verify import Report

PROBLEMS = {
    "stacked/n2": "domains/stacked/n2.yaml",
    "circular_rearrange/n2": "domains/circular_rearrange/n2.yaml",
    "force_sensing/n1": "domains/force_sensing/n1.yaml",
    "two_cans": "examples/two_cans/problem.yaml",
    "bartender/four_bottles": "domains/bartender/four_bottles.yaml",
}
SETTLED = 0.2  # [s] after the push


def displaced(name: str, runs: int, plans: Path | None = None, *, largest: bool = False) -> dict[str, Any]:
    """The figures of a problem."""
    plan = plan_of(name, ROOT / PROBLEMS[name], plans)
    assert plan is not None
    problem = kabo.load_problem(ROOT / PROBLEMS[name])
    scene = kabo.load_scene(problem.scene)
    report = kabo.verify(problem, plan, scene=scene)
    robot, least = MeasuredRobot(scene, PhysicsSettings(), plan, 1.0), Margins(plan).of_rest(plan.root)
    with tempfile.TemporaryDirectory() as folder:
        for number in range(runs):
            child = os.fork()
            if child == 0:
                try:
                    found = _one(name, number, plan, report, robot, least, largest=largest)
                    (Path(folder) / f"{number}.pickle").write_bytes(pickle.dumps(found))
                finally:
                    os._exit(0)
            os.waitpid(child, 0)
        made = [pickle.loads(path.read_bytes()) for path in Path(folder).iterdir()]  # noqa: S301 - our own
    reasons = [reason for *_, reason in made if reason]
    return {
        "runs": len(made),
        "proven mm": 1000.0 * least,
        "surprised": len(reasons),
        "goal": sum(branch.goal for branch, *_ in made),
        "largest mm": 1000.0 * max(size for _, size, _ in made),
        "kept": max(branch.off / (1000.0 * size) for branch, size, _ in made),
        "contacts": sum(len(branch.contacts) for branch, *_ in made),
        "reason": reasons[0] if reasons else None,
    }


def _one(
    name: str, number: int, plan: Plan, report: Report, robot: MeasuredRobot, least: float, *, largest: bool
) -> tuple[Branch, float, str]:
    scene = robot.scene
    moved = {body for node in plan.nodes.values() if node.after is not None for body in node.after.objects}
    choice, share, angle = uniforms(stream_key("displaced", name, number), 0, 1, 3)[0].tolist()
    bodies = sorted(moved & set(scene.movable))
    size = least * (0.97 + 0.02 * share if largest else share)
    push = size * np.array([np.cos(2.0 * np.pi * angle), np.sin(2.0 * np.pi * angle), 0.0])
    robot.physics.displace(bodies[int(choice * len(bodies))], push)
    robot.wait(SETTLED)
    run = execute(plan, scene, robot, KnownTruth(seed=number, poses=robot.poses), report=report)
    robot.wait(SETTLED)
    branch = Branch(())
    _judge(branch, run, plan, scene, robot)
    return branch, size, "" if run.reached_goal else run.reason


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=10, help="of each problem")
    parser.add_argument(
        "--only", nargs="*", default=[], metavar="WORD", help="problems with one of these in the name"
    )
    parser.add_argument("--largest", action="store_true", help="pushes that are nearly as large as what is proven")
    parser.add_argument("--plans", type=Path, metavar="DIR", help="where plans are kept")
    parser.add_argument("--output", type=Path, help="JSON")
    options = parser.parse_args()
    table = Table("Displaced within what is proven")
    for name in PROBLEMS:
        if not options.only or any(word in name for word in options.only):
            table.add(name, **displaced(name, options.runs, options.plans, largest=options.largest))
    finish([table], options.output, runs=options.runs, largest=options.largest)


if __name__ == "__main__":
    main()
