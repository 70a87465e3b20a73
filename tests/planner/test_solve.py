"""The integrated planner on the domains: lazy and eager, the same bytes in every process, and why there is no plan."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from kabo.language import Problem, load_problem
from kabo.plan import Plan, plan_statistics, plan_to_json
from kabo.planner.result import Result
from kabo.planner.solve import solve
from kabo.verify import verify_plan
from tests.planner.gantry import gantry_problem

ROOT = Path(__file__).resolve().parent.parent.parent
DOMAINS = ROOT / "domains"


def problem(name: str) -> Problem:
    return load_problem(DOMAINS / name)


@cache
def bartender() -> Result:
    return solve(problem("bartender/four_bottles.yaml"))


def plan_of(result: Result) -> Plan:
    assert result.plan is not None, result.reason
    return result.plan


def test_all_outcomes_of_bartender_end_in_the_goal_and_share_nodes() -> None:
    figures = plan_statistics(plan_of(bartender()))
    assert figures.plan_leaves == 16
    assert figures.plan_nodes <= 40
    assert verify_plan(problem("bartender/four_bottles.yaml"), plan_of(bartender())).ok


def test_somewhere_the_straight_way_is_blocked_and_gone_around() -> None:
    stages = {"reach", "transfer"}
    segments = [s for node in plan_of(bartender()).nodes.values() for s in node.motion if s.stage in stages]
    assert any(len(segment.waypoints) > 2 for segment in segments)


def test_every_seed_makes_its_own_plan() -> None:
    other = plan_of(solve(problem("bartender/four_bottles.yaml"), seed=1))
    assert other.nodes != plan_of(bartender()).nodes


def test_lazy_and_eager_geometry_find_plans_of_equal_length() -> None:
    lazy = solve(problem("stacked/n2.yaml"), search="breadth-first")
    eager = solve(problem("stacked/n2.yaml"), search="breadth-first", geometry_order="eager")
    assert plan_statistics(plan_of(lazy)).plan_actions == plan_statistics(plan_of(eager)).plan_actions == 3
    asked = [sum(row["calls"] for row in r.statistics["procedures"].values()) for r in (lazy, eager)]
    assert asked[0] == 3 < asked[1]


def test_exact_geometry_answers_the_same_questions() -> None:
    found = solve(problem("stacked/n2.yaml"), geometry="exact")
    assert plan_statistics(plan_of(found)).plan_actions == 3
    assert verify_plan(problem("stacked/n2.yaml"), plan_of(found)).ok


def test_without_geometry_the_same_actions_have_no_motion() -> None:
    found = plan_of(solve(problem("stacked/n2.yaml"), geometry="none"))
    assert found.start is None
    assert not any(node.motion for node in found.nodes.values())
    assert not verify_plan(problem("stacked/n2.yaml"), found).ok
    assert verify_plan(problem("stacked/n2.yaml"), found, knowledge_only=True).ok


def test_the_same_bytes_in_every_process_and_with_any_number_of_workers() -> None:
    code = (
        "import sys\n"
        "from kabo.language import load_problem\n"
        "from kabo.plan import plan_to_json\n"
        "from kabo.planner.solve import solve\n"
        f"plan = solve(load_problem({str(DOMAINS / 'force_sensing/n1.yaml')!r}), seed=5, workers=int(sys.argv[1])).plan\n"
        "sys.stdout.buffer.write(plan_to_json(plan))\n"
    )
    made = []
    for workers in ("1", "4"):
        environment = {**os.environ, "PYTHONHASHSEED": workers}
        program = [sys.executable, "-c", code, workers]
        run = subprocess.run(program, capture_output=True, env=environment, check=True)
        made.append(run.stdout)
    assert made[0] == made[1] == plan_to_json(plan_of(solve(problem("force_sensing/n1.yaml"), seed=5)))


@pytest.mark.parametrize("core", ["Prescott", "Haswell"])
def test_the_same_bytes_however_the_processor_adds(core: str) -> None:
    """OpenBLAS has other sums for each type of processor, and x86 processors can do those of older ones."""
    names = ("assembly/gearbox.yaml", "force_sensing/n1.yaml", "inspection/three_boxes.yaml")
    code = (
        "import hashlib, sys\n"
        "from kabo.language import load_problem\n"
        "from kabo.plan import plan_to_json\n"
        "from kabo.planner.solve import solve\n"
        "for file in sys.argv[1:]:\n"
        "    print(hashlib.sha256(plan_to_json(solve(load_problem(file), seed=5).plan)).hexdigest())\n"
    )
    program = [sys.executable, "-c", code, *(str(DOMAINS / name) for name in names)]
    environment = {**os.environ, "OPENBLAS_CORETYPE": core}
    run = subprocess.run(program, capture_output=True, env=environment, check=True, text=True)
    here = [plan_to_json(plan_of(solve(problem(name), seed=5))) for name in names]
    assert run.stdout.split() == [hashlib.sha256(each).hexdigest() for each in here]


def test_what_no_arm_reaches_is_proven_and_named() -> None:
    given = problem("bartender/four_bottles.yaml")
    assert given.scene is not None
    region = given.scene.regions["dishwasher"]
    away = replace(region, pose=replace(region.pose, frame="world", position=(5.0, 0.0, 0.2)))
    scene = replace(given.scene, regions={**given.scene.regions, "dishwasher": away})
    result = solve(replace(given, scene=scene))
    assert (result.status, result.plan) == ("no_plan", None)
    assert result.reason is not None
    assert result.reason.proved == "refusals"
    assert any("out of reach" in detail for detail in result.reason.details)


def test_what_knowledge_cannot_reach_is_proven_whatever_geometry_says() -> None:
    given = problem("stacked/n2.yaml")
    stuck = replace(given, initial=given.initial[1:])  # nobody knows what is on top of anything
    result = solve(stuck)
    assert result.status == "no_plan"
    assert result.reason is not None
    assert result.reason.proved == "knowledge"


@pytest.mark.parametrize(
    ("options", "budget"), [({"max_expansions": 5}, "expansions"), ({"timeout": 1e-3}, "time")]
)
def test_a_spent_budget_is_named(options: dict[str, float], budget: str) -> None:
    result = solve(problem("stacked/n4.yaml"), **options)  # type: ignore[arg-type]
    assert result.status == "exhausted"
    assert result.reason is not None
    assert result.reason.budget == budget


def test_every_file_that_was_read_is_in_the_plan() -> None:
    files = plan_of(bartender()).files
    assert {"four_bottles.yaml", "domain.yaml", "scene.yaml"} <= set(files)
    assert "../../meshes/arm6/arm6.urdf" in files
    assert "../../meshes/arm6/link_1.stl" in files


def test_a_robot_that_cannot_move_from_where_it_stands_is_told_before_planning(tmp_path):
    told: list[str] = []
    walls = {"post": ((0.1, 0.1, 0.2), (0.0, 0.0, 0.45))}
    problem = gantry_problem(tmp_path, walls=walls)
    result = solve(problem, progress=lambda progress: told.append(progress.line), max_samples=200)
    assert result.plan is None
    assert any("gantry cannot move from where it stands: gantry.mast and post" in line for line in told)
    told.clear()
    (tmp_path / "free").mkdir()
    solve(gantry_problem(tmp_path / "free"), progress=lambda progress: told.append(progress.line))
    assert not any("cannot move" in line for line in told)
