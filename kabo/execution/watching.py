"""Compares what is measured with what the plan has, many times a second; what is not covered by a proof is a surprise.

A robot may be as far from its path as the segment's proven clearance, a body as far from its place as what is proven of it
for the rest of the plan, in the direction in which it is off: up to there the proofs hold. What robots and bodies are off
together may use up no gap that is proven of two things. Nothing is a surprise that is within.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.looks import MOST_LOOKS, Looks, Seen, displacement_of
from kabo.execution.margins import Displacement, Margins, Slack
from kabo.execution.motions import Motion
from kabo.execution.nearness import Moving, Nearness
from kabo.execution.protocols import RobotState
from kabo.scene import Scene, link_poses

GONE_AFTER = 1.0  # [s] after which a body that is not seen may be anywhere
AT_PLACE, STANDS = 1e-3, 0.02  # [m]; [rad/s or m/s]: a robot that stands is so near to its place, and so slow
NOTED = 5e-4  # [m]: that a body is off by more, and yet no surprise, is told once at each node
CLOSED_ON_NOTHING = 0.1  # share of a hand's stroke by which it may be narrower or wider than planned


@dataclass(frozen=True)
class Surprise:
    """What no proof covers: its kind, a sentence, the thing, by how much it is off and what was permitted [m]."""

    kind: str  # "tracking", "displaced", "grasp", "gone"
    sentence: str
    thing: str
    off: float
    permitted: float


@dataclass
class Measured:
    """The greatest deviations of one motion [m]: of any link from its path, and of each body from its place."""

    tracking: float = 0.0
    permitted: float = float("inf")
    bodies: dict[str, float] | None = None


class Watch:
    """Judges measurements of one run.

    Args:
        scene: the scene. margins: what the plan has proven.
        seen_at: when each body was seen last [s]; it is written, and given to the watch of the next plan. A sensor that has
            never seen anything is no camera: then nothing is gone.
        looks: the means of poses that are seen with noise.
        errors: how far robots may be off their paths, as their makers say [m].
    """

    def __init__(
        self,
        scene: Scene,
        margins: Margins,
        seen_at: dict[str, float] | None = None,
        looks: Looks | None = None,
        errors: Mapping[str, float] | None = None,
    ) -> None:
        self.scene, self.margins = scene, margins
        self.looks, self.errors = looks or Looks(None), errors or {}
        self.displaced: dict[str, Displacement] = {}  # of bodies, by what was seen last
        self.undecided: dict[
            str, int
        ] = {}  # bodies that may be a surprise, with how many more looks it takes to tell
        self.tolerated: list[
            dict[str, object]
        ] = []  # bodies that are off, covered by proofs, since they were taken
        self._noted: set[tuple[str, str]] = set()  # nodes and bodies
        self._nearness = Nearness(scene)
        self.seen_at = {} if seen_at is None else seen_at
        self.measured = Measured()
        self._recent = Measured(bodies={})  # since it was taken
        self._radius = {
            name: float(np.linalg.norm(scene.bodies[name].mesh.vertices, axis=1).max()) for name in scene.movable
        }

    def begin(self) -> None:
        """Begins the figures of a motion."""
        self.measured = Measured(bodies={})

    def take_recent(self) -> Measured:
        """The figures since they were taken last."""
        found, self._recent = self._recent, Measured(bodies={})
        return found

    def tracking(self, motion: Motion, state: RobotState, belief: Belief) -> Surprise | None:
        """Whether each robot is near enough to the path that was proven, and nothing too near together."""
        moving: dict[str, Moving] = {}
        for name in self.scene.robots:
            running = [each for each in motion.at(state.motion_time) if each.robot == name]
            permitted = min((self.margins.of_segment(each.node, each.segment) for each in running), default=np.inf)
            planned = dict(zip(self.scene.robots[name].joint_names, belief.state.robots[name], strict=True))
            for each in running:
                planned |= dict(
                    zip(each.trajectory.joints, each.trajectory.at(state.motion_time).tolist(), strict=True)
                )
            off = self._off_path(name, state.positions[name], tuple(planned.values()))
            if running:
                moving[name] = Moving(tuple(planned.values()), off)
            for found in (self.measured, self._recent):
                found.tracking, found.permitted = max(found.tracking, off), min(found.permitted, permitted)
            if off > permitted:
                text = (
                    f"{name} is {1000 * off:.1f} mm off its path, {1000 * permitted:.1f} mm are proven to be free"
                )
                return Surprise("tracking", text, name, off, float(permitted))
        followed = frozenset((each.node, each.segment) for each in motion.at(state.motion_time))
        near = self._nearness.judge(self.margins, followed, moving, state, belief, self.displaced)
        if near is None:
            return None
        return Surprise("tracking", str(near), near.between[0], near.off, max(0.0, near.off - near.missing))

    def _off_path(self, name: str, actual: tuple[float, ...], planned: tuple[float, ...]) -> float:
        """How far any link's origin of the arm is from where it should be [m]; hands close as far as they find room."""
        robot = self.scene.robots[name]
        true, wanted = list(actual), list(planned)
        true[robot.planned :] = wanted[robot.planned :]
        first, second = link_poses(robot, true), link_poses(robot, wanted)
        return max(float(np.linalg.norm(first[link][:3, 3] - second[link][:3, 3])) for link in first)

    def bodies(
        self, seen: Mapping[str, Array], state: RobotState, belief: Belief, node: str, *, held: bool = True
    ) -> Surprise | None:
        """Whether each body that is seen is near enough to its place, on its support or in a hand.

        Args:
            seen: the poses (4, 4) of bodies. state: what is measured of robots. belief: where all should be.
            node: the node from which on proofs are needed.
            held: whether bodies in hands are judged, too.
        """
        looked = self.look(seen, state, belief)
        for name, own in looked.items():
            if held or belief.holder(name) is None:
                for found in (self.measured, self._recent):
                    if found.bodies is not None:
                        found.bodies[name] = max(found.bodies.get(name, 0.0), own.displaced.size)
        sure, maybe = self._slacks(looked, node, -1.0), self._slacks(looked, node, 1.0)
        for name, own in sorted(looked.items(), key=lambda each: -each[1].displaced.size):
            holder, off = belief.holder(name), own.displaced.size
            if holder is not None and not held:
                continue
            self.undecided.pop(name, None)
            permitted = max(0.0, off + 0.5 * (sure[name].least + maybe[name].least))
            if sure[name].least < 0.0 or (maybe[name].least < 0.0 and own.looks >= MOST_LOOKS):
                where = "where it was put" if holder is None else f"its place in the hand of {holder}"
                text = (
                    f"{name} is {1000 * off:.1f} mm from {where}, {1000 * permitted:.1f} mm are proven to be free"
                )
                return Surprise("displaced" if holder is None else "grasp", text, name, off, permitted)
            if maybe[name].least < 0.0:
                noise = self.looks.noise
                assert noise is not None
                self.undecided[name] = noise.needed(self._radius[name], abs(permitted - off)) - own.looks
            elif off > NOTED and (node, name) not in self._noted:
                self._noted.add((node, name))
                self.tolerated.append(_told(name, node, own, permitted, maybe[name]))
        return None

    def look(self, seen: Mapping[str, Array], state: RobotState, belief: Belief) -> dict[str, Seen]:
        """How far each body that is seen is from its place; arguments as of `bodies`."""
        wanted, looked = belief.poses(state.positions), {}
        for name, pose in seen.items():
            looked[name] = self.looks.take(name, wanted[name], pose, belief.holder(name), self._radius[name])
            self.displaced[name] = looked[name].displaced
        return looked

    def _slacks(self, looked: Mapping[str, Seen], node: str, sign: float) -> dict[str, Slack]:
        """How much more bodies may be off from a node on, if looks err to one side: 1, they are farther off; -1, nearer."""
        displaced = self.displaced | {name: own.with_error(sign) for name, own in looked.items()}
        tolerance = self.margins.rest(node)
        if tolerance is not None:
            return tolerance.slacks(displaced, self.errors)
        permitted = self.margins.of_rest(node)
        return {name: Slack(permitted - each.size) for name, each in displaced.items()}

    def gone(self, seen: Mapping[str, Array], time: float, node: str) -> Surprise | None:
        """Whether a body is not seen any more, and something moves from a node on that may need it, or meet it.

        Args:
            seen: what is seen now. time: of the robots' clock [s]. node: the node from which on proofs are needed.
        """
        if seen and not self.seen_at:
            self.seen_at.update(dict.fromkeys(self.scene.movable, time))
        self.seen_at.update(dict.fromkeys(seen, time))
        if self.margins.of_rest(node) == np.inf:
            return None
        for name, last in self.seen_at.items():
            if time - last > GONE_AFTER:
                text = f"{name} has not been seen for {time - last:.1f} s, and robots are still to move"
                return Surprise("gone", text, name, float("inf"), 0.0)
        return None

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
        """The joints of hands that should hold something and have closed beyond it, by robot [rad or m]."""
        found = {}
        holders = {belief.holder(name) for name in self.scene.movable} - {None}
        for robot in sorted(map(str, holders)):
            own = self.scene.robots[robot]
            if own.gripper is None:
                continue
            for number, joint in enumerate(own.gripper.joints, own.planned):
                closing = own.gripper.closed.get(joint, 0.0) - own.gripper.open.get(joint, 0.0)
                beyond = (state.positions[robot][number] - belief.state.robots[robot][number]) * np.sign(closing)
                if beyond > CLOSED_ON_NOTHING * abs(closing) > 0.0:
                    found[robot] = state.positions[robot][own.planned :]
        return found


def displacement(wanted: Array, found: Array, radius: float) -> float:
    """A bound of how far any point of a body within `radius` of its origin is from its place [m]."""
    return displacement_of(wanted, found, radius).size


def _told(name: str, node: str, seen: Seen, permitted: float, slack: Slack) -> dict[str, object]:
    """Why a body that is off is no surprise, as a record of the log."""
    nearest = "nothing" if slack.other is None else f"{slack.other} at {slack.node}"
    off, most = 1000 * seen.displaced.size, 1000 * permitted
    reason = (
        f"{name} is {off:.1f} mm off, {most:.1f} mm are proven to be free from {node} on; nearest is {nearest}"
    )
    more = {"looks": seen.looks, "error": seen.error} if seen.error else {}
    return {
        "body": name,
        "node": node,
        "off": seen.displaced.size,
        "permitted": permitted,
        **more,
        "reason": reason,
    }
