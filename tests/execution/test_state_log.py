"""States in a log: where things are, and where the plan has what is elsewhere."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import ExecutionSettings, KinematicRobot, KnownTruth, Log, Margins, execute
from kabo.plan import Plan
from kabo.scene import Scene
from tests.execution.test_executor import DOMAINS, Pushed

LOGGED = ExecutionSettings(log_rate=10.0)


def test_where_the_plan_has_a_body_that_is_off_is_told_beside_where_it_is(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    robot, offset = KinematicRobot(stacked_scene), np.array([0.004, 0.0, 0.0])
    run = execute(stacked_plan, stacked_scene, robot, Pushed(robot, "o2", offset, 1.0), settings=LOGGED)
    states = list(run.log.of("state"))
    assert len(states) > 20
    for each in states:
        assert each["planned"]["robots"] == {}, "the robot follows exactly"
        told = each["planned"]["bodies"]
        assert set(told) == ({"o2"} if each["time"] >= 1.0 else set())
        if told:
            seen = each["bodies"]["o2"]
            np.testing.assert_allclose(np.subtract(seen["position"], told["o2"]["position"]), offset, atol=2e-6)
            np.testing.assert_allclose(seen["quaternion"], told["o2"]["quaternion"], atol=2e-6)


def test_what_is_planned_of_a_robot_that_follows_otherwise_is_where_its_path_is(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    class Askew(KinematicRobot):
        """Its second joint is off by a tenth of a degree."""

        def state(self):
            state = super().state()
            own = [*state.positions["mobile"]]
            own[1] += 0.002
            return replace(state, positions={"mobile": tuple(own)})

    robot = Askew(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses), settings=LOGGED)
    states = [each for each in run.log.of("state") if each["tracking"] > 0.0]
    assert run.reached_goal and len(states) > 20
    for each in states:
        off = np.subtract(each["robots"]["mobile"], each["planned"]["robots"]["mobile"])
        np.testing.assert_allclose(off, np.eye(len(off))[1] * 0.002, atol=2e-5)


def test_each_node_begins_with_the_margins_of_bodies_that_something_limits(
    stacked_plan: Plan, stacked_scene: Scene, tmp_path: Path
) -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    report = kabo.verify(problem, stacked_plan, scene=stacked_scene)
    margins = Margins(stacked_plan, report)
    robot = KinematicRobot(stacked_scene)
    with (tmp_path / "log.jsonl").open("w") as file:
        run = execute(
            stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses), report=report, log=Log(file)
        )
    nodes = list(run.log.of("node"))
    assert [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()] == run.log.records
    limited = 0
    for each in nodes:
        rest = margins.rest(each["node"])
        assert rest is not None
        for body in stacked_scene.movable:
            slack = rest.radius(body)
            told = each["margins"].get(body)
            assert (told is None) == (slack.least == np.inf)
            if told is not None:
                assert told == {"least": pytest.approx(slack.least, abs=1e-6), "other": slack.other}
                limited += 1
    assert limited > 0


def test_a_run_without_the_report_of_a_check_tells_no_margins(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses))
    assert {each["margins"] for each in run.log.of("node")} == {None}
