"""Any robot, any epsilon: robots of example-robot-data prepared from nothing but their URDF, and domains at many epsilons.

    python benchmarks/robots.py [ready epsilon] [--only NAME …] [--epsilon 0.01] [--output robots.json]

`ready`: each robot with an arm in a scene of its own, in processes of its own: cold (no parts are stored), warm (all
are), and if meshes are unsound, once more with the line `hulls` that kabo's findings tell to paste. `epsilon`: problems
of the domains at several epsilons, solved and verified, after their geometry is prepared. Compiling is not counted.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from time import perf_counter
from typing import Any

from table import Table, finish

HERE = Path(__file__).resolve()
DOMAINS = HERE.parent.parent / "domains"
SECONDS_BAR, WARM_BAR, VERTICES_BAR, RATIO_BAR = 60.0, 1.0, 2000, 4.0
LIMIT_S = 600.0  # of one preparation, after which it counts as failed
ROBOTS = {  # names for tables, and URDFs below `robots/` of example-robot-data
    "Panda": "panda_description/urdf/panda.urdf",
    "Panda, primitives": "panda_description/urdf/panda_collision.urdf",
    "UR3": "ur_description/urdf/ur3_robot.urdf",
    "UR5": "ur_description/urdf/ur5_robot.urdf",
    "UR5, gripper": "ur_description/urdf/ur5_gripper.urdf",
    "UR10": "ur_description/urdf/ur10_robot.urdf",
    "Kinova": "kinova_description/robots/kinova.urdf",
    "ANYmal B, Kinova": "anymal_b_simple_description/robots/anymal-kinova.urdf",
    "xArm 7": "xarm_description/urdf/xarm7.urdf",
    "Z1": "z1_description/urdf/z1.urdf",
    "B1, Z1": "b1_description/urdf/b1-z1.urdf",
    "SO-100": "so_arm_description/urdf/so100.urdf",
    "SO-101": "so_arm_description/urdf/so101.urdf",
    "TIAGo": "tiago_description/robots/tiago.urdf",
    "TIAGo, no hand": "tiago_description/robots/tiago_no_hand.urdf",
    "TIAGo, two arms": "tiago_description/robots/tiago_dual.urdf",
    "TIAGo Pro": "tiago_pro_description/robots/tiago_pro.urdf",
    "TALOS' left arm": "talos_data/robots/talos_left_arm.urdf",
    "TALOS": "talos_data/robots/talos_reduced.urdf",
    "Baxter": "baxter_description/urdf/baxter.urdf",
    "PR2": "pr2_description/urdf/pr2.urdf",
    "iCub": "icub_description/robots/icub.urdf",
    "Romeo": "romeo_description/urdf/romeo.urdf",
    "G1": "g1_description/urdf/g1_29dof_rev_1_0.urdf",
    "G1, hands": "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf",
    "Alex, nubs": "alex_description/urdf/alex_nub_hands.urdf",
    "Alex, Sake": "alex_description/urdf/alex_sake_hands.urdf",
    "Centauro": "centauro_description/urdf/centauro.urdf",
    "human": "human_description/robots/human.urdf",
    "Borinot's arm": "borinot_description/urdf/borinot_flying_arm_2.urdf",
    "hextilt's arm": "hextilt_description/urdf/hextilt_flying_arm_5.urdf",
}
SCENE = """scene: robot
epsilon: {epsilon}
packages: {{example-robot-data: installed}}
robots:
  r: {{urdf: package://example-robot-data/robots/{urdf}{hulls}}}
"""
PROBLEMS = {
    "BARTENDER": "bartender/four_bottles.yaml",
    "STACKED, n = 8": "stacked/n8.yaml",
    "ASSEMBLY": "assembly/gearbox.yaml",
    "CIRCULAR, n = 3": "circular_rearrange/n3.yaml",
}
EPSILONS = (0.02, 0.01, 0.005, 0.002, 0.001)
USUAL = 0.01  # the epsilon [m] with which times are compared
_PATH = re.compile(r'"/[^"]*/([^"/]+)"')  # of a file on this machine: its name is enough
_HULLS = re.compile(r"`hulls: \[([^\]]*)\]`")


# ------------------------------------------------------------------------------------------------------------- ready
def ready(only: Sequence[str], epsilon: float) -> list[Table]:
    """Every robot: what it consists of, seconds cold and warm, and what is refused with which cause."""
    title = f"Robots from their URDF alone, epsilon = {1000 * epsilon:g} mm; seconds"
    table, causes = (
        Table(title),
        Table("Refused for faults of a robot's own files: how many, the first, its remedies"),
    )
    for name, urdf in ROBOTS.items():
        if not only or name in only:
            table.add(name, **_robot(name, urdf, epsilon, causes))
    return [table, *([causes] if causes.rows else []), _bars(table)]


def _robot(name: str, urdf: str, epsilon: float, causes: Table) -> dict[str, Any]:
    with _parts_folder() as folder:
        cold = _measured(urdf, epsilon, "", folder)
        refused = cold.get("refused", [])
        if refused:
            said = _PATH.sub(r'"\1"', refused[0]["message"])
            causes.add(name, findings=len(refused), first=said, remedy=refused[0]["hint"])
        hulls = _HULLS.search(" ".join(finding["hint"] or "" for finding in refused))
        if hulls is not None:  # as a person would, who pastes the line
            cold = {
                **_measured(urdf, epsilon, f", hulls: [{hulls[1]}]", folder),
                "hulls": len(hulls[1].split(",")),
            }
        if "links" not in cold:
            return {"refused": len(refused), "failed": cold.get("failed", "as refused")}
        warm = _measured(urdf, epsilon, "" if hulls is None else f", hulls: [{hulls[1]}]", folder)
    return {
        **{key: cold[key] for key in ("links", "elements", "triangles", "parts", "vertices")},
        "cold": cold["seconds"],
        "processor": cold["processor"],
        "warm": warm["seconds"],
        "warm processor": warm["processor"],
        "refused": len(refused),
        "hulls": cold.get("hulls", 0),
    }


def _bars(table: Table) -> Table:
    bars = Table("Robots: what must be reached")
    done = [row for row in table.rows if "cold" in row]
    for figure, bar in (("cold", SECONDS_BAR), ("warm", WARM_BAR), ("vertices", VERTICES_BAR)):
        worst = max(done, key=lambda row: row[figure], default=None)
        if worst is not None:
            above = sum(row[figure] > bar for row in done)
            bars.add(
                f"{figure}, the most of {len(done)} robots", bar=f"<= {bar:g}", found=worst[figure], of=worst[""],
                above=above, met="NO" if above else "yes",
            )  # fmt: skip
    lost = [row[""] for row in table.rows if "cold" not in row]
    bars.add(
        "robots that no remedy makes ready",
        bar="0",
        found=len(lost),
        of=", ".join(lost),
        met="NO" if lost else "yes",
    )
    return bars


class _parts_folder:  # noqa: N801 - a context, as in tempfile
    """A cache in which no parts are stored, and with the kernels that are compiled already."""

    def __enter__(self) -> Path:
        from kabo.compilation import cache_folder

        self._folder = tempfile.TemporaryDirectory(prefix="kabo-robots-")
        made = Path(self._folder.name).resolve()
        made.chmod(0o700)
        compiled = cache_folder() / "compiled"
        compiled.mkdir(parents=True, exist_ok=True)
        (made / "compiled").symlink_to(compiled.resolve())
        return made

    def __exit__(self, *_: object) -> None:
        self._folder.cleanup()


def _measured(urdf: str, epsilon: float, hulls: str, cache: Path) -> dict[str, Any]:
    return _process({"KABO_CACHE": str(cache)}, "prepare", urdf, str(epsilon), hulls)


def _process(environment: Mapping[str, str], *arguments: str) -> dict[str, Any]:
    """What this script says in a process of its own; {"failed": …} if it does not end, or dies."""
    try:
        answer = subprocess.run(
            [sys.executable, str(HERE), *arguments],
            env={**os.environ, **environment},
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {"failed": f"no end after {LIMIT_S:g} s"}
    if answer.returncode != 0:
        return {"failed": (answer.stderr.strip().splitlines() or ["no word"])[-1]}
    found: dict[str, Any] = json.loads(answer.stdout.splitlines()[-1])
    return found


def prepare_one(urdf: str, epsilon: float, hulls: str) -> dict[str, Any]:
    """The figures of one robot, prepared in this process; the seconds begin once everything is imported and compiled."""
    from kabo.errors import InputError
    from kabo.geometry_server import prepare_scene
    from kabo.language import load_scene_description
    from kabo.scene import load_scene
    from kabo.service.warming import prepare_once

    prepare_once()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.yaml"
        path.write_text(SCENE.format(urdf=urdf, epsilon=epsilon, hulls=hulls))
        began, used = perf_counter(), _processor_seconds()
        try:
            scene = load_scene(load_scene_description(path))
            made = prepare_scene(scene)
        except InputError as error:
            return {"refused": [{"message": each.message, "hint": each.hint} for each in error.diagnostics]}
        seconds = perf_counter() - began
    elements = [each for robot in scene.robots.values() for link in robot.links.values() for each in link.elements]
    return {
        "links": len(made),
        "elements": len(elements),
        "triangles": sum(len(each.mesh.faces) for each in elements if each.kind == "mesh"),
        "parts": sum(each.parts for each in made),
        "vertices": sum(each.vertices for each in made),
        "seconds": seconds,
        "processor": _processor_seconds() - used,
    }


def _processor_seconds() -> float:
    return sum(used.ru_utime + used.ru_stime for used in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))


# ----------------------------------------------------------------------------------------------------------- epsilon
def by_epsilon(only: Sequence[str], epsilons: Sequence[float]) -> list[Table]:
    """Each problem at each epsilon, no parts stored: prepared, solved, verified; the whole time beside that at 10 mm."""
    table = Table("Domains at several epsilons; seconds of the processor, one process")
    for name, problem in PROBLEMS.items():
        if only and name not in only:
            continue
        rows: dict[float, dict[str, Any]] = {}
        for epsilon in epsilons:
            with _parts_folder() as folder:
                row = rows[epsilon] = _process({"KABO_CACHE": str(folder)}, "solve", problem, str(epsilon))
            if "verifying" in row:
                row["whole"] = row["preparing"] + row["solving"] + row["verifying"]
        usual = rows.get(USUAL, {}).get("whole")
        for epsilon, row in rows.items():
            ratio = row["whole"] / usual if usual and "whole" in row else None
            table.add(f"{name}, {1000 * epsilon:g} mm", **row, **{"to 10 mm": ratio})
    found = [row["to 10 mm"] for row in table.rows if row[""].endswith(" 1 mm") and row["to 10 mm"] is not None]
    solved = sum(row.get("status") == "solved" and row.get("verified") is True for row in table.rows)
    bars = Table("Domains at several epsilons: what must be reached")
    met = "yes" if solved == len(table.rows) else "NO"
    bars.add("solved and verified", bar=f"{len(table.rows)} of {len(table.rows)}", found=solved, met=met)
    if found:
        met = "yes" if max(found) <= RATIO_BAR else "NO"
        bars.add("the time at 1 mm to that at 10 mm, the most", bar=f"<= {RATIO_BAR:g}", found=max(found), met=met)
    return [table, bars]


def solve_one(problem: str, epsilon: float) -> dict[str, Any]:
    """A problem of the domains at one epsilon: seconds of the processor to prepare, to solve and to verify it."""
    import kabo
    from kabo.errors import InputError
    from kabo.service.warming import plan_once

    plan_once()
    loaded = kabo.load_problem(DOMAINS / problem)
    try:
        from kabo.geometry_server import prepare_scene

        began = _processor_seconds()
        made = prepare_scene(kabo.load_scene(loaded.scene), epsilon=epsilon)
        prepared = _processor_seconds() - began
        began = _processor_seconds()
        result = kabo.solve(loaded, epsilon=epsilon, timeout=LIMIT_S / 2)
    except InputError as error:
        return {"status": f"refused: {error.diagnostics[0].message}"}
    row: dict[str, Any] = {
        "parts": sum(each.parts for each in made),
        "preparing": prepared,
        "status": result.status,
        "solving": _processor_seconds() - began,
    }
    if result.plan is not None:
        began = _processor_seconds()
        row["verified"] = kabo.verify(loaded, result.plan).ok
        row["verifying"] = _processor_seconds() - began
    return row


def main() -> None:
    """Runs the sections that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sections", nargs="*", help="ready, epsilon (default: both)")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="robots or problems")
    parser.add_argument("--epsilon", type=float, nargs="+", default=[], metavar="E", help="in metres")
    parser.add_argument("--output", type=Path, help="write the tables as JSON")
    options = parser.parse_args()
    sections = options.sections or ["ready", "epsilon"]
    if set(sections) - {"ready", "epsilon"}:
        parser.error("the sections are ready and epsilon")
    unknown = set(options.only) - {*ROBOTS, *PROBLEMS}
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}; known: {', '.join([*ROBOTS, *PROBLEMS])}")
    tables: list[Table] = []
    for section in sections:
        if section == "ready":
            for epsilon in options.epsilon or [USUAL]:
                tables += ready(options.only, epsilon)
        else:
            tables += by_epsilon(options.only, options.epsilon or EPSILONS)
    finish(tables, options.output, only=options.only, epsilon=options.epsilon)


if __name__ == "__main__":
    if sys.argv[1:2] == ["prepare"]:
        print(json.dumps(prepare_one(sys.argv[2], float(sys.argv[3]), sys.argv[4])))
    elif sys.argv[1:2] == ["solve"]:
        print(json.dumps(solve_one(sys.argv[2], float(sys.argv[3]))))
    else:
        main()
