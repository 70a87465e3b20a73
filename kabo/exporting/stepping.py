"""The executor, one look at a time: it runs in a thread of its own, which goes on only while somebody asks it to.

So what is ticked, such as a tree of behaviours, can carry a plan out by `kabo.execution.execute` itself, with all that it
watches, and is never blocked for longer than the time between two looks. Only one of both threads runs at any time.
"""

import threading
from collections.abc import Callable
from typing import Any

from kabo.execution import ExecutionSettings, Log, Motion, Robot, RobotState, Run, Sensor, execute
from kabo.plan import Plan
from kabo.scene import Scene


class _Abandoned(Exception):  # noqa: N818 - it ends a thread whose work nobody wants any more
    pass


class Stepping:
    """A run of a plan that goes on by `step`.

    Attributes:
        node: the node that is under way, or at which the run ended; None before the first step.
        outcomes: what was found at nodes that sense or decide.
        run: how it ended; None while it goes on.
    """

    def __init__(
        self, plan: Plan, scene: Scene | None, robot: Robot | None, sensor: Sensor, settings: ExecutionSettings
    ) -> None:
        self.node: str | None = None
        self.outcomes: dict[str, str] = {}
        self.run: Run | None = None
        self._robot = robot
        self._error: Exception | None = None
        self._own_turn, self._other_turn = threading.Semaphore(0), threading.Semaphore(0)
        self._abandoned = False
        stepped = None if robot is None else _SteppedRobot(robot, self._hand_over)
        log = Log(listener=self._hear)
        self._work: Callable[[], Run] = lambda: execute(plan, scene, stepped, sensor, settings, log)
        self._thread: threading.Thread | None = None

    def step(self) -> None:
        """Goes on until time has to pass, the next node begins, or the run ends.

        Raises:
            InputError, and what the robot or a sensor raises: as of `execute`.
        """
        if self.run is not None or self._abandoned:
            return
        if self._thread is None:
            self._thread = threading.Thread(target=self._carry_out, name="kabo execution", daemon=True)
            self._thread.start()
        else:
            self._own_turn.release()
        self._other_turn.acquire()
        if self._error is not None:
            raise self._error

    def abandon(self) -> None:
        """Stops the robots along their path, and ends the run where it is."""
        if self._thread is None or self.run is not None or self._abandoned:
            return
        self._abandoned = True
        if self._robot is not None:
            self._robot.stop()
        self._own_turn.release()
        self._thread.join()

    def _carry_out(self) -> None:
        try:
            self.run = self._work()
            self.node = self.run.node
        except _Abandoned:
            pass
        except Exception as error:  # noqa: BLE001 - raised again where the steps are asked for
            self._error = error
        self._other_turn.release()

    def _hand_over(self) -> None:
        if self._abandoned:
            raise _Abandoned
        self._other_turn.release()
        self._own_turn.acquire()
        if self._abandoned:
            raise _Abandoned

    def _hear(self, record: dict[str, Any]) -> None:
        if record["event"] == "node":
            self.node = record["node"]
            self._hand_over()
        elif record["event"] == "sensing" and isinstance(record.get("outcome"), str):
            self.outcomes[record["node"]] = record["outcome"]


class _SteppedRobot:
    """A robot that lets others act before time passes."""

    def __init__(self, robot: Robot, hand_over: Callable[[], None]) -> None:
        self._robot, self._hand_over = robot, hand_over

    def follow(self, motion: Motion) -> None:
        self._robot.follow(motion)

    def stop(self) -> None:
        self._robot.stop()

    def grip(self, robot: str, bodies: tuple[str, ...]) -> None:
        self._robot.grip(robot, bodies)

    def release(self, robot: str, bodies: tuple[str, ...]) -> None:
        self._robot.release(robot, bodies)

    def state(self) -> RobotState:
        return self._robot.state()

    def wait(self, seconds: float) -> None:
        self._hand_over()
        self._robot.wait(seconds)
