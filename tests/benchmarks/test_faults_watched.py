"""The watcher of runs with faults: silent about a run that is as its log says, and not about logs that were changed."""

import copy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.execution import Answer, ExecutionSettings, Interruption, KinematicRobot, KnownTruth, execute
from kabo.plan import Plan
from kabo.recovery import Replanner
from kabo.scene import Attachment, Scene

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "benchmarks"))
Watcher = pytest.importorskip("execution_faults_watched").Watcher
Records = list[dict[str, Any]]


class Keeping(Replanner):
    """Keeps the plans that it answers with."""

    plans: list[tuple[str, Plan]]

    def answer(self, interruption: Interruption) -> Answer:
        found = super().answer(interruption)
        if found.plan is not None:
            self.plans.append((found.kind, found.plan))
        return found


class Pushed(KinematicRobot):
    """A robot in whose world a block is pushed."""

    pushed = False

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        if not self.pushed and self.time > 0.4:
            self.pushed = True
            x, y, z = self.world.objects["o1"].position
            self.world = self.world.replace({"o1": Attachment("world", (x + 0.014, y, z), (0.0, 0.0, 0.0, 1.0))})


@pytest.fixture(scope="module")
def run() -> tuple[Scene, list[tuple[str, Plan]], Records]:
    problem = kabo.load_problem(ROOT / "domains" / "stacked" / "n2.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    scene = kabo.load_scene(problem.scene)
    robot, recovery = Pushed(scene), Keeping(problem, scene)
    recovery.plans = [("first", plan)]
    sensor, settings = KnownTruth(poses=robot.poses), ExecutionSettings(log_rate=50.0)
    found = execute(plan, scene, robot, sensor, settings, recovery=recovery)
    assert found.reached_goal and len(recovery.plans) > 1
    return scene, recovery.plans, found.log.records


def said(run: tuple[Scene, list[tuple[str, Plan]], Records], records: Records) -> list[str]:
    found: list[str] = Watcher(run[0], run[1]).replay(records)
    return found


def test_a_run_that_stopped_for_a_reason_and_went_on_is_in_order(
    run: tuple[Scene, list[tuple[str, Plan]], Records],
) -> None:
    assert said(run, run[2]) == []


def test_robots_and_bodies_that_are_not_where_they_should_be_are_seen(
    run: tuple[Scene, list[tuple[str, Plan]], Records],
) -> None:
    for change in ("robots", "bodies"):
        records = copy.deepcopy(run[2])
        for record in records:
            if record["event"] == "state" and 3.0 < record["time"] < 5.0:
                if change == "robots":
                    record["robots"]["mobile"][0] += 0.05
                else:
                    place: Array = np.array(record["bodies"]["o2"]["position"]) + (0.0, 0.03, 0.0)
                    record["bodies"]["o2"]["position"] = place.tolist()
        assert any("the run goes on, though" in each for each in said(run, records)), change


def test_a_body_that_nobody_sees_is_missed(run: tuple[Scene, list[tuple[str, Plan]], Records]) -> None:
    records = copy.deepcopy(run[2])
    for record in records:
        if record["event"] == "state" and record["time"] > 2.0:
            del record["bodies"]["o1"]
    assert any("o1 has not been seen" in each for each in said(run, records))


def test_what_goes_on_without_an_answer_and_reasons_that_are_not_true_are_told(
    run: tuple[Scene, list[tuple[str, Plan]], Records],
) -> None:
    stopped = next(k for k, record in enumerate(run[2]) if record["event"] == "answer")
    moving = next(k for k, record in enumerate(run[2]) if k > stopped and record["event"] == "moving")
    without = [*run[2][:stopped], {**run[2][stopped], "kind": "none"}, *run[2][stopped + 1 : moving + 1]]
    assert any("without an answer to the stop before" in each for each in said(run, without))
    false = [
        {**record, "reason": "o2 is 20 mm from where it was put"} if record["event"] == "stopping" else record
        for record in run[2]
    ]
    assert any("which no record shows" in each for each in said(run, false))
    assert any("does not end" in each for each in said(run, run[2][:-1]))
