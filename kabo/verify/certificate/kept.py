"""What bodies must keep from each other: the clearance that a plan claims, and what the scene says is uncertain."""

from collections.abc import Collection
from dataclasses import dataclass
from itertools import permutations

from kabo.plan import Plan
from kabo.scene import Robot, Scene
from kabo.verify.motion.stretches import MotionStretch
from kabo.verify.motion.sweep import SweptBody

Hand = tuple[str, int]  # a robot, and the last planned joint that carries what counts as its hand


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

    def spared(self, stretch: MotionStretch) -> frozenset[tuple[str, Hand]]:
        """Bodies from which a hand, and what it holds, keep nothing in a stretch, each with the hand.

        They are those that a link of the hand may touch; and where something in the hand may touch an object, as where it
        is mated with it, what else is attached to this object.
        """
        hands = {thing.name: hand for thing in stretch.moving if (hand := self.hand(thing)) is not None}
        found: set[tuple[str, Hand]] = set()
        for own, other in (each for pair in stretch.permitted for each in permutations(pair, 2)):
            hand = hands.get(own)
            if hand is not None and "." in own:
                found.add((other, hand))
            elif hand is not None and other in stretch.roots:
                root = stretch.roots[other]
                found |= {(name, hand) for name, top in stretch.roots.items() if top == root and name != other}
        return frozenset(found)

    def between(
        self, first: SweptBody, second: SweptBody, spared: Collection[tuple[str, Hand]] = frozenset()
    ) -> float:
        """The distance that two bodies keep [m]: the clearance, and how uncertain both are.

        A link is as uncertain as its robot, and what a robot carries as both together. Bodies keep nothing where only
        a gripper moves one relative to the other, and where one is of a hand that may come near the other (`spared`).
        """
        hands = self.hand(first), self.hand(second)
        if hands[0] is not None and hands[0] == hands[1]:
            return 0.0
        if (second.name, hands[0]) in spared or (first.name, hands[1]) in spared:
            return 0.0
        return self.clearance + self._uncertain(first) + self._uncertain(second)

    def hand(self, thing: SweptBody) -> Hand | None:
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
