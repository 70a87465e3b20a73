"""Sensors of a robot server: the truth stays there, and a client that asks decides as if they were its own."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import kabo
from kabo.execution import KinematicInstruments, KinematicRobot, SimulatedSensors
from kabo.language import Measurement, load_sensors, load_truth
from kabo.plan import Plan, write_plan
from kabo.remote import RemoteSensors, ServedSimulation, ZenohRobot
from kabo.service import client_config
from tests.remote.conftest import REPOSITORY, Started
from tests.service.conftest import free_endpoint

FOLDER = REPOSITORY / "examples" / "execution"
PROBLEM, SENSORS, TRUTH = (FOLDER / name for name in ("problem.yaml", "sensors.yaml", "truth.yaml"))
SERVED = ("--serve", "--kinematic", "--speed", 50, "--silence", 20)


@pytest.fixture(scope="module")
def plan() -> Plan:
    found = kabo.solve(kabo.load_problem(PROBLEM)).plan
    assert found is not None
    return found


def test_a_run_over_zenoh_finds_out_what_only_the_server_knows(
    plan: Plan, kabo_process: Callable[..., Started], tmp_path: Path
) -> None:
    write_plan(plan, tmp_path / "plan.json")
    endpoint = free_endpoint()
    given = ("--sensors", SENSORS, "--truth-file", TRUTH, "--seed", 3, "--endpoint", endpoint)
    server = kabo_process("simulate", PROBLEM, *SERVED, *given)
    server.wait_for("serves left, right")
    execute = ("execute", PROBLEM, tmp_path / "plan.json", "--no-verify", "--on", "zenoh", "--endpoint", endpoint)
    code, said = kabo_process(*execute, "--sensors", SENSORS, "-o", tmp_path / "log.jsonl").end()
    assert code == 0, said
    looked = {
        record["asked"]: record["outcome"]
        for record in map(json.loads, (tmp_path / "log.jsonl").read_text().splitlines())
        if record["event"] == "looked"
    }
    wanted = {1: "true", 2: "false", 3: "false", 4: "true"}  # truth.yaml: bottles 1 and 4 are empty
    assert looked == {f"empty_bottle(bottle_{number})": empty for number, empty in wanted.items()}
    code, said = kabo_process(*execute, "--sensors", SENSORS, "--truth-file", TRUTH).end()
    assert code == 2 and "only the robot server knows" in said and "Traceback" not in said


def test_a_server_that_only_measures_is_asked_for_weights_and_one_without_sensors_has_none(
    kabo_process: Callable[..., Started],
) -> None:
    problem, scene = kabo.load_problem(PROBLEM), kabo.load_scene(PROBLEM)
    sensors = load_sensors(SENSORS, problem)
    endpoint = free_endpoint()
    server = kabo_process("simulate", PROBLEM, *SERVED, "--endpoint", endpoint)
    server.wait_for("serves left, right")
    with ZenohRobot(client_config([endpoint]), scene) as robot:
        assert robot.read(Measurement("weight", ("bottle_1",))) is None
        assert RemoteSensors(sensors, robot).resolve("empty_bottle(bottle_1)", ("true", "false")) is None
        assert set(RemoteSensors(sensors, robot).poses()) == set(scene.movable)


def test_what_a_server_answers_is_as_noisy_and_as_wrong_as_its_sensor_file_says() -> None:
    problem, scene = kabo.load_problem(PROBLEM), kabo.load_scene(PROBLEM)
    sensors, truth = load_sensors(SENSORS, problem), load_truth(TRUTH, problem)
    robot = KinematicRobot(scene)
    robot.grip("left", ("bottle_1",))
    served = ServedSimulation(SimulatedSensors(sensors, KinematicInstruments(robot, truth), truth, 5))
    weight = Measurement("weight", ("bottle_1",))
    asked = "empty_bottle(bottle_1)"
    answers = [served.look(asked, weight, ("true", "false")) for _ in range(1000)]
    assert 5 <= answers.count("false") <= 40 and answers.count("true") + answers.count("false") == 1000
    weights = [served.look(asked, weight, None) for _ in range(200)]
    assert all(isinstance(each, float) and 0.0 < each < 0.2 for each in weights) and len(set(weights)) == 200
    assert served.look("empty_bottle(nothing)", weight, None) is None
    assert served.look(asked, Measurement("weight", ("bottle_2",)), None) is None


@pytest.mark.slow
def test_the_example_over_zenoh_finds_the_empty_bottles_in_physics() -> None:
    pytest.importorskip("mujoco")
    found = subprocess.run(
        [sys.executable, FOLDER / "over_zenoh.py", "9", "--silence", "20"],
        capture_output=True,
        text=True,
        timeout=900.0,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    assert "seed 9: the goal is reached" in found.stdout and found.stdout.rstrip().endswith("right"), found.stdout
    assert "washed ['bottle_1', 'bottle_4']" in found.stdout
