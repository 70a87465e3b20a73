"""Surprises of all kinds without forces: hands that lose what they hold, robots that do not come back, ways that fail."""

import gc
import weakref
from collections.abc import Mapping
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.arrays import Array
from kabo.execution import Executed, Interruption, KinematicRobot, KnownTruth, Run, Surprise, execute
from kabo.execution.belief import Belief
from kabo.execution.interruptions import observed
from kabo.execution.protocols import RobotState
from kabo.plan import Plan, StateChange
from kabo.recovery import Replanner, way_back, way_open
from kabo.recovery.node_ways import NoWayError
from kabo.scene import Attachment, Scene, world_T
from kabo.scene.transforms import transform

DOMAINS = Path(__file__).parents[2] / "domains"


@pytest.fixture(scope="module")
def stacked() -> tuple[kabo.Problem, Scene, Plan]:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    return problem, kabo.load_scene(problem.scene), plan


def carried_out(case: tuple[kabo.Problem, Scene, Plan], robot: KinematicRobot) -> Run:
    problem, scene, plan = case
    helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    return execute(plan, scene, robot, KnownTruth(poses=robot.poses), recovery=helper)


def answers(run: Run) -> list[str]:
    return [record["kind"] for record in run.log.of("answer")]


# ------------------------------------------------------------------------------------------------- lost on the way
class DroppingRobot(KinematicRobot):
    """A robot whose hand closes to nothing at a time, while what it has held falls to the floor."""

    def __init__(self, scene: Scene, body: str, when: float, height: float) -> None:
        super().__init__(scene)
        self.body, self.when, self.height = body, when, height

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        if self.time >= self.when and self.world.objects[self.body].parent != "world":
            self.when = np.inf
            x, y, _ = world_T(self.scene, self.world, self.body)[:3, 3].tolist()
            own = self.scene.robots["mobile"]
            values = list(self.world.robots["mobile"])
            values[own.planned :] = [0.001] * (len(values) - own.planned)
            self._follower.loads.clear()
            fallen = Attachment("world", (x, y, self.height), (0.0, 0.0, 0.0, 1.0))
            self.world = self.world.replace({self.body: fallen, "mobile": tuple(values)})


@pytest.mark.parametrize("when", [2.6, 2.8])
def test_what_was_dropped_is_taken_again_from_where_it_lies(
    stacked: tuple[kabo.Problem, Scene, Plan], when: float
) -> None:
    run = carried_out(stacked, DroppingRobot(stacked[1], "o2", when, 0.02))
    assert run.reached_goal, run.reason
    assert answers(run)[-1] in ("repair", "replan")
    assert "hand" in next(iter(run.log.of("stopping")))["reason"]


# -------------------------------------------------------------------------------------------- hands that open first
def half_closed(case: tuple[kabo.Problem, Scene, Plan], share: float, shift: float) -> Interruption:
    """A run that stands while its hand closes on a body that was pushed into a finger."""
    _, scene, plan = case
    node, start = plan.nodes[plan.root], plan.start
    assert start is not None
    number = next(k for k, segment in enumerate(node.motion) if segment.attach)
    closing = node.motion[number]
    q = dict(start.robots["mobile"])
    for segment in node.motion[:number]:
        q |= dict(zip(segment.joints, segment.waypoints[-1], strict=True))
    until = closing.times[0] + share * (closing.times[-1] - closing.times[0])
    q |= dict(zip(closing.joints, closing.at(until).tolist(), strict=True))
    belief = Belief.at_start(scene, replace(start, robots={"mobile": q}))
    fingers = [world_T(scene, belief.state, link)[:3, 3] for link in scene.robots["mobile"].gripper.touch_links]  # type: ignore[union-attr]
    across = (fingers[1] - fingers[0]) / np.linalg.norm(fingers[1] - fingers[0])
    own = start.objects["o2"]
    x, y, z = (np.array(own.position) + shift * np.array([across[0], across[1], 0.0])).tolist()
    objects = {**start.objects, "o2": replace(own, position=(x, y, z))}
    state = kabo.State((), StateChange({"mobile": q}, objects))
    executed = (*(Executed(plan.root, k) for k in range(number)), Executed(plan.root, number, until))
    return Interruption(plan, state, executed, (), Surprise("displaced", "", "o2", shift, 0.004), start)


@pytest.mark.parametrize("shift", [0.004, -0.004])
def test_a_hand_that_closes_on_a_body_beside_its_place_opens_first(
    stacked: tuple[kabo.Problem, Scene, Plan], shift: float
) -> None:
    problem, scene, _ = stacked
    stands = half_closed(stacked, 0.97, shift)
    assert not kabo.verify(scene, way_back(stands, scene)).ok
    back = way_back(stands, scene, between={"o2": "mobile"})
    report = kabo.verify(scene, back)
    assert report.ok, report
    assert back.nodes["n0"].motion[0].detach == ("o2",)
    assert kabo.verify(scene, way_open(stands, scene, {"o2": "mobile"})).ok
    answer = Replanner(problem, scene).answer(stands)
    assert answer.kind == "undo" and answer.reason == "the way back with open hands is proven"


def test_a_hand_is_not_opened_onto_what_is_beside_it(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    problem, scene, _ = stacked
    stands = half_closed(stacked, 0.97, 0.04)  # where an open finger is
    with pytest.raises(NoWayError, match="overlap"):
        way_open(stands, scene, {"o2": "mobile"})
    answer = Replanner(problem, scene, {"timeout": 3.0}).answer(stands)
    assert answer.kind == "none" and "no way out of a contact with open hands: o2 and" in answer.reason, answer
    opened = replace(stands, executed=stands.executed[:-1])
    geometry = stands.state.geometry
    assert geometry is not None
    q = {**geometry.robots["mobile"], "finger_joint": 0.04}
    opened = replace(opened, state=kabo.State((), replace(geometry, robots={"mobile": q})))
    with pytest.raises(NoWayError, match="the hand of mobile is open"):
        way_open(opened, scene, {"o2": "mobile"})


# --------------------------------------------------------------------------------------- robots that do not come back
class BentRobot(KinematicRobot):
    """A robot of which one joint is somewhere else from a time on, for so long."""

    def __init__(self, scene: Scene, when: float, lasts: float) -> None:
        super().__init__(scene)
        self.when, self.until = when, when + lasts

    def state(self) -> RobotState:
        found = super().state()
        if not self.when <= self.time < self.until:
            return found
        q = found.positions["mobile"]
        return replace(found, positions={"mobile": (q[0] + 0.05, *q[1:])})


@pytest.mark.parametrize(("lasts", "reaches"), [(1.0, True), (np.inf, False)])
def test_from_where_no_robot_was_sent_nothing_goes_on(
    stacked: tuple[kabo.Problem, Scene, Plan], lasts: float, reaches: bool
) -> None:
    run = carried_out(stacked, BentRobot(stacked[1], 0.7, lasts))
    assert run.reached_goal is reaches
    if not reaches:
        assert "does not come back" in run.reason and "from where it was to stand" in run.reason
        assert answers(run) == []


# ------------------------------------------------------------------------------------------------- surprises on ways
class PushedOnWays(KinematicRobot):
    """A robot in whose world a body is pushed to and fro: in so many plans, and on the way out of the node after each."""

    def __init__(self, scene: Scene, rounds: int = 1) -> None:
        super().__init__(scene)
        self.left = 2 * rounds
        self.when = 0.9

    def follow(self, motion: object) -> None:
        super().follow(motion)  # type: ignore[arg-type]
        self.when = self.time + (0.1 if self.left % 2 else 0.9)

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        moving, own = self.state().moving, self.world.objects["o2"]
        if self.left and moving and self.time >= self.when and own.parent == "world":
            x, y, z = own.position
            side = 0.022 if self.left % 2 else -0.012  # on a way more is proven
            self.world = self.world.replace({"o2": Attachment("world", (x + side, y, z), own.quaternion)})
            self.left, self.when = self.left - 1, np.inf


def test_a_surprise_on_a_way_out_of_a_node_is_answered_from_there(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    robot = PushedOnWays(stacked[1])
    run = carried_out(stacked, robot)
    assert run.reached_goal, run.reason
    stops = [record["reason"] for record in run.log.of("stopping")]
    assert len(stops) == 2 and all("o2 is" in reason for reason in stops)
    assert answers(run)[0] in ("finish", "undo") and answers(run)[-1] in ("repair", "replan")
    poses = {name: world_T(stacked[1], robot.world, name) for name in stacked[1].movable}
    assert np.allclose(poses["o2"][:2, 3], poses["o1"][:2, 3], atol=3e-3)


def test_surprises_on_ways_out_of_a_node_do_not_count_as_no_progress(
    stacked: tuple[kabo.Problem, Scene, Plan],
) -> None:
    run = carried_out(stacked, PushedOnWays(stacked[1], rounds=2))
    assert run.reached_goal, run.reason
    assert len(list(run.log.of("stopping"))) == 4


# ------------------------------------------------------------------------------------------------- what stays in memory
@pytest.mark.parametrize("rounds", [0, 1])
def test_nothing_of_a_run_is_kept_when_it_has_ended(
    stacked: tuple[kabo.Problem, Scene, Plan], rounds: int
) -> None:
    """A ring of objects would be kept until garbage is collected, with megabytes of physics in it."""
    problem, scene, plan = stacked
    gc.disable()
    try:
        robot = PushedOnWays(scene, rounds)
        helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
        looks = count()
        stop = lambda: rounds == 0 and next(looks) > 50  # noqa: E731
        run = execute(plan, scene, robot, KnownTruth(poses=robot.poses), stop=stop, recovery=helper)
        assert any(True for _ in run.log.of("stopping"))
        kept = [weakref.ref(each) for each in (robot, run, run.log, helper)]
        del robot, run, helper
        assert [each() for each in kept] == [None] * 4
    finally:
        gc.enable()


# ------------------------------------------------------------------------------------------------- what is observed
def test_errors_of_measuring_stay_in_where_it_is_said(stacked: tuple[kabo.Problem, Scene, Plan]) -> None:
    _, scene, plan = stacked
    belief = Belief.at_start(scene, plan.start)
    seen: dict[str, Array] = {"o1": belief.poses()["o1"].copy()}
    seen["o1"][:3, 3] += (0.0, 0.0, 0.0009)
    turned = transform((0.0, 0.0, 0.0), (0.005, 0.0, 0.0, float(np.sqrt(1.0 - 0.005**2))))
    seen["o1"] = seen["o1"] @ turned
    cleaned, exact = (
        observed(scene, plan, belief, seen, {}, exact=each)[0].objects["o1"] for each in (False, True)
    )
    assert cleaned.quaternion == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=1e-9)
    assert np.allclose(transform(exact.position, exact.quaternion), seen["o1"], atol=1e-8)


# ----------------------------------------------------------------------------------------------------- sensors
class Contradicting(KnownTruth):
    """Says what cannot be, so often."""

    left = 3

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        self.left -= 1
        return "ajar" if self.left >= 0 else super().resolve(formula, outcomes)

    def poses(self) -> Mapping[str, Array]:
        return {}


def test_a_sensor_that_says_what_cannot_be_is_asked_again() -> None:
    plan = kabo.solve(kabo.load_problem(DOMAINS / "doors" / "n3.yaml")).plan
    assert plan is not None
    run = execute(plan, None, None, Contradicting(seed=1))
    assert run.reached_goal
    assert [record["said"] for record in run.log.of("silent")] == ["ajar"] * 3
