"""Hidden truth in physics: weights by the force at the wrist, which neither plan nor controller knows beforehand."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import KnownTruth, SimulatedSensors, execute
from kabo.language import Measurement, SensorBinding, SensorsDescription, TruthDescription, load_sensors
from kabo.simulation import ContactJudge, Physics, PhysicsInstruments, SimulatedRobot
from tests.conftest import PROPERTY_SCALE

pytest.importorskip("mujoco")
ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "execution"
FORCE_SENSING = ROOT / "domains" / "force_sensing" / "n1.yaml"
EMPTY, FULL = 0.02, 0.25  # [kg]; the scene says 0.05
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def cups() -> tuple[kabo.Problem, kabo.Plan, kabo.Scene]:
    problem = kabo.load_problem(FORCE_SENSING)
    plan = kabo.solve(problem).plan
    assert plan is not None
    return problem, plan, kabo.load_scene(FORCE_SENSING)


def sensors_for(problem: kabo.Problem, folder: Path, noise: float = 0.0) -> SensorsDescription:
    text = "sensors: wrist\nanswers:\n  spillable(o) when weight(o) > 0.1: {wrong: 0.05}\n"
    (folder / "sensors.yaml").write_text(f"{text}weight: {{noise: {noise}}}\n")
    return load_sensors(folder / "sensors.yaml", problem)


@pytest.mark.parametrize("mass", [EMPTY, FULL])
def test_force_sensing_takes_the_branch_of_the_true_weight(
    mass: float, cups: tuple[kabo.Problem, kabo.Plan, kabo.Scene], tmp_path: Path
) -> None:
    problem, plan, scene = cups
    masses = {"cup_1": mass}
    robot, judge = SimulatedRobot(scene, masses=masses), ContactJudge(scene)
    robot.judge = judge.look
    sensors = sensors_for(problem, tmp_path, 0.01)
    measured = []

    class Watched(PhysicsInstruments):
        def read(self, measurement: Measurement) -> float | bool | str | None:
            measured.append(super().read(measurement))
            return measured[-1]

    sensor = SimulatedSensors(sensors, Watched(robot, sensors), TruthDescription(masses=masses), seed=1)
    run = execute(plan, scene, robot, sensor)
    assert run.reached_goal, run.reason
    assert ("true" if mass == FULL else "false") in [outcome for _, outcome in run.history]
    assert len(measured) >= 3 and np.allclose(measured, mass, atol=0.002)
    assert judge.faults == {}
    place = robot.poses()["cup_1"][:3, 3]
    assert place[1] > 0.2 and place[2] == pytest.approx(0.4, abs=0.003)  # it stands on the other table


def test_the_controller_does_not_know_the_true_mass(cups: tuple[kabo.Problem, kabo.Plan, kabo.Scene]) -> None:
    scene = cups[2]
    heavy, light = Physics(scene, masses={"cup_1": FULL}), Physics(scene)
    assert heavy.model.body("cup_1").mass[0] == FULL and light.model.body("cup_1").mass[0] == 0.05
    assert heavy.expected_mass("cup_1") == light.expected_mass("cup_1") == 0.05
    inertia = heavy.model.body("cup_1").inertia / light.model.body("cup_1").inertia
    assert np.allclose(inertia, FULL / 0.05)


def test_what_is_in_no_hand_has_no_weight_and_contacts_are_felt(
    cups: tuple[kabo.Problem, kabo.Plan, kabo.Scene],
) -> None:
    robot = SimulatedRobot(cups[2])
    instruments = PhysicsInstruments(robot)
    assert instruments.read(Measurement("weight", ("cup_1",))) is None
    assert instruments.read(Measurement("contact", ("cup_1", "source_table"))) is True
    assert instruments.read(Measurement("contact", ("arm", "cup_1"))) is False
    wrong = SensorBinding("p", ("false", "true"), Measurement("contact", ("arm.left_finge", "cup_1")))
    with pytest.raises(kabo.InputError, match='arm has no link "left_finge"'):
        PhysicsInstruments(robot, SensorsDescription("some", {"p": wrong}))


@pytest.mark.parametrize("seed", [2, 9] if PROPERTY_SCALE >= 1.0 else [9])
def test_the_example_washes_the_empty_bottles_and_only_those(
    seed: int, capsys: pytest.CaptureFixture[str]
) -> None:
    runpy.run_path(str(EXAMPLE / "hidden_truth.py"))["main"]([seed])
    told = capsys.readouterr().out
    assert told.startswith(f"seed {seed}: the goal is reached") and told.rstrip().endswith("right")


@pytest.mark.parametrize("rate", [125.0, 250.0])
def test_at_a_low_rate_motors_go_on_between_setpoints(
    rate: float, cups: tuple[kabo.Problem, kabo.Plan, kabo.Scene]
) -> None:
    """Drives interpolate: the motion takes as long as at 1 kHz, and is followed as well."""
    _, plan, scene = cups
    found = {}
    for each in (1000.0, rate):
        robot = SimulatedRobot(scene, rate=each)
        run = execute(plan, scene, robot, KnownTruth(seed=1, poses=robot.poses))
        assert run.reached_goal, run.reason
        found[each] = robot.physics.time, max(record["tracking"] for record in run.log.of("followed"))
    (time, tracking), (slow, coarse) = found.values()
    assert slow == pytest.approx(time, abs=0.2)
    assert coarse < 1.5 * tracking + 5e-5
