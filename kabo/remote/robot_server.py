"""The robot server: one client at a time drives its robots; what it sends is checked, and its heartbeats are watched.

A loop lets time pass on the robots' clock, 10 ms at a time, at the pace of real time or faster, and publishes the state
after each. Queries are decoded and checked where they arrive, and obeyed in the loop, since a robot has one thread.
"""

import queue
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import msgspec
import zenoh

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError
from kabo.execution import Robot
from kabo.execution.protocols import PacedRobot
from kabo.language import Measurement
from kabo.remote.checks import check_begin, check_motion
from kabo.remote.messages import (
    MAX_MOTION_BYTES,
    PROTOCOL,
    DriverMessage,
    HandMessage,
    LookedMessage,
    LookMessage,
    MotionMessage,
    PacedMessage,
    PaceMessage,
    StateMessage,
    TakeMessage,
    TakenMessage,
    motion_from,
    spoken,
    state_message,
)
from kabo.remote.served_sensors import ServedSensors
from kabo.remote.steady import steady
from kabo.scene import Scene
from kabo.service import Unreadable, answered, keys, open_session, payload_of, read, refuse, reply

ROBOT_ENDPOINT = "tcp/127.0.0.1:7448"  # one more than that of `kabo serve`, so that both can run
TICK_S = 0.01  # on the robots' clock: between two publications of the state
ABSENT_S = 5.0  # for which a client that rests may be silent without a token that tells when it is lost
BEHIND_S = 0.1  # by which a loop that is late catches up; later than that, the pace is what the machine can do


class ServedRobot(Robot, Protocol):
    """A robot that also sees bodies, as a simulated one does."""

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) in the world of the bodies that are seen now."""


@dataclass(frozen=True)
class RobotServerSettings:
    """How a robot server works.

    Attributes:
        limit_s: after so many seconds without a sign of life from the client, moving robots stop [s]; the client does
            the same. It is looked at every 10 ms: with the default a stop begins within 50 ms of the last sign.
        speed: how many seconds pass on the robots' clock in one second; 1 for hardware.
    """

    limit_s: float = 0.035
    speed: float = 1.0

    def __post_init__(self) -> None:
        """Checks the numbers.

        Raises:
            InputError: one is not a positive finite number.
        """
        for name, value in (("limit_s", self.limit_s), ("speed", self.speed)):
            if not 0.0 < value < float("inf"):
                text = f"{name} is {value:g}, which is not a positive number"
                raise InputError([Diagnostic("robot server", 1, 1, text, None)])


Command = tuple[zenoh.Query, Callable[[], None]]


class RobotServer:
    """Serves the robots of a scene on one zenoh session, from the moment it is made until `close`; `run` is its loop.

    Args:
        config: the configuration of the zenoh session.
        robot: the robots.
        scene: theirs: names and limits.
        settings: how.
        told: called with a sentence when a client comes, goes, or is lost.
        sensors: what it measures; None: nothing but where robots and bodies are.

    Raises:
        ServiceError: an endpoint cannot be used.
    """

    def __init__(
        self,
        config: zenoh.Config,
        robot: ServedRobot,
        scene: Scene,
        settings: RobotServerSettings = RobotServerSettings(),
        told: Callable[[str], None] = lambda sentence: None,
        sensors: ServedSensors | None = None,
    ) -> None:
        self.name = keys.new_server_name()
        self.robot, self.scene, self.settings, self._told = robot, scene, settings, told
        self._commands: queue.Queue[Command] = queue.Queue()
        self._driver: str | None = None
        self._halted: str | None = None  # why the last driver drives no more, if it was lost
        self.sensors = sensors
        self._alive: set[str] = set()  # clients with a token
        self._gone: set[str] = set()  # clients whose connection has ended
        self._heard, self._count = time.monotonic(), 0
        self._session = open_session(config)
        verbs: dict[str, Callable[[zenoh.Query], None]] = {
            "take": partial(self._asked, TakeMessage, self._take),
            "leave": partial(self._asked, DriverMessage, self._leave),
            "stop": partial(self._asked, DriverMessage, self._stop),
            "pace": partial(self._asked, PaceMessage, self._pace),
            "grip": partial(self._asked, HandMessage, self._grip),
            "release": partial(self._asked, HandMessage, self._release),
            "look": partial(self._asked, LookMessage, self._look),
            "follow": self._asked_to_follow,
        }
        self._declared: list[Any] = [
            self._session.declare_queryable(keys.robot(self.name, verb), partial(answered, handler))
            for verb, handler in verbs.items()
        ]
        drivers = keys.driver(self.name, "*")
        self._declared.append(self._session.declare_subscriber(drivers, self._beat))
        self._declared.append(self._session.liveliness().declare_subscriber(drivers, self._seen, history=True))
        self._publisher = self._session.declare_publisher(
            keys.robot(self.name, "state"),
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.INTERACTIVE_HIGH,
            express=True,
        )
        # Last, because from now on clients come.
        self._token = self._session.liveliness().declare_token(keys.robot(self.name, "alive"))

    # --------------------------------------------------------------------------------------------------------- loop
    def run(self, ended: Callable[[], bool]) -> None:
        """Lets time pass and does what clients ask, until it has `ended`; then robots that move are stopped."""
        with steady() as collections:
            period, due = TICK_S / self.settings.speed, time.monotonic()
            while not ended():
                self._watch_driver()
                self.robot.wait(TICK_S)
                collections.wait_for_rest(moving=self._publish())
                due = max(due + period, time.monotonic() - BEHIND_S)
                self._obey_until(due)
            self.robot.stop()
            while self._publish():
                self.robot.wait(TICK_S)

    def close(self) -> None:
        """Ends the session."""
        declared: list[Any] = [self._token, *self._declared, self._publisher]
        for each in declared:
            each.undeclare()
        self._session.close()

    def _obey_until(self, due: float) -> None:
        """Obeys commands as they come, until it is time to go on."""
        while True:
            left = due - time.monotonic()
            try:
                query, command = (
                    self._commands.get(timeout=max(0.0, left)) if left > 0.0 else self._commands.get_nowait()
                )
            except queue.Empty:
                return
            answered(partial(_do, command), query)

    def _watch_driver(self) -> None:
        """Stops the robots of a client that was lost, and lets another one come."""
        driver = self._driver
        if driver is None:
            return
        moving, silent = self.robot.state().moving, time.monotonic() - self._heard
        if driver in self._gone:
            self._let_go(f"the connection to client {driver} was lost", moving=moving)
        elif moving and silent > self.settings.limit_s:
            self._let_go(f"client {driver} gave no sign of life for {1000 * silent:.0f} ms", moving=moving)
        elif driver not in self._alive and silent > max(ABSENT_S, self.settings.limit_s):
            self._let_go(f"client {driver} gave no sign of life for {silent:.0f} s", moving=moving)

    def _let_go(self, why: str, *, moving: bool) -> None:
        self._driver = None
        self._halted = f"{why}; the robots were stopped" if moving else why
        if moving:
            self.robot.stop()
        self._told(self._halted)

    def _publish(self) -> bool:
        """Publishes the state; whether robots move."""
        measured = self._measured()
        with suppress(zenoh.ZError):
            self._publisher.put(msgspec.json.encode(measured))
        return measured.moving

    def _measured(self) -> StateMessage:
        self._count += 1
        poses = self.robot.poses() if self.sensors is None else self.sensors.poses()
        return state_message(self.robot.state(), poses, self._count, self._driver, self._halted)

    # -------------------------------------------------------------------------------------------- signs of clients
    def _beat(self, sample: zenoh.Sample) -> None:
        if keys.driver_of(str(sample.key_expr)) == self._driver:
            self._heard = time.monotonic()

    def _seen(self, sample: zenoh.Sample) -> None:
        client = keys.driver_of(str(sample.key_expr))
        if sample.kind == zenoh.SampleKind.PUT:
            self._alive.add(client)
            self._gone.discard(client)
            return
        self._alive.discard(client)
        if client == self._driver:
            self._gone.add(client)

    # ------------------------------------------------------------------------------------------------------ queries
    def _asked(
        self,
        kind: type[msgspec.Struct],
        command: Callable[[zenoh.Query, Any], None],
        query: zenoh.Query,
    ) -> None:
        """Reads a query where it arrives; the loop does what it asks."""
        raw = payload_of(query)
        if len(raw) > MAX_MOTION_BYTES:
            raise Unreadable(f"a message has up to {MAX_MOTION_BYTES} bytes")
        if kind is TakeMessage:
            _require_protocol(raw)
        message = read(kind, raw)
        self._commands.put((query, partial(command, query, message)))

    def _asked_to_follow(self, query: zenoh.Query) -> None:
        raw = payload_of(query)
        if len(raw) > MAX_MOTION_BYTES:
            raise Unreadable(f"a motion has up to {MAX_MOTION_BYTES} bytes; this one has {len(raw)}")
        message: MotionMessage = read(MotionMessage, raw)
        motion = motion_from(message)
        check_motion(motion, self.scene)

        def follow() -> None:
            if self._drives(query, message.client):
                state = self.robot.state()
                if state.moving:
                    raise Unreadable("a motion is being followed; another one comes when it has ended")
                check_begin(motion, state, self.scene)
                self._heard = time.monotonic()
                self.robot.follow(motion)
                self._say_state(query, "follow")

        self._commands.put((query, follow))

    def _drives(self, query: zenoh.Query, client: str) -> bool:
        """Whether it is this client that drives; otherwise it is refused."""
        if client == self._driver:
            return True
        refuse(
            query,
            "busy",
            self._halted or "take the robots first" if self._driver is None else "another client drives",
        )
        return False

    def _say_state(self, query: zenoh.Query, verb: str) -> None:
        reply(query, keys.robot(self.name, verb), msgspec.json.encode(self._measured()))

    def _take(self, query: zenoh.Query, message: TakeMessage) -> None:
        if self._driver not in (None, message.client):
            return refuse(query, "busy", "another client drives")
        if self.robot.state().moving:
            return refuse(query, "busy", "the robots still move")
        self._driver, self._halted, self._heard = message.client, None, time.monotonic()
        self._gone.discard(message.client)
        self._told(f"client {message.client} drives")
        joints = {name: list(robot.joint_names) for name, robot in self.scene.robots.items()}
        taken = TakenMessage(self.settings.limit_s, joints, list(self.scene.movable), self._measured())
        reply(query, keys.robot(self.name, "take"), msgspec.json.encode(taken))
        return None

    def _leave(self, query: zenoh.Query, message: DriverMessage) -> None:
        if self._drives(query, message.client):
            self._let_go(f"client {message.client} has left", moving=self.robot.state().moving)
            self._say_state(query, "leave")

    def _stop(self, query: zenoh.Query, message: DriverMessage) -> None:
        if self._drives(query, message.client):
            self.robot.stop()
            self._say_state(query, "stop")

    def _pace(self, query: zenoh.Query, message: PaceMessage) -> None:
        if self._drives(query, message.client):
            paced = isinstance(self.robot, PacedRobot) and self.robot.pace(message.rate)
            self._heard = time.monotonic()
            reply(query, keys.robot(self.name, "pace"), msgspec.json.encode(PacedMessage(paced, self._measured())))

    def _grip(self, query: zenoh.Query, message: HandMessage) -> None:
        if self._drives(query, message.client):
            self._require_hand(message)
            self.robot.grip(message.robot, tuple(message.bodies))
            self._say_state(query, "grip")

    def _release(self, query: zenoh.Query, message: HandMessage) -> None:
        if self._drives(query, message.client):
            self._require_hand(message)
            self.robot.release(message.robot, tuple(message.bodies))
            self._say_state(query, "release")

    def _look(self, query: zenoh.Query, message: LookMessage) -> None:
        if self._drives(query, message.client):
            measurement = Measurement(message.kind, tuple(message.things))
            outcomes = None if message.outcomes is None else tuple(message.outcomes)
            reading = None if self.sensors is None else self.sensors.look(message.asked, measurement, outcomes)
            self._heard = time.monotonic()
            looked = LookedMessage(reading, self._measured())
            reply(query, keys.robot(self.name, "look"), msgspec.json.encode(looked))

    def _require_hand(self, message: HandMessage) -> None:
        """Checks the names of what a hand takes or lets go.

        Raises:
            Unreadable: there is no such robot or body.
        """
        if message.robot not in self.scene.robots:
            raise Unreadable(f"there is no robot {message.robot!r}")
        for body in message.bodies:
            if body not in self.scene.movable:
                raise Unreadable(f"there is no movable body {body!r}")


def _require_protocol(raw: bytes) -> None:
    """Checks that a client speaks this protocol, before its message is read.

    Raises:
        Unreadable: it names another one.
    """
    with suppress(msgspec.MsgspecError, UnicodeDecodeError):
        if (protocol := spoken(raw)) != PROTOCOL:
            raise Unreadable(f"this server speaks {PROTOCOL}, and the client {protocol[:40]!r}")


def _do(command: Callable[[], None], query: zenoh.Query) -> None:
    """Does what a query asked for when it arrived."""
    command()
