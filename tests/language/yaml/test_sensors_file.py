"""Sensor files and truth files: what they bind for which objects, and what is said of mistakes in them."""

from pathlib import Path

import pytest

import kabo
from kabo.errors import InputError
from kabo.language import Measurement, check_files, load_sensors, load_truth

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "examples" / "execution"
HEAD = "sensors: some\nanswers:\n"


@pytest.fixture(scope="module")
def problem() -> kabo.Problem:
    return kabo.load_problem(EXAMPLE / "problem.yaml")


def faults(load, text: str, problem: kabo.Problem, folder: Path) -> list[tuple[int, int, str, str | None]]:
    (folder / "file.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        load(folder / "file.yaml", problem)
    return [(d.line, d.column, d.message, d.hint) for d in caught.value.diagnostics]


def test_a_formula_with_a_variable_is_bound_for_all_objects_of_its_type(problem: kabo.Problem) -> None:
    sensors = load_sensors(EXAMPLE / "sensors.yaml", problem)
    assert list(sensors.bindings) == [f"empty_bottle(bottle_{k})" for k in range(1, 5)]
    first = sensors.bindings["empty_bottle(bottle_1)"]
    assert first.measurement == Measurement("weight", ("bottle_1",))
    assert (first.comparison, first.threshold, first.wrong, first.error) == ("<", 0.25, 0.02, 1e-4)
    assert first.outcomes == ("false", "true") and first.least_looks == 3
    assert sensors.weight_noise == 0.02 and sensors.camera is None


def test_everything_that_a_file_may_say_is_read(problem: kabo.Problem, tmp_path: Path) -> None:
    (tmp_path / "file.yaml").write_text(
        HEAD
        + "  empty_bottle(bottle_1) when weight(bottle_1) <= 0.3:\n"
        + "  empty_bottle(bottle_2): {wrong: 0.1, error: 1e-3, looks: 50}\n"
        + "  hand_empty(r) when not contact(r, bottle_1): {}\n"
        + "  grasped(o) when contact(left.left_finger, o):\n"
        + "camera: {sees: [bottle_1], position: 2mm, angle: 1 deg, dropout: 0.1, rate: 25}\n"
        + "weight: {noise: 0.01, seconds: 0.2}\n"
    )
    found = load_sensors(tmp_path / "file.yaml", problem)
    assert found.bindings["empty_bottle(bottle_2)"].measurement == Measurement("told")
    assert found.bindings["empty_bottle(bottle_2)"].looks == 50
    assert found.bindings["hand_empty(right)"].measurement == Measurement("contact", ("right", "bottle_1"))
    assert found.bindings["hand_empty(right)"].comparison == "not"
    assert found.bindings["grasped(bottle_3)"].measurement.things == ("left.left_finger", "bottle_3")
    assert found.camera is not None and found.camera.bodies == ("bottle_1",)
    assert (found.camera.position, found.camera.dropout, found.camera.rate) == (0.002, 0.1, 25.0)
    assert found.weight_seconds == 0.2


@pytest.mark.parametrize(
    ("entry", "column", "message", "hint"),
    [
        ("empty_botle(o) when weight(o) < 1:", 3, 'no predicate or function "empty_botle"', 'mean "empty_bottle"'),
        ("empty_bottle(o) when wieght(o) < 1:", 24, 'no measurement "wieght"', 'did you mean "weight"?'),
        ("empty_bottle(o) when weight(p) < 1:", 16, '"o" is no object, and no variable', "there are bottle_1"),
        ("empty_bottle(bottle_5) when weight(bottle_5) < 1:", 16, 'there is no bottle "bottle_5"', "bottle_"),
        ("empty_bottle(left) when weight(left) < 1:", 16, '"left" is a robot', None),
        ("empty_bottle(o, o) when weight(o) < 1:", 3, "has 1 argument, not 2", "empty_bottle(bottle)"),
        ("empty_bottle(bottle_1) when weight(tap) < 1:", 38, "no body that moves", None),
        ("grasped(o) when contact(left_arm, o):", 27, 'no body or robot "left_arm"', 'did you mean "left"?'),
        ("empty_bottle(o) when weight(o):", 3, "a formula compares it", "write empty_bottle"),
        ("empty_bottle(o) is weight(o):", 3, "it is true or false", "write empty_bottle(…) when …"),
        ("empty_bottle(o) when weight(o) < heavy:", 3, '"heavy" is no number', "write"),
        ("empty_bottle(o) when weight(o) < 1: {wrong: 0.5}", 40, "from 0 to less than 0.5", "says nothing"),
        ("empty_bottle(o) when weight(o) < 1: {wrong: 0.1, looks: 3}", 3, "3 looks cannot bring", "at least 4"),
        ("empty_bottle(o) when weight(o) < 1: {rong: 0.1}", 40, 'unknown key "rong"', 'did you mean "wrong"?'),
    ],
)
def test_a_mistake_is_told_with_its_place_and_a_remedy(
    entry: str, column: int, message: str, hint: str | None, problem: kabo.Problem, tmp_path: Path
) -> None:
    (line, at, told, remedy) = faults(load_sensors, f"{HEAD}  {entry}\n", problem, tmp_path)[0]
    assert (line, at) == (3, column)
    assert message in told
    assert hint is None or (remedy is not None and hint in remedy)


def test_a_formula_is_answered_once(problem: kabo.Problem, tmp_path: Path) -> None:
    text = HEAD + "  empty_bottle(bottle_1):\n  empty_bottle(o) when weight(o) < 1:\n"
    ((line, _, message, _),) = faults(load_sensors, text, problem, tmp_path)
    assert line == 4 and message == "empty_bottle(bottle_1) has an answer already"


def test_the_camera_sees_only_bodies_of_the_scene(problem: kabo.Problem, tmp_path: Path) -> None:
    ((line, _, message, hint),) = faults(load_sensors, HEAD + "camera: {sees: [botle_1]}\n", problem, tmp_path)
    assert line == 3 and "botle_1" in message and hint == 'did you mean "bottle_1"?'


def test_a_truth_has_masses_places_and_answers(problem: kabo.Problem, tmp_path: Path) -> None:
    text = (
        "truth: one\nmasses: {bottle_1: 0.1}\nanswers: {empty_bottle(bottle_2): true}\n"
        "offsets: {position: 1mm, turn: 2 deg}\ndisplaced: {bottle_3: {by: [0.01, 0, 0]}}\n"
    )
    (tmp_path / "file.yaml").write_text(text)
    truth = load_truth(tmp_path / "file.yaml", problem)
    assert truth.masses == {"bottle_1": 0.1} and truth.answers == {"empty_bottle(bottle_2)": "true"}
    assert truth.position == 0.001 and truth.displaced["bottle_3"] == ((0.01, 0.0, 0.0), 0.0)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ("masses: {botle_1: 0.1}", 'no body "botle_1"'),
        ("masses: {tap: 0.1}", 'no body "tap"'),
        ("masses: {bottle_1: 0}", "must be greater than 0"),
        ("answers: {empty_bottle(o): true}", '"o" is no object'),
        ("answers: {empty_bottle(bottle_1): perhaps}", "no answer of empty_bottle"),
        ("mass: {}", 'unknown key "mass"'),
    ],
)
def test_a_mistake_in_a_truth_is_told(entry: str, message: str, problem: kabo.Problem, tmp_path: Path) -> None:
    found = faults(load_truth, f"truth: one\n{entry}\n", problem, tmp_path)
    assert found[0][0] == 2 and message in found[0][2]


def test_kabo_check_knows_both_kinds_of_files(tmp_path: Path) -> None:
    assert check_files([EXAMPLE / "sensors.yaml", EXAMPLE / "truth.yaml"]) == []
    (tmp_path / "sensors.yaml").write_text("sensors: some\nanswer: {}\n")
    (found,) = check_files([tmp_path / "sensors.yaml"])
    assert found.hint == 'did you mean "answers"?'
