"""What bodies must keep from each other: the clearance that a plan claims, and what the scene says is uncertain."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from kabo.plan import Plan
from kabo.scene import Robot, Scene
from kabo.verify.motion.sweep import SweptBody


@dataclass(frozen=True)
class KeptDistances:
    """The distances that pairs of bodies keep along every motion, contacts that are permitted apart."""

    scene: Scene
    clearance: float  # [m] as the plan's options say

    @classmethod
    def of(cls, plan: Plan, scene: Scene) -> "KeptDistances":
        """The distances for a plan."""
        return cls(scene, float(plan.options.get("clearance") or 0.0))

    @property
    def greatest(self) -> float:
        """The greatest distance that any pair keeps, or more [m]."""
        return self.clearance + 4.0 * max(self.scene.uncertain.values(), default=0.0)

    def between(
        self,
        first: SweptBody,
        second: SweptBody,
        things: Sequence[SweptBody],
        permitted: Collection[frozenset[str]],
    ) -> float:
        """The distance that two bodies keep [m]: the clearance, and how uncertain both are.

        A link is as uncertain as its robot, and what a robot carries as both together. Bodies keep nothing where only
        a gripper moves one relative to the other.
        """
        if first.mount is not None and second.mount is not None and first.mount.robot == second.mount.robot:
            robot = self.scene.robots[first.mount.robot]
            hands = {
                _last_planned(robot, thing.mount.joint) for thing in (first, second) if thing.mount is not None
            }
            if len(hands) == 1 and hands != {0}:
                return 0.0
        return self.clearance + self._uncertain(first) + self._uncertain(second)

    def _hand(self, thing: SweptBody) -> tuple[str, int] | None:
        """The robot that carries a body, and the last planned joint that does; None of what stands."""
        if thing.mount is None:
            return None
        joint = _last_planned(self.scene.robots[thing.mount.robot], thing.mount.joint)
        return (thing.mount.robot, joint) if joint else None

    def _uncertain(self, thing: SweptBody) -> float:
        owner, carrier = thing.name.partition(".")[0], None if thing.mount is None else thing.mount.robot
        own = self.scene.uncertain.get(owner, 0.0)
        return own if carrier is None or carrier == owner else own + self.scene.uncertain.get(carrier, 0.0)


def _last_planned(robot: Robot, joint: int) -> int:
    """The last joint that is planned, of those that carry a joint of the robot's model, itself included; 0 if none is."""
    names, parents = robot.model.names, robot.model.parents
    while joint > 0 and names[joint] not in robot.planned_joints:
        joint = int(parents[joint])
    return joint
