"""Surprises where nodes end, and where several nodes have begun: what has ended counts as done, and a way leads out."""

from dataclasses import replace

import numpy as np
import pytest

import kabo
from kabo.execution import Executed, KinematicRobot, KnownTruth, Run, execute
from kabo.execution.interruptions import begun_nodes
from kabo.execution.protocols import RobotState
from kabo.plan import Plan
from kabo.recovery import Replanner
from kabo.scene import Attachment, Scene, world_T
from tests.planner.gantry import gantry_problem
from tests.support.two_gantries import two_gantries

Case = tuple[kabo.Problem, Scene, Plan]
Shift = tuple[float, float, float]
IN_THE_HAND = (0.0, 0.016, 0.0)  # [m]: more than is proven of what the hand holds, and less than makes it lost


class Shifting(KinematicRobot):
    """A robot in whose world a body is shifted once [m], on its support or in a hand, as seen in the world."""

    def __init__(self, scene: Scene, body: str, when: float, shift: Shift) -> None:
        super().__init__(scene)
        self.body, self.when, self.shift = body, when, shift

    def wait(self, seconds: float) -> None:
        super().wait(seconds)
        if self.time >= self.when:
            self.when, own = np.inf, self.world.objects[self.body]
            turn = world_T(self.scene, self.world, own.parent)[:3, :3] if own.parent != "world" else np.eye(3)
            x, y, z = (np.array(own.position) + turn.T @ np.array(self.shift)).tolist()
            self.world = self.world.replace({self.body: Attachment(own.parent, (x, y, z), own.quaternion)})


def carried_out(case: Case, body: str, when: float, shift: Shift, *, recovers: bool = True) -> Run:
    problem, scene, plan = case
    robot = Shifting(scene, body, when, shift)
    helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan)) if recovers else None
    sensor = KnownTruth(poses=robot.poses)
    return execute(plan, scene, robot, sensor, recovery=helper, report=kabo.verify(problem, plan))


def ends_of_nodes(case: Case) -> list[float]:
    """When the motion of each node, or of those that overlap, has ended in a run without a surprise [s]."""
    run = carried_out(case, "cube", np.inf, (0.0, 0.0, 0.0))
    assert run.reached_goal, run.reason
    followed = [record["time"] for record in run.log.of("followed")]
    begins = [record["time"] for record in run.log.of("node")][1:]
    return [max(time for time in followed if time <= begin) for begin in sorted({*begins} - {0.0})] + followed[-1:]


def answers(run: Run) -> list[str]:
    return [record["kind"] for record in run.log.of("answer")]


@pytest.fixture(scope="module")
def one_gantry(tmp_path_factory: pytest.TempPathFactory) -> Case:
    problem = gantry_problem(tmp_path_factory.mktemp("gantry"))
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    return problem, kabo.load_scene(problem.scene), plan


@pytest.fixture(scope="module")
def two_at_once(tmp_path_factory: pytest.TempPathFactory) -> Case:
    problem = two_gantries(tmp_path_factory.mktemp("gantries"), events=True)
    plan = kabo.solve(problem, quality="good").plan
    assert plan is not None and problem.scene is not None
    assert sum(node.overlap > 0.0 for node in plan.nodes.values()) == 2
    return problem, kabo.load_scene(problem.scene), plan


def test_what_slips_where_a_node_ends_is_held_by_what_was_done(one_gantry: Case) -> None:
    """The domain has no event, and needs none: the cube was taken."""
    when = ends_of_nodes(one_gantry)[0] + 0.03
    run = carried_out(one_gantry, "cube", when, IN_THE_HAND)
    assert run.reached_goal, run.reason
    assert answers(run) == ["repair"]
    assert [step.action for step in run.state.done] == ["take", "put"]


def test_the_state_of_a_run_that_ends_there_can_be_planned_from(one_gantry: Case) -> None:
    problem, _, plan = one_gantry
    run = carried_out(one_gantry, "cube", ends_of_nodes(one_gantry)[0] + 0.03, IN_THE_HAND, recovers=False)
    assert not run.reached_goal and run.history == ((plan.root, None),)
    found = kabo.solve(problem, start=run.state).plan
    assert found is not None and [node.action for node in found.nodes.values()] == ["put", None]


@pytest.mark.parametrize("shift", [(0.0, 0.03, 0.0), (0.0, 0.3, 0.0)])
def test_what_is_pushed_where_the_last_node_ends_is_in_its_region_or_the_run_says_that_it_is_not(
    one_gantry: Case, shift: Shift
) -> None:
    run = carried_out(one_gantry, "cube", ends_of_nodes(one_gantry)[-1] + 0.03, shift)
    if shift[1] < 0.1:
        assert run.reached_goal and answers(run) == ["repair"], run.reason
    else:
        assert not run.reached_goal and "cube is not in shelf any more" in run.reason, run.reason


def test_what_a_hand_has_lost_where_a_node_ends_was_not_taken(one_gantry: Case) -> None:
    """It lies where it was, more or less: no event is needed to take it again."""
    when = ends_of_nodes(one_gantry)[0] + 0.03

    class Dropping(Shifting):
        def wait(self, seconds: float) -> None:
            KinematicRobot.wait(self, seconds)
            if self.time >= self.when:
                self.when = np.inf
                self.release("gantry", ("cube",))
                self.world = self.world.replace({"cube": Attachment("world", (0.21, 0.01, 0.02), (0, 0, 0, 1))})

    problem, scene, plan = one_gantry
    robot = Dropping(scene, "cube", when, (0.0, 0.0, 0.0))
    helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    sensor = KnownTruth(poses=robot.poses)
    run = execute(plan, scene, robot, sensor, recovery=helper, report=kabo.verify(problem, plan))
    assert run.reached_goal, run.reason
    assert [step.action for step in run.state.done] == ["take", "put"]


class ShiftingWhereAWayEnds(Shifting):
    """A robot that is off its path for a moment; what it holds then slips so shortly before the way out of the node ends
    that no robot stops before that.
    """

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, "cube", np.inf, (0.0, 0.025, 0.0))
        self.bent, self.on_way = (0.3, 0.4), False

    def state(self) -> RobotState:
        found = super().state()
        if not self.bent[0] <= self.time < self.bent[1]:
            return found
        self.on_way, q = True, found.positions["gantry"]
        return replace(found, positions={"gantry": (q[0] + 0.05, *q[1:])})

    def wait(self, seconds: float) -> None:
        motion, held = self._follower.motion, self.world.objects["cube"].parent != "world"
        rest = motion.end - self._follower.time if motion is not None and self._follower.moving else np.inf
        if self.on_way and held and rest < 0.012:  # [s]: a little more than between two looks
            self.when, self.on_way = self.time, False
        super().wait(seconds)


def test_a_node_counts_as_done_if_a_surprise_stops_the_way_to_its_end_only_there(one_gantry: Case) -> None:
    problem, scene, plan = one_gantry
    robot = ShiftingWhereAWayEnds(scene)
    helper = Replanner(problem, scene, memo=kabo.Memo.of_plan(problem, plan))
    sensor = KnownTruth(poses=robot.poses)
    run = execute(plan, scene, robot, sensor, recovery=helper, report=kabo.verify(problem, plan))
    assert run.reached_goal, run.reason
    assert answers(run) == ["finish", "repair"]
    assert [step.action for step in run.state.done] == ["take", "put"]


@pytest.mark.parametrize(
    ("body", "when", "shift"),
    [
        ("second", 0.3, (0.0, 0.025, 0.0)),  # both hands go down
        ("cube", 0.3, (0.0, 0.025, 0.0)),
        ("cube", 1.35, IN_THE_HAND),  # both are lifted
        ("second", 1.35, IN_THE_HAND),
        ("second", 1.53, IN_THE_HAND),  # both nodes have ended
        ("cube", 1.65, IN_THE_HAND),  # both are carried
        ("second", 3.2, (0.0, 0.03, 0.0)),  # one hand is back, the other one is not
    ],
)
def test_out_of_several_nodes_that_have_begun_a_way_leads_on_or_back(
    two_at_once: Case, body: str, when: float, shift: Shift
) -> None:
    run = carried_out(two_at_once, body, when, shift)
    assert run.reached_goal, run.reason
    assert answers(run)
    assert run.state.geometry is not None
    for name, x in (("cube", -0.3), ("second", 0.9)):
        assert abs(run.state.geometry.objects[name].position[0] - x) < 0.1
    assert not any(step.action in ("lost", "moved") for step in run.state.done)


def test_nodes_that_have_begun_are_in_the_order_of_the_plan(two_at_once: Case) -> None:
    plan = two_at_once[2]
    second = str(plan.nodes[plan.root].next)
    assert begun_nodes(plan, [Executed(second, 0), Executed(plan.root, 0, 0.1)]) == (plan.root, second)
    assert begun_nodes(plan, [Executed(second, 0)]) == (second,)
    assert begun_nodes(plan, []) == ()
