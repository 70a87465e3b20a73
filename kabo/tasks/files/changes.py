"""The changes between two scenes as text: robots that moved, objects taken or put down, contacts permitted."""

from collections.abc import Iterable, Iterator
from typing import Any

from kabo.tasks.core import Solution

_MAX_SCENE_CHARACTERS = 120  # characters of a scene that is shown as it is


def scene_change(solution: Solution) -> list[str]:
    """The changes between a solution's start and end scenes, one line each.

    The list is empty if one of the scenes is unknown.
    """
    if solution.start is None or solution.end is None:
        return []
    return list(changes(solution.start.scene, solution.end.scene))


def changes(before: Any, after: Any) -> Iterator[str]:
    """The differences between two scenes, one line each.

    Scenes that are not of robots are shown as `before → after`.
    """
    if before is after:
        return
    if not hasattr(before, "situation") or not hasattr(after, "situation"):
        if (shown := (_short(before), _short(after))) and shown[0] != shown[1]:
            yield f"{shown[0]} → {shown[1]}"
        return
    yield from _moved(before.situation, after.situation)
    yield from _placed(before.situation, after.situation)
    yield from _pairs("may touch", after.permitted - before.permitted)
    yield from _pairs("must not touch any more", before.permitted - after.permitted)
    extras = {each.name for each in before.extras}, {each.name for each in after.extras}
    yield from (f"{name} is added" for name in sorted(extras[1] - extras[0]))
    yield from (f"{name} is removed" for name in sorted(extras[0] - extras[1]))


def _short(scene: Any) -> str:
    text = repr(scene)
    return text if len(text) <= _MAX_SCENE_CHARACTERS else text[: _MAX_SCENE_CHARACTERS - 1] + "…"


def _moved(before: Any, after: Any) -> Iterator[str]:
    for robot, values in after.robots.items():
        first, last = before.robots[robot][0], values[0]
        apart = [abs(x - y) for x, y in zip(first, last, strict=True)]
        if any(apart):
            joint = apart.index(max(apart))
            yield f"{robot} moves, joint {joint + 1} most: {first[joint]:.3f} → {last[joint]:.3f}"


def _placed(before: Any, after: Any) -> Iterator[str]:
    for name, values in after.objects.items():
        if before.objects[name] == values:
            continue
        old, new = before.objects[name][0], values[0]
        if old.parent != new.parent:
            yield f"{name}: from {old.parent} to {new.parent}"
        elif new.parent == "world" and hasattr(new, "position"):
            yield f"{name} is at ({', '.join(f'{value:.3f}' for value in new.position)})"
        else:
            yield f"{name} lies otherwise in {new.parent}"


def _pairs(words: str, pairs: Iterable[frozenset[str]]) -> Iterator[str]:
    for pair in sorted(sorted(pair) for pair in pairs):
        yield f"{' and '.join(pair)} {words}"
