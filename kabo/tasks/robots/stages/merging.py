"""Merger: motions of different robots at the same time [T 3.3].

Each child moves robots and objects of its own. All motions begin at once and keep the times that they have alone; robots
that are done earlier wait. Each child's motion was proven while the others stood still; what different children move is
proven apart here, at the times of the motions.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from kabo.geometry_server import Contacts, ProcedureContext, Refusal, Situation
from kabo.scene import Component, Scene
from kabo.tasks.core import Merger as CoreMerger
from kabo.tasks.core import Result, Solution, Stage
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.together import Track, met
from kabo.tasks.robots.scenes import Stretch, TaskScene
from kabo.tasks.robots.stages.geometry import AddGeometry, Pad, RemoveGeometry
from kabo.tasks.robots.timed_paths import TIME_DECIMALS, TimedPath


class Merger(RobotStage, CoreMerger):
    """Lets all children move at once, each with the times that it has alone; robots that are done earlier wait.

    Each child moves robots and objects of its own. What different children move is proven apart at those times.
    """

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for fewer than two children, a thing that two of them move, or stages that change geometry."""
        if len(self.children) < 2:
            yield "a merger has at least two children, whose motions are merged"
        owners: dict[str, Stage] = {}
        for child in self.children:
            inside = [stage for stage in _within(child) if isinstance(stage, RobotStage)]
            for stage in inside:
                if isinstance(stage, AddGeometry | RemoveGeometry | Pad):
                    yield f"{stage.path!r} changes what geometry there is, which nothing in a merger may"
            for name in dict.fromkeys(name for stage in inside for name in stage.moves()):
                other = owners.setdefault(name, child)
                if other is not child:
                    yield _shared(name, other.name, child.name, scene)

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof that two children move the same robot or object."""
        fault = next(iter(self.faults(context.scene)), None)
        return None if fault is None else Refusal("constraint", fault, proof=True)

    def merge(self, scene: TaskScene, solutions: Sequence[Solution], properties: Values, seed: int) -> Any:
        """The children's motions combined into one that begins at the same time, with the resulting scene."""
        tracks = [Track.of(solution) for solution in solutions]
        refused = _conflict(tracks, scene.context.scene)
        if refused is not None:
            return [refused]
        forward = all(track.before is scene for track in tracks)
        far = _merged(scene, [track.after if forward else track.before for track in tracks], tracks)
        before, after = (scene, far) if forward else (far, scene)
        refused = met(before, after, tracks)
        if refused is not None:
            return [refused]
        written = {name: value for solution in solutions for name, value in _written(solution, forward).items()}
        seconds = max((track.seconds for track in tracks), default=0.0)
        cost, comment = sum(solution.cost for solution in solutions), f"{seconds:.2f} s at once"
        return [Result(far, cost, comment, tuple(_motion(tracks)), written)]


def _within(stage: Stage) -> Iterator[Stage]:
    yield stage
    for child in stage.children:
        yield from _within(child)


def _shared(name: str, first: str, second: str, scene: Scene) -> str:
    both = f"{first!r} and {second!r} both move {name}"
    if name not in scene.robots:
        return f"{both}: a merger moves each object in one of its children"
    return f"{both}: a merger moves each robot, arm and gripper, in one of its children"


def _conflict(tracks: Sequence[Track], scene: Scene) -> Refusal | None:
    """Why the motions cannot be merged at any time: they share a robot or an object."""
    owners: dict[str, Track] = {}
    for track in tracks:
        if track.before.extras != track.after.extras:
            return Refusal(
                "constraint", f"{track.name!r} changes what geometry there is, which nothing in a merger may"
            )
        for name in track.moves:
            if owners.setdefault(name, track) is not track:
                return Refusal("constraint", _shared(name, owners[name].name, track.name, scene))
    return None


def _merged(near: TaskScene, far: Sequence[TaskScene], tracks: Sequence[Track]) -> TaskScene:
    """The scene on the far side: the changes of all children, and contacts that no child forbids or some child permits."""
    changes: dict[str, Component] = {}
    for each, track in zip(far, tracks, strict=True):
        for name in track.moves:
            known = each.situation.robots if name in each.situation.robots else each.situation.objects
            (changes[name],) = known[name]
    permitted: Contacts = frozenset(
        pair
        for pair in frozenset().union(near.permitted, *(each.permitted for each in far))
        if pair not in near.permitted or all(pair in each.permitted for each in far)
    )
    return replace(near.having(changes), permitted=permitted, _known={})


def _written(solution: Solution, forward: bool) -> Mapping[str, Any]:
    """The interface properties that a child has written; where several children write one, the last counts."""
    near, far = (solution.start, solution.end) if forward else (solution.end, solution.start)
    assert near is not None and far is not None
    return {
        name: v
        for name, v in far.properties.items()
        if name not in near.properties or near.properties[name] is not v
    }


def _motion(tracks: Sequence[Track]) -> Iterator[Stretch]:
    """The timed stretches of all tracks, ordered by when they begin, each with its delay after the previous one."""
    every = [
        (segment.times[0], k, n) for k, track in enumerate(tracks) for n, (_, segment) in enumerate(track.line)
    ]
    last: float | None = None
    for begin, k, n in sorted(every):
        stretch, segment = tracks[k].line[n]
        since = None if last is None else round(begin - last, TIME_DECIMALS)
        assert segment.trajectory is not None
        timed = TimedPath(segment.times, segment.trajectory).beginning(0.0)
        part = MotionPart(stretch, tracks[k].before, segment.stage or "")
        yield replace(part.along(timed), since=since)
        last = begin
