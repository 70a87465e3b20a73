"""The executor: walks a plan from its root to a goal, or to a safe stop with its reason [K 6.1.3; T 3.8].

States of a run, each logged when it is entered: `node`, `moving`, `gripping`, `releasing`, `sensing`, `stopping`, and
at the end `goal` or `stopped`. The state by the plan changes only when a motion has succeeded.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from math import ceil
from typing import TypeVar

import numpy as np

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError
from kabo.execution.belief import Belief
from kabo.execution.fitting import require_fit
from kabo.execution.interruptions import Executed, Interruption, Recovery, observed
from kabo.execution.log import Log
from kabo.execution.margins import Margins
from kabo.execution.motions import HandAction, Motion, Stretch, motion_of, parts_of
from kabo.execution.protocols import Robot, RobotFailed, Sensor
from kabo.execution.state_log import StateLog
from kabo.execution.watching import Surprise, Watch
from kabo.plan import Node, Plan, State, state_after
from kabo.scene import Scene

_T = TypeVar("_T")

STILL_AFTER = 1.0  # [s] within which a hand stands, after it began to press
AT_REST, MOST_RESTS = 2e-4, 30  # [m, or of a turn] within which a body stays between two looks; how many looks
MOST_ALIKE = 3  # surprises by one thing at one node, until the run ends
STOPS_WITHIN = 30.0  # [s]
ASKED, ASKED_EACH = 5, 0.2  # how often a sensor that is silent is asked, and after how long again [s]
SETTLED_AFTER = 0.1  # [s] after a body was let go of, until it is looked at


@dataclass(frozen=True)
class ExecutionSettings:
    """How a plan is carried out.

    Attributes:
        watch_rate: how often measurements are compared with the plan [Hz], 100 or more on hardware.
        tracking_error: how far any point of a robot may be off its path, as its maker says [m]; a plan that has
            less proven clearance somewhere is refused.
        despite_margins: whether such a plan is carried out nevertheless.
        log_rate: how often a record `state` is added to the log [Hz]: where everything is; 0: never.
        most_recoveries: how often a run goes on after a surprise.
    """

    watch_rate: float = 100.0
    tracking_error: float = 0.0
    despite_margins: bool = False
    log_rate: float = 0.0
    most_recoveries: int = 20


USUAL = ExecutionSettings()


@dataclass(frozen=True)
class Run:
    """How a run ended.

    Attributes:
        reached_goal: whether a goal node was reached.
        reason: why it stopped, in a sentence; what was reached, otherwise.
        node: the node at which it ended.
        history: the nodes that were done, in order, each with the outcome that was observed, if any; after a surprise,
            nodes of the plan that it went on with.
        state: what was done since the problem began, and where everything is by what was observed last.
        surprise: what no proof covers, if that was the reason.
        log: all that happened.
    """

    reached_goal: bool
    reason: str
    node: str
    history: tuple[tuple[str, str | None], ...]
    state: State
    surprise: Surprise | None = None
    log: Log = field(default_factory=Log, repr=False, compare=False)


class _Stopped(Exception):  # noqa: N818 - it is no error
    def __init__(self, reason: str, surprise: Surprise | None = None) -> None:
        super().__init__(reason)
        self.surprise = surprise


def execute(
    plan: Plan,
    scene: Scene | None,
    robot: Robot | None,
    sensor: Sensor,
    settings: ExecutionSettings = USUAL,
    log: Log | None = None,
    stop: Callable[[], bool] = lambda: False,
    recovery: Recovery | None = None,
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

    Raises:
        InputError: the plan does not fit the scene, or has less proven clearance than the robots' tracking error.
    """
    return _Executor(plan, scene, robot, sensor, settings, log or Log(), stop, recovery).run()


class _Executor:
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
    ) -> None:
        self.scene, self.robot, self.sensor = scene, robot, sensor
        self.settings, self.log, self.stop, self.recovery = settings, log, stop, recovery
        self.followed: list[tuple[str, str | None]] = []  # nodes of former plans
        self.known: dict[str, str] = {}
        self.recoveries = 0
        self.seen_at: dict[str, float] = {}  # when each body was seen last [s]
        self.recovered: list[tuple[int, str]] = []  # nodes done, and the thing that surprised
        self.states = StateLog(log, settings.log_rate)
        self._begin(plan)

    def _begin(self, plan: Plan) -> None:
        """Takes over a plan, which begins where everything is now.

        Raises:
            InputError: it does not fit the scene, or has less proven clearance than the robots' tracking error.
        """
        self.plan, self.name, self.margins = plan, plan.root, Margins(plan)
        self.history: list[tuple[str, str | None]] = []
        # What a node delivers and another one branches on is looked at once: where the plan senses it.
        self.decided_later = {n.on: tuple(n.branches) for n in plan.nodes.values() if n.kind == "branch" and n.on}
        self.executed: list[Executed] = []  # of the nodes that are not done
        self.under_way: list[Stretch] = []
        self.released: list[str] = []
        self.gripped: list[tuple[str, tuple[str, ...]]] = []  # hands that have closed and are not judged yet
        self.clock = plan.root  # the node on whose clock the robots' motion is
        if any(node.motion for node in plan.nodes.values()):
            if self.scene is None or self.robot is None:
                raise InputError([Diagnostic("plan", 1, 1, "it has motions, and there is no robot", None)])
            require_fit(plan, self.scene)
            self._require_margins()
        if self.scene is not None and self.robot is not None:
            self.belief = Belief.at_start(self.scene, plan.start)
            self.watch = Watch(self.scene, self.margins, self.seen_at)

    def run(self) -> Run:
        self._enter("start", problem=self.plan.problem)
        while True:
            try:
                self._walk()
                self._enter("goal", node=self.name)
                return self._ended(True, "the goal is reached", None)
            except _Stopped as end:
                stopped = end
            except RobotFailed as lost:
                stopped = _Stopped(str(lost))
            try:
                self._recover(stopped)
            except (_Stopped, RobotFailed) as end:
                self._enter("stopped", node=self.name, reason=str(end))
                return self._ended(False, str(end), end.surprise if isinstance(end, _Stopped) else None)

    def _walk(self) -> None:
        """Carries out the plan to its goal."""
        while (node := self.plan.nodes[self.name]).kind != "goal":
            if self.stop():
                raise _Stopped("it was asked to stop")
            self.name = self._after(node)

    def _ended(self, reached_goal: bool, reason: str, surprise: Surprise | None) -> Run:
        history = (*self.followed, *self.history)
        return Run(reached_goal, reason, self.name, history, self._state()[0], surprise, self.log)

    # ------------------------------------------------------------------------------------------------- surprises
    def _state(self) -> tuple[State, tuple[tuple[str, str], ...]]:
        """What was done and where everything is, as it is observed; and what hands do not hold any more."""
        if self.scene is None or self.robot is None:
            return state_after(self.plan, self.history), ()
        empty = self.watch.empty_hands(self.robot.state(), self.belief)
        change, lost = observed(self.scene, self.plan, self.belief, self.sensor.poses(), empty)
        return state_after(self.plan, self.history, robots=change.robots, objects=change.objects), lost

    def _recover(self, stopped: _Stopped) -> None:
        """Goes on after a surprise, if there is a plan from where all is now.

        Raises:
            _Stopped: there is none; it says why.
        """
        if self.recovery is None or stopped.surprise is None or self.recoveries >= self.settings.most_recoveries:
            raise stopped
        self.recoveries += 1
        if (
            self.recovered.count(done := (len(self.followed) + len(self.history), stopped.surprise.thing))
            >= MOST_ALIKE
        ):
            raise _Stopped(f"{stopped}, again and again", stopped.surprise)
        self.recovered.append(done)
        kind, plan = self._answer(stopped)
        try:
            if kind in ("finish", "undo"):
                self._detour(plan, done=kind == "finish")
            else:
                self.followed += self.history
                self._begin(plan)
                return
        except InputError as error:
            raise _Stopped(f"{stopped}; {error}", stopped.surprise) from None
        self._recover(stopped)

    def _answer(self, stopped: _Stopped) -> tuple[str, Plan]:
        """How to go on from where all rests, as the recovery says: the kind of its answer, and a plan.

        Raises:
            _Stopped: not at all; it says why.
        """
        assert self.recovery is not None and stopped.surprise is not None
        self._come_to_rest(stopped)
        surprise = self._gone() or stopped.surprise
        if surprise.kind == "gone":  # it may be anywhere: nothing that moves is proven
            raise _Stopped(
                str(stopped) if stopped.surprise.kind == "gone" else f"{stopped}; {surprise.sentence}", surprise
            )
        state, lost = self._state()
        for body, robot in lost:
            self._robot.release(robot, (body,))
        expected = state_after(self.plan, self.history).geometry
        answer = self.recovery.answer(
            Interruption(self.plan, state, tuple(self.executed), lost, surprise, expected)
        )
        self._enter("answer", kind=answer.kind, reason=answer.reason)
        if answer.plan is None:
            raise _Stopped(f"{stopped}; {answer.reason}", stopped.surprise)
        return answer.kind, answer.plan

    def _come_to_rest(self, stopped: _Stopped) -> None:
        """Waits until no body moves that is seen, and robots are where they were sent; not for ever.

        Raises:
            _Stopped: a robot is somewhere else: nothing is proven from there.
        """
        before = self.sensor.poses()
        for _ in range(MOST_RESTS):
            for _ in self._looks(SETTLED_AFTER):
                pass
            now = self.sensor.poses()
            moved = (np.abs(now[name] - pose).max() for name, pose in before.items() if name in now)
            self._gone()
            tracked = stopped.surprise is not None and stopped.surprise.kind == "tracking"
            late = self.watch.not_at_rest(self._robot.state(), self.belief) if tracked else None
            if max(moved, default=0.0) < AT_REST and late is None and not self._unseen(now):
                return
            before = now
        if late is not None:
            raise _Stopped(f"{stopped}; {late}, and does not come back", stopped.surprise)

    def _gone(self) -> Surprise | None:
        return self.watch.gone(self.sensor.poses(), self.time, self.name)

    def _unseen(self, seen: Mapping[str, Array]) -> bool:
        """Whether a body is not seen, and it is not yet time to say that it is gone."""
        return any(name not in seen for name in self.seen_at) and self._gone() is None

    def _detour(self, way: Plan, *, done: bool) -> None:
        """Follows a way out of the middle of the node; `done`: to its end, or else back to where it began."""
        plan, name, history = self.plan, self.name, self.history
        try:
            self._follow_way(way)
        finally:  # what was done is told by the plan, whatever becomes of the way
            self.plan, self.name, self.history, self.executed = plan, name, history, []
            self.margins = self.watch.margins = Margins(plan)
        if done:
            self.name = self._left(name)

    def _follow_way(self, way: Plan, *, again: bool = True) -> None:
        """Follows a way to its end; a surprise on it is answered once, if the way can be ended."""
        self._begin(way)
        try:
            self._walk()
        except _Stopped as stopped:
            if not again or stopped.surprise is None or not self.executed:
                raise
            kind, rest = self._answer(stopped)
            if kind != "finish":
                raise
            self._follow_way(rest, again=False)

    def _require_margins(self) -> None:
        least, needed = self.margins.of_rest(self.plan.root), self.settings.tracking_error
        if least < needed and not self.settings.despite_margins:
            proven, off = f"{1000 * least:.2g} mm", f"{1000 * needed:.2g} mm"
            text = f"a clearance of {proven} is proven, and robots are up to {off} off their paths"
            hint = f"plan with --clearance {1000 * needed:.2g}mm, or carry it out --despite-margins"
            raise InputError([Diagnostic("plan", 1, 1, text, hint)])

    @property
    def time(self) -> float:
        return 0.0 if self.robot is None else self.robot.state().time

    def _enter(self, state: str, **more: object) -> None:
        self.log.add(self.time, state, **more)

    def _after(self, node: Node) -> str:
        """Carries out a node, and says which one follows."""
        begun = self.name
        nodes: tuple[str, ...] = (begun,)
        if node.motion:
            nodes = self._move()
        else:
            self._enter("node", node=begun, kind=node.kind, action=node.action, arguments=dict(node.arguments))
        for done in nodes[:-1]:
            self.history.append((done, None))
        self.name = nodes[-1]
        return self._left(self.name)

    def _left(self, name: str) -> str:
        """Looks at what a node that was carried out observes, and says which one follows."""
        node = self.plan.nodes[name]
        outcome = self._outcome(node)
        self.history.append((name, outcome))
        following = node.next if outcome is None else node.branches[outcome]
        if following is None:
            raise _Stopped(f"{name} has no successor")
        return following

    def _outcome(self, node: Node) -> str | None:
        for term in node.delivers:
            outcomes = self.decided_later.get(term)
            ask = self.sensor.value if outcomes is None else partial(self.sensor.resolve, outcomes=outcomes)
            value = self._asked(partial(ask, term))
            if outcomes is not None and value is not None:
                self.known[term] = str(value)
            self._enter("sensing", node=self.name, term=term, value=value)
            if value is None:
                raise _Stopped(f"{self.name}: the value of {term} was not measured")
        if node.on is None:
            return None
        outcomes = tuple(node.branches)
        found = self.known.get(node.on) if node.kind == "branch" else None
        if found is None:
            found = self._asked(partial(self.sensor.resolve, node.on, outcomes))
        self._enter("sensing", node=self.name, formula=node.on, outcome=found)
        if found is None:
            raise _Stopped(f"{self.name}: {node.on} was not measured")
        if found not in node.branches:
            raise _Stopped(f"{self.name}: {node.on} is {found}, for which the plan has no branch")
        self.known[node.on] = found
        return found

    def _asked(self, sensor: Callable[[], _T | None]) -> _T | None:
        """What a sensor says; one that is silent is asked again, a few times."""
        for number in range(ASKED):
            if (found := sensor()) is not None or number == ASKED - 1:
                return found
            self._enter("silent", node=self.name, asked=number + 1)
            for _ in self._looks(ASKED_EACH) if self.robot is not None else ():
                pass
        return None

    def _move(self) -> tuple[str, ...]:
        """Follows the motion of the node and of those that overlap it; the names of all of them."""
        assert self.scene is not None
        motion = motion_of(self.plan, self.name, self.scene)
        for name in motion.nodes:
            node = self.plan.nodes[name]
            self._enter("node", node=name, kind=node.kind, action=node.action, arguments=dict(node.arguments))
        self._look_at_bodies(self.name)
        for part in parts_of(motion):
            self._follow(part)
        self.executed, self.released = [], []
        for name in motion.nodes:
            change = self.plan.nodes[name].after
            if change is not None:
                self.belief.take(change)
        self._settle()
        self._look_at_bodies(motion.nodes[-1])
        return motion.nodes

    def _follow(self, part: Motion) -> None:
        """Follows a part until its end, looks at it meanwhile, and lets hands act when it is time."""
        assert self.robot is not None
        robot, waiting = self.robot, list(part.actions)
        self.watch.begin()
        self._act(waiting, part.begin)
        self.under_way = list(part.stretches)
        robot.follow(part)
        self.clock = part.nodes[0]
        self._enter("moving", nodes=part.nodes, begin=part.begin, end=part.end)
        while (state := robot.state()).moving:
            self._act(waiting, state.motion_time)
            self.under_way = self._finished(self.under_way, state.motion_time)
            surprise = self.watch.tracking(part, state, self.belief) or self._surprise_of_bodies(part.nodes[0])
            self._log_state(part.nodes[0])
            if surprise is not None or self.stop():
                self._halt(surprise)
            robot.wait(1.0 / self.settings.watch_rate)
        self.under_way = self._finished(self.under_way, part.end)
        measured = self.watch.measured
        self._enter(
            "followed", tracking=measured.tracking, permitted=_finite(measured.permitted), bodies=measured.bodies
        )
        self._act(waiting, part.end)
        self._check_grasps()

    def _finished(self, stretches: list[Stretch], time: float) -> list[Stretch]:
        """The stretches that have not ended by then; robots are believed to be at the ends of the others."""
        for done in stretches:
            if done.end <= time:
                self.belief.move(done.robot, done.trajectory.joints, done.trajectory.at(done.end))
                self.executed.append(Executed(done.node, done.segment))
        return [each for each in stretches if each.end > time]

    def _act(self, waiting: list[HandAction], time: float) -> None:
        """Lets hands do what is due at a time of the motion."""
        while waiting and waiting[0].time <= time + 1e-9:
            action = waiting.pop(0)
            segment = self.plan.nodes[action.node].motion[action.segment]
            if action.kind == "grip":
                self.belief.finish(segment)
                self._grip(action)
            elif action.kind == "release":
                self._enter("releasing", robot=action.robot, bodies=action.detach)
                self.released += action.detach
                self._robot.release(action.robot, action.detach)
            else:
                self.belief.finish(segment)

    @property
    def _robot(self) -> Robot:
        assert self.robot is not None
        return self.robot

    def _grip(self, action: HandAction) -> None:
        bodies = tuple(body for body, _ in action.attach)
        self._robot.grip(action.robot, bodies)
        self._enter("gripping", robot=action.robot, bodies=bodies)
        self.gripped.append((action.robot, bodies))
        if (
            not self._robot.state().moving
        ):  # another robot that moves is not kept waiting: the hand is judged later
            self._check_grasps()

    def _check_grasps(self) -> None:
        """Judges the hands that have closed, when they stand."""
        while self.gripped:
            robot, bodies = self.gripped.pop(0)
            for _ in self._looks(STILL_AFTER):
                if robot in self._robot.state().still:
                    break
            surprise = self.watch.grasp(robot, self._robot.state(), self.belief, bodies)
            if surprise is not None:
                self._halt(surprise)

    def _settle(self) -> None:
        for _ in self._looks(SETTLED_AFTER):
            pass

    def _looks(self, seconds: float) -> Iterator[None]:
        for _ in range(ceil(seconds * self.settings.watch_rate)):
            self._robot.wait(1.0 / self.settings.watch_rate)
            self._log_state(self.name)
            yield

    def _log_state(self, node: str) -> None:
        state = self._robot.state()
        if self.states.is_due(state):
            self.states.add(self.clock, state, self.sensor.poses(), self.watch, self.margins.of_rest(node))

    def _look_at_bodies(self, node: str) -> None:
        surprise = self._surprise_of_bodies(node)
        if surprise is not None:
            self._halt(surprise)

    def _surprise_of_bodies(self, node: str) -> Surprise | None:
        seen, state = self.sensor.poses(), self._robot.state()
        return self.watch.bodies(seen, state, self.belief, node) or self.watch.gone(seen, state.time, node)

    def _halt(self, surprise: Surprise | None) -> None:
        """A planned stop.

        Raises:
            _Stopped: always.
        """
        reason = "it was asked to stop" if surprise is None else surprise.sentence
        self._enter("stopping", reason=reason)
        self._robot.stop()
        for _ in self._looks(STOPS_WITHIN):
            if not self._robot.state().moving:
                break
        self._stand(self._robot.state().motion_time)
        raise _Stopped(reason, surprise)

    def _stand(self, time: float) -> None:
        """Robots stand where they were sent at a time of the motion's clock [s]."""
        for stretch in self._finished(self.under_way, time):
            if stretch.begin < time:
                self.belief.move(stretch.robot, stretch.trajectory.joints, stretch.trajectory.at(time))
                self.executed.append(Executed.of(stretch, self.plan, time))
        self.under_way = []
        for body in self.released:  # a hand that opens holds no more, though the plan says so until it is open
            self.belief.let_go(body)


def _finite(value: float) -> float | None:
    return value if value < float("inf") else None
