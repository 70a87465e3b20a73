"""After a surprise: on to the end of the node or back, then the same actions or others, each proven; or a stop."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.execution import (
    Executed,
    Interruption,
    KinematicRobot,
    KnownTruth,
    Motion,
    Recovery,
    Run,
    Surprise,
    execute,
)
from kabo.execution.belief import Belief
from kabo.execution.interruptions import observed
from kabo.plan import Done, Plan, StateChange
from kabo.planner.geometry.relations import relations
from kabo.recovery import Replanner, way_back, way_on
from kabo.recovery.node_ways import NoWayError
from kabo.remote import check_begin
from kabo.scene import Attachment, Scene, link_poses, world_T
from kabo.scene.transforms import transform

DOMAINS = Path(__file__).parents[2] / "domains"


@pytest.fixture(scope="module")
def stacked() -> tuple[kabo.Problem, Scene, Plan]:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    return problem, kabo.load_scene(problem.scene), plan


class PushingRobot(KinematicRobot):
    """A robot in whose world one body is moved at a time."""

    def __init__(self, scene: Scene, body: str, when: float, shift: tuple[float, float, float]) -> None:
        super().__init__(scene)
        self.body, self.when, self.shift = body, when, shift

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        own = self.world.objects[self.body]
        if self.time >= self.when and own.parent == "world":
            x, y, z = (a + b for a, b in zip(own.position, self.shift, strict=True))
            self.world = self.world.replace({self.body: Attachment("world", (x, y, z), own.quaternion)})
            self.when = np.inf


def carried_out(
    case: tuple[kabo.Problem, Scene, Plan], robot: KinematicRobot, recovery: Recovery | None = None
) -> Run:
    problem, scene, plan = case
    helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    return execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=recovery or helper)


@pytest.mark.parametrize(("body", "when"), [("o1", 0.4), ("o1", 3.6), ("o2", 0.9), ("o2", 7.5)])
def test_a_body_that_was_pushed_is_put_where_the_new_plan_says(
    stacked: tuple[kabo.Problem, Scene, Plan], body: str, when: float
) -> None:
    problem, scene, plan = stacked
    robot = PushingRobot(scene, body, when, (0.014, -0.009, 0.0))
    run = carried_out(stacked, robot)
    assert run.reached_goal, run.reason
    kinds = [record["kind"] for record in run.log.of("answer")]
    assert kinds and set(kinds) <= {"finish", "undo", "repair", "replan"} and kinds[-1] in ("repair", "replan")
    assert run.state.geometry is not None
    poses = {name: world_T(scene, robot.world, name) for name in scene.movable}
    for name, pose in run.state.geometry.objects.items():
        assert np.allclose(poses[name], transform(pose.position, pose.quaternion), atol=1e-6), name
    assert np.allclose(poses["o2"][:2, 3], poses["o1"][:2, 3], atol=3e-3)  # stacked, wherever they were pushed
    assert kabo.solve(problem, start=run.state).plan.statistics.plan_actions == 0  # type: ignore[union-attr]


def test_nothing_is_planned_anew_for_what_the_proofs_cover(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    for number in range(12):
        angle = 2.0 * np.pi * number / 12.0
        robot = PushingRobot(stacked[1], "o1", 0.3, (0.004 * np.cos(angle), 0.004 * np.sin(angle), 0.0))
        run = carried_out(stacked, robot)
        assert list(run.log.of("answer")) == []


@pytest.mark.parametrize("told", [True, False])
def test_knowledge_of_what_has_left_its_support_is_what_the_domain_says_or_the_run_ends(
    stacked: tuple[kabo.Problem, Scene, Plan], told: bool
) -> None:
    problem, scene, plan = stacked
    if not told:
        problem = replace(problem, domain=replace(problem.domain, events={}))
    robot = PushingRobot(scene, "o1", 0.4, (0.0, -0.09, -0.01))  # from its stack to the floor
    run = carried_out((problem, scene, plan), robot)
    assert not robot.state().moving
    if told:
        assert run.reached_goal, run.reason
        assert Done("moved", {"this": "o1"}) in run.state.done
    else:
        assert not run.reached_goal and "o1 does not rest on stack_2 any more, but on floor" in run.reason
        assert "no event that says what is then known" in run.reason


def test_events_happen_and_no_plan_does_them(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    problem, _, plan = stacked
    node = replace(plan.nodes[plan.root], action="moved", arguments={"this": "o1"})
    report = kabo.verify(problem, replace(plan, nodes={**plan.nodes, plan.root: node}), knowledge_only=True)
    assert any("is an event: it happens, and nobody does it" in each.message for each in report.findings)
    state = kabo.after(problem, plan)
    fallen = replace(state, done=(Done("moved", {"this": "o1"}),))
    after = kabo.solve(problem, start=fallen, geometry="none").plan
    assert after is not None and all(each.action != "moved" for each in after.nodes.values())
    assert kabo.verify(problem, after, start=fallen, knowledge_only=True).ok


def test_without_a_recovery_a_surprise_ends_the_run(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    robot = PushingRobot(scene, "o1", 0.4, (0.02, 0.0, 0.0))
    run = execute(plan, scene, robot, KnownTruth(poses=robot.poses))
    assert not run.reached_goal and run.surprise is not None and list(run.log.of("answer")) == []


class CheckedRobot(KinematicRobot):
    """A robot that refuses to begin a motion where it is not, as a robot server does."""

    def follow(self, motion: Motion) -> None:
        check_begin(motion, self.state(), self.scene)
        super().follow(motion)


def test_a_plan_that_begins_elsewhere_is_planned_anew_from_where_the_robot_stands(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    scene = stacked[1]
    first = CheckedRobot(scene)
    assert carried_out(stacked, first).reached_goal
    again = CheckedRobot(scene, first.world)  # where the first run has left everything
    run = carried_out(stacked, again)
    assert run.reached_goal, run.reason
    turned = {"mobile": (0.4, *scene.start.robots["mobile"][1:])}
    run = carried_out(stacked, CheckedRobot(scene, scene.start.replace(turned)))
    assert run.reached_goal, run.reason
    first_answer = next(run.log.of("answer"))
    assert first_answer["kind"] == "repair" and next(run.log.of("moving"))["time"] >= first_answer["time"]


def test_a_hand_that_holds_what_the_plan_does_not_know_ends_the_run_before_anything_moves(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    robot = CheckedRobot(stacked[1])
    robot.grip("mobile", ())
    run = carried_out(stacked, robot)
    assert "the hand of mobile presses already" in run.reason and not list(run.log.of("moving"))


class Stubborn:
    """Answers every surprise with the plan that was surprised."""

    def __init__(self) -> None:
        self.asked: list[Interruption] = []

    def answer(self, interruption: Interruption) -> "kabo.execution.Answer":
        self.asked.append(interruption)
        return kabo.execution.Answer("repair", interruption.plan, "on as before")


def test_one_surprise_again_and_again_ends_the_run(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    recovery = Stubborn()
    run = carried_out(stacked, PushingRobot(stacked[1], "o1", 0.4, (0.02, 0.0, 0.0)), recovery)
    assert not run.reached_goal and "again and again" in run.reason
    kinds = [each.surprise.kind for each in recovery.asked]
    assert kinds == [
        "displaced",
        "elsewhere",
        "elsewhere",
        "elsewhere",
    ]  # the plan begins where no robot is any more


# ----------------------------------------------------------------------------------------------------------- ways
def interrupted(plan: Plan, node: str, segment: int, share: float) -> Interruption:
    """A run that stands within a segment of the plan's first node."""
    motion, start = plan.nodes[node].motion, plan.start
    assert start is not None
    executed = [Executed(node, number) for number in range(segment)]
    now = motion[segment]
    until = now.times[0] + share * (now.times[-1] - now.times[0])
    robots = {robot: dict(joints) for robot, joints in start.robots.items()}
    for each in motion[:segment]:
        robots[each.robot].update(zip(each.joints, each.waypoints[-1], strict=True))
    robots[now.robot].update(zip(now.joints, now.at(until).tolist(), strict=True))
    state = kabo.State((), StateChange(robots, start.objects))
    surprise = Surprise("displaced", "", "o1", 0.02, 0.01)
    return Interruption(plan, state, (*executed, Executed(node, segment, until)), (), surprise, start)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.93])
def test_ways_out_of_a_node_end_where_it_begins_and_ends_and_are_proven(
    stacked: tuple[kabo.Problem, Scene, Plan], share: float
) -> None:
    _, scene, plan = stacked
    interruption = interrupted(plan, plan.root, 0, share)
    back, on = way_back(interruption, scene), way_on(interruption, scene)
    for way in (back, on):
        report = kabo.verify(scene, way)
        assert report.ok, report
        assert way.certificate is not None
    first, last = plan.start, plan.nodes[plan.root].after
    reached = back.nodes["n0"].after
    assert first is not None and last is not None and reached is not None
    assert reached.robots["mobile"] == pytest.approx(first.robots["mobile"], abs=2e-9)
    found = on.nodes["n0"].after
    assert found is not None and found.robots["mobile"] == pytest.approx(last.robots["mobile"], abs=2e-9)
    for name, pose in last.objects.items():
        assert found.objects[name].position == pytest.approx(pose.position, abs=1e-6)


def test_a_way_that_is_blocked_is_not_proven(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    interruption = interrupted(plan, plan.root, 0, 0.9)
    assert interruption.state.geometry is not None
    hand = interruption.state.geometry
    q = tuple(hand.robots["mobile"].values())
    half = plan.nodes[plan.root].motion[0].at(0.5 * interruption.executed[0].until)  # type: ignore[operator]
    place = link_poses(scene.robots["mobile"], (*half, *q[len(half) :]))["left_finger"][:3, 3]
    moved = replace(hand.objects["o1"], position=tuple(map(float, place)))
    state = kabo.State((), replace(hand, objects={**hand.objects, "o1": moved}))
    blocked = way_back(replace(interruption, state=state), scene)
    assert not kabo.verify(scene, blocked).ok


def test_what_a_hand_has_lost_is_not_carried_on(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    interruption = replace(interrupted(plan, plan.root, 0, 0.5), lost=(("o2", "mobile"),))
    with pytest.raises(NoWayError, match="mobile has lost o2"):
        way_on(interruption, scene)


# ---------------------------------------------------------------------------------------------- what is observed
@pytest.mark.parametrize("seed", range(20))
def test_errors_of_measuring_are_taken_out_and_displacements_are_not(
    stacked: tuple[kabo.Problem, Scene, Plan], seed: int
) -> None:
    _, scene, plan = stacked
    dice, belief = np.random.default_rng(seed), Belief.at_start(scene, plan.start)
    pose = belief.poses()["o1"]
    tilt = transform((0.0, 0.0, 0.0), _quaternion(dice.normal(0.0, 1e-4, 3)))
    seen = pose @ tilt
    seen[:3, 3] = pose[:3, 3] + dice.uniform(-2e-4, 2e-4, 3)
    found, lost = observed(scene, plan, belief, {"o1": seen}, {})
    assert lost == () and found.objects["o1"].position == pytest.approx(tuple(pose[:3, 3]), abs=1e-8)
    shift, turn = dice.uniform(-0.05, 0.05, 2) + 0.002, float(dice.uniform(-3.0, 3.0))
    seen[:3, 3] += (*shift, 0.0)
    seen[:3, :3] = transform((0, 0, 0), (0.0, 0.0, np.sin(turn / 2), np.cos(turn / 2)))[:3, :3] @ seen[:3, :3]
    moved = observed(scene, plan, belief, {"o1": seen}, {})[0].objects["o1"]
    placed: Array = transform(moved.position, moved.quaternion)
    assert placed[:2, 3] == pytest.approx(seen[:2, 3], abs=1e-8) and placed[2, 3] == pytest.approx(
        pose[2, 3], abs=1e-8
    )
    assert placed[2, :3] == pytest.approx(pose[2, :3], abs=1e-8)  # upright as it was
    assert np.abs(placed[:3, :3] - seen[:3, :3]).max() < 1e-3


def _quaternion(small: Array) -> tuple[float, float, float, float]:
    x, y, z = (float(0.5 * value) for value in small)
    return x, y, z, float(np.sqrt(1.0 - x * x - y * y - z * z))


def test_relations_say_on_what_a_body_rests_and_whether_it_is_held(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    _, scene, plan = stacked
    assert plan.start is not None
    first = relations(scene, plan.start)
    assert first["o1"].supports and not first["o1"].regions and first["o1"].parent == "world"
    x, y, z = plan.start.objects["o1"].position
    for shift, same in (((0.01, 0.0, 0.0), True), ((0.0, 0.0, 0.05), False)):
        moved = replace(plan.start.objects["o1"], position=(x + shift[0], y, z + shift[2]))
        now = relations(scene, replace(plan.start, objects={**plan.start.objects, "o1": moved}))
        assert (now["o1"] == first["o1"]) is same and now["o2"] == first["o2"]
