"""Whether what robots and bodies are off *together* uses up a gap that is proven of two things, at the moment."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import permutations

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.displacements import Displacement
from kabo.execution.link_corners import Corners, Held
from kabo.execution.margins import Margins, Running, Tolerance
from kabo.execution.protocols import RobotState
from kabo.scene import Scene, world_T
from kabo.scene.state import GeometricState


@dataclass(frozen=True)
class Moving:
    """A robot that moves: where the plan has its joints, and how far an origin of its links is off at most [m]."""

    planned: tuple[float, ...]
    off: float


@dataclass(frozen=True)
class TooNear:
    """Two things that are nearer to each other than is proven to be free, by `missing` [m]; `off`: of any robot's point."""

    between: tuple[str, str]
    missing: float
    off: float

    def __str__(self) -> str:
        first, second = self.between
        return f"{first} and {second} are nearer to each other than is proven to be free, by {1000 * self.missing:.1f} mm"


class Nearness:
    """Judges one run: by a quick bound, and where that does not suffice, by the corners of boxes around bodies."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self._corners: Corners | None = None
        self._during: tuple[Margins | None, Running, Tolerance | None] = None, frozenset(), None
        self._in_hands: tuple[GeometricState | None, dict[str, Held]] = None, {}

    def judge(
        self,
        margins: Margins,
        running: Running,
        robots: Mapping[str, Moving],
        state: RobotState,
        belief: Belief,
        displaced: Mapping[str, Displacement],
    ) -> TooNear | None:
        """Two things that are too near to each other; None if proofs cover all, or none of pairs are at hand.

        Args:
            margins: of the plan. running: what is followed now. robots: those that move.
            state: what is measured. belief: where the plan has everything. displaced: bodies that are off.
        """
        if self._during[:2] != (margins, running):
            self._during = margins, running, margins.during(running)
        tolerance = self._during[2]
        if tolerance is None or not robots:
            return None
        self._corners = corners = self._corners or Corners(self.scene)
        sizes = sorted(each.size for each in displaced.values())[-2:]
        held = {name: self._held(name, belief) for name in robots}
        joints = {name: self._with_hand(name, state.positions[name], own.planned) for name, own in robots.items()}
        quick = sum(
            corners.bound(name, joints[name], own.planned, own.off, held[name]) for name, own in robots.items()
        )
        if 2.0 * quick + sum(sizes) < tolerance.least:
            return None
        poses: dict[str, tuple[Array, Array]] = {}
        carrier: dict[str, str] = {}
        for name, moving in robots.items():
            own = corners.poses(name, joints[name], moving.planned, held[name])
            poses |= own
            carrier |= dict.fromkeys(own, name)
        least, pair = tolerance.together(displaced, lambda *pair: corners.lost(poses, carrier, pair))
        far = tolerance.near - self._farthest(corners, poses, carrier, tolerance.near) - sum(sizes)
        if least >= 0.0 and far >= 0.0:
            return None
        off = max(corners.off(name, *own) for name, own in poses.items())
        return TooNear(pair if least <= far else (next(iter(robots)), "what is near"), -min(least, far), off)

    @staticmethod
    def _farthest(
        corners: Corners, poses: Mapping[str, tuple[Array, Array]], carrier: Mapping[str, str], near: float
    ) -> float:
        """How much nearer to each other any two things may be because robots are off their paths [m]."""
        most = dict.fromkeys(carrier.values(), 0.0)
        for name, own in poses.items():
            most[carrier[name]] = max(most[carrier[name]], corners.off(name, *own))
        found = sum(most.values())
        for robot, off in most.items():
            if 2.0 * off > near:  # two links of one robot may be off in opposite directions
                things = [name for name, each in carrier.items() if each == robot]
                found = max([found, *(corners.lost(poses, carrier, pair) for pair in permutations(things, 2))])
        return found

    def _held(self, robot: str, belief: Belief) -> Held:
        """What a robot holds, each body with the link of its hand and its pose there; looked up once in each state."""
        if self._in_hands[0] is not belief.state:
            self._in_hands = belief.state, {}
        known = self._in_hands[1]
        if robot not in known:
            known[robot] = self._taken(robot, belief)
        return known[robot]

    def _taken(self, robot: str, belief: Belief) -> Held:
        found: dict[str, tuple[str, Array]] = {}
        for name in self.scene.movable:
            if belief.holder(name) != robot:
                continue
            link = name
            while link in belief.state.objects:
                link = belief.state.objects[link].parent
            place = np.linalg.inv(world_T(self.scene, belief.state, link)) @ world_T(
                self.scene, belief.state, name
            )
            found[name] = link.partition(".")[2], place
        return found

    def _with_hand(self, robot: str, actual: Sequence[float], planned: Sequence[float]) -> tuple[float, ...]:
        """The measured values of an arm's joints, with a hand as planned: it closes as far as it finds room."""
        count = self.scene.robots[robot].planned
        return (*actual[:count], *planned[count:])
