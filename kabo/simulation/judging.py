"""Judges what touches in physics while a plan is carried out: each contact is one that the plan permits, or a fault.

It knows nothing of the executor's decisions: it reads the plan's segments, and what moves by them.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from kabo.execution import Motion
from kabo.scene import Scene
from kabo.simulation.physics import Physics
from kabo.simulation.touching import Contact

DEEP = 1e-4  # [m]: shallower contacts are the softness of the simulation


@dataclass
class ContactJudge:
    """Collects the contacts that no segment permits, by pair of things, with the greatest depth [m].

    Args:
        scene: the scene.
    """

    scene: Scene
    faults: dict[tuple[str, str], float] = field(default_factory=dict)
    looks: int = 0

    def look(
        self, physics: Physics, motion: Motion | None, time: float, holding: Iterable[tuple[str, str]]
    ) -> None:
        """Looks at all contacts of this moment.

        Args:
            physics: the world. motion: what is followed, at its `time` [s]; None: nothing.
            time: on the clock of the motion.
            holding: robots, each with a body that it holds, or is about to take or has just let go of.
        """
        self.looks += 1
        running = [] if motion is None else list(motion.at(time))
        moving = {each.robot for each in running}
        allowed = {frozenset(pair) for each in running for pair in each.permitted}
        held = list(holding)
        carried = {body for robot, body in held if robot in moving}
        for contact in physics.contacts(DEEP):
            if not self._permitted(contact, allowed, held, moving, carried):
                self.faults[contact.things] = max(contact.depth, self.faults.get(contact.things, 0.0))

    def _permitted(
        self,
        contact: Contact,
        allowed: set[frozenset[str]],
        held: list[tuple[str, str]],
        moving: set[str],
        carried: set[str],
    ) -> bool:
        pair = frozenset(contact.things)
        if pair in allowed or self.scene.never_collide(*contact.things):
            return True
        if not any(thing in carried or thing.partition(".")[0] in moving for thing in contact.things):
            return True  # neither moves by the plan: one stands on the other
        return any(
            pair == frozenset((link, body))
            for robot, body in held
            if (gripper := self.scene.robots[robot].gripper) is not None
            for link in gripper.touch_links
        ) or any(  # a hand that has closed on nothing
            pair <= {*gripper.touch_links} for robot in self.scene.robots.values() if (gripper := robot.gripper)
        )
