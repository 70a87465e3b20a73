"""What bodies must keep from each other: the clearance that a plan claims, and what the scene says is uncertain."""

from dataclasses import dataclass

from kabo.plan import Plan
from kabo.scene import Scene
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

    def between(self, first: SweptBody, second: SweptBody) -> float:
        """The distance that two bodies keep [m]: the clearance, and how uncertain both are.

        A link is as uncertain as its robot, and what a robot carries as both together.
        """
        return self.clearance + self._uncertain(first) + self._uncertain(second)

    def _uncertain(self, thing: SweptBody) -> float:
        owner, carrier = thing.name.partition(".")[0], None if thing.mount is None else thing.mount.robot
        own = self.scene.uncertain.get(owner, 0.0)
        return own if carrier is None or carrier == owner else own + self.scene.uncertain.get(carrier, 0.0)
