"""The robots of a scene in physics, as the executor drives them, with what sensors would measure of them."""

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.execution.following import Follower, Setpoint
from kabo.execution.loads import load_of
from kabo.execution.motions import Motion
from kabo.execution.protocols import RobotState
from kabo.execution.settings import LONGEST_DELAY, MOST_RATE
from kabo.given import require_functions, require_number
from kabo.scene import Scene, motion_limits
from kabo.scene.state import GeometricState
from kabo.scene.transforms import inverse
from kabo.simulation.joined_parts import joined
from kabo.simulation.judging import DEEP
from kabo.simulation.physics import Physics
from kabo.simulation.settings import USUAL, PhysicsSettings

IN_HAND = 0.2  # [m] between the tool and the nearest point of what a hand takes, at most
JUDGED_EACH = 5  # time steps
SAGGED = 0.01  # [rad or m] by which a joint that its motor cannot hold has given way
STILL = 0.003  # [rad/s or m/s] below which a hand stands
SETTLING = 0.5  # [s] for which gravity acts before anything is done
FELL, TURNED = 0.005, 5.0  # [m], [degrees]: what gravity moves farther meanwhile does not stand


class SimulatedRobot:
    """All robots of a scene in physics.

    Args:
        scene: the scene.
        settings: of the physics.
        start: where everything is at first; None: as the scene says.
        rate: setpoints a second [Hz]: at most one each time step.
        disturb: called before each time step with the physics, to push, drop or break something.
        masses: true masses of bodies [kg], which neither the plan nor the controller knows.
        delay: how late motors get their setpoints [s].

    Raises:
        ArgumentError: an argument is of a wrong kind, or no such number.
    """

    def __init__(
        self,
        scene: Scene,
        settings: PhysicsSettings = USUAL,
        start: GeometricState | None = None,
        *,
        rate: float = 1000.0,
        disturb: Callable[[Physics], None] | None = None,
        masses: Mapping[str, float] | None = None,
        delay: float = 0.0,
    ) -> None:
        require_number("rate", rate, above=0.0, most=MOST_RATE, unit="Hz")
        require_number("delay", delay, 0.0, LONGEST_DELAY, unit="s")
        require_functions(disturb=disturb)
        self.scene, self.settings = scene, settings
        self.physics = Physics(scene, settings, start, masses)
        self.each = max(1, round(1.0 / (rate * settings.timestep)))  # time steps between two setpoints
        self._follower = Follower(scene)
        self._disturb = disturb
        self._late = round(delay / settings.timestep)  # time steps
        self._waiting: deque[tuple[Any, ...]] = deque()  # steps of setpoints that motors have not got
        self.judge: Callable[[Physics, Motion | None, float, list[tuple[str, str]]], None] | None = None
        self._held: dict[str, tuple[str, ...]] = {}
        self.joined: set[frozenset[str]] = set()  # pairs of parts that hold together
        self._sent: list[Setpoint] = []
        self._behind = 0  # steps of a motion that has ended for which setpoints are still on their way
        self._next: list[Any] = []  # setpoints of this step, for motors that are late
        self._from: float | None = None  # of the motion's clock [s], when the last setpoints were sent
        self._share = 1.0  # of the way from there to the setpoints that motors have gone
        self._steps = 0
        before = self.poses()
        self._join(scene.movable)
        self.wait(SETTLING)
        self.doubts = (*self._doubts((start or scene.start).robots), *self._moved_by_gravity(before))

    def _doubts(self, start: Mapping[str, tuple[float, ...]]) -> Iterator[str]:
        """Sentences about what makes the simulation unlike the robots: what touches at the start, weak motors."""
        scene, physics = self.scene, self.physics
        for contact in physics.contacts(DEEP):
            links = [thing for thing in contact.things if "." in thing]
            if len(links) == 2 and not scene.never_collide(*links):
                deep = f"{1000.0 * contact.depth:.2g} mm"
                yield f"{links[0]} and {links[1]} overlap by {deep} at the start: contact shapes bridge hollows"
        for name in scene.robots:
            joints = scene.robots[name].joint_names
            for joint, is_at, was in zip(joints, physics.configuration(name), start[name], strict=True):
                if abs(is_at - was) > SAGGED and physics.is_exhausted(name, joint):
                    yield f"the motor of {name}.{joint} is too weak for what it bears, by the effort in its URDF"
            yield from self._hasty(name)

    def _hasty(self, name: str) -> Iterator[str]:
        """Sentences about the planned joints that plans accelerate harder than their motors can."""
        own = self.scene.robots[name]
        limits = motion_limits(own, own.planned_joints).acceleration.tolist()
        for joint, limit in zip(own.planned_joints, limits, strict=True):
            share = self.physics.needed(name, joint, limit)
            if share > 1.0:
                yield (
                    f"the motor of {name}.{joint} needs {share:.2g} times its effort where plans accelerate most "
                    f"({limit:.3g} rad/s² or m/s²): give the joint a limit of acceleration in the scene"
                )

    def _moved_by_gravity(self, before: Mapping[str, Array]) -> Iterator[str]:
        """A sentence about each body that does not stay where it is put, with nobody touching it."""
        for name, pose in self.poses().items():
            shift = float(np.linalg.norm(pose[:3, 3] - before[name][:3, 3]))
            cosine = 0.5 * (np.trace(before[name][:3, :3].T @ pose[:3, :3]) - 1.0)
            turn = float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))
            if shift > FELL or turn > TURNED:
                moved = f"{1000 * shift:.0f} mm and {turn:.0f} degrees within {SETTLING:g} s"
                yield f"{name} does not stay where it is put: gravity has moved it by {moved}"

    def follow(self, motion: Motion) -> None:
        """Begins a motion."""
        self._follower.follow(motion)
        self._from = None

    def stop(self) -> None:
        """Slows down along the path until it stands."""
        self._follower.stop()

    def pace(self, rate: float) -> bool:
        """Goes to another rate of the motion's clock, within all limits."""
        return self._follower.pace(rate)

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        """The hand presses, or locks where hands lock; what is far away it does not take."""
        bodies = tuple(body for body in bodies if self._is_near(robot, body))
        self.physics.grip(robot, bodies)
        self._held[robot] = bodies
        self._add_loads(robot, bodies)
        for body in bodies if self.settings.welds else ():
            self.physics.weld(robot, body)

    def _is_near(self, robot: str, body: str) -> bool:
        """Whether a body could be between the fingers: a controller would bear what is elsewhere on a long lever."""
        tool = self.scene.robots[robot].tool
        if tool is None:
            return True
        hand, place = self.physics.pose(f"{robot}.{tool.frame}"), self.physics.pose(body)
        radius = np.linalg.norm(self.scene.bodies[body].mesh.vertices, axis=1).max()
        return bool(np.linalg.norm(place[:3, 3] - hand[:3, 3]) <= radius + IN_HAND)

    def _add_loads(self, robot: str, bodies: tuple[str, ...]) -> None:
        """What the hand holds, as the scene says, limits stops from now on."""
        tool = self.scene.robots[robot].tool
        if tool is None:
            return
        hand = inverse(self.physics.pose(f"{robot}.{tool.frame}"))
        for body in bodies:
            place = (hand @ self.physics.pose(body))[:3, 3]
            load = load_of(
                self.scene, robot, self.physics.configuration(robot), place, self.scene.bodies[body].mass
            )
            if load is not None:
                self._follower.loads.setdefault(robot, []).append(load)

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        """The hand presses no more."""
        self.physics.release(robot)
        self._held.pop(robot, None)
        self._follower.loads.pop(robot, None)
        for body in bodies if self.settings.welds else ():
            self.physics.unweld(robot, body)
        self._join(bodies)

    def _join(self, bodies: tuple[str, ...]) -> None:
        """Fixes bodies that nobody holds back to the parts that they have been joined with, if their mates hold."""
        for fixed, moving in joined(self.scene, bodies, self.physics.pose):
            self.physics.weld(fixed, moving)
            self.joined.add(frozenset((fixed, moving)))

    def state(self) -> RobotState:
        """What encoders and hands measure."""
        physics, robots = self.physics, self.scene.robots
        velocities = {name: physics.velocities(name) for name in robots}
        hands = {name: max(map(abs, velocities[name][own.planned :]), default=0.0) for name, own in robots.items()}
        pressing = {name: force for name in robots if (force := physics.pressing(name)) is not None}
        return RobotState(
            physics.time,
            self._motion_time,
            self._follower.moving
            or (self._from is not None and self._motion_time < self._follower.time)
            or self._behind > 0,
            {name: physics.configuration(name) for name in robots},
            velocities,
            pressing,
            frozenset(name for name, speed in hands.items() if speed < STILL and not physics.builds_up(name)),
        )

    def wait(self, seconds: float) -> None:
        """Simulates so long."""
        physics, step = self.physics, self.settings.timestep
        for _ in range(max(1, round(seconds / step))):
            if self._disturb is not None:
                self._disturb(physics)
            physics.step()
            self._behind = self._late if self._follower.moving else max(0, self._behind - 1)
            self._send(self._steps % self.each, step)
            self._steps += 1
            if self.judge is not None and self._steps % JUDGED_EACH == 0:
                held = [(robot, body) for robot, bodies in self._held.items() for body in bodies]
                follower = self._follower
                self.judge(physics, follower.motion if follower.moving else None, follower.time, held)

    def _send(self, tick: int, step: float) -> None:
        """Gives motors what is due; between two setpoints drives go on with their velocities and accelerations.

        A setpoint is where a joint is to be when the next one comes, so in between motors are as far before it.
        """
        if tick == 0:
            self._from = self._follower.time
            self._sent = list(self._follower.advance(self.each * step))
        self._share = (tick + 1) / self.each
        early = (tick + 1 - self.each) * step  # [s], 0 or less
        for sent in self._sent:
            if early == 0.0:
                self._command(*sent)
                continue
            q, v, a = sent.positions, sent.velocities, sent.accelerations
            now = q + early * (v + 0.5 * early * a)
            self._command(sent.robot, sent.joints, now, v + early * a, a)
        self._pass_on()

    def _command(self, *sent: Any) -> None:
        """Gives motors a setpoint, now or after the delay."""
        if self._late:
            self._next.append(sent)
        else:
            self.physics.command(*sent)

    def _pass_on(self) -> None:
        """Motors get what has been on its way for the delay."""
        if self._late:
            self._waiting.append(tuple(self._next))
            self._next.clear()
            for sent in self._waiting.popleft() if len(self._waiting) > self._late else ():
                self.physics.command(*sent)

    @property
    def _motion_time(self) -> float:
        """Where motors are on the clock of the motion [s]: at the last setpoints, or between them and those before."""
        time = self._follower.time
        return time if self._from is None or self._share == 1.0 else self._from + self._share * (time - self._from)

    def holder(self, body: str) -> str | None:
        """The robot whose hand presses on a body, or is fixed to it."""
        return next((robot for robot, bodies in self._held.items() if body in bodies), None)

    def held_by(self, robot: str) -> tuple[str, ...]:
        """The bodies that a hand holds."""
        return self._held.get(robot, ())

    def poses(self) -> Mapping[str, Array]:
        """The true poses (4, 4) of all movable bodies."""
        return {name: self.physics.pose(name) for name in self.scene.movable}
