"""Carries out the nodes of a plan: follows their motions, watches, lets hands act, and asks sensors [K 6.1.3].

What no proof covers ends in a planned stop, and in the exception `Stopped`; `executor.py` says whether the run goes on.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from math import ceil
from typing import TypeVar

from kabo.arrays import Array
from kabo.errors import Diagnostic, InputError
from kabo.execution.belief import Belief
from kabo.execution.checked import CheckedPoses, checked
from kabo.execution.fitting import require_fit, require_graph
from kabo.execution.interruptions import Executed, Stop, ended_nodes
from kabo.execution.log import Log
from kabo.execution.looks import MOST_LOOKS, Looks
from kabo.execution.margin_table import least_margins
from kabo.execution.margins import Margins
from kabo.execution.motions import SAME_TIME, HandAction, Motion, Stretch, motion_of, parts_of
from kabo.execution.off_path import OffPath
from kabo.execution.pacing import Pace, Pacer
from kabo.execution.protocols import PacedRobot, Robot, RobotState, Sensor, not_measured, picture_period
from kabo.execution.settings import ExecutionSettings
from kabo.execution.sightings import Sightings
from kabo.execution.state_log import StateLog
from kabo.execution.watching import Surprise, Watch
from kabo.plan import Node, Plan
from kabo.scene import MAX_DISTANCE, Scene
from kabo.verify import Report

_T = TypeVar("_T")

STILL_AFTER = 1.0  # [s] within which a hand stands, after it began to press
STOPS_WITHIN = 30.0  # [s]
ASKED, ASKED_EACH = 15, 0.2  # how often a sensor is asked that is silent or contradicts; after how long again [s]
MOST_PERIODS = 10  # of the watch for each look that may be needed, since a camera is slower than the watch
SETTLED_AFTER = 0.1  # [s] after a body was let go of, until it is looked at


class Stopped(Exception):  # noqa: N818 - it is no error
    """The run does not go on from here; robots stand, or are asked to."""

    def __init__(self, reason: str, surprise: Surprise | None = None) -> None:
        super().__init__(reason)
        self.stop = Stop(reason, surprise)


class Carrier:
    """One plan at a time, carried out node by node; arguments as of `kabo.execution.execute`."""

    def __init__(
        self,
        plan: Plan,
        scene: Scene | None,
        robot: Robot | None,
        sensor: Sensor,
        settings: ExecutionSettings,
        log: Log,
        stop: Callable[[], bool],
        report: Report | None = None,
    ) -> None:
        self.scene, self.sensor, movable = scene, sensor, () if scene is None else scene.movable
        self.seen_now = CheckedPoses(sensor, movable)
        self.robot = robot if robot is None or scene is None else checked(robot, scene)
        self.settings, self.log, self.stop = settings, log, stop
        self.known: dict[str, str] = {}
        bodies, self.picture = getattr(sensor, "sees", None), picture_period(sensor)
        self.sightings = Sightings(movable if bodies is None else bodies, settings.watch_rate, self.picture)
        self.pacer = Pacer({} if scene is None else scene.robots)
        self.states = StateLog(log, settings.log_rate)
        self.looks = Looks(getattr(sensor, "noise", None))
        self._begin(plan, report)

    def _begin(self, plan: Plan, report: Report | None) -> None:
        """Takes over a plan, which begins where everything is now, with the report of its check if there is one.

        Raises:
            InputError: it does not fit the scene, or has less proven clearance than the robots' tracking error.
        """
        self.name = plan.root
        self.history: list[tuple[str, str | None]] = []
        self.executed: list[Executed] = []  # of the nodes that are not done
        self.ended: tuple[str, ...] = ()  # nodes of which the motion is over, and that do not count as done yet
        self.under_way: list[Stretch] = []
        self.part: Motion | None = None  # what is followed
        self.waiting: list[HandAction] = []  # what hands are still to do meanwhile
        self.stopping = False
        self.released: list[tuple[str, str]] = []  # bodies, each with the robot that lets go of it
        self.gripped: list[tuple[str, tuple[str, ...]]] = []  # hands that have closed and are not judged yet
        self.clock = plan.root  # the node on whose clock the robots' motion is
        self._take(plan, report)
        if self.scene is not None and self.robot is not None:
            self.belief = Belief.at_start(self.scene, plan.start)
            errors = {} if self.settings.despite_margins else self.settings.tracking_errors(self.scene.robots)
            self.watch = Watch(self.scene, self.margins, self.sightings, self.looks, errors, self.settings.delay)

    def _take(self, plan: Plan, report: Report | None) -> None:
        """Goes on with a plan from the node that is reached; raises as `_begin`."""
        require_graph(plan)
        moves = any(node.motion for node in plan.nodes.values())
        if moves:
            if self.scene is None or self.robot is None:
                text = "it has motions, and there is no robot" if plan.start else "it has motions, and no `start`"
                raise InputError([Diagnostic("plan", 1, 1, text, None)])
            require_fit(plan, self.scene)
        self.plan, self.margins = plan, Margins(plan, report)
        # What a node delivers and another one branches on is looked at once: where the plan senses it.
        self.decided_later = {n.on: tuple(n.branches) for n in plan.nodes.values() if n.kind == "branch" and n.on}
        if moves and not self.settings.despite_margins:
            self.margins.require(self.settings.tracking_errors(() if self.scene is None else self.scene.robots))

    @property
    def time(self) -> float:
        """The time on the robots' clock [s]."""
        return 0.0 if self.robot is None else self.robot.state().time

    def _enter(self, state: str, **more: object) -> None:
        self.log.add(self.time, state, **more)

    def _enter_node(self, name: str) -> None:
        node, bodies = self.plan.nodes[name], () if self.scene is None else self.scene.movable
        does = {"kind": node.kind, "action": node.action, "arguments": dict(node.arguments)}
        self._enter("node", node=name, **does, margins=least_margins(self.margins, name, bodies))

    def _after(self, node: Node) -> str:
        """Carries out a node, and says which one follows."""
        begun = self.name
        nodes: tuple[str, ...] = (begun,)
        if node.motion:
            nodes = self._move()
        else:
            self._enter_node(begun)
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
            raise Stopped(f"{name} has no successor")
        return following

    def _outcome(self, node: Node) -> str | None:
        for term in node.delivers:
            outcomes = self.decided_later.get(term)
            ask = self.sensor.value if outcomes is None else partial(self.sensor.resolve, outcomes=outcomes)
            value = self._asked(partial(ask, term), outcomes)
            if outcomes is not None and value is not None:
                self.known[term] = str(value)
            self._enter("sensing", node=self.name, term=term, value=value)
            if value is None:
                raise Stopped(f"{self.name}: the value of {not_measured(self.sensor, term)}")
        if node.on is None:
            return None
        outcomes = tuple(node.branches)
        found = self.known.get(node.on) if node.kind == "branch" else None
        if found is None:
            found = self._asked(partial(self.sensor.resolve, node.on, outcomes), outcomes)
        self._enter("sensing", node=self.name, formula=node.on, outcome=found)
        if found is None:
            raise Stopped(f"{self.name}: {not_measured(self.sensor, node.on)}")
        if found not in node.branches:
            raise Stopped(f"{self.name}: {node.on} is {found}, for which the plan has no branch")
        self.known[node.on] = found
        return found

    def _asked(self, sensor: Callable[[], _T | None], outcomes: tuple[str, ...] | None) -> _T | None:
        """What a sensor says; one that is silent, or says none of the possible outcomes, is asked again, a few times."""
        for number in range(ASKED):
            found = sensor()
            possible = found is not None and (outcomes is None or found in outcomes)
            if possible or number == ASKED - 1:
                return found
            self._enter("silent", node=self.name, asked=number + 1, **({} if found is None else {"said": found}))
            for _ in self._looks(ASKED_EACH) if self.robot is not None else ():
                pass
        return None

    def _move(self) -> tuple[str, ...]:
        """Follows the motion of the node and of those that overlap it; the names of all of them."""
        assert self.scene is not None
        motion = motion_of(self.plan, self.name, self.scene)
        for name in motion.nodes:
            self._enter_node(name)
        self._look_at_bodies(self.name)
        for part in parts_of(motion):
            self._follow(part)
        self.ended, self.executed, self.released = ended_nodes(self.plan, self.executed), [], []
        for name in motion.nodes:
            change = self.plan.nodes[name].after
            if change is not None:
                self.belief.take(change)
        self._settle()
        self._look_at_bodies(motion.nodes[-1])
        self.ended = ()
        return motion.nodes

    def _follow(self, part: Motion) -> None:
        """Follows a part until its end, looks at it meanwhile, and lets hands act when it is time."""
        assert self.robot is not None
        robot, self.waiting = self.robot, list(part.actions)
        self.watch.begin(part, self.belief)
        self._act(part.begin)
        self.looks.forget()
        self.under_way, self.part = list(part.stretches), part
        robot.follow(part)
        self.clock = part.nodes[0]
        self._enter("moving", nodes=part.nodes, begin=part.begin, end=part.end)
        self._begin_pace(part)
        while (state := robot.state()).moving:
            surprise = self.watch.tracking(part, state, self.belief)
            self._keep_up(self.watch.path)
            surprise = surprise or self._surprise_of_bodies(part.nodes[0], state)
            self._log_state(part.nodes[0], state)
            self._keep_pace(state, self.watch.path, stops=surprise is not None)
            if surprise is not None or self.stop():
                self._halt(surprise)
            robot.wait(1.0 / self.settings.watch_rate)
        self.under_way, self.part = self._finished(self.under_way, part.end), None
        self._enter("followed", **vars(self.watch.measured))
        self._act(part.end)
        self._check_grasps()

    def _begin_pace(self, part: Motion) -> None:
        """A motion begins slowly if robots would get too far off its path."""
        standing = self.watch.standing(self._robot.state(), self.belief)
        self._set_pace(self.pacer.begin(part, self.belief, self.margins, standing))

    def _keep_up(self, path: OffPath) -> None:
        """Lets hands do what is due, and takes into account what is done, where robots are on their path."""
        self._act(path.time)
        self.under_way = self._finished(self.under_way, path.time)

    def _keep_pace(self, state: RobotState, path: OffPath, *, stops: bool) -> None:
        """Slows down the clock before robots are too far off their paths, or goes back to full speed."""
        self.pacer.learn(state, path)
        if not stops:
            self._set_pace(self.pacer.wanted(state.motion_time))

    def _set_pace(self, wanted: Pace | None) -> None:
        if wanted is None or not isinstance(self.robot, PacedRobot):
            return
        if self.robot.pace(wanted.rate):
            self.pacer.rate = wanted.rate
            self._enter("pace", rate=wanted.rate, reason=wanted.reason)

    def _finished(self, stretches: list[Stretch], time: float) -> list[Stretch]:
        """The stretches that have not ended by then; robots are believed to be at the ends of the others."""
        for done in stretches:
            if done.end <= time:
                self.belief.move(done.robot, done.trajectory.joints, done.trajectory.at(done.end))
                self.executed.append(Executed(done.node, done.segment))
        return [each for each in stretches if each.end > time]

    def _act(self, time: float) -> None:
        """Lets hands do what is due at a time of the motion."""
        while self.waiting and self.waiting[0].time <= time + SAME_TIME:
            action = self.waiting.pop(0)
            self.looks.forget()
            self.watch.acted(action)
            segment = self.plan.nodes[action.node].motion[action.segment]
            if action.kind == "grip":
                self.belief.finish(segment)
                self._grip(action)
            elif action.kind == "release":
                self._enter("releasing", robot=action.robot, bodies=action.detach)
                self.released += ((body, action.robot) for body in action.detach)
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
        # Another robot that moves is not kept waiting, and a stop is no time to judge: the hand is judged later.
        if not self.stopping and not self._robot.state().moving:
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
            self._log_state(self.name, self._robot.state())
            yield

    def _log_state(self, node: str, state: RobotState) -> None:
        if self.states.is_due(state):
            self._poses(state.time)
            planned = self.watch.planned(self.belief, self.part)
            self.states.add(self.clock, state, planned, self.watch, self.margins.of_rest(node))

    def _look_at_bodies(self, node: str) -> None:
        """Looks as often as it takes to tell whether bodies are near enough to their places, with a bound."""
        surprise, looks = self._surprise_of_bodies(node, self._robot.state()), 0
        most = MOST_LOOKS * max(MOST_PERIODS, ceil(self.picture * self.settings.watch_rate) + 1)
        while surprise is None and self.watch.undecided and looks < most:
            for _ in self._looks(1.0 / self.settings.watch_rate):
                looks += 1
            surprise = self._surprise_of_bodies(node, self._robot.state())
        if self.looks.noise is not None:
            decision = "as planned" if surprise is None else surprise.kind
            self._enter("looked", node=node, bodies=self.looks.counts(), waited=looks, outcome=decision)
        if surprise is not None:
            self._halt(surprise)

    def _surprise_of_bodies(self, node: str, state: RobotState) -> Surprise | None:
        seen = self._poses(state.time)
        done = frozenset((each.node, each.segment) for each in self.executed if each.until is None)
        found = self.watch.bodies(seen, state, self.belief, node, part=self.part, done=done)
        found = found or self.watch.gone(state.time, node)
        for record in self.watch.tolerated:
            self._enter("tolerated", **record)
        self.watch.tolerated.clear()
        return found

    def _poses(self, time: float) -> Mapping[str, Array]:
        """The poses (4, 4) of bodies seen at a time [s]; what is too far away to plan with counts as not seen."""
        every = self.seen_now()
        seen = {name: pose for name, pose in every.items() if max(map(abs, pose[:3, 3].tolist())) <= MAX_DISTANCE}
        self.sightings.saw(seen, time)
        if seen:  # a camera that is slower than the watch shows each picture once, to whoever looks
            if self.states.rate > 0.0:
                self.states.saw(seen, self.watch.planned(self.belief, self.part))
            if self.part is None:
                self.looks.note(seen)
        return seen

    def _halt(self, surprise: Surprise | None) -> None:
        """A planned stop.

        Raises:
            Stopped: always.
        """
        reason = "it was asked to stop" if surprise is None else surprise.sentence
        self._enter("stopping", reason=reason)
        self.stopping = True
        self._robot.stop()
        for _ in self._looks(STOPS_WITHIN):
            state = self._robot.state()
            if not state.moving:
                break
            if self.part is not None:  # how far robots are off is often seen only now
                path = self.watch.off_path(self.part, state)
                self._act_within(self.part, path.time)
                self.pacer.learn(state, path)
        ended, moving = self._robot.state().motion_time, self._robot.state().moving
        if self.part is not None:
            self._act_within(self.part, ended)
        self._stand(ended)
        if moving:
            raise Stopped(f"{reason}; robots still move {STOPS_WITHIN:.0f} s after they were asked to stop")
        raise Stopped(reason, surprise)

    def _act_within(self, part: Motion, time: float) -> None:
        """Lets hands do what robots pass on their way to a stop; not what they were to do where they stand."""
        self._act(min(time, part.end - 2.0 * SAME_TIME))

    def _stand(self, time: float) -> None:
        """Robots stand where they were sent at a time of the motion's clock [s]."""
        for stretch in self._finished(self.under_way, time):
            if stretch.begin < time:
                self.belief.move(stretch.robot, stretch.trajectory.joints, stretch.trajectory.at(time))
                self.executed.append(Executed.of(stretch, self.plan, time))
        if self.part is not None:
            self.ended = ended_nodes(self.plan, self.executed, [robot for robot, _ in self.gripped])
        self.under_way, self.waiting, self.part, self.stopping = [], [], None, False
        # A hand that opens holds no more, though the plan says so until it is open.
        for body, robot in self.released:
            self.belief.let_go(body, robot)
