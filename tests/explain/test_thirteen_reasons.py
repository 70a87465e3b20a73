"""Thirteen reasons why there is no plan, or why it is not the one that was meant: each is told with its numbers.

What is told is compared with what can be measured by hand on the meshes, without kabo's widths, depths and reach.
"""

import re
from collections.abc import Callable
from pathlib import Path

import jsonschema
import numpy as np
import pytest
import trimesh

from kabo.explain.explain import Explanation, explain, explanation_to_json
from kabo.geometry_server import start_findings
from kabo.language import load_problem
from kabo.plan import schema
from kabo.planner.result import Result
from kabo.planner.solve import solve
from tests.explain import infeasible

SCHEMA = schema("kabo-explain-1")
MESHES = Path(__file__).resolve().parents[2] / "meshes"
Make = Callable[[Path], Path]


def told(make: Make, folder: Path, samples: int = 2000, **options: object) -> Explanation:
    found = explain(load_problem(make(folder)), max_samples=samples, timeout=600.0, **options)  # type: ignore[arg-type]
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    return found


def solved(make: Make, folder: Path, samples: int = 2000) -> Result:
    return solve(load_problem(make(folder)), max_samples=samples, timeout=600.0)


def reasons(result: Result) -> str:
    assert result.reason is not None
    return "\n".join((result.reason.message, *result.reason.details))


def warnings(path: Path) -> list[str]:
    scene = load_problem(path).scene
    assert scene is not None
    return [finding.message for finding in start_findings(scene)]


def number(text: str, pattern: str) -> float:
    found = re.search(pattern, text)
    assert found is not None, text
    return float(found[1])


# ------------------------------------------------------------------------------------------------------- out of reach
def test_what_is_too_far_says_how_far_and_where_the_base_would_do(tmp_path: Path) -> None:
    found = told(infeasible.too_far, tmp_path, 4000, changes=0)
    assert found.summary[1].startswith("It is out of reach by 0.")
    far = number(found.summary[1], r"out of reach of mobile by ([\d.]+) mm")
    at = re.search(r"base would do at \(([-\d.]+), ([-\d.]+), 0\), and is at \(0, 0, 0\)", found.summary[1])
    assert at is not None
    assert abs(1000.0 * float(np.hypot(float(at[1]), float(at[2]))) - far) < 1.0
    assert f"by {far:g} mm" in reasons(solved(infeasible.too_far, tmp_path, 4000))
    near = tmp_path / "near"  # the arm reaches what stands as far from it as it would from there
    near.mkdir()
    x, y = 1.0 - float(at[1]), 0.18 - float(at[2])
    pad = f"stack_1: {{model: pad, pose: {{position: [{x - 0.01}, {y}, 0.005]}}}}"
    path = infeasible.stacked(near, scene=[(infeasible.PAD_1, pad)])
    assert solve(load_problem(path), max_samples=40_000).status == "solved"


def test_a_joint_at_its_limit_is_named_with_the_value_that_would_do(tmp_path: Path) -> None:
    found = told(infeasible.joint_limit, tmp_path, changes=0)
    said = found.summary[1]
    need = number(said, r"arm_joint_4 of mobile would have to be at ([\d.]+) deg, its limits are -5 deg to 5 deg")
    assert "arm_joint_4" in reasons(solved(infeasible.joint_limit, tmp_path))
    wide, tight = tmp_path / "wide", tmp_path / "tight"
    for folder in (wide, tight):
        folder.mkdir()
    enough = infeasible.joint_limit(wide, degrees=need + 40.0)  # the grasp, its way to it, and the lift
    assert solve(load_problem(enough), max_samples=40_000).status == "solved"
    short = infeasible.joint_limit(tight, degrees=need - 2.0)
    assert solve(load_problem(short), max_samples=2000).status != "solved"


# ---------------------------------------------------------------------------------------------------------- in the way
def test_a_roof_is_blamed_and_leaving_it_out_helps(tmp_path: Path) -> None:
    found = told(infeasible.roof, tmp_path)
    assert found.summary[1] == "It was blocked by board in 40 of 40 samples (100 %)."
    assert found.summary[2] == "Without board a plan of 1 action exists."


@pytest.mark.slow
def test_a_wall_between_two_arms_is_told_of_the_hand_over_and_not_of_the_last_pick(tmp_path: Path) -> None:
    found = told(infeasible.wall_between_arms, tmp_path, 20_000, changes=1)
    first = "pick(right, bottle_1) never succeeded after left had put bottle_1 down: left cannot hand it over to right."
    assert found.summary[0].endswith(first)
    assert found.summary[1].startswith("It was blocked by wall in ")
    assert found.summary[2].startswith("Without wall a plan of ")
    assert found.findings[0].needed and not any(finding.needed for finding in found.findings[1:])


# ------------------------------------------------------------------------------------------------------------- widths
def test_a_gripper_that_opens_less_than_a_cup_is_wide_is_told_with_both(tmp_path: Path) -> None:
    (said,) = warnings(infeasible.too_wide_for_the_gripper(tmp_path))
    cup = trimesh.load_mesh(MESHES / "cup" / "cup.stl")
    wide = 1800.0 * float(2.0 * np.linalg.norm(cup.vertices[:, :2], axis=1).max())
    assert abs(number(said, r"cup_1 is ([\d.]+) mm wide where grasp above holds it") - wide) < 0.3
    assert "the gripper of arm opens 110 mm" in said  # two fingers, 0.055 m each


@pytest.mark.parametrize("width", [0.05, 0.06])
def test_a_region_that_is_narrower_than_its_cup_is_a_proof(tmp_path: Path, width: float) -> None:
    cup = trimesh.load_mesh(MESHES / "cup" / "cup.stl")
    turns = np.linspace(0.0, np.pi, 2000)
    across = cup.vertices[:, :2] @ np.stack([np.cos(turns), np.sin(turns)])
    least = 1000.0 * float(np.ptp(across, axis=0).min())
    result = solved(lambda folder: infeasible.region_too_narrow(folder, width), tmp_path)
    assert result.status == "no_plan"
    said = reasons(result)
    assert abs(number(said, r"cup_1 is at least ([\d.]+) mm wide along the x axis of target") - least) < 0.1
    assert f"which has {1000 * width:g} mm: {round(least - 1000 * width, 1):g} mm too much, proven" in said
    found = told(lambda folder: infeasible.region_too_narrow(folder, width), tmp_path)
    assert found.verdict == "proved" and f"which has {1000 * width:g} mm" in found.summary[1]
    assert any("can contain no object" in text for text in warnings(tmp_path / "problem.yaml"))


def test_a_region_that_is_18_mm_too_low_is_a_proof(tmp_path: Path) -> None:
    result = solved(infeasible.region_too_low, tmp_path)
    assert result.status == "no_plan"
    assert "cup_1 stands 100 mm high on target_table, where target is 82 mm high" in reasons(result)
    assert "target is 18 mm too low, proven" in reasons(result)


def test_a_region_that_is_flush_with_its_support_works(tmp_path: Path) -> None:
    path = infeasible.flush_region(tmp_path)
    assert warnings(path) == []
    assert solve(load_problem(path), max_samples=40_000, timeout=600.0).status == "solved"


# ----------------------------------------------------------------------------------------------------------- the start
def test_a_cup_that_begins_inside_the_plinth_is_not_out_of_reach(tmp_path: Path) -> None:
    found = told(infeasible.inside_the_plinth, tmp_path, changes=0)
    depth = number(found.summary[1], r"^cup_1 begins inside plinth, up to ([\d.]+) mm deep, proven")
    # The farthest from the plinth's faces x = y = +-0.12, z = 0, z = 0.4 is what is near its axis: 0.25 m up.
    assert 110.0 < depth <= 120.0
    assert "cup_1 begins inside plinth" in reasons(solved(infeasible.inside_the_plinth, tmp_path))


def test_two_bottles_in_one_place_are_told_by_check_solve_and_explain(tmp_path: Path) -> None:
    (said,) = warnings(infeasible.bottle_in_bottle(tmp_path))
    assert said == "bottle_1 and bottle_2 overlap at the start, by up to 30 mm, proven"  # 60 mm wide, 30 mm apart
    assert said in reasons(solved(infeasible.bottle_in_bottle, tmp_path, 500))


@pytest.mark.parametrize("gap", [0.3, 0.02, 0.003])
def test_what_hangs_in_the_air_is_a_warning_with_its_height(tmp_path: Path, gap: float) -> None:
    (said,) = warnings(infeasible.floating(tmp_path, gap))
    assert abs(number(said, r"o1 hangs in the air at the start: ([\d.]+) mm above stack_2") - 1000.0 * gap) < 0.15


# ----------------------------------------------------------------------------------------------------------- knowledge
def test_a_goal_that_contradicts_itself_is_proven_and_names_both_parts(tmp_path: Path) -> None:
    found = told(infeasible.contradiction, tmp_path)
    assert found.verdict == "proved" and found.findings == ()
    assert "K(one_below(o1) = stack_1) and K(one_below(o1) = stack_3)" in str(found)


@pytest.mark.parametrize("make", [infeasible.no_sensing, infeasible.never_sensed])
def test_what_is_never_sensed_is_proven_and_named(tmp_path: Path, make: Make) -> None:
    found = told(make, tmp_path)
    assert found.verdict == "proved" and "spillable(cup_1)" in str(found)
    assert solved(make, tmp_path).status == "no_plan"


# ------------------------------------------------------------------------------------------------------------- epsilon
def test_what_only_epsilon_refuses_is_told_as_such(tmp_path: Path) -> None:
    found = told(infeasible.slot, tmp_path, changes=0)
    assert found.summary[1].startswith("It was refused only because of epsilon = 0.03 in ")
    assert found.summary[1].endswith("exact geometry would pass.")
    assert all(finding.because_of_epsilon == finding.refused for finding in found.findings)
    exact = solve(load_problem(infeasible.slot(tmp_path)), max_samples=4000, geometry="exact", timeout=300.0)
    assert exact.status == "solved"  # on the original meshes nothing is in the way
