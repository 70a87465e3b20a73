"""Streams of candidates: configurations that grasp an object or put one down, drawn evenly or by projection.

The key of a stream depends only on what is sampled: the robot, the object, the family, the values that its
constraints read. So the same grasps and placements are tried in the same order wherever the robot starts, and
branches of a plan with the same knowledge can reach the same geometric state (docs/reference/plans.md#sharing).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array, Integers
from kabo.geometry_server.configurations import Candidate, candidate, joints_at, poses_at
from kabo.geometry_server.driving.standing import Standing
from kabo.geometry_server.frames import WORLD, Frame, Roles, carried_frame, fits, rows, standing_frame, tool_frame
from kabo.geometry_server.open_turns import open_turn
from kabo.kinematics import (
    ClosedArm,
    OutOfReach,
    drawn,
    is_carried,
    project,
    reaching,
    rows_of,
    sample,
    stacked,
    unlimited,
    with_the_same_pose,
)
from kabo.kinematics.kernels import rows as columns
from kabo.language.scene_description import Feature, GraspFamily, PlacementFamily
from kabo.scene import BASE_VALUES, Attachment, Body, Region, Robot, Structure
from kabo.scene.transforms import length
from kabo.streams import stream_key

RANDOM_EVERY = 4  # samples of which one has joints at random that its constraints do not read
BATCH_SAMPLES = 64  # in one kernel call; candidates of a batch are tried in order of preference


@dataclass(frozen=True)
class Stream:
    """Configurations of a robot that fulfil constraint rows, in an order determined by the stream's `key`.

    `hand` holds the values of the gripper's joints, which stay fixed. `standing` says where a base that drives may
    stand; None if the base stands.
    """

    robot: Robot
    rows: Array
    key: np.uint64
    hand: tuple[float, ...]
    standing: Standing | None = None

    def batch(self, number: int, size: int = BATCH_SAMPLES, along: Array | None = None) -> list[Candidate]:
        """The valid samples of batch `number`, which has `size` samples, in order of their index.

        Samples are spread evenly along the rows `along`, as far as the arm reaches, and over the intervals of the
        stream's rows. A closed form gives several branches of the arm for each sample. Then even batches hold the
        branch nearest to home of each sample, and odd batches its other branches, tried later since they put the
        hand at the same pose.
        """
        if self._structure is None:
            return self.samples(number * size, size, along)
        half, others = divmod(number, 2)
        found, owner = self._branches(half * size, size, along)
        nearest = _nearest_home(self.robot, found, owner)
        return self._candidates(_distinct(found[~nearest if others else nearest]))

    def samples(self, first: int, count: int, along: Array | None = None) -> list[Candidate]:
        """The valid samples among `count` from index `first` on, in order, along `along`, with all branches of the arm."""
        return self._candidates(self._branches(first, count, along)[0])

    def draws(self, count: int) -> bool | None:
        """Whether one of the first `count` samples is valid if drawn pose first; None where that is not possible."""
        made = self._drawn(0, count, None)
        return None if made is None else len(made[0]) > 0

    def _branches(self, first: int, count: int, along: Array | None) -> tuple[Array, Integers]:
        """The valid samples (M, n), with all branches if there is a closed form, and each one's sample (M,).

        With a closed form on a base that stands, the pose of the hand is drawn first where the rows allow; samples
        that find none so are projected.
        """
        made = self._drawn(first, count, along)
        missing = np.ones(count, np.bool_)
        if made is not None:
            missing[made[1]] = False
        if made is not None and not missing.any():
            return made
        found, owner = self._projected(first, count, along, missing)
        if made is not None:
            found, owner = np.concatenate([made[0], found]), np.concatenate([made[1], owner])
        order = np.argsort(owner, kind="stable")
        return found[order], owner[order]

    def _drawn(self, first: int, count: int, along: Array | None) -> tuple[Array, Integers] | None:
        """The samples that are drawn pose first, with all branches; None where that is not possible."""
        structure = self._structure
        if structure is None or self.robot.drive is not None:
            return None
        return drawn(
            _closed_arm(self.robot, structure, self.hand),
            self.rows,
            self.key,
            first,
            count,
            free=along,
            every_branch=True,
        )

    def _projected(
        self, first: int, count: int, along: Array | None, wanted: npt.NDArray[np.bool_]
    ) -> tuple[Array, Integers]:
        """The samples that projection of seeds finds, of those `wanted` (count,), as `_branches` gives them."""
        tree, structure = self.robot.tree, self._structure
        limits = (tree.lower, tree.upper) if structure is None else unlimited(tree, structure)
        found, valid = self._sampled(first, count, along, limits)
        chosen = np.flatnonzero(valid & wanted)
        if structure is None:
            return found[chosen], chosen
        branches, owner = self._same_pose(structure, found[chosen])
        return branches, chosen[owner]

    def _sampled(
        self, first: int, count: int, along: Array | None, limits: tuple[Array, Array]
    ) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Samples (count, n), and which are valid (count,).

        If the base drives, the arm reaches from where a table of arms says that it does. Where that fails, as it does
        near the end of its reach, base and arm are projected together from anywhere.
        """
        robot, tree = self.robot, self.robot.tree
        some = self.key, first, count, *limits
        base = np.concatenate([np.zeros(robot.planned), self.hand])
        planned = np.arange(tree.size) < robot.planned
        if self.standing is None or robot.drive is None:
            found, valid = sample(tree, self.rows, *some, planned, along, base=base)
            return self._at_home(found, first, along), valid
        placed = self.standing.starts(self.rows, along, self.key, first, count, self.hand)
        found, valid = base[None].repeat(count, axis=0), np.zeros(count, np.bool_)
        if placed is not None:
            found, valid = sample(tree, self.rows, *some, robot.arm, along, starts=placed[0])
            valid &= placed[1]
        if not valid.all():
            other, fulfils = sample(tree, self.rows, *some, planned, along, base=base)
            fulfils &= ~valid & (robot.drive.outside(other[:, :BASE_VALUES]) <= 0.0)
            found[fulfils], valid[fulfils] = other[fulfils], True
        return self._at_home(found, first, along), valid

    def _at_home(self, found: Array, first: int, along: Array | None) -> Array:
        """Samples (count, n) from index `first` on; most have joints that no row reads at home, as the arm of a look."""
        every = self.rows if along is None else np.concatenate([self.rows, along])
        moving = self.robot.moving({int(j) for j in every[:, (columns.FIRST, columns.SECOND)].ravel()})
        idle = np.flatnonzero(~moving[: self.robot.planned])
        chosen = np.flatnonzero((first + 1 + np.arange(len(found))) % RANDOM_EVERY)
        home = np.clip(_home(self.robot)[idle], self.robot.tree.lower[idle], self.robot.tree.upper[idle])
        found[np.ix_(chosen, idle)] = home
        return found

    def _same_pose(self, structure: Structure, found: Array) -> tuple[Array, Integers]:
        """All configurations with the same pose of the hand as a row of (N, n) and the same base, and each one's row."""
        tree, n = self.robot.tree, self.robot.base_values
        still = found.copy()
        still[:, :n] = 0.0  # the structure is that of the arm on a base at zero
        made, owner = with_the_same_pose(tree, structure, still)
        made[:, :n] = found[owner, :n]
        return made, owner

    def _candidates(self, found: Array) -> list[Candidate]:
        return [Candidate(q, self.robot.tree) for q in np.round(found, 9) + 0.0]

    @cached_property
    def _structure(self) -> Structure | None:
        """The closed form that gives branches; None without one, or if rows constrain other joints than the hand's."""
        robot, structure = self.robot, closed_form_of(self.robot)
        joints = {int(j) for j in self.rows[:, (columns.FIRST, columns.SECOND)].ravel()} - {0}
        if structure is None or not all(is_carried(robot, structure, joint) for joint in joints):
            return None
        return structure

    def near(self, q: Sequence[float] | Array) -> list[Candidate]:
        """A list of the candidate onto which a configuration (n,) is projected; empty if the projection fails.

        A base that drives stays where it is.
        """
        tree = self.robot.tree
        found, valid = project(
            tree, self.rows, np.asarray(q, dtype=np.float64), tree.lower, tree.upper, self.robot.arm
        )
        return [candidate(self.robot, np.round(each, 9) + 0.0) for each in found[valid]]

    def at_pose(self, frame: Frame, world_T_frame: Array) -> list[Candidate] | OutOfReach | None:
        """All candidates with a frame of the tree at a pose (4, 4), by the closed form, or why there is none.

        None if the robot has no closed form for this frame, or one with a free joint, as for seven axes, or drives.
        """
        robot, structure = self.robot, closed_form_of(self.robot)
        if robot.drive is not None or structure is None or structure.lock >= 0:
            return None
        if not is_carried(robot, structure, frame.joint):
            return None
        found = reaching(robot, frame.joint, frame.joint_T_frame, world_T_frame, self.key, 1, hand=self.hand)
        if isinstance(found, OutOfReach):
            return found
        return self._candidates(found.configurations)


def _closed_arm(robot: Robot, structure: Structure, hand: tuple[float, ...]) -> ClosedArm:
    """The arm of a robot with its gripper's joints at some values, the same for all that is grasped and placed so."""
    key = "closed arm", hand
    if key not in robot.memory:
        robot.memory[key] = ClosedArm(robot.tree, structure, np.concatenate([np.zeros(robot.planned), hand]))
    arm: ClosedArm = robot.memory[key]
    return arm


def closed_form_of(robot: Robot) -> Structure | None:
    """The closed form of a robot's inverse kinematics; None if the scene's settings or the axes require projection."""
    structure = None if robot.inverse_kinematics == "projection" else robot.structure
    return structure if isinstance(structure, Structure) else None


def _distinct(found: Array) -> Array:
    """The configurations (M, n) without repetitions, which occur where constraints leave a few poses only."""
    kept = np.unique(np.round(found, 5), axis=0, return_index=True)[1]
    return found[np.sort(kept)]


def _home(robot: Robot) -> Array:
    """The planned joints (planned,) at home; at zero without one."""
    return np.array(robot.configurations.get("home", np.zeros(robot.planned)))


def _nearest_home(robot: Robot, found: Array, owner: Integers) -> npt.NDArray[np.bool_]:
    """Which of the branches (M, n) is the nearest to home among those of its sample (M,); the first of equals."""
    home = _home(robot)
    away = np.round(np.linalg.norm(found[:, : robot.planned] - home, axis=1), 6)
    order = np.lexsort((away, owner))
    nearest = np.zeros(len(found), np.bool_)
    nearest[order[np.unique(owner[order], return_index=True)[1]]] = True
    return nearest


def from_home(robot: Robot, found: list[Candidate]) -> list[Candidate]:
    """The candidates, sorted by distance from the robot's home configuration."""
    home = _home(robot)
    return sorted(found, key=lambda c: (round(length(c.q[: robot.planned] - home), 6), *c.q))


@dataclass(frozen=True)
class GraspStream:
    """Grasps of a standing object by one robot, all from one grasp family."""

    stream: Stream
    family: GraspFamily
    tool: Frame
    roles: Roles

    def __iter__(self) -> Iterator[list[Candidate]]:
        number = 0
        while True:
            yield from_home(self.stream.robot, self.stream.batch(number, along=self.turn))
            number += 1

    @cached_property
    def turn(self) -> Array | None:
        """The rotation about the object that the grasp family does not fix, as a row (1, W); None if there is none."""
        return open_turn(self.stream.rows, self.tool)


def grasp_roles(robot: Robot, body: Body, family: GraspFamily, world_T_body: Array) -> Roles | None:
    """The frame of each role in a grasp family, for a standing object; None if the family does not fit this robot."""
    if robot.tool is None or (family.robots is not None and robot.name not in family.robots):
        return None
    roles = {"tool": tool_frame(robot), "this": standing_frame(body, world_T_body), "world": WORLD}
    return roles if fits(family.constraints, roles) else None


def grasp_stream(
    robot: Robot,
    body: Body,
    family: GraspFamily,
    world_T_body: Array,
    hand: tuple[float, ...],
    seed: int,
    standing: Standing | None = None,
) -> GraspStream | None:
    """The stream of grasps of a standing object; None if the grasp family does not fit this robot."""
    if (roles := grasp_roles(robot, body, family, world_T_body)) is None:
        return None
    numbers = [float(value) for value in np.round(world_T_body[:3], 9).ravel()]
    key = stream_key(seed, "grasp", robot.name, body.name, family.name, *numbers)
    stream = Stream(robot, rows(family.constraints, roles), key, hand, standing)
    return GraspStream(stream, family, roles["tool"], roles)


@dataclass(frozen=True)
class PlacementStream:
    """Placements of an object that a robot holds, on a support, in a region, or both, from one placement family."""

    stream: Stream
    family: PlacementFamily
    this: Frame
    others: tuple[Array, ...]  # positions (3,) of the other robots' bases

    def __iter__(self) -> Iterator[list[Candidate]]:
        number = 0
        while True:
            yield self._ordered(self.stream.batch(number))
            number += 1

    def _ordered(self, found: list[Candidate]) -> list[Candidate]:
        """The candidates, farthest from the robot first: so a support fills up from the back, and others may reach it.

        A robot that drives comes from any side: its candidates are in the order of `from_home`.
        """
        if self.stream.robot.drive is not None:
            return from_home(self.stream.robot, found)
        base = base_position(self.stream.robot)

        places = poses_at(self.stream.robot, self.this, np.array([c.q for c in found])) if found else ()

        def preference(number: int) -> tuple[float, ...]:
            at, c = places[number][:3, 3], found[number]
            others = [length(at[:2] - other[:2]) for other in self.others]
            own = length(at[:2] - base[:2])
            return (round(max(own, *others), 3), -round(own, 3), *c.q) if others else (-round(own, 3), *c.q)

        return [found[number] for number in sorted(range(len(found)), key=preference)]


def base_position(robot: Robot) -> Array:
    """The position (3,) of a robot's first moving joint in the world."""
    joint = next((j for j in range(1, len(robot.tree.parent)) if robot.tree.ratio[j] != 0.0), 0)
    lower = np.clip(0.0, robot.tree.lower, robot.tree.upper)
    return np.array(joints_at(robot.tree, lower)[joint, 9:])


def placement_stream(
    robot: Robot,
    body: Body,
    held: Attachment,
    family: PlacementFamily,
    support: tuple[Body, Array] | None,
    region: Region | None,
    margin: float,
    others: tuple[Array, ...],
    seed: int,
    hand: tuple[float, ...],
    standing: Standing | None = None,
) -> PlacementStream | None:
    """The stream of placements of a held object; None if the placement family does not fit the support.

    `support` is the supporting body and its pose; the body's box stays `margin` away from the region's walls.
    """
    this = carried_frame(robot, body, held)
    roles = {"this": this, "world": WORLD}
    if support is not None:
        roles["support"] = standing_frame(*support)
    if region is not None:
        roles["region"] = Frame(0, region.world_T_region, {})
    if not fits(family.constraints, roles):
        return None
    parts = [rows(family.constraints, roles)]
    if region is not None:
        parts.append(within(this, body, region, margin))
    where = () if support is None else (*np.round(support[1][:3], 9).ravel(),)
    numbers = [float(v) for v in (*held.position, *held.quaternion, *where)]
    place = (support[0].name if support else "", region.name if region else "")
    key = stream_key(seed, "place", robot.name, body.name, family.name, *place, held.parent, *numbers)
    return PlacementStream(Stream(robot, stacked(parts), key, hand, standing), family, this, others)


def within(this: Frame, body: Body, region: Region, margin: float) -> Array:
    """Rows that keep a body's centre so far inside a region's box that the body probably fits; not a proof."""
    low, high = body.mesh.bounds
    middle = Feature("point", tuple(float(v) for v in (low + high) / 2))  # type: ignore[arg-type]
    thickness = float(np.min(high - low)) / 2 + margin
    parts = []
    for axis in range(3):
        if abs(region.world_T_region[2, axis]) < 0.9:  # the vertical place is the support's business
            room = max(region.size[axis] - thickness, 0.0)
            direction = np.eye(3)[axis]
            plane = Feature("plane", (0.0, 0.0, 0.0), tuple(float(v) for v in direction))  # type: ignore[arg-type]
            across = Frame(0, region.world_T_region, {}).moved(plane)
            parts.append(rows_of("height", this.moved(middle), across, -room, room))
    return stacked(parts)
