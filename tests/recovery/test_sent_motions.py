"""What is sent after surprises, judged by python-fcl on the original meshes, where everything truly is, at 1 kHz."""

from pathlib import Path

import numpy as np
import pytest

import kabo
from kabo.execution import KinematicRobot, KnownTruth, Motion, execute
from kabo.recovery import Replanner
from kabo.scene import Attachment, Scene, link_poses, world_T
from tests.support.oracles_motions import Judge, Moment
from tests.support.two_gantries import two_gantries

DOMAINS = Path(__file__).parents[2] / "domains"
Shift = tuple[float, float, float]


class JudgedRobot(KinematicRobot):
    """A robot in whose world a body is shifted once [m]; each millisecond of its motions is looked at for overlaps."""

    def __init__(self, scene: Scene, body: str, when: float, shift: Shift) -> None:
        super().__init__(scene, rate=1000.0)
        self.body, self.when, self.shift, self.judge = body, when, shift, Judge(scene)
        self.hits: set[tuple[str, str]] = set()
        self.judged = 0
        self.motion: Motion | None = None

    def follow(self, motion: Motion) -> None:
        super().follow(motion)
        self.motion = motion

    def wait(self, seconds: float) -> None:
        for _ in range(max(1, round(1000.0 * seconds))):
            super().wait(0.001)
            if self.state().moving:
                self.look()
        if self.time >= self.when:
            self.when, own = np.inf, self.world.objects[self.body]
            turn = world_T(self.scene, self.world, own.parent)[:3, :3] if own.parent != "world" else np.eye(3)
            x, y, z = (np.array(own.position) + turn.T @ np.array(self.shift)).tolist()
            self.world = self.world.replace({self.body: Attachment(own.parent, (x, y, z), own.quaternion)})

    def gripped(self) -> frozenset[frozenset[str]]:
        """What hands hold, with their fingers."""
        holders = {body: own.parent.partition(".")[0] for body, own in self.world.objects.items()}
        grippers = {name: robot.gripper for name, robot in self.scene.robots.items() if robot.gripper is not None}
        return frozenset(
            frozenset((link, body))
            for body, holder in holders.items()
            if holder in grippers
            for link in grippers[holder].touch_links
        )

    def look(self) -> None:
        """Adds pairs that overlap, of which one moves, and which what is followed does not permit."""
        assert self.motion is not None
        poses = {name: world_T(self.scene, self.world, name) for name in self.scene.bodies}
        moving = {name for name, own in self.world.objects.items() if own.parent != "world"}
        for name, robot in self.scene.robots.items():
            links = link_poses(robot, np.array(self.world.robots[name]))
            own = {f"{name}.{link}": pose for link, pose in links.items()}
            poses |= own
            moving |= own.keys()
        followed = self.motion.at(self._follower.time)
        permitted = frozenset(frozenset(pair) for each in followed for pair in each.permitted) | self.gripped()
        moment = Moment(self.time, poses, permitted, frozenset(moving), 0)
        for pair in self.judge._near(moment):
            if frozenset(pair) not in permitted and self.judge._overlap(pair, moment):
                self.hits.add(pair)
        self.judged += 1


def judged_run(problem: kabo.Problem, plan: kabo.Plan, robot: JudgedRobot) -> list[str]:
    """The kinds of answers of a run that reaches its goal."""
    helper = Replanner(problem, robot.scene, memo=kabo.Memo.of_plan(problem, plan))
    sensor, report = KnownTruth(poses=robot.poses), kabo.verify(problem, plan)
    run = execute(plan, robot.scene, robot, sensor, recovery=helper, report=report)
    assert run.reached_goal, run.reason
    return [record["kind"] for record in run.log.of("answer")]


@pytest.fixture(scope="module")
def two_at_once(tmp_path_factory: pytest.TempPathFactory) -> tuple[kabo.Problem, Scene, kabo.Plan]:
    problem = two_gantries(tmp_path_factory.mktemp("gantries"), events=True)
    plan = kabo.solve(problem, quality="good").plan
    assert plan is not None and problem.scene is not None
    return problem, kabo.load_scene(problem.scene), plan


@pytest.mark.parametrize(("body", "when"), [("second", 0.3), ("cube", 1.35)])
def test_nothing_overlaps_where_two_robots_go_on_or_back_one_after_the_other(
    two_at_once: tuple[kabo.Problem, Scene, kabo.Plan], body: str, when: float
) -> None:
    problem, scene, plan = two_at_once
    robot = JudgedRobot(scene, body, when, (0.0, 0.016, 0.0))
    assert judged_run(problem, plan, robot)
    assert robot.hits == set() and robot.judged > 3000


def test_nothing_overlaps_after_a_block_was_pushed() -> None:
    problem = kabo.load_problem(DOMAINS / "stacked" / "n2.yaml")
    plan = kabo.solve(problem).plan
    assert plan is not None and problem.scene is not None
    robot = JudgedRobot(kabo.load_scene(problem.scene), "o2", 0.9, (0.014, -0.009, 0.0))
    assert judged_run(problem, plan, robot)
    assert robot.hits == set() and robot.judged > 8000


def test_the_judge_sees_what_overlaps(two_at_once: tuple[kabo.Problem, Scene, kabo.Plan]) -> None:
    """A cube is pushed into a finger while hands go down: the run cannot help it, and the judge tells."""
    _, scene, plan = two_at_once
    robot = JudgedRobot(scene, "cube", 0.45, (0.03, 0.0, 0.0))
    execute(plan, scene, robot, KnownTruth(poses=robot.poses))
    assert {frozenset(pair) for pair in robot.hits} & {frozenset(("cube", "gantry.left"))}
