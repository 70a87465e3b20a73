"""Simultaneous motions of different robots, which are proven not to collide with each other when timed together.

The moving robots form one tree of joints, their motions one path of it, straight between the places of all at common
times; how far their joined trajectory is from it is part of the proof. Whatever one motion moves is proven apart from
whatever another moves, by the bounded sweep check of both at once [K Def. 1.3]; everything else was proven for each
motion alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from kabo.arrays import Array
from kabo.geometry import FixedGroup, MovingGroup
from kabo.geometry_server import Contacts, Pair, Refusal, Team, pair_text
from kabo.motion import Polynomials, joined_deviations, passing_times
from kabo.plan import Segment
from kabo.scene.transforms import flat, transform
from kabo.tasks.core import Solution
from kabo.tasks.robots.motion.exporting import timeline
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.scenes import Stretch, TaskScene

POSITION_TOLERANCE = 1e-6  # m: distance between where an object is at the end and where the motions take it


@dataclass(frozen=True)
class Track:
    """The motion of one child of a merger, timed from 0, with the scenes before and after it."""

    name: str
    before: TaskScene
    after: TaskScene
    line: tuple[tuple[Stretch, Segment], ...]

    @classmethod
    def of(cls, solution: Solution) -> "Track":
        """The track of a child's solution."""
        assert solution.start is not None and solution.end is not None
        before, after = solution.start.scene, solution.end.scene
        return cls(solution.stage.name, before, after, tuple(timeline(solution, before.context.scene)))

    @property
    def seconds(self) -> float:
        """The duration of the track [s]."""
        return max((segment.times[-1] for _, segment in self.line), default=0.0)

    @cached_property
    def robots(self) -> tuple[str, ...]:
        """The robots that move, or attach or release something, in this track."""
        first, last = self.before.situation.robots, self.after.situation.robots
        moved = {stretch.robot for stretch, _ in self.line}
        return tuple(name for name in first if name in moved or first[name] != last[name])

    @cached_property
    def objects(self) -> tuple[str, ...]:
        """The objects that the track's robots carry at some time, or whose attachment changes."""
        scenes = self.before, self.after
        taken = {name for stretch, _ in self.line for name in (*(n for n, _ in stretch.attach), *stretch.detach)}
        for scene in scenes:
            taken |= {name for robot in self.robots for name in scene.situation.carried(robot)}
        first, last = (scene.situation.objects for scene in scenes)
        taken |= {name for name in first if first[name] != last[name]}
        found = {member for name in taken for scene in scenes for member in scene.situation.group(name)}
        return tuple(name for name in first if name in found)

    @property
    def moves(self) -> tuple[str, ...]:
        """The robots and objects that the track moves or changes."""
        return (*self.robots, *self.objects)

    def at(self, robot: str, moments: Array) -> Array:
        """The configurations (m, n) of one robot at m times [s].

        The robot stands still before and after the track.
        """
        found = np.tile(np.array(self.before.situation.configuration(robot)), (len(moments), 1))
        for _, segment in self.line:
            if segment.robot == robot:
                assert segment.trajectory is not None
                after = np.flatnonzero(moments > segment.times[0])
                found[after[:, None], self._columns(segment)] = segment.trajectory.at(moments[after])
        return found

    def polynomials(self, robot: str, until: float) -> Polynomials:
        """What the joints of one robot follow from 0 to `until` [s], which is no earlier than the end of the track."""
        at = np.array(self.before.situation.configuration(robot))
        times, pieces = [0.0], []
        for _, segment in self.line:
            own = segment.trajectory
            if segment.robot == robot and own is not None:
                pieces += [_standing(at, 1)] if own.times[0] > times[-1] else []
                moving = _standing(at, len(own.coefficients))
                moving[:, self._columns(segment)] = own.padded
                pieces.append(moving)
                times += [time for time in own.times if time > times[-1]]
                at[self._columns(segment)] = own.at(own.times[-1])
        if until > times[-1]:
            pieces.append(_standing(at, 1))
            times.append(until)
        return Polynomials(np.array(times), np.concatenate(pieces))

    def _columns(self, segment: Segment) -> list[int]:
        names = self.before.robot(segment.robot).joint_names
        return [names.index(joint) for joint in segment.joints]


def _standing(configuration: Array, pieces: int) -> Array:
    """The coefficients (pieces, n, 6) of joints that keep their values (n,)."""
    found = np.zeros((pieces, len(configuration), 6))
    found[..., 0] = configuration
    return found


def met(before: TaskScene, after: TaskScene, tracks: Sequence[Track]) -> Refusal | None:
    """The refusal with a pair not proven apart when all motions begin at once; None if all are proven apart.

    Args:
        before: the scene before all motions.
        after: the scene after all motions.
        tracks: the motions; each has robots and objects of its own.
    """
    robots = tuple(name for track in tracks for name in track.robots)
    if not robots:
        return None
    permitted = before.permitted.intersection(
        *(scene.permitted for track in tracks for scene in (track.before, track.after))
    )
    owners = {name: k for k, track in enumerate(tracks) for name in track.moves}
    team = Team.of(before.context.scene, robots)
    now, reads = before, frozenset(owners)
    until = max(track.seconds for track in tracks)
    motions = [tracks[owners[robot]].polynomials(robot, until) for robot in robots] if until > 0.0 else []
    for begin, end, events in _spans(tracks):
        moments = _moments(tracks, begin, end)
        path = np.hstack([tracks[owners[robot]].at(robot, moments) for robot in robots])
        off = joined_deviations(motions, path, moments) if end > begin else np.zeros((0, path.shape[1]))
        hit = _MovingBodies(now, team, owners, permitted).hit(path, off)
        if hit is not None:
            pair, k = hit
            text = f"{pair_text(pair)} between {moments[k]:.2f} s and {moments[k + 1]:.2f} s"
            return Refusal.collision(pair, text, reads=reads)
        for robot in robots:
            now = now.at(robot, tracks[owners[robot]].at(robot, np.array([end]))[0])
        for stretch in events:
            now = _changed(now, stretch)
    return _elsewhere(now, after, tracks) or _touching(after, robots)


def _spans(tracks: Sequence[Track]) -> Iterator[tuple[float, float, list[Stretch]]]:
    """The times between which nothing is attached or released, and the stretches that end each such span with a change."""
    events: dict[float, list[Stretch]] = {max(track.seconds for track in tracks): []}
    for track in tracks:
        for stretch, segment in track.line:
            if stretch.attach or stretch.detach:
                events.setdefault(segment.times[-1], []).append(stretch)
    begin = 0.0
    for end in sorted(events):
        yield begin, end, events[end]
        begin = end


def _moments(tracks: Sequence[Track], begin: float, end: float) -> Array:
    """The times [s] within a span at which any motion passes a way point or a border of pieces, and in steps between."""
    known = (
        each for track in tracks for _, s in track.line for each in (s.times, s.trajectory and s.trajectory.times)
    )
    inner = {t for times in known for t in times or () if begin < t < end}
    return passing_times([begin, *sorted(inner), end])


def _changed(scene: TaskScene, stretch: Stretch) -> TaskScene:
    """The scene after the attachments and releases at a stretch's end."""
    taken = {name for name, _ in stretch.attach}
    for name, to in stretch.attach:
        robot, dot, link = to.partition(".")
        (q,) = scene.situation.robots[robot] if dot else (None,)
        pose = scene.pose(to) if q is None else scene.context.surroundings.links(robot, q)[link]
        scene = hung(scene, name, to, pose)
    for name in stretch.detach:
        if name not in taken and scene.holder(name) == stretch.robot:
            scene = hung(scene, name, "world", np.eye(4))
    return scene


def _elsewhere(walked: TaskScene, after: TaskScene, tracks: Sequence[Track]) -> Refusal | None:
    """A component that does not end where the motions take it: some stage changes it without a motion."""
    for track in tracks:
        for name in track.robots:
            if np.abs(walked.configuration(name) - after.configuration(name)).max() > POSITION_TOLERANCE:
                return Refusal("constraint", f"{track.name!r} changes where {name} is, but no motion of it does")
        for name in track.objects:
            own, other = walked.situation.attachment(name), after.situation.attachment(name)
            if (
                own.parent == other.parent
                and np.abs(walked.pose(name) - after.pose(name)).max() <= POSITION_TOLERANCE
            ):
                continue
            return Refusal("constraint", f"{track.name!r} changes where {name} is, but no motion of it does")
    return None


def _touching(after: TaskScene, robots: Sequence[str]) -> Refusal | None:
    """The pair of things that touch at the end although the contact is forbidden there."""
    hits = (after.hit(robot) for robot in robots)
    hit = next((hit for hit in hits if hit is not None), None)
    return None if hit is None else Refusal.collision(hit)


@dataclass(frozen=True)
class _MovingBodies:
    """The bodies that move, on the joints of the common tree, and those that stand, each with the motion that moves it."""

    scene: TaskScene
    team: Team
    owners: Mapping[str, int]
    permitted: Contacts

    def hit(self, path: Array, deviations: Array) -> tuple[Pair, int] | None:
        """The first pair of different motions that is not proven apart along a path (m, n), and the index of the piece.

        `deviations` (m - 1, n): how far each joint may be from each piece [rad or m].
        """
        mounts = list(self._mounts())
        moving = [(name, mount) for name, mount in mounts if isinstance(mount, MovingGroup)]
        standing = [(name, mount) for name, mount in mounts if isinstance(mount, FixedGroup)]
        every = [name for name, _ in (*moving, *standing)]
        pairs = [
            (i, k) for i in range(len(moving)) for k in range(i + 1, len(every)) if self._asked(every[i], every[k])
        ]
        if not pairs or len(path) < 2:
            return None
        view = self.scene.context.surroundings.checker(
            self.team.tree, [m for _, m in moving], [m for _, m in standing], np.array(pairs)
        )
        for piece, (start, goal, off) in enumerate(zip(path, path[1:], deviations, strict=False)):
            index = view.segment_hit(start, goal, off)
            if index >= 0:
                return (every[pairs[index][0]], every[pairs[index][1]]), piece
        return None

    def _asked(self, first: str, second: str) -> bool:
        """Whether two things belong to different motions and may not touch; padding may touch what its parent may."""
        one, other = self._parent(first), self._parent(second)
        if self._owner(one) == self._owner(other) or frozenset((one, other)) in self.permitted:
            return False
        extras = {extra.name for extra in self.scene.extras}
        return not {first, second} <= extras and not self.scene.context.surroundings.never_collide(one, other)

    def _parent(self, name: str) -> str:
        return next((extra.parent for extra in self.scene.extras if extra.name == name), name)

    def _owner(self, name: str) -> int:
        return self.owners[name.partition(".")[0]]

    def _mounts(self) -> Iterator[tuple[str, MovingGroup | FixedGroup]]:
        surroundings = self.scene.context.surroundings
        for k, robot in enumerate(self.team.robots):
            for link in robot.links.values():
                if link.mesh is not None and not robot.stands(link.name):
                    name, arrays = f"{robot.name}.{link.name}", (link.mesh.vertices, link.mesh.faces)
                    joint = self.team.joined.joint(k, link.joint)
                    enclosure, at = surroundings.enclosure(name), flat(link.joint_T_link)
                    kept = surroundings.asked(name)
                    yield name, MovingGroup(joint, at, enclosure, arrays, link.elements, kept)
        for name in self.scene.situation.objects:
            if name in self.owners:
                body = self.scene.context.scene.bodies[name]
                arrays = body.mesh.vertices, body.mesh.faces
                enclosure = surroundings.enclosure(name)
                yield name, self._placed(name, np.eye(4), enclosure, arrays, body.elements)
        for extra in self.scene.extras:
            if extra.parent.partition(".")[0] in self.owners:
                arrays = extra.mesh.vertices, extra.mesh.faces
                enclosure, elements = surroundings.enclosed(extra.element), (extra.element,)
                placed = self._placed(extra.parent, extra.parent_T, enclosure, arrays, elements)
                yield extra.name, placed

    def _placed(self, name: str, own: Array, enclosure, arrays, elements) -> MovingGroup | FixedGroup:  # type: ignore[no-untyped-def]
        """A body at a pose (4, 4) in the frame of an object, or of a link of the common tree."""
        parent, at, surroundings = name, own, self.scene.context.surroundings
        if name in self.scene.situation.objects:
            held = self.scene.situation.held(name)
            parent, at = held.parent, transform(held.position, held.quaternion) @ own
        robot, _, link = parent.partition(".")
        names = [each.name for each in self.team.robots]
        if robot not in names:
            kept = surroundings.asked(name) if name in self.scene.situation.objects else 0.0
            return FixedGroup(flat(self.scene.pose(name) @ own), enclosure, arrays, elements, kept)
        chosen = self.team.robots[names.index(robot)].links[link]
        joint = self.team.joined.joint(names.index(robot), chosen.joint)
        kept = surroundings.asked(name, robot) if name in self.scene.situation.objects else 0.0
        return MovingGroup(joint, flat(chosen.joint_T_link @ at), enclosure, arrays, elements, kept)
