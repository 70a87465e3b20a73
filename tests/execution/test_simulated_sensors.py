"""Sensors of a file in a world without forces: what is true decides, the seed repeats, errors are as frequent as stated."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.errors import InputError
from kabo.execution import (
    KinematicInstruments,
    KinematicRobot,
    Log,
    SimulatedSensors,
    execute,
    require_answers,
    true_start,
)
from kabo.execution.bound_sensors import Reading, answer_of
from kabo.execution.protocols import not_measured
from kabo.execution.simulated_sensors import NoInstruments, normals, rotation
from kabo.language import (
    CameraDescription,
    Measurement,
    SensorBinding,
    SensorsDescription,
    TruthDescription,
    load_sensors,
)
from kabo.plan import Plan
from kabo.scene import Scene, world_T
from kabo.streams import stream_key, uniforms

DOMAINS = Path(__file__).parents[2] / "domains"
YES_NO = ("false", "true")


class Scales:
    """Instruments that read one weight, and see one body."""

    def __init__(self, weight: float | None) -> None:
        self.weight, self.time = weight, 0.0

    def read(self, measurement: Measurement) -> Reading:
        return self.weight

    def poses(self) -> Mapping[str, Array]:
        return {"cup": np.eye(4)}


def weighing(wrong: float = 0.0, noise: float = 0.0, looks: int = 100, **more: object) -> SensorsDescription:
    binding = SensorBinding("full(cup)", YES_NO, Measurement("weight", ("cup",)), ">", 0.2, wrong, 1e-2, looks)
    return SensorsDescription("scales", {"full(cup)": binding}, weight_noise=noise, **more)  # type: ignore[arg-type]


@pytest.mark.parametrize(("weight", "answer"), [(0.1, "false"), (0.3, "true"), (None, None), (np.nan, None)])
def test_a_weight_is_compared_with_the_threshold(weight: float | None, answer: str | None) -> None:
    assert SimulatedSensors(weighing(), Scales(weight)).resolve("full(cup)", YES_NO) == answer


def test_what_was_not_measured_is_told_with_the_reason(stacked_scene: Scene) -> None:
    """A hand that holds nothing weighs nothing, and too few looks decide nothing."""
    robot = KinematicRobot(stacked_scene)
    weight = SensorBinding("full(o1)", YES_NO, Measurement("weight", ("o1",)), ">", 0.2)
    touch = SensorBinding("there(o1)", YES_NO, Measurement("contact", ("o1", "o2")))
    sensors = SensorsDescription("hand", {"full(o1)": weight, "there(o1)": touch})
    bound = SimulatedSensors(sensors, KinematicInstruments(robot))
    assert bound.resolve("full(o1)", YES_NO) is bound.resolve("there(o1)", YES_NO) is None
    assert not_measured(bound, "full(o1)") == "full(o1) was not measured: no hand holds o1"
    assert not_measured(bound, "there(o1)") == "there(o1) was not measured: robots without forces feel no contact"
    silent = SimulatedSensors(weighing(wrong=0.4, looks=3), Scales(0.3))
    assert silent.resolve("full(cup)", YES_NO) is None
    assert not_measured(silent, "full(cup)") == "full(cup) was not measured: 3 looks were not enough"
    broken = SimulatedSensors(weighing(), Scales(np.nan))
    assert broken.resolve("full(cup)", YES_NO) is None
    assert not_measured(broken, "full(cup)") == "full(cup) was not measured: there is no reading of weight(cup)"


@pytest.mark.parametrize(
    ("comparison", "reading", "answer"),
    [("<", 1.0, "false"), ("<=", 1.0, "true"), (">", 1.0, "false"), (">=", 1.0, "true"), ("not", True, "false")],
)
def test_comparisons(comparison: str, reading: Reading, answer: str) -> None:
    binding = SensorBinding("p", YES_NO, Measurement("weight", ("cup",)), comparison, 1.0)
    assert answer_of(binding, reading) == answer


def test_single_answers_are_wrong_as_often_as_stated_and_decisions_as_seldom() -> None:
    wrong, answers, decisions = 0.1, 0, 0
    sensors = weighing(wrong)
    for seed in range(2000):
        sensor = SimulatedSensors(sensors, Scales(0.3), seed=seed)
        answers += sensor.answer(sensors.bindings["full(cup)"], YES_NO) == "false"
        decisions += SimulatedSensors(sensors, Scales(0.3), seed=seed).resolve("full(cup)", YES_NO) == "false"
    assert answers / 2000 == pytest.approx(wrong, abs=0.02)
    assert decisions / 2000 < 0.01 + 0.006


def test_noise_has_its_spread_and_the_same_seed_gives_the_same_looks() -> None:
    sensors = weighing(noise=0.05)
    sensor, again = (SimulatedSensors(sensors, Scales(0.3), seed=1) for _ in range(2))
    read = [sensor.look(sensors.bindings["full(cup)"]) for _ in range(2000)]
    assert read == [again.look(sensors.bindings["full(cup)"]) for _ in range(2000)]
    assert np.mean(read) == pytest.approx(0.3, abs=0.005) and np.std(read) == pytest.approx(0.05, rel=0.05)


def test_each_decision_is_in_the_log_with_its_error() -> None:
    log = Log()
    SimulatedSensors(weighing(0.1), Scales(0.3), seed=2, log=log).resolve("full(cup)", YES_NO)
    (record,) = log.of("looked")
    assert record["asked"] == "full(cup)" and record["looks"] >= 3 and record["error"] <= 1e-2


def test_a_camera_sees_at_its_rate_with_noise_and_overlooks_bodies() -> None:
    camera = CameraDescription(("cup",), position=0.002, angle=0.01, dropout=0.2, rate=25.0)
    scales = Scales(None)
    sensor = SimulatedSensors(weighing(camera=camera), scales, seed=3)
    pictures = []
    for number in range(8000):
        scales.time = number / 100.0
        pictures.append(sensor.poses())
    seen = [each["cup"] for each in pictures if each]
    assert len(seen) == pytest.approx(0.8 * 80.0 * 25.0, rel=0.05)
    assert all(not each for number, each in enumerate(pictures) if number % 4)
    offsets = np.array([pose[:3, 3] for pose in seen])
    assert np.allclose(offsets.std(axis=0), 0.002, rtol=0.08) and np.allclose(offsets.mean(axis=0), 0.0, atol=2e-4)
    angles = [np.arccos(np.clip(0.5 * (np.trace(pose[:3, :3]) - 1.0), -1.0, 1.0)) for pose in seen]
    assert np.sqrt(np.mean(np.square(angles))) == pytest.approx(0.01 * np.sqrt(3.0), rel=0.08)


def test_normal_numbers_and_rotations_are_what_they_are_called() -> None:
    drawn = normals(uniforms(stream_key("normal"), 0, 1, 20_000)[0])
    assert drawn.mean() == pytest.approx(0.0, abs=0.03) and drawn.std() == pytest.approx(1.0, rel=0.03)
    assert np.mean(drawn**4) == pytest.approx(3.0, rel=0.1)
    turn = rotation(np.array([0.0, 0.0, np.pi / 2.0]))
    assert np.allclose(turn @ [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    assert np.allclose(rotation(np.array([0.3, -0.2, 0.5])) @ rotation(np.array([-0.3, 0.2, -0.5])), np.eye(3))


def test_true_places_are_off_by_the_seed_or_as_given_and_the_plan_does_not_know(stacked_scene: Scene) -> None:
    truth = TruthDescription(position=0.002, turn=0.01, displaced={"o2": ((0.03, 0.0, 0.0), 0.0)})
    start = true_start(stacked_scene, stacked_scene.start, truth, 5)
    assert start == true_start(stacked_scene, stacked_scene.start, truth, 5)
    assert start != true_start(stacked_scene, stacked_scene.start, truth, 6)
    for name in stacked_scene.movable:
        off = (world_T(stacked_scene, start, name) - world_T(stacked_scene, stacked_scene.start, name))[:3, 3]
        assert off[2] == pytest.approx(0.0, abs=1e-9)
        assert abs(off[0] - (0.03 if name == "o2" else 0.0)) < 0.01
    assert true_start(stacked_scene, stacked_scene.start, TruthDescription(), 5) == stacked_scene.start


@pytest.fixture(scope="module")
def doors() -> tuple[kabo.Problem, Plan]:
    problem = kabo.load_problem(DOMAINS / "doors" / "n3.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None
    return problem, plan


def test_what_no_instrument_reads_is_told_by_the_truth(doors: tuple[kabo.Problem, Plan], tmp_path: Path) -> None:
    problem, plan = doors
    (tmp_path / "sensors.yaml").write_text("sensors: eyes\nanswers:\n  open(c): {wrong: 0.1}\n")
    sensors = load_sensors(tmp_path / "sensors.yaml", problem)
    require_answers(plan, sensors)
    formula = next(str(node.on) for node in plan.nodes.values() if node.on)
    for answer in YES_NO:
        truth = TruthDescription(answers={formula: answer})
        run = execute(plan, None, None, SimulatedSensors(sensors, NoInstruments(), truth, seed=4))
        assert run.reached_goal and answer in [outcome for _, outcome in run.history]


def test_a_plan_whose_questions_nobody_answers_is_refused(doors: tuple[kabo.Problem, Plan]) -> None:
    with pytest.raises(InputError, match="which no sensor answers"):
        require_answers(doors[1], SensorsDescription("none", {}))
