"""A robot that is where it is sent, at once, in a world without forces: what is gripped is fixed to the hand."""

from collections import deque
from collections.abc import Mapping
from types import NoneType

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.following import Follower, Setpoint
from kabo.execution.loads import load_of
from kabo.execution.motions import SAME_TIME, HandAction, Motion
from kabo.execution.protocols import RobotState
from kabo.execution.settings import LONGEST_DELAY, MOST_RATE
from kabo.given import require_given, require_number
from kabo.scene import Scene, attachment, world_T
from kabo.scene.state import GeometricState


class KinematicRobot:
    """All robots of a scene without physics; it also knows where bodies are.

    Args:
        scene: the scene.
        start: where everything is at first; None: as the scene says.
        rate: setpoints a second [Hz].
        delay: how late robots follow setpoints, or each of them by name [s].

    Raises:
        ArgumentError: an argument is of a wrong kind, or no such number.
    """

    def __init__(
        self,
        scene: Scene,
        start: GeometricState | None = None,
        rate: float = 500.0,
        delay: float | Mapping[str, float] = 0.0,
    ) -> None:
        require_given("scene", scene, Scene)
        require_given("start", start, GeometricState, NoneType)
        require_number("rate", rate, above=0.0, most=MOST_RATE, unit="Hz")
        for each in delay.values() if isinstance(delay, Mapping) else (delay,):
            require_number("delay", each, 0.0, LONGEST_DELAY, unit="s")
        self.scene, self.world, self.rate = scene, start or scene.start, rate
        self.time = 0.0
        self._follower = Follower(scene)
        delays = delay if isinstance(delay, Mapping) else dict.fromkeys(scene.robots, delay)
        self._late = {name: round(delays.get(name, 0.0) * rate) for name in scene.robots}  # setpoints
        self._latest = max(self._late.values(), default=0)
        self._sent: deque[list[Setpoint]] = deque(maxlen=self._latest + 1)
        self._behind = 0  # setpoints that are still on their way, of a motion that has ended
        self._velocities = {name: (0.0,) * len(q) for name, q in self.world.robots.items()}
        self._pressing: dict[str, float] = {}
        self._joined: list[HandAction] = []  # still to come in the motion

    def follow(self, motion: Motion) -> None:
        """Begins a motion."""
        self._follower.follow(motion)
        self._joined = [each for each in motion.actions if each.kind == "detach" and each.attach]

    def stop(self) -> None:
        """Slows down along the path until it stands."""
        self._follower.stop()

    def pace(self, rate: float) -> bool:
        """Goes to another rate of the motion's clock, within all limits."""
        return self._follower.pace(rate)

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Fixes bodies to the frame of the tool."""
        own = self.scene.robots[robot]
        self._pressing[robot] = 0.0
        for body in bodies if own.tool is not None else ():
            parent = f"{robot}.{own.tool.frame}"  # type: ignore[union-attr]
            self._hang(body, parent)
            place = np.asarray(self.world.objects[body].position)
            load = load_of(self.scene, robot, self.world.robots[robot], place, self.scene.bodies[body].mass)
            if load is not None:
                self._follower.loads.setdefault(robot, []).append(load)

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Leaves bodies where they are; what another hand holds it keeps."""
        self._pressing.pop(robot, None)
        self._follower.loads.pop(robot, None)
        for body in bodies:
            if Belief(self.scene, self.world).holder(body) == robot:
                self._hang(body, "world")

    def _hang(self, body: str, parent: str) -> None:
        place = np.linalg.inv(world_T(self.scene, self.world, parent)) @ world_T(self.scene, self.world, body)
        self.world = self.world.replace({body: attachment(parent, place)})

    def state(self) -> RobotState:
        """Where the robots are."""
        follower = self._follower
        robots, hands = dict(self.world.robots), frozenset(self.world.robots)
        return RobotState(
            self.time, follower.time, self._moving, robots, dict(self._velocities), dict(self._pressing), hands
        )

    @property
    def _moving(self) -> bool:
        return self._follower.moving or self._behind > 0

    def wait(self, seconds: float) -> None:
        """Goes on along the motion."""
        for _ in range(max(1, round(seconds * self.rate))):
            self.time += 1.0 / self.rate
            self._velocities = {name: (0.0,) * len(q) for name, q in self.world.robots.items()}
            self._behind = self._latest if self._follower.moving else max(0, self._behind - 1)
            self._sent.append(list(self._follower.advance(1.0 / self.rate)))
            for sent in self._arrived():
                names = self.scene.robots[sent.robot].joint_names
                values, speeds = list(self.world.robots[sent.robot]), list(self._velocities[sent.robot])
                for joint, value, speed in zip(sent.joints, sent.positions, sent.velocities, strict=True):
                    values[names.index(joint)], speeds[names.index(joint)] = float(value), float(speed)
                self.world = self.world.replace({sent.robot: tuple(values)})
                self._velocities[sent.robot] = tuple(speeds)
            while self._joined and self._joined[0].time <= self._follower.time + SAME_TIME:
                for body, parent in self._joined.pop(0).attach:
                    self._hang(body, parent)

    def _arrived(self) -> list[Setpoint]:
        """The setpoints that reach each robot now."""
        lists = {name: self._sent[-1 - late] for name, late in self._late.items() if late < len(self._sent)}
        return [sent for name, own in lists.items() for sent in own if sent.robot == name]

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) of all movable bodies."""
        return {name: world_T(self.scene, self.world, name) for name in self.scene.movable}
