"""Solutions at hand, tried first in the scene that was observed: each piece is proven anew, or the solution is left out.

Motions are kept as they are: so the task must be the same, and what they touch, or what the task names, must be where it
was. What else stands around may have changed; it is what the motions are proven against. Where robots have lower limits
now, or hold less firmly, motions that were timed for more are left out.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf
from typing import Any, Literal

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server import Refusal, extra
from kabo.language.scene_description import Shape
from kabo.motion import Trajectory, path_deviations
from kabo.scene import Region, Robot, Scene, motion_limits, world_T
from kabo.tasks.core import Solution, Stage, Task
from kabo.tasks.core.model.solutions import State
from kabo.tasks.files.motions import state_in
from kabo.tasks.files.report_form import AddedBody, ChangeReport, MotionReport, Report, SegmentReport, StageReport
from kabo.tasks.files.reports import stage_reports
from kabo.tasks.robots import Stretch, TaskScene
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.motion.held_bodies import bounds_of_held
from kabo.tasks.robots.motion.keeping import kept, not_kept
from kabo.tasks.robots.motion.parts import KEPT_DEVIATION
from kabo.tasks.robots.scenes import stretch
from kabo.tasks.robots.timed_paths import TimedPath

EFFORT = ("attempt_timeout", "max_ik_solutions")  # properties of stages that do not change what a solution is
_ADDRESS = re.compile(r" at 0x[0-9a-f]+")  # in the text of a function, which is another one in each process
RATES = "velocity", "acceleration", "jerk"
ROUNDED = 1e-9  # rad or m: as much of a limit may be lost in files
SAME_PLACE, SAME_TURN = 1e-6, 1e-6  # m or rad: things that differ by less are where they were


class NotAgainError(Exception):
    """A solution that does not hold in the scene that was observed; says why."""


@dataclass
class _Replay:
    """The replay of one motion: the scene so far, and the parts of the new solution."""

    task: Task
    planned: Scene
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
        columns = robot.columns(segment["joints"])
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
        if timed is not None:
            _require_limits(timed.trajectory, self.planned.robots[name], robot)
            self._require_grip(name)
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

    def _require_grip(self, name: str) -> None:
        """Checks that the robot holds what is in its hand as firmly as when the motion was timed.

        Raises:
            NotAgainError: a body is heavier now, or the gripper weaker.
        """
        now, situation = self.scene.context.scene, self.scene.situation
        before = dict(bounds_of_held(self.planned, situation, self.planned.robots[name]))
        for body, bound in bounds_of_held(now, situation, now.robots[name]):
            if bound < before.get(body, inf):
                raise NotAgainError(f"{name} could hold {body} while it moved faster than it can now")

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


def _require_limits(trajectory: Trajectory, before: Robot, now: Robot) -> None:
    """Checks a motion against those limits of its joints that are lower than when it was timed.

    Raises:
        NotAgainError: names the first joint that would exceed one.
    """
    joints, limits = trajectory.joints, motion_limits(now, trajectory.joints)
    for order, (name, old, new) in enumerate(
        zip(RATES, motion_limits(before, joints).rows, limits.rows, strict=True), 1
    ):
        if (new >= old).all():
            continue
        reached = np.max(np.abs(trajectory.bounds(order)), axis=0)
        for i in np.flatnonzero((new < old) & (reached > new)):
            raise NotAgainError(
                f"{now.name}.{joints[i]} reaches {reached[i]:.4g} and its limit of {name} is {new[i]:.4g} now"
            )
    for joint, low, high in zip(joints, *trajectory.bounds(), strict=True):
        place = now.joint_names.index(joint)
        if low < now.tree.lower[place] - ROUNDED or high > now.tree.upper[place] + ROUNDED:
            raise NotAgainError(f"{now.name}.{joint} leaves its limits of position")


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
        replay = _Replay(task, planned, first)
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


def adopted(
    task: Task, report: Report, planned: Scene, first: TaskScene, wanted: int | None = None
) -> Iterator[str]:
    """Adds the solutions of a report that hold in the scene that was observed to the task; yields why others do not.

    Args:
        task: the task.
        report: what was found before, in the scene `planned`.
        planned: the scene in which it was found.
        first: the scene that was observed.
        wanted: the number of solutions after which it ends; None: all are tried.
    """
    fault, found = _other_task(task, report) or _moved_thing(task, planned, first), 0
    for run in report["runs"]:
        for number, whole in enumerate(run["solutions"], 1):
            if "motion" not in whole or (wanted is not None and found >= wanted):
                continue
            try:
                if fault is not None:
                    raise NotAgainError(fault)
                solution = replayed(task, whole["motion"], planned, first)
            except NotAgainError as error:
                yield f"solution {number} with seed {run['seed']}: {error}"
                continue
            solution.cost = whole["cost"]
            found += task.adopt(solution, first)


def _other_task(task: Task, report: Report) -> str | None:
    """How the task of a report differs from this one, at the first stage where it does; None if it is the same."""
    before = [_comparable(each) for each in report["stages"]]
    now = [_comparable(each) for each in stage_reports(task, {})]
    for (kind, path, old), (other_kind, other_path, new) in zip(before, now, strict=False):
        if (kind, path) != (other_kind, other_path):
            return f"it is of another task, in which {path} is where {other_path} is now"
        for name in sorted(old.keys() | new.keys()):
            if old.get(name) != new.get(name):
                return f"{name} of {path} was {_shown(old, name)}, and is {_shown(new, name)} now"
    return None if len(before) == len(now) else "it is of another task, which has not the same stages"


def _comparable(stage: StageReport) -> tuple[str, str, dict[str, str]]:
    """The kind of a stage, its path, and as text the properties on which its solutions depend."""
    texts = {name: json.dumps(value, ensure_ascii=False) for name, value in stage["properties"].items()}
    given = {name: _ADDRESS.sub("", text) for name, text in texts.items() if name not in EFFORT}
    return stage["type"], stage["path"], given


def _shown(properties: Mapping[str, str], name: str) -> str:
    return properties[name].strip('"') if name in properties else "not given"


def _moved_thing(task: Task, planned: Scene, first: TaskScene) -> str | None:
    """What a task names and has changed in the observed scene: a body, a region, a configuration; None if nothing has."""
    now = first.context.scene
    names = {name for stage in task.walk() for value in stage.properties.given.values() for name in _texts(value)}
    for name in sorted(names):
        if name in planned.regions and not _same_region(planned.regions[name], now.regions.get(name)):
            return f"the region {name} is elsewhere"
        if name in planned.bodies and not planned.bodies[name].movable:
            here = now.bodies.get(name)
            if here is None or not _same(world_T(planned, planned.start, name), world_T(now, now.start, name)):
                return f"{name} is elsewhere"
        for robot in (each for each in planned.robots if each in now.robots):
            before, after = (scene.robots[robot].configurations.get(name) for scene in (planned, now))
            if before is not None and before != after:
                return f"the configuration {name} of {robot} is another one"
    return None


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts(inner)


def _same_region(before: Region, now: Region | None) -> bool:
    if (
        now is None
        or before.normals.shape != now.normals.shape
        or not _same(before.world_T_region, now.world_T_region)
    ):
        return False
    return bool(np.allclose(before.normals, now.normals) and np.allclose(before.offsets, now.offsets))


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
