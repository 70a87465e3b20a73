"""The executor: walks a plan from its root to a goal, or to a safe stop with its reason [K 6.1.3; T 3.8].

States of a run, each logged when it is entered: `node`, `moving`, `gripping`, `releasing`, `sensing`, `stopping`,
`answer`, `proven`, and at the end `goal` or `stopped`. The state by the plan changes only when a motion has succeeded.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from math import ceil
from types import NoneType

import numpy as np

from kabo.arrays import Array
from kabo.errors import InputError
from kabo.execution.carrying import SETTLED_AFTER, Carrier, Stopped
from kabo.execution.interruptions import (
    SAME_PLACE,
    Answer,
    Executed,
    Interruption,
    Recovery,
    Stop,
    begun_nodes,
    ended_nodes,
    hand_within_limits,
    observed,
)
from kabo.execution.log import Log
from kabo.execution.protocols import Robot, RobotFailed, Sensor
from kabo.execution.repetitions import Repetitions
from kabo.execution.runs import Run
from kabo.execution.settings import USUAL, ExecutionSettings
from kabo.execution.watching import Surprise
from kabo.given import require_function, require_given, require_methods
from kabo.plan import Plan, State, state_after
from kabo.scene import Scene
from kabo.verify import Report

AT_REST, MOST_RESTS = 2e-4, 30  # [m, or of a turn] within which a body stays between two looks; how many looks
RESTING_PICTURES = 4.0  # of a slow camera, for which is waited as well: two that are alike, and one that was lost


def execute(
    plan: Plan,
    scene: Scene | None,
    robot: Robot | None,
    sensor: Sensor,
    settings: ExecutionSettings = USUAL,
    log: Log | None = None,
    stop: Callable[[], bool] = lambda: False,
    recovery: Recovery | None = None,
    report: Report | None = None,
) -> Run:
    """Carries out a plan until a goal is reached, or something happens that no proof covers.

    Args:
        plan: a plan that was verified.
        scene: of the problem; None for a plan without motions.
        robot: all robots of the scene; None for a plan without motions.
        sensor: answers what the plan asks.
        settings: how.
        log: where records go; None: a new one, which is in the result.
        stop: asked at each look; if true, all robots come to a planned stop.
        recovery: asked after a surprise how to go on; None: the run ends there.
        report: of `kabo.verify` about this plan: then each body may be off by what is proven of it, for the rest of
            the plan and by direction; None: by the least clearance that the plan states.

    Raises:
        ArgumentError: an argument is of a wrong kind.
        InputError: the plan does not fit the scene, or has less proven clearance than the robots' tracking error.
    """
    require_given("plan", plan, Plan)
    require_given("scene", scene, Scene, NoneType)
    require_given("settings", settings, ExecutionSettings)
    require_given("log", log, Log, NoneType)
    require_given("report", report, Report, NoneType)
    require_methods("sensor", sensor, "resolve", "value", "poses")
    if robot is not None:
        require_methods("robot", robot, "follow", "stop", "grip", "release", "state", "wait")
    require_function("stop", stop)
    if recovery is not None:
        require_methods("recovery", recovery, "answer")
    return _Executor(plan, scene, robot, sensor, settings, log or Log(), stop, recovery, report).run()


class _Executor(Carrier):
    """A run: the plan, and after each surprise the one that it goes on with."""

    def __init__(
        self,
        plan: Plan,
        scene: Scene | None,
        robot: Robot | None,
        sensor: Sensor,
        settings: ExecutionSettings,
        log: Log,
        stop: Callable[[], bool],
        recovery: Recovery | None,
        report: Report | None,
    ) -> None:
        super().__init__(plan, scene, robot, sensor, settings, log, stop, report)
        self.recovery = recovery
        self.followed: list[tuple[str, str | None]] = []  # nodes of former plans
        self.repetitions = Repetitions(settings.most_recoveries)
        self.rest: Answer | None = None  # with what a plan begins, whose whole is being made

    def run(self) -> Run:
        """Carries out the plan; robots stop also where a robot or a sensor fails, or the program is interrupted."""
        ended = None
        try:
            ended = self._run()
        finally:
            if ended is None:
                self._abandon()
        return ended

    def _run(self) -> Run:
        self._enter("start", problem=self.plan.problem)
        while True:
            stop = self._stop_of(self._walk)
            if stop is None:
                self._enter("goal", node=self.name)
                return self._ended(True, "the goal is reached", None)
            stop = self._stop_of(partial(self._recover, stop))
            if stop is not None:
                self._enter("stopped", node=self.name, reason=stop.reason)
                return self._ended(False, *stop)

    def _stop_of(self, act: Callable[[], None]) -> Stop | None:
        """Does something; how it was stopped, or None. An exception that is kept would keep all of the run, in a ring."""
        try:
            act()
        except Stopped as stopped:
            return stopped.stop
        except RobotFailed as lost:
            self._abandon()
            return Stop(str(lost))
        return None

    def _abandon(self) -> None:
        """Asks robots that may move to stop, whether they hear it or not."""
        if self.robot is not None and self.part is not None:
            with suppress(Exception):
                self.robot.stop()

    def _walk(self) -> None:
        """Carries out the plan to its goal."""
        self._require_begin()
        while True:
            if self.history:
                self._require_proven()
            node = self.plan.nodes[self.name]
            if node.kind == "goal":
                return
            if self.stop():
                raise Stopped("it was asked to stop")
            self.name = self._after(node)

    def _require_proven(self) -> None:
        """Waits for the rest of a plan of which only the first motion was made and proven before it began.

        Raises:
            Stopped: it is not proven, or has less proven clearance than the robots' tracking error.
        """
        if self.rest is None or self.rest.rest is None or self.rest.plan is not self.plan:
            return
        whole, self.rest = self.rest.rest(), None
        text = whole.reason
        if whole.plan is not None:
            try:
                self._take(whole.plan, whole.report)
                self.watch.margins, text = self.margins, ""
            except InputError as error:
                text = str(error).rstrip("\n")
        self._enter("proven", node=self.name, rest=not text)
        if text:
            text = f"the rest of the plan is not proven: {text}"
            raise Stopped(text, Surprise("unproven", text, self.name, 0.0, 0.0))

    def _require_begin(self) -> None:
        """Checks that robots stand where the plan begins; if not, nothing of it is proven.

        Raises:
            Stopped: a robot stands elsewhere.
        """
        if self.robot is None or self.scene is None or not self.plan.nodes[self.name].motion:
            return
        state = self.robot.state()
        if not self.repetitions.answers and not self.history and self.plan.start is not None:
            held = {self.belief.holder(body) for body in self.scene.movable}
            for name in sorted(set(state.pressing) - held):
                raise Stopped(f"the hand of {name} presses already, and the plan does not know what it holds")
        surprise = self.watch.elsewhere(state, self.belief, self.name)
        if surprise is not None:
            raise Stopped(surprise.sentence, surprise)

    def _ended(self, reached_goal: bool, reason: str, surprise: Surprise | None) -> Run:
        self._count_ended()
        history = (*self.followed, *self.history)
        return Run(reached_goal, reason, self.name, history, self._state()[0], surprise, self.log)

    # ------------------------------------------------------------------------------------------------- surprises
    def _state(self, *, exact: bool = False) -> tuple[State, tuple[tuple[str, str], ...]]:
        """What was done and where everything is, as it is observed; and what hands do not hold any more.

        `exact`: small errors stay in.
        """
        if self.scene is None or self.robot is None:
            return state_after(self.plan, self.history), ()
        measured = self.robot.state()
        belief = self.watch.corrected(measured, self.belief)
        empty = self.watch.empty_hands(measured, belief)
        change, lost = observed(self.scene, self.plan, belief, self._seen(), empty, exact=exact)
        return state_after(self.plan, self.history, robots=change.robots, objects=change.objects), lost

    def _count_ended(self) -> None:
        """Nodes of which the motion is over are done, wherever a body is seen; not if a hand has lost what it held."""
        ended, self.ended = self.ended, ()
        if not ended or self._state()[1]:
            return
        self.executed = [each for each in self.executed if each.node not in ended]
        for name in ended:
            self.name = self._left(name)

    def _recover(self, stop: Stop) -> None:
        """Goes on after a surprise, if there is a plan from where all is now.

        Raises:
            Stopped: there is none; it says why.
        """
        on_way = False
        while True:
            self._require_progress(stop, on_way=on_way)
            answer = self._answer(stop)
            try:
                if answer.kind not in ("finish", "undo"):
                    self.followed += self.history
                    self._begin_with(answer)
                    self.rest = None if answer.rest is None else answer
                    return
                ended = self._detour(answer)
            except InputError as error:
                raise Stopped(f"{stop.reason}; {error}", stop.surprise) from None
            stop, on_way = ended or stop, ended is not None

    def _require_progress(self, stop: Stop, *, on_way: bool) -> None:
        """Checks that it may go on after a surprise, and counts it; one on a way out of a node ends only the way.

        Raises:
            Stopped: it may not, or the same thing has surprised at the same action again and again.
        """
        if self.recovery is None or stop.surprise is None:
            raise Stopped(*stop)
        done = len(self.followed) + len(self.history)
        given_up = self.repetitions.add(stop, self.plan.nodes[self.name], done, on_way=on_way)
        if given_up is not None:
            raise Stopped(f"{stop.reason}, {given_up}".removesuffix(", "), stop.surprise)

    def _answer(self, stop: Stop) -> Answer:
        """How to go on from where all rests, as the recovery says; it has a plan.

        Raises:
            Stopped: not at all; it says why.
        """
        assert self.recovery is not None and stop.surprise is not None
        self._come_to_rest(stop)
        surprise = self._gone() or stop.surprise
        if surprise.kind == "gone":  # it may be anywhere: nothing that moves is proven
            known = stop.surprise.kind == "gone"
            raise Stopped(stop.reason if known else f"{stop.reason}; {surprise.sentence}", surprise)
        again = self.repetitions.is_again()
        self._count_ended()
        state, lost = self._state(exact=again)  # what was taken out may be what surprised
        if lost:
            self._let_go_of(lost)
            self._come_to_rest(stop)
            state, _ = self._state(exact=again)
        expected = state_after(self.plan, self.history).geometry
        answer = self.recovery.answer(
            Interruption(self.plan, state, tuple(self.executed), lost, surprise, expected)
        )
        self._enter("answer", kind=answer.kind, reason=answer.reason)
        if answer.plan is None:
            raise Stopped(f"{stop.reason}; {answer.reason}", stop.surprise)
        return answer

    def _begin_with(self, answer: Answer) -> None:
        """Begins with the plan of an answer."""
        assert answer.plan is not None
        self._begin(answer.plan, answer.report)

    def _let_go_of(self, lost: tuple[tuple[str, str], ...]) -> None:
        """Hands press no more on what they do not hold as planned: it stays, or falls from where it is."""
        measured = self._robot.state().positions
        for body, robot in lost:
            self._robot.release(robot, (body,))
            own = self.watch.scene.robots[robot]
            hand = hand_within_limits(own, measured[robot][own.planned :])
            self.belief.move(robot, own.gripper_joints, np.array([hand[joint] for joint in own.gripper_joints]))
            self.belief.let_go(body, robot)

    def _come_to_rest(self, stop: Stop) -> None:
        """Waits until no body moves that is seen, and robots are where they were sent; not for ever.

        Raises:
            Stopped: a robot is somewhere else: nothing is proven from there.
        """
        last, stands = dict(self._seen()), set[str]()
        for _ in range(max(MOST_RESTS, ceil(RESTING_PICTURES * self.picture / SETTLED_AFTER))):
            now: dict[str, Array] = {}
            for _ in self._looks(SETTLED_AFTER):
                now |= self._look()
            means = self.looks.poses(now)
            now = {name: means[name] for name in now}
            allowed = self.looks.still(AT_REST)
            stands -= set(now)
            stands |= {each for each in now if each in last and np.abs(now[each] - last[each]).max() < allowed}
            last |= now
            tracked = stop.surprise is not None and stop.surprise.kind == "tracking"
            late = self.watch.not_at_rest(self._robot.state(), self.belief) if tracked else None
            known = self._gone() is not None or stands.issuperset(self.sightings)
            if late is None and known and stands.issuperset(now) and self.looks.are_enough(SAME_PLACE):
                return
        if late is not None:
            raise Stopped(f"{stop.reason}; {late}, and does not come back", stop.surprise)

    def _look(self) -> Mapping[str, Array]:
        """The poses (4, 4) of bodies that are seen now; with noise, each is one more look for its mean."""
        state = self._robot.state()
        seen = self._poses(state.time)
        if self.looks.noise is not None:
            self.watch.look(seen, state, self.belief)
        return seen

    def _seen(self) -> Mapping[str, Array]:
        """The poses (4, 4) of bodies, as they were seen last since robots stand; with noise, the means of looks at them."""
        return self.looks.poses(self._look())

    def _gone(self) -> Surprise | None:
        return self.watch.gone(self.time, self.name)

    def _detour(self, way: Answer) -> Stop | None:
        """Follows a way out of the middle of the node, to its end, or back to where it began.

        Returns:
            the surprise that has ended the way before; then the node is given up where the robots stand.
        """
        plan, name, history, margins = self.plan, self.name, self.history, self.margins
        begun, ended = begun_nodes(plan, self.executed), None
        try:
            self._follow_way(way)
        except Stopped as stopped:
            if stopped.stop.surprise is None:
                raise
            ended = stopped.stop
        finally:  # what was done is told by the plan, whatever becomes of the way
            over = bool(self.ended)
            self.plan, self.name, self.history, self.executed, self.ended = plan, name, history, [], ()
            self.margins = self.watch.margins = margins
        if way.kind == "finish" and ended is None:
            for each in begun:
                self.name = self._left(each)
        elif way.kind == "finish" and over:  # what has surprised was seen at its end
            whole = [Executed(each, k) for each in begun for k in range(len(plan.nodes[each].motion))]
            self.ended = ended_nodes(plan, whole)
        return ended

    def _follow_way(self, way: Answer, *, again: bool = True) -> None:
        """Follows a way to its end; a surprise on it is answered once, if there is a rest of the way."""
        self._begin_with(way)
        try:
            self._walk()
        except Stopped as stopped:
            if not again or stopped.stop.surprise is None or not self.executed or self.ended:
                raise
            rest = self._answer(stopped.stop)
            if rest.kind != "finish":
                raise
            self._follow_way(rest, again=False)
