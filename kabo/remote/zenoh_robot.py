"""A robot of another process: what the executor asks is sent as messages, and what is measured comes as a publication.

While the executor waits, each wait is a heartbeat: so the server knows that somebody looks at its robots, not only that a
process is there. What is measured changes only while the executor waits or commands, so robots and bodies are of one time.
"""

import threading
import time
import uuid
from collections.abc import Mapping
from contextlib import ExitStack, suppress
from typing import Any, TypeVar

import msgspec
import zenoh

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, ServiceError
from kabo.execution import Motion, RobotFailed, RobotState
from kabo.execution.bound_sensors import Reading
from kabo.language import Measurement
from kabo.remote.messages import (
    PROTOCOL,
    DriverMessage,
    HandMessage,
    LookedMessage,
    LookMessage,
    PacedMessage,
    PaceMessage,
    StateMessage,
    TakeMessage,
    TakenMessage,
    fits,
    motion_message,
    poses_from,
    spoken,
    state_from,
)
from kabo.remote.steady import steady
from kabo.scene import Scene
from kabo.service import ErrorReply, connected_endpoints, keys, open_session

_Reply = TypeVar("_Reply", bound=msgspec.Struct)
BEAT_S = 0.01  # between two heartbeats
ANSWER_S = 5.0  # in which a server answers that is there
STOPPING_S = (
    1.0  # for which a server may be silent that was asked to stop or slow down, since it then looks for a way
)


class ZenohRobot:
    """All robots of a scene, driven by a robot server elsewhere; a context manager, which lets the robots go at its end.

    Args:
        config: the configuration of the zenoh session.
        scene: the scene: the server has the same robots and bodies.
        patience_s: how long to wait for a server that can be taken [s].

    Raises:
        ServiceError: there is no robot server in time, others drive it, or it speaks another protocol.
        InputError: the server's scene is another one.
    """

    def __init__(self, config: zenoh.Config, scene: Scene, patience_s: float = 5.0) -> None:
        self.scene, self.client = scene, uuid.uuid4().hex[:12]
        self._news = threading.Condition()
        self._latest: StateMessage | None = None  # that has arrived
        self._now: StateMessage  # as the executor has it
        self._arrived = self._resumed = self._left = time.monotonic()
        self._patient_until = 0.0  # for as long as a server may be silent
        self._lost: str | None = None
        self._asking: set[zenoh.CancellationToken] = set()
        self._joints = {name: robot.joint_names for name, robot in scene.robots.items()}
        self._declared: list[Any] = []
        ends = ", ".join(connected_endpoints(config))
        self._unanswered = f"no robot server answers{ends and f' at {ends}'}"
        self._session = open_session(config)
        try:
            self.server, taken = self._take(patience_s)
            self._require_same(taken)
        except BaseException:
            self._end()
            raise
        self._limit, self._latest = taken.limit_s, taken.state
        own = keys.driver(self.server, self.client)
        self._beats = self._session.declare_publisher(own, express=True, priority=zenoh.Priority.INTERACTIVE_HIGH)
        alive, state = keys.robot(self.server, "alive"), keys.robot(self.server, "state")
        self._declared += [
            self._beats,
            self._session.liveliness().declare_subscriber(alive, self._seen, history=True),
            self._session.declare_subscriber(state, self._told),
        ]
        self._steady = ExitStack()
        self._collections = self._steady.enter_context(steady())
        self._look_again()

    def __enter__(self) -> "ZenohRobot":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Lets the robots go, and ends the session; robots that still move are stopped by the server."""
        if self._lost is None:
            with suppress(RobotFailed):
                self._ask("leave", DriverMessage(self.client))
        self._steady.close()
        self._end()

    def _end(self) -> None:
        for each in self._declared:
            each.undeclare()
        self._session.close()

    # ------------------------------------------------------------------------------------------------- as a robot
    def follow(self, motion: Motion) -> None:
        """Sends a motion; the server follows it from now on."""
        self._collections.wait_for_rest(moving=True)
        self._command("follow", motion_message(self.client, motion))

    def stop(self) -> None:
        """Asks for a planned stop."""
        self._patient_until = time.monotonic() + STOPPING_S
        self._command("stop", DriverMessage(self.client))

    def pace(self, rate: float) -> bool:
        """Asks for another rate of the motion's clock; whether the server goes to it."""
        self._patient_until = time.monotonic() + STOPPING_S
        paced = self._answer("pace", PaceMessage(self.client, rate), PacedMessage)
        self._take_over(paced.state)
        return paced.paced

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Lets a hand press."""
        self._command("grip", HandMessage(self.client, robot, list(bodies)))

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Lets a hand press no more."""
        self._command("release", HandMessage(self.client, robot, list(bodies)))

    def state(self) -> RobotState:
        """What was measured last, also of a server that was lost."""
        return state_from(self._now)

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) of the bodies that are seen in the state that was measured last."""
        return {name: pose for name, pose in poses_from(self._now).items() if name in self.scene.bodies}

    @property
    def time(self) -> float:
        """Of the robots' clock [s]."""
        return self._now.time

    def read(self, measurement: Measurement) -> Reading:
        """What the server reads, for no question."""
        return self.look("", measurement, None)

    def look(self, asked: str, measurement: Measurement, outcomes: tuple[str, ...] | None) -> Reading:
        """One look of the server's sensors at what is asked: a number, yes or no, or one of the outcomes.

        Raises:
            RobotFailed: the server is lost, or refuses.
        """
        told = None if outcomes is None else list(outcomes)
        message = LookMessage(self.client, asked, measurement.kind, list(measurement.things), told)
        looked = self._answer("look", message, LookedMessage)
        self._take_over(looked.state)
        return looked.reading

    def wait(self, seconds: float) -> None:
        """Waits until so much time has passed on the robots' clock; meanwhile the server is given signs of life.

        Raises:
            RobotFailed: the server is lost, or gave this client up.
        """
        until, left = self._now.time + seconds - 1e-9, self._left
        while True:
            self._beat()
            with self._news:
                assert self._latest is not None
                if self._latest.time < until:
                    self._news.wait(BEAT_S)
                now = time.monotonic()
            if (
                now - left > 3.0 * BEAT_S
            ):  # it did something else, or got no time: what was sent meanwhile comes now
                self._resumed = now
            left = self._left = now
            self._look_again()
            self._require_server(now)
            if self._now.time >= until:
                return

    def _look_again(self) -> None:
        """Takes over what has arrived."""
        with self._news:
            assert self._latest is not None
            self._now = self._latest
        self._collections.wait_for_rest(moving=self._now.moving)

    def _beat(self) -> None:
        with suppress(zenoh.ZError):
            self._beats.put(b"")

    def _require_server(self, now: float) -> None:
        """Checks that the server is there, and that this client drives.

        Raises:
            RobotFailed: it is not.
        """
        silent = now - max(self._arrived, self._resumed)
        if self._lost is None and silent > self._limit and now > self._patient_until:
            self._lost = f"the robot server {self.server} gave no sign of life for {1000 * silent:.0f} ms"
        if self._lost is None and self._now.driver != self.client:
            self._lost = f"the robot server gave up: {self._now.halted or 'another client drives'}"
        if self._lost is not None:
            raise RobotFailed(self._lost)

    # --------------------------------------------------------------------------------------------------- messages
    def _take(self, patience_s: float) -> tuple[str, TakenMessage]:
        """The first robot server that can be taken, with what it says."""
        until, told = time.monotonic() + patience_s, ""
        while True:
            found = [
                keys.server_of(str(each.ok.key_expr))
                for each in self._session.liveliness().get(keys.ALL_ROBOTS, timeout=1.0)
                if each.ok
            ]
            for server in sorted(found):
                token = self._session.liveliness().declare_token(keys.driver(server, self.client))
                answer = self._get(server, "take", TakeMessage(self.client))
                if isinstance(answer, bytes):
                    self._declared.append(token)
                    return server, _taken(server, answer)
                token.undeclare()
                told = "" if answer is None else answer.message
                if answer is not None and answer.code == "bad_request":
                    raise ServiceError("unavailable", f"the robot server {server} cannot be taken: {told}")
            if time.monotonic() > until:
                said = f"the robot server {found[0]} cannot be taken: {told}" if told else self._unanswered
                raise ServiceError("unavailable", f"{said}; `kabo simulate SCENE --serve` starts one")
            time.sleep(0.05)

    def _require_same(self, taken: TakenMessage) -> None:
        own = {name: list(robot.joint_names) for name, robot in self.scene.robots.items()}
        if own != taken.robots or sorted(self.scene.movable) != sorted(taken.bodies):
            text = f"the robot server {self.server} has another scene: {_difference(own, taken, self.scene)}"
            raise InputError([Diagnostic(self.scene.name, 1, 1, text, "serve the scene of the plan's problem")])

    def _command(self, verb: str, message: msgspec.Struct) -> None:
        """Asks the server for something, and takes over the state after it.

        Raises:
            RobotFailed: the server is lost, or refuses.
        """
        self._beat()
        self._take_over(self._answer(verb, message, StateMessage))

    def _take_over(self, state: StateMessage) -> None:
        self._believe(state)
        self._left = time.monotonic()
        self._look_again()

    def _answer(self, verb: str, message: msgspec.Struct, kind: type[_Reply]) -> _Reply:
        raw = self._ask(verb, message)
        try:
            return msgspec.json.decode(raw, type=kind)
        except (msgspec.MsgspecError, UnicodeDecodeError) as error:
            self._lost = f"the robot server {self.server} replies to {verb} with what is no message: {error}"
            raise RobotFailed(self._lost) from None

    def _ask(self, verb: str, message: msgspec.Struct) -> bytes:
        if self._lost is None:
            answer = self._get(self.server, verb, message)
            if isinstance(answer, bytes):
                return answer
            if answer is not None:
                raise RobotFailed(f"the robot server refuses to {verb}: {answer.message}")
            self._lost = self._lost or f"the robot server {self.server} does not answer"
        raise RobotFailed(self._lost)

    def _get(self, server: str, verb: str, message: msgspec.Struct) -> bytes | ErrorReply | None:
        """The answer to a query; None if there is none."""
        token = zenoh.CancellationToken()
        self._asking.add(token)
        key, payload = keys.robot(server, verb), msgspec.json.encode(message)
        block = zenoh.CongestionControl.BLOCK
        try:
            for each in self._session.get(
                key, payload=payload, timeout=ANSWER_S, cancellation_token=token, congestion_control=block
            ):
                if each.ok is not None:
                    return bytes(each.ok.payload.to_bytes())
                if (
                    each.err is not None and str(each.err.encoding) == "application/json"
                ):  # else zenoh's own: the time is up
                    return msgspec.json.decode(each.err.payload.to_bytes(), type=ErrorReply)
        except (zenoh.ZError, msgspec.MsgspecError):
            return None
        finally:
            self._asking.discard(token)
        return None

    def _told(self, sample: zenoh.Sample) -> None:
        with suppress(msgspec.MsgspecError, UnicodeDecodeError):
            self._believe(msgspec.json.decode(sample.payload.to_bytes(), type=StateMessage))

    def _believe(self, message: StateMessage) -> None:
        """Notes a state that has arrived, unless a later one is here already."""
        if not fits(message, self._joints):
            self._lost = self._lost or f"the robot server {self.server} sends states that are not of this scene"
            return
        with self._news:
            self._arrived = time.monotonic()
            if self._latest is None or message.count > self._latest.count:
                self._latest = message
                self._news.notify_all()

    def _seen(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.DELETE:
            with self._news:
                self._lost = self._lost or f"the robot server {self.server} is gone"
                self._news.notify_all()
            for token in list(self._asking):  # what was asked of it ends now
                token.cancel()


def _taken(server: str, raw: bytes) -> TakenMessage:
    """What a server that was taken says.

    Raises:
        ServiceError: it speaks another protocol.
    """
    try:
        protocol = spoken(raw)
        if protocol == PROTOCOL:
            return msgspec.json.decode(raw, type=TakenMessage)
        text = f"speaks {protocol}, and this is {PROTOCOL}"
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        text = f"replies with what is no message of {PROTOCOL}: {error}"
    raise ServiceError("unavailable", f"the robot server {server} {text}")


def _difference(own: Mapping[str, list[str]], taken: TakenMessage, scene: Scene) -> str:
    """What one scene has and the other has not."""
    here = {*own, *(f"{name}.{joint}" for name in own for joint in own[name]), *scene.movable}
    there = {*taken.robots, *(f"{n}.{j}" for n in taken.robots for j in taken.robots[n]), *taken.bodies}
    only = sorted(here ^ there)
    return ", ".join(only[:4]) + (" …" if len(only) > 4 else "") if only else "the order of joints"
