"""Runs of plans without forces: to the goal, or to a stop with a true reason; never on from what no proof covers."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.errors import InputError
from kabo.execution import ExecutionSettings, KinematicRobot, KnownTruth, Log, Margins, execute
from kabo.plan import Plan
from kabo.recovery import Replanner
from kabo.scene import Scene, world_T

DOMAINS = Path(__file__).parents[2] / "domains"


class Pushed(KnownTruth):
    """Sees one body somewhere else, from a time on."""

    def __init__(self, robot: KinematicRobot, body: str, offset: Array, since: float) -> None:
        super().__init__(poses=robot.poses)
        self.robot, self.body, self.offset, self.since = robot, body, offset, since

    def poses(self) -> Mapping[str, Array]:
        found = {name: pose.copy() for name, pose in super().poses().items()}
        if self.robot.time >= self.since:
            found[self.body][:3, 3] += self.offset
        return found


def test_the_plan_is_carried_out_to_its_goal_and_all_is_logged(
    stacked_plan: Plan, stacked_scene: Scene, tmp_path: Path
) -> None:
    robot = KinematicRobot(stacked_scene)
    with (tmp_path / "log.jsonl").open("w") as file:
        run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses), log=Log(file))
    assert run.reached_goal and stacked_plan.nodes[run.node].kind == "goal"
    assert [node for node, _ in run.history] == walk(stacked_plan)
    records = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert records == run.log.records
    assert [each["event"] for each in records][0] == "start" and records[-1]["event"] == "goal"
    assert max(each["tracking"] for each in run.log.of("followed")) < 1e-6
    for name, change in ((n, stacked_plan.nodes[n].after) for n, _ in run.history):
        assert change is not None, name
    last = stacked_plan.nodes[run.history[-1][0]].after
    assert last is not None
    for body, pose in last.objects.items():
        placed = world_T(stacked_scene, robot.world, body)
        assert np.allclose(placed[:3, 3], pose.position, atol=1e-6)


def walk(plan: Plan) -> list[str]:
    """The nodes of a plan without branches, without its goal."""
    names, name = [], plan.root
    while plan.nodes[name].next is not None:
        names.append(name)
        name = str(plan.nodes[name].next)
    return names


@pytest.mark.parametrize("since", [0.0, 0.5, 3.0])
def test_a_body_farther_away_than_what_is_proven_stops_the_run(
    since: float, stacked_plan: Plan, stacked_scene: Scene
) -> None:
    margin = Margins(stacked_plan).of_rest(stacked_plan.root)
    robot = KinematicRobot(stacked_scene)
    sensor = Pushed(robot, "o2", np.array([1.2 * margin, 0.0, 0.0]), since)
    run = execute(stacked_plan, stacked_scene, robot, sensor)
    assert not run.reached_goal and run.surprise is not None and run.surprise.thing == "o2"
    assert run.surprise.off > run.surprise.permitted
    assert "o2 is" in run.reason and "proven to be free" in run.reason
    assert robot.time < since + 2.5
    assert not robot.state().moving
    assert max(np.abs(robot.state().velocities["mobile"])) < 1e-2


def test_a_body_within_what_is_proven_is_no_surprise(stacked_plan: Plan, stacked_scene: Scene) -> None:
    margin = Margins(stacked_plan).of_rest(stacked_plan.root)
    robot = KinematicRobot(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, Pushed(robot, "o2", np.array([0.9 * margin, 0.0, 0.0]), 0.0))
    assert run.reached_goal, run.reason


def test_who_asks_to_stop_is_obeyed_at_once(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, KnownTruth(poses=robot.poses), stop=lambda: robot.time > 0.4)
    assert not run.reached_goal and run.reason == "it was asked to stop"
    assert 0.4 < robot.time < 1.5 and not robot.state().moving
    assert [each["event"] for each in run.log.records][-2:] == ["stopping", "stopped"]


def test_a_plan_with_too_little_clearance_for_the_robot_is_refused(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    robot = KinematicRobot(stacked_scene)
    sensor = KnownTruth(poses=robot.poses)
    with pytest.raises(InputError, match="a clearance of .* is proven, and robots are up to 50 mm off"):
        execute(stacked_plan, stacked_scene, robot, sensor, ExecutionSettings(tracking_error=0.05))
    told = ExecutionSettings(tracking_error=0.05, despite_margins=True)
    assert execute(stacked_plan, stacked_scene, robot, sensor, told).reached_goal


@pytest.fixture(scope="module")
def doors() -> Plan:
    plan = kabo.solve(kabo.load_problem(DOMAINS / "doors" / "n3.yaml")).plan
    assert plan is not None
    return plan


def outcomes(run: "kabo.execution.Run") -> list[str]:
    return [outcome for _, outcome in run.history if outcome is not None]


def test_what_is_sensed_decides_the_branch_and_every_seed_reaches_a_goal(doors: Plan) -> None:
    seen = set()
    for seed in range(20):
        run = execute(doors, None, None, KnownTruth(seed=seed))
        assert run.reached_goal
        assert execute(doors, None, None, KnownTruth(seed=seed)).history == run.history
        seen.add(tuple(outcomes(run)))
    assert len(seen) > 1


def test_a_sensor_that_is_silent_or_contradicts_the_plan_stops_the_run(doors: Plan) -> None:
    class Silent(KnownTruth):
        def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
            return None

    run = execute(doors, None, None, Silent())
    assert not run.reached_goal and "was not measured" in run.reason
    formula = next(str(node.on) for node in doors.nodes.values() if node.on)
    run = execute(doors, None, None, KnownTruth({formula: "ajar"}, seed=1))
    assert "ajar" in run.reason and "no branch" in run.reason or run.reached_goal
    assert any(formula == each.get("formula") for each in run.log.records) or run.reached_goal


@pytest.fixture(scope="module")
def two_arms() -> tuple[Plan, Scene]:
    """A plan whose actions overlap: one arm begins before the other has ended."""
    problem = kabo.load_problem(DOMAINS / "circular_rearrange" / "n3.yaml")
    plan = kabo.solve(problem, quality="good").plan
    assert plan is not None and any(node.overlap > 0.0 for node in plan.nodes.values())
    return plan, kabo.load_scene(problem.scene)


@pytest.mark.slow
def test_two_arms_move_at_once_where_the_plan_overlaps(two_arms: tuple[Plan, Scene]) -> None:
    plan, scene = two_arms
    robot = KinematicRobot(scene)
    run = execute(plan, scene, robot, KnownTruth(poses=robot.poses))
    assert run.reached_goal, run.reason
    assert any(len(set(each["nodes"])) > 1 for each in run.log.of("moving"))
    assert max(each["tracking"] for each in run.log.of("followed")) < 1e-6
    alone = sum(
        max(s.times[-1] for s in plan.nodes[name].motion) for name, _ in run.history if plan.nodes[name].motion
    )
    overlaps = sum(plan.nodes[name].overlap for name, _ in run.history)
    moved = sum(each["end"] - each["begin"] for each in run.log.of("moving"))
    assert moved == pytest.approx(alone - overlaps, abs=1e-3)


class Hidden(KnownTruth):
    """Does not see a body from a time on."""

    def __init__(self, robot: KinematicRobot, body: str, since: float, until: float = np.inf) -> None:
        super().__init__(poses=robot.poses)
        self.robot, self.body, self.since, self.until = robot, body, since, until

    def poses(self) -> Mapping[str, Array]:
        hidden = self.since <= self.robot.time < self.until
        return {name: pose for name, pose in super().poses().items() if not hidden or name != self.body}


@pytest.mark.parametrize("since", [-1.0, 0.7, 5.0])
def test_a_body_that_is_not_seen_any_more_stops_the_run(
    since: float, stacked_plan: Plan, stacked_scene: Scene
) -> None:
    robot = KinematicRobot(stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, Hidden(robot, "o2", since))
    assert not run.reached_goal and run.surprise is not None
    assert (run.surprise.kind, run.surprise.thing) == ("gone", "o2")
    assert "o2 has not been seen for 1." in run.reason
    assert robot.time < max(since, 0.0) + 3.5 and not robot.state().moving


def test_a_body_that_is_hidden_for_a_moment_stops_nothing(stacked_plan: Plan, stacked_scene: Scene) -> None:
    robot = KinematicRobot(stacked_scene)
    assert execute(stacked_plan, stacked_scene, robot, Hidden(robot, "o2", 0.7, 1.6)).reached_goal


def test_who_sees_no_body_at_all_misses_none(stacked_plan: Plan, stacked_scene: Scene) -> None:
    assert execute(stacked_plan, stacked_scene, KinematicRobot(stacked_scene), KnownTruth()).reached_goal


@pytest.mark.parametrize(("silent", "reaches"), [(14, True), (15, False)])
def test_a_sensor_that_is_silent_is_asked_again_a_few_times(silent: int, reaches: bool, doors: Plan) -> None:
    class Slow(KnownTruth):
        left = silent

        def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
            self.left -= 1
            return None if self.left >= 0 else super().resolve(formula, outcomes)

    run = execute(doors, None, None, Slow())
    assert run.reached_goal is reaches
    assert len(list(run.log.of("silent"))) == 14


def test_a_body_that_is_seen_too_far_away_to_plan_with_counts_as_not_seen(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    """A simulator throws what overlaps, and a camera may err: no plan is looked for from a kilometre away."""
    robot = KinematicRobot(stacked_scene)
    sensor = Pushed(robot, "o1", np.array([1500.0, 0.0, 0.0]), 1.0)
    recovery = Replanner(kabo.load_problem(DOMAINS / "stacked" / "n2.yaml"), stacked_scene)
    run = execute(stacked_plan, stacked_scene, robot, sensor, recovery=recovery)
    assert not run.reached_goal and run.surprise is not None
    assert run.surprise.kind == "gone" and "o1 has not been seen" in run.reason
