"""Samples configurations at which one robot can grasp the object that another robot holds, or mate a part with it.

Both robots' configurations are sampled together, subject to the constraints of a mate or of a grasp family between
their tools; the path of the second robot to its configuration is planned by later stages.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Candidate, Contacts, Pair, Refusal, Situation, Team, TeamStream, candidate
from kabo.kinematics import project, uniform
from kabo.language.scene_description import Constraint
from kabo.scene import Configuration, Scene
from kabo.streams import stream_key
from kabo.tasks.core import Monitor, Property, Result
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, ROBOT, RobotStage
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.grasps import ANY, family_faults
from kabo.tasks.robots.stages.placements import mate_of

SPREADS = (0.25, 0.5, 1.0)  # rad: distances from home of the configurations that are projected
SEEDS_PER_SPREAD = 16  # configurations for each of these distances


@dataclass(frozen=True)
class Meeting(Candidate):
    """A candidate configuration of the first robot, with the matching configuration of the second robot."""

    other: Configuration


@dataclass(frozen=True)
class MeetingTarget:
    """All pairs of configurations at which two robots meet, as a target for the robot that moves first."""

    robot: str
    partner: str
    stream: TeamStream
    touching: Contacts  # contacts permitted once they have met

    def batches(self) -> Iterator[list[Candidate]]:
        """The meetings in batches: first solutions close to home, then samples, each batch sorted likewise."""
        for spread in SPREADS:
            yield self._ordered(self._led(spread))
        number = 0
        while True:
            yield self._ordered(self.stream.batch(number))
            number += 1

    def _led(self, spread: float) -> list[Candidate]:
        """Projections of configurations up to `spread` [rad or m] from home."""
        team, first = self.stream.team, SEEDS_PER_SPREAD * round(spread / SPREADS[0])
        seeds = np.tile(self._home, (SEEDS_PER_SPREAD, 1))
        for k, seed in enumerate(seeds):
            noise = [2.0 * uniform(self.stream.key, first + k, i) - 1.0 for i in range(len(seed))]
            seed += spread * np.array(noise) * team.moving
        limits = team.tree.lower, team.tree.upper
        found, valid = project(team.tree, self.stream.rows, np.clip(seeds, *limits), *limits, team.moving)
        return [self.stream.candidate(q) for q in found[valid]]

    def _ordered(self, found: list[Candidate]) -> list[Candidate]:
        team, home, made = self.stream.team, self._home, []
        for each in found:
            q = team.configurations(each.q)
            away = float(np.abs((each.q - home) * team.moving).max())
            first = candidate(team.robots[0], q[self.robot])
            made.append((round(away, 6), tuple(each.q), Meeting(first.q, first.tree, q[self.partner])))
        return [each for _, _, each in sorted(made, key=lambda one: one[:2])]

    @property
    def _home(self) -> Array:
        """Both arms at home, the grippers as they are (n,)."""
        home: Array = self.stream.base.copy()
        for robot, place in zip(self.stream.team.robots, self.stream.team.joined.values, strict=False):
            home[place][: robot.planned] = robot.configurations.get("home", np.zeros(robot.planned))
        return home

    def blocked(self, scene: TaskScene) -> Pair | None:
        """None: no blocking pair can be found before sampling, because the robots can meet in many poses."""
        return None

    def refused(self, scene: TaskScene, at: Candidate) -> str | None:
        """The message if the second robot would collide at its own configuration; None if it would not."""
        assert isinstance(at, Meeting)
        there = scene.permitting(tuple(sorted(pair)) for pair in self.touching)  # type: ignore[misc]
        hit = there.at(self.robot, at.q).at(self.partner, at.other).hit(self.partner)
        return None if hit is None else f"where they meet, {hit[0]} would be too near to {hit[1]}"


class SampleMeeting(RobotStage, Monitor):
    """Samples where a robot brings what it holds so that a partner reaches it; writes `target` for this robot.

    The partner is either to mate what it holds (`part`) with it, as `mate` says, or to grasp it by `family`. Later stages
    plan how the partner gets there.
    """

    READS = ("object", "part")
    WRITES = ("target",)
    PROPERTIES = {
        "robot": ROBOT,
        "object": OBJECT,
        "partner": Property(str, doc="the other robot", wrong=meanings.name),
        "part": Property(
            (str, type(None)),
            None,
            "what the other robot holds, the moving part of the mate; none: it grasps the object",
            meanings.name,
        ),
        "mate": Property(
            (str, type(None)),
            None,
            "the mate of the scene for `part`; none: the other robot grasps the object",
            meanings.name,
        ),
        "family": Property(
            str, ANY, "a grasp family of the object, or `any`: all that fit the other robot", meanings.name
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a mate without a part, a part without a mate, or a family that the object lacks."""
        part, mate = self.known("part"), self.known("mate")
        if (part is None) != (mate is None) and not any(map(self.undecided, ("part", "mate"))):
            yield "a `part` and its `mate` go together: the other robot takes the object, or brings it a part"
        if part is None:
            yield from family_faults(self, scene, "grasps")

    def generate(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """One result with the scene for each grasp family, or one for the mate."""
        robot, partner, name = (properties[key] for key in ("robot", "partner", "object"))
        for each, holder in ((name, robot), (properties["part"], partner)):
            if each is not None and scene.holder(each) != holder:
                text = f"{holder} does not hold {each}"
                return [Refusal("constraint", text, reads=frozenset({each}), proof=True)]
        results = []
        for label, constraints, roles, touching in _ways(scene, properties):
            target = _target(scene, robot, partner, (label, constraints), roles, touching)
            if target is not None:
                results.append(Result(scene, properties={"target": target}, comment=label))
        if not results:
            text = f"{name} and {partner} do not fit together"
            return [Refusal("empty_family", text, reads=frozenset({name}), proof=True)]
        return results


Way = tuple[str, tuple[Constraint, ...], Mapping[str, str], list[Pair]]


def _ways(scene: TaskScene, properties: Values) -> Iterator[Way]:
    """The mate, or the partner's grasp families: name, constraints, roles, and the contacts to be permitted."""
    partner, name, part = (properties[key] for key in ("partner", "object", "part"))
    if part is not None:
        mate = mate_of(scene, properties["mate"])
        yield mate.name, mate.constraints, {"moving": part, "fixed": name}, [(part, name)]
        return
    wanted, gripper = properties["family"], scene.robot(partner).gripper
    touching = [(link, name) for link in (() if gripper is None else gripper.touch_links)]
    for family in scene.context.scene.bodies[name].grasps.values():
        if wanted in (ANY, family.name) and (family.robots is None or partner in family.robots):
            yield family.name, family.constraints, {"tool": f"{partner}.tool", "this": name}, touching


def _target(
    scene: TaskScene,
    robot: str,
    partner: str,
    what: tuple[str, tuple[Constraint, ...]],
    roles: Mapping[str, str],
    touching: list[Pair],
) -> MeetingTarget | None:
    """The target; None if a feature that the constraints name is missing."""
    label, constraints = what
    state = scene.situation.first
    held = [scene.situation.held(each) for each in roles.values() if each in scene.situation.objects]
    numbers = [value for each in held for value in (*each.position, *each.quaternion)]
    key = stream_key(scene.context.seed, "meeting", robot, partner, label, *sorted(roles.values()), *numbers)
    team = Team.of(scene.context.scene, (robot, partner))
    try:
        stream = TeamStream.of(team, constraints, state, key, roles)
    except ValueError:
        return None
    return MeetingTarget(robot, partner, stream, frozenset(frozenset(pair) for pair in touching))
