"""A hand that takes nothing from another one opens again, and it is tried anew; meanwhile the giver has it."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.execution import Executed, Interruption
from kabo.execution.protocols import RobotState
from kabo.execution.watching import Surprise
from kabo.plan import Segment, state_after
from kabo.recovery.node_ways import way_back
from kabo.scene import Attachment, Scene, world_T
from kabo.verify.verification import verify_plan
from tests.recovery.test_handovers import Case, GivingRobot, carried_out, events, giving, parent

__all__ = ["giving"]
STUCK = 0.03  # [m] of a finger from the middle that does not close as far as the rod


class MissingRobot(GivingRobot):
    """The taking hand misses the rod so often; while it closes the rod is shifted in the hand of the giver, or it is stuck.

    Attributes:
        times: how often. shift: by how much the rod is shifted in the giver's hand [m]; None: the taker does not close.
    """

    def __init__(self, scene: Scene, times: int, shift: tuple[float, float, float] | None = None) -> None:
        super().__init__(scene)
        self.times, self.shift, self.is_stuck = times, shift, False

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        if robot != "other" or self.times <= 0:
            super().grip(robot, bodies)
            return
        self.times -= 1
        self._pressing[robot] = 0.0
        if self.shift is None:
            self.is_stuck = True
        else:
            own = self.world.objects["rod"]
            place = tuple(np.add(own.position, self.shift).tolist())
            self.world = self.world.replace({"rod": Attachment(own.parent, place, own.quaternion)})
            self.empty.add(robot)

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        self.is_stuck &= robot != "other"
        super().release(robot, bodies)

    def state(self) -> RobotState:
        found = super().state()
        if not self.is_stuck:
            return found
        arm = found.positions["other"][: self.scene.robots["other"].planned]
        return replace(found, positions={**found.positions, "other": (*arm, STUCK)})


@pytest.mark.parametrize("shift", [None, (0.0, -0.02, 0.0), (0.0, 0.0, -0.025), (0.0, 0.0, 0.02)])
def test_what_was_missed_is_given_again(giving: Case, shift: tuple[float, float, float] | None) -> None:
    """The giver opens once, at the second time; where the rod is between the taker's fingers these open first."""
    robot = MissingRobot(giving[1], 1, shift)
    run = carried_out(giving, robot)
    assert run.reached_goal, run.reason
    answers = [each["kind"] for each in run.log.of("answer")]
    assert answers == ["undo", "repair"]
    wanted = [] if shift is None else [("gripping", "gantry"), ("releasing", "other")]
    first = [("gripping", "gantry"), ("gripping", "other"), *wanted, ("gripping", "other")]
    assert events(run, "gripping", "releasing") == [*first, ("releasing", "gantry"), ("releasing", "other")]
    assert abs(world_T(giving[1], robot.world, "rod")[0, 3] - 0.8) < 0.1


def test_a_hand_that_has_not_closed_far_enough_has_taken_nothing(giving: Case) -> None:
    run = carried_out(giving, MissingRobot(giving[1], 9), recovers=False)
    assert not run.reached_goal and parent(run) == "gantry.hand"


def test_a_hand_that_misses_again_and_again_is_told_and_the_giver_has_it(giving: Case) -> None:
    run = carried_out(giving, MissingRobot(giving[1], 99))
    assert not run.reached_goal and "again and again" in run.reason, run.reason
    assert parent(run) == "gantry.hand"


def test_the_way_back_leads_into_the_giver_s_hand_after_it_has_opened(giving: Case) -> None:
    """First the giver closes, then the taker opens; each is proven."""
    _, scene, plan = giving
    held = state_after(plan, [("n0", None), ("n1", None)])
    begun = state_after(plan, [("n0", None)])
    assert held.geometry is not None and begun.geometry is not None
    motion = plan.nodes["n1"].motion
    robots = {
        "other": held.geometry.robots["other"],
        "gantry": {**begun.geometry.robots["gantry"], **_end(motion[0]), **_end(motion[4])},
    }
    geometry = replace(held.geometry, robots=robots)
    executed = tuple(Executed("n1", k) for k in range(5))
    surprise = Surprise("tracking", "", "gantry", 0.0, 0.0)
    stands = Interruption(plan, replace(begun, geometry=geometry), executed, (), surprise)
    back = way_back(stands, scene)
    assert scene.description is not None
    report = verify_plan(scene.description, back, scene=scene)
    assert report.ok, report.findings
    changes = [(s.robot, s.attach, s.detach) for s in back.nodes["n0"].motion if s.attach or s.detach]
    assert changes == [("gantry", (("rod", "gantry.hand"),), ()), ("other", (), ("rod",))]
    after = back.nodes["n0"].after
    assert after is not None and after.objects["rod"].parent == "gantry.hand"


def _end(segment: Segment) -> dict[str, float]:
    return dict(zip(segment.joints, segment.waypoints[-1], strict=True))
