"""Solutions at hand, tried first in the scene that was observed: each piece is proven anew, or the solution is left out.

Motions are kept as they are: so the things that they touch must be where they were. What else stands around may have
changed; it is what the motions are proven against.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refusal, extra
from kabo.language.scene_description import Shape
from kabo.motion import Trajectory, path_deviations
from kabo.scene import Scene, world_T
from kabo.tasks.core import Solution, Stage, Task
from kabo.tasks.core.model.solutions import State
from kabo.tasks.files.motions import state_in
from kabo.tasks.files.report_form import AddedBody, ChangeReport, MotionReport, Report, SegmentReport
from kabo.tasks.robots import Stretch, TaskScene
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.motion.keeping import kept, not_kept
from kabo.tasks.robots.motion.parts import KEPT_DEVIATION
from kabo.tasks.robots.scenes import stretch
from kabo.tasks.robots.timed_paths import TimedPath

SAME_PLACE, SAME_TURN = 1e-6, 1e-6  # m or rad: things that differ by less are where they were


class NotAgainError(Exception):
    """A solution that does not hold in the scene that was observed; says why."""


@dataclass
class _Replay:
    """The replay of one motion: the scene so far, and the parts of the new solution."""

    task: Task
    scene: TaskScene
    parts: list[Solution] = field(default_factory=list)

    def change(self, change: ChangeReport) -> None:
        """Applies a change of the scene, as a part of its stage."""
        before = self.scene
        motion: tuple[Stretch, ...] = ()
        if change["change"] in ("attach", "join"):
            motion = (self._hand(change, attach=((change["object"], change["to"]),)),)
            self.scene = hung(self.scene, change["object"], change["to"], self.scene.frame(change["to"]))
        elif change["change"] == "detach":
            motion = (self._hand(change, detach=(change["object"],)),)
            if self.scene.holder(change["object"]) == change["of"]:
                self.scene = hung(self.scene, change["object"], "world", np.eye(4))
        elif change["change"] == "permit":
            self.scene = self.scene.permitting(change["pairs"])
        elif change["change"] == "forbid":
            self.scene = self.scene.forbidding(change["pairs"])
        elif change["change"] in ("add", "pad"):
            self.scene = self.scene.adding(_added(change["body"], pads=change["change"] == "pad"))
        else:
            gone = change["object"]
            names = [e.name for e in self.scene.extras if gone == (e.parent if e.pads else e.name)]
            self.scene = self.scene.removing(*names)
        self._note(change["stage"], before, motion)

    def _hand(self, change: ChangeReport, **what: Any) -> Stretch:
        name = change["of"] if "of" in change else _robot_of(change["to"], self.scene)
        here = stretch(self.scene, name, "gripper", [self.scene.situation.configuration(name)])
        return Stretch(name, "gripper", here.waypoints, here.permitted, **what)

    def move(self, segment: SegmentReport) -> None:
        """Proves a segment in the scene, and adds it as a part of its stage."""
        before, name = self.scene, segment["robot"]
        robot = self.scene.robot(name)
        columns = [robot.joint_names.index(joint) for joint in segment["joints"]]
        path = np.tile(self.scene.configuration(name), (len(segment["waypoints"]), 1))
        if np.abs(path[0][columns] - segment["waypoints"][0]).max() > SAME_PLACE:
            raise NotAgainError(f"{name} is elsewhere before {segment['stage']}")
        path[:, columns] = segment["waypoints"]
        timed, away = _timed(segment), np.zeros((len(path) - 1, len(path[0])))
        if timed is not None:
            passing = np.asarray(timed.times)
            rows = np.asarray(segment["waypoints"])
            trajectory = timed.trajectory
            away[:, columns] = path_deviations(trajectory.knots, trajectory.padded, rows, passing)
        moves = bool(np.ptp(path, axis=0).max() > 0.0)
        if moves:
            self._prove(segment, path, away)
        group: Literal["arm", "gripper"] = (
            "arm" if tuple(segment["joints"]) == tuple(robot.planned_joints) else "gripper"
        )
        made = stretch(self.scene, name, group, path, segment.get("constraint"))
        seconds = 0.0 if moves else segment["times"][-1] - segment["times"][0]
        whole = Stretch(
            name, group, made.waypoints, made.permitted, made.constraint, seconds=seconds, timed=timed, exact=True
        )
        self.scene = self.scene.at(name, path[-1])
        self._note(str(segment["stage"]), before, (whole,))

    def _prove(self, segment: SegmentReport, path: Array, away: Array) -> None:
        name, constraint = segment["robot"], segment.get("constraint")
        hit = self.scene.workspace(name).path_hit(list(path), away)
        if hit is not None:
            raise NotAgainError(f"{hit[0]} and {hit[1]} are not proven apart in {segment['stage']}")
        keep = kept(self.scene, name, constraint)
        if isinstance(keep, Refusal):
            raise NotAgainError(keep.comment)
        refused = None if keep is None else not_kept(keep, list(path))
        if refused is not None or (keep is not None and float(away.max(initial=0.0)) > KEPT_DEVIATION):
            raise NotAgainError(f"{constraint} is not proven to be kept in {segment['stage']}")

    def _note(self, path: str, before: TaskScene, motion: tuple[Stretch, ...]) -> None:
        stage: Stage = self.task.find(path) or self.task
        start = self.parts[-1].end if self.parts else State(before, {}, 0)
        self.parts.append(Solution(stage, start, State(self.scene, {}, 0), 0.0, motion=motion or None))


def replayed(task: Task, motion: MotionReport, planned: Scene, first: TaskScene) -> Solution:
    """The solution of a report in the scene that was observed, each piece of it proven anew.

    Args:
        task: the task, whose stages the parts of the solution name.
        motion: the motion of the solution.
        planned: the scene in which it was found.
        first: the scene that was observed.

    Raises:
        NotAgainError: it does not hold there; says why.
    """
    segments = motion["segments"]
    if any(after["times"][0] < before["times"][-1] - SAME_PLACE for before, after in pairwise(segments)):
        raise NotAgainError("robots that move at once are planned anew")
    try:
        first = _begun(motion, planned, first)
        _require_same(motion, planned, first)
        replay = _Replay(task, first)
        for number in (None, *range(len(segments))):
            if number is not None:
                replay.move(segments[number])
            for change in motion["changes"]:
                if change["segment"] == number:
                    replay.change(change)
    except (KeyError, ValueError) as error:  # a robot, joint, body or link of the report that is no more
        raise NotAgainError(f"the scene has no {error}" if isinstance(error, KeyError) else str(error)) from None
    _require_end(motion, planned, replay.scene)
    start, end = replay.parts[0].start, replay.parts[-1].end
    return Solution(task, start, end, 0.0, "as before", parts=tuple(replay.parts))


def adopted(task: Task, report: Report, planned: Scene, first: TaskScene) -> Iterator[str]:
    """Adds the solutions of a report that hold in the scene that was observed to the task; yields why others do not."""
    for run in report["runs"]:
        for number, whole in enumerate(run["solutions"], 1):
            if "motion" not in whole:
                continue
            try:
                solution = replayed(task, whole["motion"], planned, first)
            except NotAgainError as error:
                yield f"solution {number} with seed {run['seed']}: {error}"
                continue
            solution.cost = whole["cost"]
            task.adopt(solution, first)


def _begun(motion: MotionReport, planned: Scene, first: TaskScene) -> TaskScene:
    """The scene in which the motion begins: the observed one, but for what the task itself has put elsewhere."""
    state, elsewhere = state_in(motion["start"], planned), motion["start"]
    robots = {name: state.robots[name] for name in elsewhere.get("robots", {})}
    return first.having({**robots, **{name: state.objects[name] for name in elsewhere.get("objects", {})}})


def _require_same(motion: MotionReport, planned: Scene, first: TaskScene) -> None:
    """Checks that robots that move, and all that is touched or taken, are where they were.

    Raises:
        NotAgainError: names the first that is not.
    """
    before = state_in(motion["start"], planned)
    for name in dict.fromkeys(segment["robot"] for segment in motion["segments"]):
        q = first.configuration(name)
        if len(q) != len(before.robots[name]) or np.abs(q - before.robots[name]).max() > SAME_PLACE:
            raise NotAgainError(f"{name} is elsewhere")
    for name in _touched(motion["changes"], planned):
        known = name in before.objects or name in planned.bodies
        if known and not _same(world_T(planned, before, name), first.frame(name)):
            raise NotAgainError(f"{name} is elsewhere")


def _require_end(motion: MotionReport, planned: Scene, last: TaskScene) -> None:
    """Checks that everything that changed hands ends where it ended.

    Raises:
        NotAgainError: names the first thing that does not.
    """
    after = state_in(motion["after"], planned)
    for name in _touched(motion["changes"], planned):
        if name in after.objects and not _same(world_T(planned, after, name), last.frame(name), 1e3):
            raise NotAgainError(f"{name} would end elsewhere")


def _touched(changes: Sequence[ChangeReport], scene: Scene) -> list[str]:
    """The bodies that changes name: taken, let go, joined, or permitted to be touched."""
    named = [change["object"] for change in changes if change["change"] in ("attach", "detach", "join")]
    named += [change["to"] for change in changes if change["change"] == "join"]
    named += [each for change in changes for pair in change.get("pairs", ()) for each in pair]
    return [name for name in dict.fromkeys(named) if name in scene.bodies]


def _same(before: Array, now: Array, share: float = 1.0) -> bool:
    apart = float(np.linalg.norm(now[:3, 3] - before[:3, 3]))
    turned = float(np.linalg.norm(now[:3, :3] - before[:3, :3]))
    return apart <= share * SAME_PLACE and turned <= share * SAME_TURN


def _timed(segment: SegmentReport) -> TimedPath | None:
    found = segment.get("trajectory")
    if found is None:
        return None
    rows = tuple(tuple(map(float, row)) for row in segment["waypoints"])
    pieces = tuple(tuple(tuple(joint) for joint in piece) for piece in found["coefficients"])
    trajectory = Trajectory(tuple(segment["joints"]), rows, tuple(found["times"]), pieces, found["deviation"])
    return TimedPath(tuple(segment["times"]), trajectory).beginning(0.0)


def _added(body: AddedBody, *, pads: bool) -> Any:
    ((kind, size),) = body["shape"].items()
    shape = Shape(kind, size=(size[0], size[1], size[2]))  # type: ignore[arg-type]
    made = extra(body["name"], body["parent"], shape, body["position"], body["quaternion"])
    return replace(made, pads=pads)


def _robot_of(parent: str, scene: TaskScene) -> str:
    """The robot of a link; of a body, the one that holds it, else the first."""
    robot, dot, _ = parent.partition(".")
    holder = None if dot else scene.holder(parent)
    return robot if dot else holder or next(iter(scene.context.scene.robots))
