"""The permitted contacts of a solution's segments that something may grant; elsewhere a plan has its two bodies apart.

A stage permits a contact from there on, and a task may never forbid it again. A plan claims it only where a hand may
touch what it takes, holds or has just let go, and where what is held leaves its support or comes to it.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kabo.tasks.files.motions import state_in
from kabo.tasks.files.report_form import MotionReport, SegmentReport

if TYPE_CHECKING:
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need

Pair = tuple[str, str]


def with_needed_contacts(
    motion: MotionReport, objects: Mapping[str, Mapping[str, Any]], scene: "Scene"
) -> Iterator[SegmentReport]:
    """The segments, each with those of its permitted contacts that something may grant.

    Args:
        motion: that of a solution.
        objects: where all objects are before it: {name: {parent, …}}.
        scene: the scene of the task.
    """
    segments = motion["segments"]
    follow = _Holding({name: str(pose["parent"]) for name, pose in objects.items()})
    for number, segment in enumerate(segments):
        pairs = segment.get("allowed_contacts", [])
        moves_arm = len({tuple(row) for row in segment["waypoints"]}) > 1 and not _is_hand(segment, scene)
        kept = [pair for pair in pairs if follow.may_be_granted(pair, motion, number, scene)]
        yield segment if len(kept) == len(pairs) else {**segment, "allowed_contacts": kept}
        follow.end(segment, moves_arm)


def _is_hand(segment: SegmentReport, scene: "Scene") -> bool:
    robot = scene.robots.get(segment["robot"])
    return robot is not None and tuple(segment["joints"]) == tuple(robot.gripper_joints)


class _Holding:
    """What hangs on what while a solution's motion goes on."""

    def __init__(self, parents: dict[str, str]) -> None:
        self._parents = parents
        # Objects that have not moved since the motion began, or since they were taken.
        self._unmoved = set(parents)
        self._near = {(self._holder(name), name) for name in parents}  # (robot, what it holds or has just let go)

    def may_be_granted(self, pair: Pair, motion: MotionReport, number: int, scene: "Scene") -> bool:
        """Whether something may grant a contact of a segment; False where no rule of a plan does."""
        segments = motion["segments"]
        segment, robot = segments[number], segments[number]["robot"]
        link = next((name for name in pair if "." in name), None)
        if link is not None:
            name = pair[0] if link == pair[1] else pair[1]
            taken = any(each["object"] == name for each in segment["attach"])
            elsewhere = link.partition(".")[0] != robot or name not in self._parents
            return elsewhere or taken or (robot, name) in self._near
        held = [name for name in pair if self._holder(name) == robot]
        if len(held) != 1 or frozenset(pair) in scene.allowed or _mates(pair, segments):
            return True
        if held[0] in self._unmoved or self._is_let_go(held[0], segments, number):
            return True
        return _next_move(segments, number) == len(segments) and _rests(pair, held[0], motion, scene)

    def end(self, segment: SegmentReport, moves_arm: bool) -> None:
        """Takes note of what a segment has moved, taken and let go."""
        robot = segment["robot"]
        if moves_arm:
            held = {name for name in self._parents if self._holder(name) == robot}
            self._unmoved -= held
            self._near = {each for each in self._near if each[0] != robot or each[1] in held}
        for name in segment["detach"]:
            self._parents[name] = "world"
        for each in segment["attach"]:
            self._parents[each["object"]] = each["to"]
            self._unmoved.add(each["object"])
        self._near |= {(self._holder(name), name) for name in self._parents}

    def _is_let_go(self, name: str, segments: Sequence[SegmentReport], number: int) -> bool:
        """Whether an object is let go where a segment ends: before the arm moves again."""
        stop = _next_move(segments, number)
        return any(
            name in each["detach"] or any(taken["object"] == name for taken in each["attach"])
            for each in segments[number:stop]
        )

    def _holder(self, name: str) -> str | None:
        """The robot on which an object hangs, directly or on other objects; None if it hangs on none."""
        seen: set[str] = set()
        while name in self._parents and name not in seen:
            seen.add(name)
            name = self._parents[name]
        robot, dot, _ = name.partition(".")
        return robot if dot else None


def _next_move(segments: Sequence[SegmentReport], number: int) -> int:
    """The index of the next segment that moves the same joints of the robot; their number if there is none."""
    now = segments[number]
    for index, later in enumerate(segments[number + 1 :], number + 1):
        same = later["robot"] == now["robot"] and later["joints"] == now["joints"]
        if same and len({tuple(row) for row in later["waypoints"]}) > 1:
            return index
    return len(segments)


def _rests(pair: Pair, name: str, motion: MotionReport, scene: "Scene") -> bool:
    """Whether an object that is held stands on the other body of a pair when the motion ends."""
    # Load kernels, as the scene's tasks have done.
    from kabo.geometry_server import GeometryServer, Situation, rests_on, supports

    after, surroundings = Situation.of(state_in(motion["after"], scene)), GeometryServer(scene).surroundings
    return bool({*supports(surroundings, after, name), *rests_on(surroundings, after, name)} & {*pair})


def _mates(pair: Pair, segments: Sequence[SegmentReport]) -> bool:
    """Whether the motion puts the two together."""
    joined = ({each["object"], each["to"]} for segment in segments for each in segment["attach"])
    return any(set(pair) == two for two in joined)
