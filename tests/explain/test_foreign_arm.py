"""The thirteen reasons on a UR5 with jaws that kabo does not ship: headline, numbers, proven or not, and in time."""

import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest

from kabo.explain.explain import Explanation, explain, explanation_to_json
from kabo.geometry_server import start_findings
from kabo.language import load_problem
from kabo.language.recorded_paths import installed_folder
from kabo.plan import schema
from kabo.planner.result import Result
from kabo.planner.solve import solve
from tests.explain.foreign import AT, TWO_ARMS, cups

pytestmark = pytest.mark.skipif(
    installed_folder("example-robot-data") is None, reason="the extra `robots` is not installed"
)
SCHEMA = schema("kabo-explain-1")
PICK = "pick(arm, cup)"


def explained(path: Path, **options: Any) -> Explanation:
    """The explanation with the limits of the command line, time excepted: samples end it."""
    found = explain(load_problem(path), timeout=600.0, **options)
    jsonschema.validate(explanation_to_json(found), SCHEMA)
    return found


def solved(path: Path, **options: Any) -> Result:
    return solve(load_problem(path), timeout=600.0, certificate=False, **options)


def reasons(result: Result) -> list[str]:
    assert result.reason is not None
    return list(result.reason.details)


def base_in(text: str) -> np.ndarray:
    found = re.search(r"would do (?:[\d.]+ mm away, )?at \(([-\d.e]+), ([-\d.e]+), ([-\d.e]+)\)", text)
    assert found is not None, text
    return np.array([float(each) for each in found.groups()])


def warnings(path: Path) -> list[str]:
    scene = load_problem(path).scene
    assert scene is not None
    return [finding.message for finding in start_findings(scene, parts=False)]


# ------------------------------------------------------------------------------------------------------- out of reach
def test_a_cup_far_away_ends_solving_before_its_samples_with_a_base_that_does(tmp_path: Path) -> None:
    """With 5,000,000 samples permitted the run ends after some ten thousand: nothing of the arm's reach is near."""
    result = solved(cups(tmp_path, at={"cup": (1.05, -0.25, 0.05)}))
    assert result.status == "exhausted" and result.statistics["inverse_kinematics_calls"] < 100_000
    (said,) = reasons(result)
    far = re.search(r"pick\(arm, cup\): cup is out of reach of arm by ([\d.]+) mm", said)
    assert far is not None
    base = base_in(said)
    assert abs(1000.0 * float(np.linalg.norm(base)) - float(far[1])) < 1.0
    moved = {"arm": base * (1.0 + 0.02 / float(np.linalg.norm(base)))}  # 2 cm more: the approach needs room, too
    assert solved(cups(tmp_path, at={"cup": (1.05, -0.25, 0.05)}, robots=moved)).status == "solved"


@pytest.mark.slow
def test_a_cup_far_away_is_explained(tmp_path: Path) -> None:
    found = explained(cups(tmp_path, at={"cup": (1.05, -0.25, 0.05)}), changes=1)
    assert found.summary[0] == f"No plan was found: {PICK} never succeeded."
    assert found.summary[1].startswith("It is out of reach by 0.") and "its base would do at" in found.summary[1]
    assert found.summary[2].startswith("With the base of arm moved by")


@pytest.mark.parametrize("joint", ["elbow_joint", pytest.param("shoulder_lift_joint", marks=pytest.mark.slow)])
def test_a_joint_that_turns_by_seven_degrees_either_way_is_named_first(joint: str, tmp_path: Path) -> None:
    home = {"elbow_joint": 90, "shoulder_lift_joint": -90}[joint]
    limits = f"limits: {{{joint}: [{home - 7} deg, {home + 7} deg]}}"
    result = solved(cups(tmp_path, limits=limits))
    assert result.status == "exhausted" and result.statistics["inverse_kinematics_calls"] < 100_000
    (said,) = reasons(result)
    found = re.search(rf"{PICK[:4]}.*: {joint} of arm would have to be at ([-\d.]+) deg, its limits are", said)
    assert found is not None, said
    need = float(found[1])
    wide = f"limits: {{{joint}: [{min(need, home) - 25} deg, {max(need, home) + 25} deg]}}"
    assert solved(cups(tmp_path, limits=wide)).status == "solved"


def test_a_base_too_far_away_is_a_proof_that_says_where_it_would_do(tmp_path: Path) -> None:
    path = cups(tmp_path, robots={"arm": (-0.9, 0.0, 0.0)})
    result = solved(path)
    assert result.status == "no_plan"
    said = next(each for each in reasons(result) if each.startswith(PICK))
    assert re.search(r"cup is 0\.\d+ m out of reach of arm by the lengths of its links alone", said)
    base = base_in(said)
    assert said.endswith("and is at (-0.9, 0, 0)") and base[0] > -0.6
    inner = base + np.array([0.02, 0.0, 0.0])
    near = cups(tmp_path, robots={"arm": inner})
    assert solved(near).status == "solved"


# ----------------------------------------------------------------------------------------------------------- widths
def test_jaws_that_open_less_than_the_cup_is_wide_are_told_with_both_and_proven(tmp_path: Path) -> None:
    path = cups(tmp_path, radius=0.061)
    result = solved(path)
    assert result.status == "no_plan"
    text = (
        "cup is 122 mm wide where grasp above holds it, the gripper of arm opens 110 mm: 12 mm too little, proven"
    )
    assert reasons(result) == [f"{PICK}: {text}"]
    found = explained(path)
    assert found.verdict == "proved" and found.summary[1] == f"{text}."
    (measure,) = found.findings[0].measures
    assert measure.proven and abs(measure.required - 0.11) < 1e-9 and abs(measure.found - 0.122) < 1e-4


def test_a_shelf_narrower_than_the_cup_is_a_proof(tmp_path: Path) -> None:
    result = solved(cups(tmp_path, box=(0.05, 0.2, 0.2)))
    assert result.status == "no_plan"
    text = "cup is at least 68 mm wide along the x axis of shelf, which has 50 mm: 18 mm too much, proven"
    assert reasons(result) == [f"place(arm, cup, shelf): {text}"]


# -------------------------------------------------------------------------------------------------------- the start
BLOCK = {"block": ((0.2, 0.2, 0.3), (0.5, -0.25, 0.15))}


def test_a_cup_that_begins_inside_a_plinth_can_provably_not_be_grasped(tmp_path: Path) -> None:
    result = solved(cups(tmp_path, walls=BLOCK))
    assert result.status == "no_plan"
    assert reasons(result)[-1] == f"{PICK}: cup begins inside block, up to 100 mm deep, proven"


@pytest.mark.slow
def test_two_cups_in_one_place_are_a_proof_for_both(tmp_path: Path) -> None:
    path = cups(tmp_path, at={"cup": AT, "cup_2": (0.53, -0.25, 0.05)})
    result = solved(path)
    assert result.status == "no_plan"
    assert any(
        re.search(r"cup and cup_2 overlap at the start, by up to 29.9 mm, proven", each)
        for each in reasons(result)
    )


@pytest.mark.slow
def test_a_cup_inside_a_plinth_is_explained_by_where_it_begins(tmp_path: Path) -> None:
    found = explained(cups(tmp_path, walls=BLOCK))
    assert found.verdict == "proved"
    assert found.summary[1:] == (
        "cup begins inside block, up to 100 mm deep, proven.",
        "Without block a plan of 2 actions exists.",
    )


def test_a_cup_that_hangs_in_the_air_is_a_warning_with_its_height(tmp_path: Path) -> None:
    path = cups(tmp_path, at={"cup": (0.5, -0.25, 0.25)})
    assert warnings(path) == ["cup hangs in the air at the start: 200 mm above table"]


# ------------------------------------------------------------------------------------------------------- in the way
@pytest.mark.slow
def test_a_roof_is_blamed_and_leaving_it_out_helps(tmp_path: Path) -> None:
    found = explained(cups(tmp_path, walls={"roof": ((0.3, 0.3, 0.01), (0.5, -0.25, 0.16))}))
    assert found.summary[0] == f"No plan was found: {PICK} never succeeded."
    assert found.summary[1].startswith("It was blocked by roof in ")
    assert found.summary[2] == "Without roof a plan of 2 actions exists."


@pytest.mark.slow
def test_a_wall_between_two_arms_is_told_of_the_hand_over(tmp_path: Path) -> None:
    wall = {"wall": ((1.0, 0.03, 1.6), (0.6, 0.0, 0.8))}
    given: dict[str, Any] = {"robots": TWO_ARMS, "at": {"cup": (0.4, -1.0, 0.05)}, "side": 1.0}
    found = explained(cups(tmp_path, walls=wall, **given), changes=1)
    handed = "pick(left, cup) never succeeded after right had put cup down: right cannot hand it over to left."
    assert found.summary[0].endswith(handed)
    assert found.summary[1].startswith("It was blocked by wall in ")
    assert re.match(r"Without wall a plan of \d actions exists\.", found.summary[2])


# -------------------------------------------------------------------------------------------- knowledge and epsilon
def test_a_goal_that_contradicts_itself_is_proven_and_names_both_parts(tmp_path: Path) -> None:
    found = explained(cups(tmp_path, goal="K(at(cup, shelf))\nK(not at(cup, shelf))"))
    assert found.verdict == "proved" and found.findings == ()
    assert "K(at(cup, shelf)) and K(not at(cup, shelf))" in str(found)


def test_solving_says_that_epsilon_alone_decides_and_one_that_does(tmp_path: Path) -> None:
    """The forearm and the last but one link of a UR5 are never 30 mm apart: with that epsilon it collides with itself."""
    path = cups(tmp_path, epsilon=0.03)
    said = reasons(solved(path, max_samples=40_000))[0]
    assert said.startswith(PICK)
    found = re.search(r"are ([\d.]+) mm apart, nearer than epsilon = 30 mm \(try --epsilon ([\d.]+)\)", said)
    assert found is not None and said.endswith("only because of epsilon")
    assert 0.0 < float(found[2]) <= min(float(found[1]) / 1000.0, 0.015)
    assert solved(path, epsilon=float(found[2])).status == "solved"


@pytest.mark.slow
def test_explaining_says_that_epsilon_alone_decides_with_the_distance(tmp_path: Path) -> None:
    found = explained(cups(tmp_path, epsilon=0.03))
    assert re.match(
        r"It was refused only because of epsilon = 0\.03 in .*: arm\.\w+ and arm\.\w+ are [\d.]+ mm apart",
        found.summary[1],
    )
    assert found.summary[2] == "With epsilon = 0.0075 a plan of 2 actions exists."
    (alone,) = (each for each in found.findings[0].measures if each.epsilon)
    assert alone.required < alone.found == 0.03
