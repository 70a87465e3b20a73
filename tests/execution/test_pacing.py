"""The clock of a motion is slowed down within all limits, and so that late robots are near enough to their paths."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import (
    ExecutionSettings,
    Follower,
    KinematicRobot,
    KnownTruth,
    Log,
    Margins,
    Motion,
    RobotState,
    execute,
    motion_of,
)
from kabo.execution.belief import Belief
from kabo.execution.clock import Change, StopWhileChanging
from kabo.execution.motions import HandAction, parts_of
from kabo.execution.off_path import Off, OffPath
from kabo.execution.pacing import Pacer
from kabo.plan import Plan
from kabo.scene import Scene, motion_limits

DOMAINS = Path(__file__).parents[2] / "domains"
FINE = 10_000.0  # [Hz]: ten times finer than changes are checked


@pytest.fixture(scope="module")
def motion(stacked_plan: Plan, stacked_scene: Scene) -> Motion:
    return motion_of(stacked_plan, stacked_plan.root, stacked_scene)


@pytest.mark.parametrize("delay", [-0.15, -0.05, 0.0, 0.1])
def test_how_far_a_clock_comes_is_the_integral_of_its_rate(delay: float) -> None:
    seconds = np.linspace(0.0, 1.2, 120_001)
    change = Change(delay, 0.3, 0.9, 0.4)
    for law in (change, StopWhileChanging(change, Change(0.05, 0.6))):
        rate, first, second = law.rate(seconds)
        summed = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))]) * 1e-5
        passed = law.passed(seconds) - law.passed(np.array([0.0]))
        assert np.allclose(passed, summed, atol=1e-9)
        assert np.allclose(np.gradient(rate, 1e-5, edge_order=2), first, atol=1e-4)
        assert np.allclose(np.gradient(first, 1e-5, edge_order=2), second, atol=2e-2)
    assert float(law.rate(np.array([1.2]))[0][0]) == 0.0


def rows_of(follower: Follower, robot: str, joints: tuple[str, ...], until: float) -> np.ndarray:
    """What is sent until a time of the motion's clock (k, 3, joints): values and two derivatives."""
    rows = []
    while follower.moving and follower.time < until:
        for each in follower.advance(1.0 / FINE):
            if (each.robot, each.joints) == (robot, joints):
                rows.append(np.stack(each[2:]))
    return np.array(rows)


@pytest.mark.parametrize("rate", [0.1, 0.5, 0.85])
@pytest.mark.parametrize("share", np.linspace(0.05, 0.9, 8).tolist())
def test_a_slower_clock_and_back_keeps_all_limits_on_the_path(
    share: float, rate: float, motion: Motion, stacked_scene: Scene
) -> None:
    transfer = max(motion.stretches, key=lambda each: each.trajectory.duration)
    joints = transfer.trajectory.joints
    limits = motion_limits(stacked_scene.robots[transfer.robot], joints)
    follower, since = Follower(stacked_scene), transfer.begin + share * transfer.trajectory.duration
    follower.follow(motion)
    while follower.time < since:
        list(follower.advance(0.001))
    changed = follower.pace(rate)
    rows = [rows_of(follower, transfer.robot, joints, follower.time + 0.2)]
    back = follower.pace(1.0)
    rows.append(rows_of(follower, transfer.robot, joints, follower.time + 0.2))
    follower.stop()
    rows.append(rows_of(follower, transfer.robot, joints, transfer.end - 0.002))
    sent = np.concatenate([each for each in rows if len(each)])
    assert (np.abs(sent[:, 1]) <= limits.velocity * (1 + 1e-6)).all()
    for part, room in ((rows[0], 1e-6), (rows[1], 1e-6), (rows[2], 0.03)):  # a stop is checked each millisecond
        if len(part) > 1:
            assert (np.abs(part[:, 2]) <= limits.acceleration * (1.0 + room)).all()
            assert (np.abs(np.diff(part[:, 2], axis=0)) * FINE <= limits.jerk * (1.0 + room)).all()
    steps = np.diff(sent[:, 0], axis=0)
    assert np.allclose(steps * FINE, 0.5 * (sent[1:, 1] + sent[:-1, 1]), atol=1e-4)  # without a jump
    assert changed or share > 0.7
    assert isinstance(back, bool)


def test_a_motion_begins_at_the_rate_that_was_asked_for_before(motion: Motion, stacked_scene: Scene) -> None:
    follower = Follower(stacked_scene)
    follower.follow(motion)
    assert follower.pace(0.25)
    list(follower.advance(0.1))
    assert follower.time == pytest.approx(motion.begin + 0.025)
    with pytest.raises(ValueError, match="above 0 and at most 1"):
        follower.pace(0.0)


def late_run(
    plan: Plan, scene: Scene, delay: float | dict[str, float], stated: float = 0.0
) -> tuple[object, list[dict[str, object]]]:
    robot = KinematicRobot(scene, delay=delay)
    settings = ExecutionSettings(delay=stated)
    run = execute(plan, scene, robot, KnownTruth(poses=robot.poses), settings)
    return run, list(run.log.of("pace"))


@pytest.mark.parametrize("stated", [0.0, 0.02])
@pytest.mark.parametrize("delay", [0.02, 0.08])
def test_a_late_robot_that_moves_alone_is_on_its_path(
    delay: float, stated: float, stacked_plan: Plan, stacked_scene: Scene
) -> None:
    """Of where it should be at the time it is up to 13 mm off at 20 ms, and 10 mm are proven."""
    run, paces = late_run(stacked_plan, stacked_scene, delay, stated)
    assert run.reached_goal, run.reason
    assert all(each["tracking"] <= 0.3 * each["permitted"] for each in run.log.of("followed"))
    assert paces == []


def test_a_robot_that_is_on_its_path_is_never_slowed_down(stacked_plan: Plan, stacked_scene: Scene) -> None:
    run, paces = late_run(stacked_plan, stacked_scene, 0.0)
    assert run.reached_goal and paces == []


def test_a_robot_that_was_far_off_its_path_is_not_slow_for_ever(
    motion: Motion, stacked_plan: Plan, stacked_scene: Scene
) -> None:
    """Its brakes were on, and at a fiftieth of its speed it never moves as fast as is needed to tell how it strays."""
    pacer, belief = Pacer(stacked_scene.robots), Belief(stacked_scene, stacked_scene.start)
    pacer.strays["mobile"] = 2.0
    slow = pacer.begin(motion, belief, Margins(stacked_plan), {})
    assert slow is not None and slow.rate < 0.1
    rows = dict(stacked_scene.start.robots)
    for seconds in np.arange(0.01, 10.0, 0.01).tolist():
        clock = motion.begin + slow.rate * seconds
        path = OffPath(clock, {"mobile": Off(1e-6, 0.01, rows["mobile"])})
        pacer.learn(RobotState(seconds, clock, True, rows, {}), path)
    pacer.rate = slow.rate
    fast = pacer.wanted(motion.begin + slow.rate * 10.0)
    assert fast is not None and fast.rate == 1.0


def test_what_is_too_late_still_stops_the_run(stacked_plan: Plan, stacked_scene: Scene) -> None:
    run, _ = late_run(stacked_plan, stacked_scene, 0.5)
    assert not run.reached_goal and run.surprise is not None and run.surprise.kind == "tracking"
    assert run.surprise.off > Margins(stacked_plan).of_rest(stacked_plan.root)


@pytest.fixture(scope="module")
def two_arms() -> tuple[Plan, Scene]:
    problem = kabo.load_problem(DOMAINS / "circular_rearrange" / "n3.yaml")
    plan = kabo.solve(problem, quality="good").plan
    assert plan is not None and any(node.overlap > 0.0 for node in plan.nodes.values())
    return plan, kabo.load_scene(problem.scene)


@pytest.mark.slow
@pytest.mark.parametrize(("delay", "stated"), [(0.02, 0.0), (0.08, 0.0), (0.3, 0.3)])
def test_two_arms_that_are_both_as_late_are_on_their_path(
    delay: float, stated: float, two_arms: tuple[Plan, Scene]
) -> None:
    """Hands act while the other arm moves: when the arms are there, not when they should be."""
    on_time, _ = late_run(*two_arms, 0.0)
    run, paces = late_run(*two_arms, delay, stated)
    assert run.reached_goal, run.reason
    assert any(len(set(each["nodes"])) > 1 for each in run.log.of("moving"))
    assert all(each["share"] <= 0.3 for each in run.log.of("followed"))
    assert paces == []
    waited = run.log.records[-1]["time"] - on_time.log.records[-1]["time"]
    assert waited <= 2.0 * delay * len(list(run.log.of("moving")))


@pytest.mark.slow
def test_of_two_arms_one_of_which_is_later_the_clock_is_slower(two_arms: tuple[Plan, Scene]) -> None:
    run, paces = late_run(*two_arms, {"left": 0.045, "right": 0.04})
    assert run.reached_goal, run.reason
    assert paces and min(pace["rate"] for pace in paces) < 0.8
    assert all(each["share"] <= 1.0 for each in run.log.of("followed"))


@pytest.mark.slow
def test_a_panda_with_thin_clearances_may_be_late_all_the_same() -> None:
    """Some segments of this plan are proven to be free by hardly a millimetre."""
    problem = kabo.load_problem(DOMAINS.parent / "examples" / "two_cans" / "problem.yaml")
    plan, scene = kabo.solve(problem).plan, kabo.load_scene(problem.scene)
    assert plan is not None
    on_time, _ = late_run(plan, scene, 0.0)
    run, _ = late_run(plan, scene, 0.04)
    assert run.reached_goal, run.reason
    assert run.log.records[-1]["time"] <= 1.1 * on_time.log.records[-1]["time"]
    assert all(each["share"] <= 1.0 for each in run.log.of("followed"))


@pytest.mark.slow
@pytest.mark.parametrize("before", [0.05, 0.2])
def test_in_a_stop_a_hand_does_what_its_arm_passes(before: float, two_arms: tuple[Plan, Scene]) -> None:
    """A hand grips while the other arm moves; asked to stop just before, its arm goes on by a little, and not alone."""
    plan, scene = two_arms
    motion, action = passed_grip(plan, scene)
    robot = KinematicRobot(scene)
    log = Log()

    def is_due() -> bool:
        state = robot.state()
        begun = [each for each in log.of("moving") if set(each["nodes"]) == set(motion.nodes)]
        return bool(begun) and state.moving and state.motion_time > action.time - before

    run = execute(plan, scene, robot, KnownTruth(poses=robot.poses), log=log, stop=is_due)
    assert not run.reached_goal and run.reason == "it was asked to stop"
    stopped = robot.state().motion_time
    grips = [each for each in log.of("gripping") if each["bodies"] == [body for body, _ in action.attach]]
    held = robot.world.objects[action.attach[0][0]].parent.startswith(f"{action.robot}.")
    assert stopped > action.time and grips and held


def passed_grip(plan: Plan, scene: Scene) -> tuple[Motion, HandAction]:
    """A motion of both arms, and a grip in the middle of what the other one does."""
    for name in plan.nodes:
        if plan.nodes[name].motion:
            for part in parts_of(motion_of(plan, name, scene)):
                for action in part.actions:
                    if action.kind == "grip" and part.begin + 0.15 < action.time < part.end - 0.15:
                        return part, action
    raise AssertionError("no hand grips while the other arm moves")
