"""Judges what touches in physics while a plan is carried out: each contact is one that the plan permits, or a fault.

It knows nothing of the executor's decisions: it reads the plan's segments, and what moves by them.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from kabo.execution import Motion
from kabo.execution.motions import Stretch
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
    _now: tuple[Any, ...] = ()  # what moves and is held, of which it is known what is permitted
    _known: dict[tuple[str, str], bool] = field(default_factory=dict)

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
        running, held = () if motion is None else tuple(motion.at(time)), tuple(holding)
        if self._now != (running, held):
            self._now, self._known = (running, held), {}
        for contact in physics.contacts(DEEP, resting=False):  # what sleeps does not move
            permitted = self._known.get(contact.things)
            if permitted is None:
                permitted = self._known[contact.things] = self._permitted(contact, running, held)
            if not permitted:
                self.faults[contact.things] = max(contact.depth, self.faults.get(contact.things, 0.0))

    def _permitted(self, contact: Contact, running: Sequence[Stretch], held: Sequence[tuple[str, str]]) -> bool:
        moving = {each.robot for each in running}
        allowed = {frozenset(pair) for each in running for pair in each.permitted}
        carried = {body for robot, body in held if robot in moving}
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
