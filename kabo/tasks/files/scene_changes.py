"""The changes of the scene in a solution as data: what is taken, let go, permitted, added, and at which segment's end."""

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from kabo.tasks.core import Merger, Solution
from kabo.tasks.files.report_form import AddedBody, Change, ChangeReport

if TYPE_CHECKING:
    from kabo.plan import Segment


def scene_changes(solution: Solution, motion: "Sequence[Segment]") -> Iterator[ChangeReport]:
    """The changes in the order of time; those of one time in the order of stages.

    Args:
        solution: the solution of a task that moves robots.
        motion: its segments, as `kabo.tasks.robots.segments` gives them.
    """
    timeline = _Timeline(solution, motion)
    timeline.walk(solution, None)
    yield from sorted(timeline.found, key=lambda change: change["time"])


class _Timeline:
    """Walks through the parts of a solution, and finds for each the segment after which it takes effect."""

    def __init__(self, solution: Solution, motion: "Sequence[Segment]") -> None:
        self.motion = motion
        self.found: list[ChangeReport] = []
        self._of_stage: dict[str | None, list[int]] = {}  # the segments of a stage that no part has taken yet
        for number, segment in enumerate(motion):
            self._of_stage.setdefault(segment.stage, []).append(number)
        # Stages of one name beside each other share a path.
        self._sharing = Counter(part.stage.path for part in solution.walk() if not part.parts)
        self._hands: dict[tuple[str, str, str], list[int]] = {}
        for number, segment in enumerate(motion):
            for name, to in segment.attach:
                self._hands.setdefault(("attach", name, to), []).append(number)
            for name in segment.detach:
                self._hands.setdefault(("detach", name, segment.robot), []).append(number)

    def walk(self, solution: Solution, last: int | None) -> int | None:
        """Notes the changes of a solution that begins after the segment `last`; returns the last segment after it."""
        if not solution.parts:
            last = self._after(solution, last)
            self._note(solution, last)
            return last
        if isinstance(solution.stage, Merger):
            ends = [self.walk(part, last) for part in solution.parts]
            return max((end for end in ends if end is not None), key=self._end, default=last)
        for part in solution.parts:
            last = self.walk(part, last)
        return last

    def _after(self, part: Solution, last: int | None) -> int | None:
        """The last segment that has ended when a stage has: its own, else that of the stage before it."""
        path = part.stage.path
        own = self._of_stage.get(path, [])
        count = len(own) if self._sharing[path] == 1 else len([s for s in part.motion or () if _lasts(s)])
        self._of_stage[path] = own[count:]
        return own[:count][-1] if own[:count] else last

    def _hand(self, kind: str, name: str, to: str, last: int | None) -> int | None:
        """The segment at whose end something changes hands, each time the next one."""
        waiting = self._hands.get((kind, name, to), [])
        return waiting.pop(0) if waiting else last

    def _end(self, segment: int) -> float:
        return self.motion[segment].times[-1]

    def _note(self, part: Solution, last: int | None) -> None:
        if part.start is None or part.end is None or part.start.scene is part.end.scene:
            return
        for kind, what, segment in self._changes(part, part.start.scene, part.end.scene, last):
            time = 0.0 if segment is None else self._end(segment)
            self.found.append({"change": kind, "stage": part.stage.path, "segment": segment, "time": time, **what})  # type: ignore[typeddict-item]

    def _changes(
        self, part: Solution, before: Any, after: Any, last: int | None
    ) -> Iterator[tuple[Change, dict[str, Any], int | None]]:
        """Each change of a part: its kind, what it is about, and the segment at whose end it takes effect."""
        for each in part.motion or ():
            for name, to in each.attach:
                kind: Change = "attach" if "." in to else "join"
                yield kind, {"object": name, "to": to}, self._hand("attach", name, to, last)
            for name in each.detach:
                yield "detach", {"object": name, "of": each.robot}, self._hand("detach", name, each.robot, last)
        for kind, pairs in (
            ("permit", after.permitted - before.permitted),
            ("forbid", before.permitted - after.permitted),
        ):
            if pairs:
                yield kind, {"pairs": sorted(_pair(pair) for pair in pairs)}, last
        old, new = ({each.name: each for each in scene.extras} for scene in (before, after))
        for name, body in new.items():
            if old.get(name) != body:
                yield "pad" if body.pads else "add", {"body": _body(body)}, last
        for name, body in old.items():
            if name not in new:
                yield "unpad" if body.pads else "remove", {"object": body.parent if body.pads else name}, last


def _lasts(stretch: Any) -> bool:
    return len(stretch.waypoints) > 1 or stretch.seconds > 0.0


def _pair(pair: frozenset[str]) -> tuple[str, str]:
    names = sorted(pair)
    return names[0], names[-1]


def _body(body: Any) -> AddedBody:
    return {
        "name": body.name,
        "parent": body.parent,
        "position": body.position,
        "quaternion": body.quaternion,
        "shape": {body.shape.kind: list(body.shape.size)},
    }
