"""A robot of another process: what the executor asks is sent as messages, and what is measured comes as a publication.

While the executor waits, each wait is a heartbeat: so the server knows that somebody looks at its robots, not only that a
process is there.
"""

import threading
import time
import uuid
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

import msgspec
import zenoh

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError, ServiceError
from kabo.execution import Motion, RobotFailed, RobotState
from kabo.remote.messages import (
    DriverMessage,
    HandMessage,
    StateMessage,
    TakenMessage,
    motion_message,
    poses_from,
    state_from,
)
from kabo.scene import Scene
from kabo.service import ErrorReply, keys, open_session

BEAT_S = 0.01  # between two heartbeats
ANSWER_S = 5.0  # in which a server answers that is there
STOPPING_S = (
    1.0  # for which a server may be silent when it was asked to stop, since it looks for the fastest stop then
)


class ZenohRobot:
    """All robots of a scene, driven by a robot server elsewhere; a context manager, which lets the robots go at its end.

    Args:
        config: the configuration of the zenoh session.
        scene: the scene: the server has the same robots and bodies.
        patience_s: how long to wait for a server that can be taken [s].

    Raises:
        ServiceError: there is no robot server in time, or others drive it.
        InputError: the server's scene is another one.
    """

    def __init__(self, config: zenoh.Config, scene: Scene, patience_s: float = 5.0) -> None:
        self.scene, self.client = scene, uuid.uuid4().hex[:12]
        self._news = threading.Condition()
        self._latest: StateMessage | None = None
        self._arrived = self._resumed = time.monotonic()
        self._patient_until = 0.0  # for as long as a server may be silent
        self._lost: str | None = None
        self._asking: set[zenoh.CancellationToken] = set()
        self._session = open_session(config)
        try:
            self.server, taken = self._take(patience_s)
            self._require_same(taken)
        except BaseException:
            self._session.close()
            raise
        self._limit = taken.limit_s
        self._believe(taken.state)
        own = keys.driver(self.server, self.client)
        liveliness = self._session.liveliness()
        self._beats = self._session.declare_publisher(own, express=True, priority=zenoh.Priority.INTERACTIVE_HIGH)
        self._declared: list[Any] = [
            liveliness.declare_token(own),
            liveliness.declare_subscriber(keys.robot(self.server, "alive"), self._seen, history=True),
            self._session.declare_subscriber(keys.robot(self.server, "state"), self._told),
            self._beats,
        ]

    def __enter__(self) -> "ZenohRobot":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Lets the robots go, and ends the session; robots that still move are stopped by the server."""
        if self._lost is None:
            with suppress(RobotFailed):
                self._ask("leave", DriverMessage(self.client))
        for each in self._declared:
            each.undeclare()
        self._session.close()

    # ------------------------------------------------------------------------------------------------- as a robot
    def follow(self, motion: Motion) -> None:
        """Sends a motion; the server follows it from now on."""
        self._command("follow", motion_message(self.client, motion))

    def stop(self) -> None:
        """Asks for a planned stop."""
        self._patient_until = time.monotonic() + STOPPING_S
        self._command("stop", DriverMessage(self.client))

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Lets a hand press."""
        self._command("grip", HandMessage(self.client, robot, list(bodies)))

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        """Lets a hand press no more."""
        self._command("release", HandMessage(self.client, robot, list(bodies)))

    def state(self) -> RobotState:
        """What was measured last, also of a server that was lost."""
        assert self._latest is not None
        return state_from(self._latest)

    def poses(self) -> Mapping[str, Array]:
        """The poses (4, 4) of the bodies that were seen last."""
        assert self._latest is not None
        return poses_from(self._latest)

    def wait(self, seconds: float) -> None:
        """Waits until so much time has passed on the robots' clock; meanwhile the server is given signs of life.

        Raises:
            RobotFailed: the server is lost, or gave this client up.
        """
        assert self._latest is not None
        until = self._latest.time + seconds - 1e-9
        while True:
            self._beat()
            with self._news:
                begun = time.monotonic()
                if self._latest.time < until:
                    self._news.wait(BEAT_S)
                now = time.monotonic()
            if now - begun > 3.0 * BEAT_S:  # this process got no time itself: what was sent meanwhile comes now
                self._resumed = now
            self._require_server(now)
            if self._latest.time >= until:
                return

    def _beat(self) -> None:
        with suppress(zenoh.ZError):
            self._beats.put(b"")

    def _require_server(self, now: float) -> None:
        """Checks that the server is there, and that this client drives.

        Raises:
            RobotFailed: it is not.
        """
        assert self._latest is not None
        silent = now - max(self._arrived, self._resumed)
        if self._lost is None and silent > self._limit and now > self._patient_until:
            self._lost = f"the robot server {self.server} gave no sign of life for {1000 * silent:.0f} ms"
        if self._lost is None and self._latest.driver != self.client:
            self._lost = f"the robot server gave up: {self._latest.halted or 'another client drives'}"
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
                answer = self._get(server, "take", DriverMessage(self.client))
                if isinstance(answer, bytes):
                    return server, msgspec.json.decode(answer, type=TakenMessage)
                told = "" if answer is None else answer.message
            if time.monotonic() > until:
                said = (
                    f"the robot server {found[0]} cannot be taken: {told}" if told else "no robot server answers"
                )
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
        self._believe(msgspec.json.decode(self._ask(verb, message), type=StateMessage))

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
        """Takes over a state, unless a later one is here already."""
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


def _difference(own: Mapping[str, list[str]], taken: TakenMessage, scene: Scene) -> str:
    """What one scene has and the other has not."""
    here = {*own, *(f"{name}.{joint}" for name in own for joint in own[name]), *scene.movable}
    there = {*taken.robots, *(f"{n}.{j}" for n in taken.robots for j in taken.robots[n]), *taken.bodies}
    only = sorted(here ^ there)
    return ", ".join(only[:4]) + (" …" if len(only) > 4 else "") if only else "the order of joints"
