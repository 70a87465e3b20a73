"""Compares what is measured with what the plan has, many times a second; what is not covered by a proof is a surprise.

A robot may be as far from its path as the segment's proven clearance, a body as far from its place as what is proven of it
for the rest of the plan, in the direction in which it is off: up to there the proofs hold. What robots and bodies are off
together may use up no gap that is proven of two things. Nothing is a surprise that is within.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.displacements import displacements
from kabo.execution.link_origins import LinkOrigins
from kabo.execution.looks import MOST_LOOKS, Looks, Seen
from kabo.execution.margins import Margins, Running, Slack
from kabo.execution.motions import HandAction, Motion
from kabo.execution.nearness import Moving, Nearness
from kabo.execution.off_path import OffPath, off_path
from kabo.execution.protocols import RobotState
from kabo.execution.sightings import Sightings
from kabo.motion.kernels.deviations import positions_at
from kabo.scene import Scene

LATEST = 0.1  # [s] by which robots may be later than they are stated to be
PUSHED = 1e-4  # [m]: a robot that should rest and is off by more may be in the way of another one
AT_PLACE, STANDS = 1e-3, 0.02  # [m]; [rad/s or m/s]: a robot that stands is so near to its place, and so slow
NOTED = 5e-4  # [m]: that a body is off by more, and yet no surprise, is told once at each node
CLOSED_ON_NOTHING = 0.1  # share of a hand's stroke by which it may be narrower or wider than planned


@dataclass(frozen=True)
class Surprise:
    """What no proof covers: its kind, a sentence, the thing, by how much it is off and what was permitted [m]."""

    kind: str  # "tracking", "displaced", "grasp", "gone", "elsewhere", "unproven"
    sentence: str
    thing: str
    off: float
    permitted: float


class _Following(NamedTuple):
    """Where a plan is: a node that has not ended, its segments that have, those that run, and what hands close on."""

    node: str
    done: Running
    running: Running
    taken: frozenset[str]


@dataclass
class Planned:
    """Where the plan has things at one time: the values of all joints of each robot, and what it says of bodies."""

    robots: Mapping[str, Sequence[float]]
    belief: Belief

    @cached_property
    def bodies(self) -> Mapping[str, Array]:
        """The poses (4, 4) of bodies."""
        return self.belief.poses(self.robots)


@dataclass
class Measured:
    """The greatest deviations of one motion [m]: of any link from its path, and of each body from its place."""

    tracking: float = 0.0
    permitted: float = float("inf")
    share: float = 0.0  # the greatest one of what was permitted at the same time
    bodies: dict[str, float] | None = None


class Watch:
    """Judges measurements of one run.

    Args:
        scene: the scene. margins: what the plan has proven.
        sightings: when bodies were seen last; they are written, and given to the watch of the next plan.
        looks: the means of poses that are seen with noise.
        errors: how far robots may be off their paths, as their makers say [m].
        delay: how late robots follow, as their makers say [s].
    """

    def __init__(
        self,
        scene: Scene,
        margins: Margins,
        sightings: Sightings | None = None,
        looks: Looks | None = None,
        errors: Mapping[str, float] | None = None,
        delay: float = 0.0,
    ) -> None:
        self.scene, self.margins = scene, margins
        self.looks, self.errors, self.latest = looks or Looks(None), errors or {}, LATEST + delay
        self._known: dict[str, Seen] = {}  # of bodies, by what was seen last
        self.undecided: set[str] = set()  # bodies that may be a surprise or not, as far as looks tell
        self.tolerated: list[
            dict[str, object]
        ] = []  # bodies that are off, covered by proofs, since they were taken
        self._noted: set[tuple[str, str]] = set()  # nodes and bodies
        self._nearness = Nearness(scene)
        self.sightings = sightings or Sightings(scene.movable)
        self.measured = Measured()
        self._recent = Measured(bodies={})  # since it was taken
        self.path = OffPath(0.0, {})  # how far robots are off theirs, at the last look
        self._since = 0.0  # from when on robots may be late, on the motion's clock [s]
        self._resting: Mapping[str, Sequence[float]] = {}  # the values of all joints before the motion
        self._corners = {name: scene.bodies[name].mesh.box_corners for name in scene.movable}
        # The kernel is loaded now, not while robots move.
        positions_at(np.zeros(2), np.zeros((1, 1, 6)), np.zeros(1))

    def begin(self, motion: Motion, belief: Belief) -> None:
        """Begins a motion, and its figures; `belief`: where all is before it."""
        self.measured, self._resting, self._since = Measured(bodies={}), dict(belief.state.robots), motion.begin

    def acted(self, action: HandAction) -> None:
        """A hand has acted: where robots were before that does not count any more."""
        self._since = action.time

    def take_recent(self) -> Measured:
        """The figures since they were taken last."""
        found, self._recent = self._recent, Measured(bodies={})
        return found

    def tracking(self, motion: Motion, state: RobotState, belief: Belief) -> Surprise | None:
        """Whether each robot is near enough to the path that was proven, and no two things too near to each other."""
        path = self.off_path(motion, state)
        for name, (off, permitted, _) in path.robots.items():
            for found in (self.measured, self._recent):
                found.tracking, found.permitted = max(found.tracking, off), min(found.permitted, permitted)
                found.share = max(
                    found.share, 0.0 if off <= 0.0 else off / permitted if permitted > 0.0 else np.inf
                )
            if off > permitted:
                text = (
                    f"{name} is {1000 * off:.1f} mm off its path, {1000 * permitted:.1f} mm are proven to be free"
                )
                return Surprise("tracking", text, name, off, permitted)
        return self._together(motion, path, state, belief)

    def off_path(self, motion: Motion, state: RobotState) -> OffPath:
        """How far robots are off the path of the motion that has begun."""
        since = max(self._since, state.motion_time - self.latest)
        self.path = off_path(self.scene, self.margins, motion, self._resting, state, since)
        return self.path

    def planned(self, belief: Belief, part: Motion | None) -> Planned:
        """Where the plan has robots and bodies: at the last look at them, if a part of a motion is followed."""
        robots = dict(belief.state.robots)
        if part is not None:
            robots |= {name: own.planned for name, own in self.path.robots.items()}
        return Planned(robots, Belief(belief.scene, belief.state, belief.givers))

    def _together(self, motion: Motion, path: OffPath, state: RobotState, belief: Belief) -> Surprise | None:
        running = list(motion.at(path.time))
        robots = {each.robot for each in running}
        moving = {
            name: Moving(planned, off)
            for name, (off, _, planned) in path.robots.items()
            if name in robots or (running and off > PUSHED)
        }
        followed = frozenset((each.node, each.segment) for each in running)
        displaced = {name: own.displaced for name, own in self._known.items()}
        near = self._nearness.judge(self.margins, followed, moving, state, belief, displaced)
        if near is None:
            return None
        return Surprise("tracking", str(near), near.between[0], near.off, max(0.0, near.off - near.missing))

    def _off_path(self, name: str, actual: Sequence[float], planned: Sequence[float]) -> float:
        """How far any link's origin of the arm is from where it should be [m]; hands close as far as they find room."""
        return float(LinkOrigins.of(self.scene.robots[name]).farthest([planned], actual)[0])

    def standing(self, state: RobotState, belief: Belief) -> dict[str, float]:
        """How far each robot is from where it should stand [m]."""
        robots = belief.state.robots
        return {name: self._off_path(name, state.positions[name], robots[name]) for name in self.scene.robots}

    def bodies(
        self,
        seen: Mapping[str, Array],
        state: RobotState,
        belief: Belief,
        node: str,
        *,
        held: bool = True,
        part: Motion | None = None,
        done: Running = frozenset(),
    ) -> Surprise | None:
        """Whether each body is near enough to its place, on its support or in a hand, where it is seen or was seen last.

        A hand that closes on a body moves it, and nobody knows where to: until it has closed, what is followed meanwhile
        has to be proven with the body where it is; the rest is judged before it begins.

        Args:
            seen: the poses (4, 4) of bodies. state: what is measured of robots. belief: where all should be.
            node: the node from which on proofs are needed.
            held: whether bodies in hands are judged, too.
            part: what is followed now. done: segments that have ended, of nodes that have not.
        """
        looked = self.look(seen, state, belief)
        holders = {name: belief.holder(name) for name in self._known}
        judged = {name for name, holder in holders.items() if held or holder is None}
        for name in judged & looked.keys():
            for found in (self.measured, self._recent):
                if found.bodies is not None:
                    found.bodies[name] = max(found.bodies.get(name, 0.0), looked[name].size)
        self.undecided.difference_update(looked)
        if not self._is_to_judge([looked[name] for name in judged & looked.keys()], node):
            return None
        following = _Following(node, done, *self._closing(part))
        farther = self._slacks(following, 1.0)
        nearer = self._slacks(following, -1.0) if self.looks.noise is not None else farther
        for name in sorted(judged, key=lambda each: (-self._known[each].size, each)):
            off = self._known[name].size
            permitted = max(0.0, off + 0.5 * (farther[name].least + nearer[name].least))
            if nearer[name].least < 0.0 or (farther[name].least < 0.0 and self._never_told(name, following)):
                text = self._sentence(name, holders[name], permitted, nearer[name], is_seen=name in looked)
                return Surprise("displaced" if holders[name] is None else "grasp", text, name, off, permitted)
            if farther[name].least < 0.0:
                self.undecided.add(name)
            elif off > NOTED and (node, name) not in self._noted:
                self._noted.add((node, name))
                self.tolerated.append(_told(name, node, self._known[name], permitted, farther[name]))
        return None

    def _sentence(self, name: str, holder: str | None, permitted: float, slack: Slack, *, is_seen: bool) -> str:
        """That a body is farther off than is proven, and of what at which node."""
        off = 1000 * self._known[name].size
        is_off = f"is {off:.1f} mm" if is_seen else f"was seen last {off:.1f} mm"
        where = "where it was put" if holder is None else f"its place in the hand of {holder}"
        text = f"{name} {is_off} from {where}, {1000 * permitted:.1f} mm are proven to be free"
        return text if slack.other is None else f"{text} of {slack.other} at {slack.node}"

    def look(self, seen: Mapping[str, Array], state: RobotState, belief: Belief) -> dict[str, Seen]:
        """How far each body that is seen is from its place; arguments as of `bodies`."""
        wanted, names = belief.poses(state.positions), list(seen)
        if self.looks.noise is None:
            poses = ([wanted[name] for name in names], [seen[name] for name in names])
            found = displacements(*poses, [self._corners[name] for name in names])
            looked = {name: Seen(own, own.size) for name, own in zip(names, found, strict=True)}
        else:
            looked = {
                name: self.looks.take(
                    name, wanted[name], seen[name], belief.holder(name), self._corners[name], state.time
                )
                for name in names
            }
        self._known |= looked
        return looked

    def _is_to_judge(self, looked: Sequence[Seen], node: str) -> bool:
        """Whether any body is so far off, or may be, that pairs are to be looked at; mostly none is."""
        most = max((own.size + own.error for own in looked), default=0.0)
        tolerance = self.margins.rest(node)
        if tolerance is None or most > NOTED:
            return True
        others = max((own.size for own in self._known.values()), default=0.0)
        return most + max(most, others) + 2.0 * sum(self.errors.values()) >= tolerance.least

    def _never_told(self, name: str, following: _Following) -> bool:
        """Whether a body was looked at as often as it may be, and may still be a surprise by itself."""
        return self._known[name].looks >= MOST_LOOKS and self._slacks(following, 1.0, name)[name].least < 0.0

    def _closing(self, part: Motion | None) -> tuple[Running, frozenset[str]]:
        """The segments that are followed now, and the bodies on which hands close."""
        followed = () if part is None else part.at(self.path.time)
        running = frozenset((each.node, each.segment) for each in followed)
        nodes = self.margins.plan.nodes
        return running, frozenset(b for node, k in running for b, _ in nodes[node].motion[k].attach)

    def _slacks(self, following: _Following, sign: float, only: str | None = None) -> dict[str, Slack]:
        """How much more bodies may be off from a node on, if looks err to one side: 1, they are farther off; -1, nearer.

        Args:
            only: the body of which looks err; None: of all.
        """
        displaced = {
            name: own.with_error(sign) if only in (None, name) else own.displaced
            for name, own in self._known.items()
        }
        node, done, running, taken = following
        tolerance = self.margins.rest(node)
        if tolerance is None:
            permitted = self.margins.of_rest(node)
            return {name: Slack(permitted - each.size) for name, each in displaced.items()}
        found = tolerance.slacks(displaced, self.errors)
        for name in [name for name, slack in found.items() if slack.least < 0.0]:
            ahead = self.margins.during(running) if name in taken else self.margins.rest(node, done)
            if ahead is not None:
                found[name] = ahead.slacks(displaced, self.errors)[name]
        return found

    def gone(self, time: float, node: str) -> Surprise | None:
        """Whether a body is not seen any more, and something moves from a node on that may need it, or meet it.

        Args:
            time: of the robots' clock [s]. node: the node from which on proofs are needed.
        """
        if self.margins.of_rest(node) == np.inf:
            return None
        found = self.sightings.gone(time)
        if found is None:
            return None
        name, seconds = found
        text = f"{name} has not been seen for {seconds:.1f} s, and robots are still to move"
        return Surprise("gone", text, name, float("inf"), 0.0)

    def not_at_rest(self, state: RobotState, belief: Belief) -> str | None:
        """Which robot does not stand where it was sent, in a sentence; None: all do."""
        for name, robot in self.scene.robots.items():
            off = self._off_path(name, state.positions[name], belief.state.robots[name])
            speed = np.abs(state.velocities[name][: robot.planned]).max(initial=0.0)
            if off > AT_PLACE:
                return f"{name} is {1000 * off:.1f} mm from where it was to stand"
            if speed > STANDS:
                return f"{name} still moves"
        return None

    def elsewhere(self, state: RobotState, belief: Belief, node: str) -> Surprise | None:
        """Whether a robot that rests is farther from where a node begins than what is proven from there on."""
        permitted = max(AT_PLACE, self.margins.of_rest(node))
        for name in self.scene.robots:
            off = self._off_path(name, state.positions[name], belief.state.robots[name])
            if off > permitted:
                text = f"{name} is {1000 * off:.1f} mm from where the plan begins"
                return Surprise("elsewhere", text, name, off, permitted)
        return None

    def corrected(self, state: RobotState, belief: Belief) -> Belief:
        """What is believed, with arms where they are measured to be if they rest somewhere else."""
        found = {
            name: (*state.positions[name][: robot.planned], *belief.state.robots[name][robot.planned :])
            for name, robot in self.scene.robots.items()
            if self._off_path(name, state.positions[name], belief.state.robots[name]) > AT_PLACE
        }
        return Belief(belief.scene, belief.state.replace(dict(found)), belief.givers) if found else belief

    def grasp(self, robot: str, state: RobotState, belief: Belief, bodies: tuple[str, ...]) -> Surprise | None:
        """Whether a hand that has closed is about as wide as planned."""
        own = self.scene.robots[robot]
        if own.gripper is None:
            return None
        for number, joint in enumerate(own.gripper.joints, own.planned):
            stroke = abs(own.gripper.open.get(joint, 0.0) - own.gripper.closed.get(joint, 0.0))
            off = abs(state.positions[robot][number] - belief.state.robots[robot][number])
            if off > CLOSED_ON_NOTHING * stroke > 0.0:
                found = f"{joint} is at {state.positions[robot][number]:.4g}, not {belief.state.robots[robot][number]:.4g}"
                text = f"{robot} does not hold {', '.join(bodies)} as planned: {found}"
                return Surprise("grasp", text, ", ".join(bodies), off, CLOSED_ON_NOTHING * stroke)
        return None

    def empty_hands(self, state: RobotState, belief: Belief) -> dict[str, tuple[float, ...]]:
        """The joints of hands that should hold something and do not, by robot [rad or m].

        They have closed beyond it; or, while another hand still gives it, not far enough: then that one must not open.
        """
        found = {}
        given = {name for name in self.scene.movable if belief.held_by_giver(name) is not None}
        takers = {belief.holder(name) for name in given}
        givers = {hold[0] for name in given if (hold := belief.held_by_giver(name)) is not None}
        holders = {belief.holder(name) for name in self.scene.movable} - {None}
        for robot in sorted({*map(str, holders), *givers}):
            own = self.scene.robots[robot]
            if own.gripper is None:
                continue
            for number, joint in enumerate(own.gripper.joints, own.planned):
                closing = own.gripper.closed.get(joint, 0.0) - own.gripper.open.get(joint, 0.0)
                beyond = (state.positions[robot][number] - belief.state.robots[robot][number]) * np.sign(closing)
                off = abs(beyond) if robot in takers else beyond
                if off > CLOSED_ON_NOTHING * abs(closing) > 0.0:
                    found[robot] = state.positions[robot][own.planned :]
        return found


def _told(name: str, node: str, seen: Seen, permitted: float, slack: Slack) -> dict[str, object]:
    """Why a body that is off is no surprise, as a record of the log."""
    nearest = "nothing" if slack.other is None else f"{slack.other} at {slack.node}"
    reason = (
        f"{name} is {1000 * seen.size:.1f} mm off, {1000 * permitted:.1f} mm are proven to be free from {node} on; "
        f"nearest is {nearest}"
    )
    more = {"looks": seen.looks, "error": seen.error} if seen.error else {}
    return {"body": name, "node": node, "off": seen.size, "permitted": permitted, **more, "reason": reason}
