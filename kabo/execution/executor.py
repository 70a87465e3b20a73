"""The executor: walks a plan from its root to a goal, or to a safe stop with its reason [K 6.1.3; T 3.8].

States of a run, each logged when it is entered: `node`, `moving`, `gripping`, `releasing`, `sensing`, `stopping`, and
at the end `goal` or `stopped`. The state by the plan changes only when a motion has succeeded.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import ceil

from kabo.errors import Diagnostic, InputError
from kabo.execution.belief import Belief
from kabo.execution.fitting import require_fit
from kabo.execution.log import Log
from kabo.execution.margins import Margins
from kabo.execution.motions import HandAction, Motion, Stretch, motion_of, parts_of
from kabo.execution.protocols import Robot, RobotFailed, Sensor
from kabo.execution.state_log import StateLog
from kabo.execution.watching import Surprise, Watch
from kabo.plan import Node, Plan
from kabo.scene import Scene

STILL_AFTER = 1.0  # [s] within which a hand stands, after it began to press
STOPS_WITHIN = 30.0  # [s]
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
    """

    watch_rate: float = 100.0
    tracking_error: float = 0.0
    despite_margins: bool = False
    log_rate: float = 0.0


USUAL = ExecutionSettings()


@dataclass(frozen=True)
class Run:
    """How a run ended.

    Attributes:
        reached_goal: whether a goal node was reached.
        reason: why it stopped, in a sentence; what was reached, otherwise.
        node: the node at which it ended.
        history: the nodes that were done, in order, each with the outcome that was observed, if any.
        surprise: what no proof covers, if that was the reason.
        log: all that happened.
    """

    reached_goal: bool
    reason: str
    node: str
    history: tuple[tuple[str, str | None], ...]
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

    Raises:
        InputError: the plan does not fit the scene, or has less proven clearance than the robots' tracking error.
    """
    return _Executor(plan, scene, robot, sensor, settings, log or Log(), stop).run()


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
    ) -> None:
        self.plan, self.scene, self.robot, self.sensor = plan, scene, robot, sensor
        self.settings, self.log, self.stop = settings, log, stop
        self.margins = Margins(plan)
        self.history: list[tuple[str, str | None]] = []
        self.known: dict[str, str] = {}
        self.gripped: list[tuple[str, tuple[str, ...]]] = []  # hands that have closed and are not judged yet
        self.name = self.clock = plan.root  # where it is; and the node on whose clock the robots' motion is
        self.states = StateLog(log, settings.log_rate)
        if any(node.motion for node in plan.nodes.values()):
            if scene is None or robot is None:
                raise InputError([Diagnostic("plan", 1, 1, "it has motions, and there is no robot", None)])
            require_fit(plan, scene)
            self._require_margins()
            self.belief = Belief.at_start(scene, plan.start)
            self.watch = Watch(scene, self.margins)

    def run(self) -> Run:
        self._enter("start", problem=self.plan.problem)
        try:
            while (node := self.plan.nodes[self.name]).kind != "goal":
                if self.stop():
                    raise _Stopped("it was asked to stop")
                self.name = self._after(node)
        except (_Stopped, RobotFailed) as end:
            self._enter("stopped", node=self.name, reason=str(end))
            surprise = end.surprise if isinstance(end, _Stopped) else None
            return Run(False, str(end), self.name, tuple(self.history), surprise, self.log)
        self._enter("goal", node=self.name)
        return Run(True, "the goal is reached", self.name, tuple(self.history), None, self.log)

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
        last = self.plan.nodes[nodes[-1]]
        self.name = nodes[-1]
        outcome = self._outcome(last)
        self.history.append((nodes[-1], outcome))
        following = last.next if outcome is None else last.branches[outcome]
        if following is None:
            raise _Stopped(f"{nodes[-1]} has no successor")
        return following

    def _outcome(self, node: Node) -> str | None:
        for term in node.delivers:
            value = self.sensor.value(term)
            self._enter("sensing", node=self.name, term=term, value=value)
            if value is None:
                raise _Stopped(f"{self.name}: the value of {term} was not measured")
        if node.on is None:
            return None
        outcomes = tuple(node.branches)
        found = self.known.get(node.on) if node.kind == "branch" else None
        if found is None:
            found = self.sensor.resolve(node.on, outcomes)
        self._enter("sensing", node=self.name, formula=node.on, outcome=found)
        if found is None:
            raise _Stopped(f"{self.name}: {node.on} was not measured")
        if found not in node.branches:
            raise _Stopped(f"{self.name}: {node.on} is {found}, for which the plan has no branch")
        self.known[node.on] = found
        return found

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
        robot, waiting, under_way = self.robot, list(part.actions), list(part.stretches)
        self.watch.begin()
        self._act(waiting, part.begin)
        robot.follow(part)
        self.clock = part.nodes[0]
        self._enter("moving", nodes=part.nodes, begin=part.begin, end=part.end)
        while (state := robot.state()).moving:
            self._act(waiting, state.motion_time)
            under_way = self._finished(under_way, state.motion_time)
            surprise = self.watch.tracking(part, state, self.belief) or self._surprise_of_bodies(part.nodes[0])
            self._log_state(part.nodes[0])
            if surprise is not None or self.stop():
                self._halt(surprise)
            robot.wait(1.0 / self.settings.watch_rate)
        self._finished(under_way, part.end)
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
        return self.watch.bodies(self.sensor.poses(), self._robot.state(), self.belief, node)

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
        raise _Stopped(reason, surprise)


def _finite(value: float) -> float | None:
    return value if value < float("inf") else None
