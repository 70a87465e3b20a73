"""A two-arm assembly that nobody here wrote: time of kabo beside the peer's own, in one run.

    python benchmarks/construction_set.py [--seeds 10] [--peer PYTHON] [--limit 600] [--output FILE]

Two UR3 arms put two spheres on the magnets of a cylinder and lay it in its place: robots of the package
example-robot-data (extra `robots`), parts and task of hpp-environments. kabo gets actions and a goal, no sequence of
states. PYTHON is that of an environment with hpp-python, hpp-environments and example-robot-data; the peer plans once
over all states that its rules allow, and once over those along one way to the goal. Seconds are those of the
processor, without loading and compiling; kabo's include proof and certificate, and every plan is verified.
"""

import argparse
import json
import os
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import mean, median, stdev
from typing import Any
from xml.etree import ElementTree

from table import Table, finish

import kabo

HERE = Path(__file__).resolve().parent
PROBLEM = HERE / "construction_set" / "two_spheres.yaml"
PEER = HERE / "construction_set_peer.py"


def row(seconds: Sequence[float | None]) -> dict[str, Any]:
    """How many runs ended with a plan, and their seconds."""
    solved = [each for each in seconds if each is not None]
    if not solved:
        return {"solved": f"0 of {len(seconds)}"}
    spread = stdev(solved) if len(solved) > 1 else 0.0
    return {
        "solved": f"{len(solved)} of {len(seconds)}",
        "mean s": mean(solved),
        "deviation s": spread,
        "median s": median(solved),
        "most s": max(solved),
    }


def solved(seed: int) -> tuple[float | None, dict[str, Any]]:
    """Seconds of the processor, and the figures of one run of kabo; the plan must be verified."""
    problem = kabo.load_problem(PROBLEM)
    began = time.process_time()
    result = kabo.solve(problem, seed=seed)
    seconds = time.process_time() - began
    if result.plan is None:
        return None, result.statistics
    report = kabo.verify(problem, result.plan)
    if not report.ok:
        raise SystemExit(f"seed {seed}: the plan does not hold: {report.findings[0]}")
    return seconds - result.statistics["load_s"], result.statistics


def peer(python: Path, states: str, seeds: int, limit: float) -> list[float | None]:
    """Seconds of the processor of each run of the peer; None for those that did not end in `limit` seconds for all."""
    prefix = next(python.parent.parent.glob("lib/python3*/site-packages/cmeel.prefix"))
    paths = {"LD_LIBRARY_PATH": str(prefix / "lib"), "ROS_PACKAGE_PATH": str(prefix / "share")}
    program = [str(python), str(PEER), "--states", states, "--seeds", str(seeds)]
    try:
        done = subprocess.run(program, env={**os.environ, **paths}, capture_output=True, check=True, timeout=limit)
        told = done.stdout
    except subprocess.TimeoutExpired as stopped:
        told = stopped.stdout or b""
    found: list[float | None] = [json.loads(line) for line in told.splitlines()[-seeds:]]
    return [*found, *[None] * (seeds - len(found))]


def same_lengths(python: Path) -> None:
    """Refuses to compare if the scene's parts are not those of the package."""
    prefix = next(python.parent.parent.glob("lib/python3*/site-packages/cmeel.prefix"))
    folder = prefix / "share" / "hpp_environments" / "urdf" / "construction_set"
    scene = kabo.load_problem(PROBLEM).scene
    assert scene is not None
    for file, body, attribute in (("cylinder_08", "cylinder0", "size"), ("sphere", "sphere0", "radius")):
        tree = ElementTree.parse(folder / f"{file}.urdf")  # noqa: S314 (a package that was installed on purpose)
        shape = tree.find(".//collision/geometry/*")
        assert shape is not None
        theirs = tuple(float(word) for word in shape.attrib[attribute].split())
        if scene.bodies[body].shape.size[: len(theirs)] != theirs:
            raise SystemExit(f"{file} of the package has the {attribute} {theirs}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Runs everything, prints the table and writes the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--peer", type=Path, metavar="PYTHON", help="of an environment that has hpp-python")
    parser.add_argument(
        "--limit", type=float, default=600.0, metavar="S", help="for all runs of the peer in one way"
    )
    parser.add_argument("--output", type=Path, default=Path("construction_set.json"))
    options = parser.parse_args(arguments)
    solved(0)  # compiles what is not compiled yet
    table = Table("Construction set, two UR3 arms: six actions")
    runs = [solved(seed) for seed in range(options.seeds)]
    checks = median(figures["collision_checks"] for _, figures in runs)
    table.add("kabo, actions and a goal", **row([seconds for seconds, _ in runs]), checks=int(checks))
    if options.peer is not None:
        same_lengths(options.peer)
        table.add("HPP, all states", **row(peer(options.peer, "all", options.seeds, options.limit)))
        along = peer(options.peer, "few", options.seeds, options.limit)
        table.add("HPP, the states along one way", **row(along))
    finish([table], options.output, seeds=options.seeds, limit=options.limit)


if __name__ == "__main__":
    main()
