"""Faults of a run in physics: drawn from a seed, and made in the simulator or in what sensors say.

A body is displaced along the horizontal. A hand drops by pressing outwards for a while. A grasp closes on nothing since the
body was moved away just before, to a place where it is in nothing else. What is in the way is another body, put below
where the tool will be. A motor with half its torque is one joint's; a robot that is stopped has no torque, and brakes
hold its arm. A body that is removed is neither seen any more nor touched.
"""

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.execution import KnownTruth
from kabo.plan import Plan
from kabo.scene import Scene, link_pose
from kabo.simulation import Physics, SimulatedRobot
from kabo.streams import stream_key, uniforms

KINDS = (
    "displaced",
    "dropped",
    "closed on nothing",
    "sensor contradicts",
    "sensor silent",
    "in the way",
    "torque halved",
    "robot stopped",
    "controller late",
    "removed",
)
SENSING = ("sensor contradicts", "sensor silent")
BEFORE = 0.3  # [s]: gravity has settled by then, and the run has not begun
LATE = 0.02  # [s]
FAR = 30.0  # [m]
FOREVER = 10**9  # looks
BRAKES = 1e5  # [N s/m or N m s/rad]
OUTWARDS = -40.0  # [N]
INTO = 1e-3  # [m]: a body is in another one
TURNS = 8  # directions in which a body may be moved


@dataclass(frozen=True)
class Fault:
    """What disturbs a run; shares are uniform in [0, 1), and their meaning depends on the kind."""

    kind: str
    problem: str
    seed: int
    share: float  # of the plan's duration, or of the time in a hand
    size: float  # [m], displaced
    angle: float  # [rad], of a direction in the horizontal
    choice: float  # of a body, a joint or a robot
    lasts: float  # share

    @classmethod
    def drawn(cls, kind: str, problem: str, seed: int) -> "Fault":
        """The fault of a kind that a seed gives in a problem."""
        u = uniforms(stream_key("fault", kind, problem, seed), 0, 1, 5)[0].tolist()
        return cls(kind, problem, seed, u[0], 0.03 * u[1], 2.0 * np.pi * u[2], u[3], u[4])


class Disturbance:
    """Makes one fault in physics; called before each time step."""

    def __init__(self, fault: Fault, plan: Plan, scene: Scene) -> None:
        self.fault, self.plan, self.scene = fault, plan, scene
        self.came, self.removed = False, frozenset[str]()
        self.robot: SimulatedRobot | None = None
        self.undo: tuple[float, Callable[[], None]] | None = None
        self._queue: deque[tuple[float, tuple[object, ...]]] = deque()
        self._direct: Callable[..., None] | None = None  # the physics' command, while it is late
        name, lasts = plan.root, 0.0
        while (node := plan.nodes[name]).kind != "goal":
            lasts += max((each.times[-1] for each in node.motion), default=0.0)
            name = node.next or next(iter(node.branches.values()))
        early = fault.kind in ("displaced", "removed") and fault.lasts < 0.3
        self.time = BEFORE if early else 0.5 + 0.9 * fault.share * lasts
        moved = {name for node in plan.nodes.values() if node.after is not None for name in node.after.objects}
        self.bodies = sorted(moved & set(scene.movable))

    def __call__(self, physics: Physics) -> None:
        """Looks whether it is time."""
        self._late(physics)
        if self.undo is not None and physics.time >= self.undo[0]:
            self.undo[1]()
            self.undo = None
        if self.came or (self.robot is None and self.time > BEFORE):
            return
        if physics.time >= self.time:
            self._make(physics)

    def end(self) -> None:
        """Lets go of the robot, which knows the disturbance: such a ring would keep the physics of each run."""
        if self._direct is not None and self.robot is not None:
            del self.robot.physics.command
        self.robot = self.undo = self._direct = None
        self._queue.clear()

    def _make(self, physics: Physics) -> None:
        kind = self.fault.kind
        direction = np.array([np.cos(self.fault.angle), np.sin(self.fault.angle), 0.0])
        if kind == "displaced":
            physics.displace(self._body(self.bodies), self.fault.size * direction)
            self.came = True
        elif kind == "removed":
            self._remove(physics, self._body(self.bodies))
        elif kind == "dropped":
            self._drop(physics)
        elif kind == "closed on nothing":
            self._move_away(physics, (0.08 + 2.0 * self.fault.size) * direction)
        elif kind == "in the way":
            self._put_in_the_way(physics)
        elif kind == "torque halved":
            self._weaken(physics)
        elif kind == "robot stopped":
            self._brake(physics)
        elif kind == "controller late":
            self._delay(physics)

    def _body(self, names: list[str]) -> str:
        return names[int(self.fault.choice * len(names))]

    @property
    def _driven(self) -> SimulatedRobot:
        assert self.robot is not None
        return self.robot

    def _remove(self, physics: Physics, body: str) -> None:
        for geom in range(physics.model.ngeom):
            if physics.model.geom_bodyid[geom] == physics.model.body(body).id:
                physics.model.geom_contype[geom] = physics.model.geom_conaffinity[geom] = 0
        physics.displace(body, np.array([FAR, 0.0, 0.0]))
        self.removed, self.came = frozenset({body}), True

    def _drop(self, physics: Physics) -> None:
        for robot, bodies in self._driven._held.items():
            if self._driven._follower.moving and bodies:
                physics.grip(robot, (), OUTWARDS)

                def again(robot: str = robot, bodies: tuple[str, ...] = bodies) -> None:
                    if physics.pressing(robot) == OUTWARDS:
                        physics.grip(robot, bodies)

                self.undo, self.came = (physics.time + 0.1 + 0.5 * self.fault.lasts, again), True
                return

    def _move_away(self, physics: Physics, offset: Array) -> None:
        follower = self._driven._follower
        for action in follower.motion.actions if follower.motion is not None and follower.moving else ():
            lead = 0.002 + 0.05 * self.fault.lasts
            if action.kind == "grip" and action.time - lead <= follower.time <= action.time:
                _into_the_open(physics, action.attach[0][0], offset)
                self.came = True
                return

    def _put_in_the_way(self, physics: Physics) -> None:
        follower = self._driven._follower
        held = {body for bodies in self._driven._held.values() for body in bodies}
        free = [name for name in self.scene.movable if name not in held]
        if follower.motion is None or not follower.moving or not free:
            return
        ahead = follower.time + 0.2 + 0.8 * self.fault.lasts
        for stretch in follower.motion.at(ahead):
            robot = self.scene.robots[stretch.robot]
            if robot.tool is None or stretch.trajectory.joints != robot.planned_joints:
                continue
            values = [*stretch.trajectory.at(ahead).tolist(), *physics.configuration(robot.name)[robot.planned :]]
            place = link_pose(robot, tuple(values), robot.tool.frame)[:3, 3]
            body = self._body(free)
            if float(np.linalg.norm(offset := place - physics.pose(body)[:3, 3])) > 0.1:
                physics.displace(body, np.array([offset[0], offset[1], 0.0]))
                self.came = True
            return

    def _weaken(self, physics: Physics) -> None:
        arms = [
            number
            for number, motor in enumerate(physics.motors)
            if motor.joint in self.scene.robots[motor.robot].planned_joints
        ]
        physics.model.actuator_gainprm[arms[int(self.fault.choice * len(arms))], 0] *= 0.5
        self.came = True

    def _brake(self, physics: Physics) -> None:
        model, names = physics.model, sorted(self.scene.robots)
        name = self._body(names)
        arms = [k for k, each in enumerate(physics.motors) if each.robot == name]
        rates = [model.joint(physics.motors[k].name).dofadr[0] for k in arms]
        gains, damping = model.actuator_gainprm[arms, 0].copy(), model.dof_damping[rates].copy()
        model.actuator_gainprm[arms, 0], model.dof_damping[rates] = 0.0, BRAKES

        def free() -> None:
            model.actuator_gainprm[arms, 0], model.dof_damping[rates] = gains, damping

        self.undo, self.came = (physics.time + 0.05 + 0.95 * self.fault.lasts, free), True

    def _delay(self, physics: Physics) -> None:
        direct, queue = physics.command, self._queue
        physics.command = lambda *sent: queue.append((physics.time, sent))  # type: ignore[method-assign]
        self._direct, self.came = direct, True

    def _late(self, physics: Physics) -> None:
        while self._queue and self._queue[0][0] <= physics.time - LATE:
            self._direct(*self._queue.popleft()[1])


class FaultySensor(KnownTruth):
    """Says the truth, but for the fault: for a few looks, or in half of the runs for ever."""

    def __init__(self, disturbance: Disturbance, seed: int, poses: Callable[[], Mapping[str, Array]]) -> None:
        super().__init__(seed=seed, poses=poses)
        self.disturbance = disturbance
        broken = disturbance.fault.kind in SENSING and disturbance.fault.choice < 0.5
        self.looks = FOREVER if broken else 1 + int(12 * disturbance.fault.lasts)  # that fail

    def resolve(self, formula: str, outcomes: tuple[str, ...]) -> str | None:
        """The outcome, or none, or another one."""
        disturbance = self.disturbance
        if disturbance.fault.kind in SENSING and self.looks > 0:
            disturbance.came = True
            self.looks -= 1
            return None if disturbance.fault.kind == "sensor silent" else "contradicting"
        return super().resolve(formula, outcomes)

    @property
    def broken(self) -> bool:
        """Whether it fails for ever."""
        return self.looks > FOREVER // 2

    def poses(self) -> Mapping[str, Array]:
        """The poses of what is there."""
        removed = self.disturbance.removed
        return {name: pose for name, pose in super().poses().items() if name not in removed}


def _into_the_open(physics: Physics, body: str, offset: Array) -> None:
    """Moves a body by an offset; in another direction of the horizontal if it would be in something else there."""
    for number in range(TURNS):
        angle = 2.0 * np.pi * number / TURNS
        cosine, sine = np.cos(angle), np.sin(angle)
        turned = np.array(
            [cosine * offset[0] - sine * offset[1], sine * offset[0] + cosine * offset[1], offset[2]]
        )
        physics.displace(body, turned)
        if not any(body in contact.things for contact in physics.contacts(INTO)):
            return
        physics.displace(body, -turned)
    physics.displace(body, offset)
