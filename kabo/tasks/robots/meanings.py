"""Checks of property values beyond their type: each returns the reason why a value is invalid, or None.

The reasons follow the name of the property ("distance is at least 0, not -1"). Without these checks a stage with
an invalid value would silently do nothing, or something else than was asked for.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from kabo.errors import did_you_mean

RRT_CONNECT, STRAIGHT, TOOL_LINE = "rrt_connect", "straight", "tool_line"
PLANNERS = (RRT_CONNECT, STRAIGHT, TOOL_LINE)
DIRECTIONS = (
    "{along or against: feature, distance}, {vector: [x, y, z], frame}, {twist: [x, y, z, rx, ry, rz], frame} "
    "or {joints: {joint: offset}}"
)
Wrong = Callable[[Any], str | None]  # why a value is invalid; None: it is valid


def name(value: Any) -> str | None:
    """Checks that a name is not empty."""
    return "names nothing" if isinstance(value, str) and not value.strip() else None


def some(what: str) -> Wrong:
    """A check that a list, mapping or text is not empty; `what` names its elements in the message."""

    def wrong(value: Any) -> str | None:
        return f"has no {what}" if isinstance(value, (str, Sequence, Mapping)) and not len(value) else None

    return wrong


def at_least(least: float, *, above: bool = False) -> Wrong:
    """A check that a number is finite and at least `least` (or `above` it)."""

    def wrong(value: Any) -> str | None:
        if not _number(value):
            return None
        fits = math.isfinite(value) and (value > least if above else value >= least)
        return None if fits else f"is {'above' if above else 'at least'} {least:g}, not {value:g}"

    return wrong


def finite(value: Any) -> str | None:
    """Checks that a number is finite."""
    return "is a finite number" if _number(value) and not math.isfinite(value) else None


def one_of(*texts: str) -> Wrong:
    """A check that a text is one of `texts`."""

    def wrong(value: Any) -> str | None:
        return f"is {' or '.join(texts)}, not {value!r}" if isinstance(value, str) and value not in texts else None

    return wrong


def planners(value: Any) -> str | None:
    """A check of the name of a planner, or of a list of such names."""
    given = [value] if isinstance(value, str) else list(value)
    if not given:
        return "names no planner"
    for each in given:
        if each not in PLANNERS:
            meant = did_you_mean(str(each), PLANNERS)
            return f"is {', '.join(PLANNERS)} or a list of these, not {each!r}{f': {meant}' if meant else ''}"
    return None


def names(count: int | None = None, *, empty: bool = False) -> Wrong:
    """A check of a list of names.

    Args:
        count: the number of names, if there are any; None: any number.
        empty: whether the list may be empty although `count` is None.
    """

    def wrong(value: Any) -> str | None:
        if count is None and not value and not empty:
            return "names nothing"
        if value and count is not None and len(value) != count:
            return f"is a list of {count} names, not {list(value)!r}"
        return next((f"is a list of names, not {each!r}" for each in value if not _named(each)), None)

    return wrong


def pairs(value: Any) -> str | None:
    """Checks a list of pairs of names."""
    if not value:
        return "has no pairs"
    for pair in value:
        if not isinstance(pair, (list, tuple)) or len(pair) != 2 or not all(map(_named, pair)):
            return f"is a list of pairs of names, not of {pair!r}"
        if pair[0] == pair[1]:
            return f"has a pair of {pair[0]} with itself"
    return None


def numbers(value: Any, count: int) -> str | None:
    """Checks that a value is a list or an array of `count` finite numbers."""
    found = np.asarray(value, dtype=object).ravel() if isinstance(value, (Sequence, np.ndarray)) else None
    if found is None or isinstance(value, str) or len(found) != count:
        return f"is {count} numbers, not {value!r}"
    if not all(_number(v) and math.isfinite(v) for v in found):
        return f"is {count} finite numbers, not {value!r}"
    return None


def direction(value: Any) -> str | None:
    """Checks a direction: {along or against: feature, distance}, {vector, frame}, {twist, frame} or {joints}.

    Values of other types are accepted: samplers write them.
    """
    if not isinstance(value, Mapping):
        return f"is {DIRECTIONS}, not {value!r}" if isinstance(value, (str, Sequence, int, float)) else None
    kinds = [kind for kind in ("along", "against", "vector", "twist", "joints") if kind in value]
    if len(kinds) != 1:
        return f"is {DIRECTIONS}"
    kind, given = kinds[0], value[kinds[0]]
    beside = {"joints": (), "vector": ("frame",), "twist": ("frame",)}.get(kind, ("distance",))
    extra = set(value) - {kind, *beside}
    if extra:
        meant = did_you_mean(min(map(str, extra)), beside)
        return f"has no {min(map(str, extra))!r} beside {kind!r}{f', {meant}' if meant else ''}"
    if kind == "joints":
        return _offsets(given)
    if kind in ("vector", "twist"):
        wrong = numbers(given, 3 if kind == "vector" else 6) or name(value.get("frame", "world"))
        return (
            _prefixed(kind, wrong)
            if wrong
            else f"has no length: {kind} {list(given)!r}"
            if not np.any(given)
            else None
        )
    return _stroke(kind, given, value.get("distance"))


def goal(value: Any) -> str | None:
    """Checks a goal: the name of a configuration, a list of values, {joint: value}, a pose or a point."""
    if isinstance(value, (str, Sequence, Mapping)) and not (value.strip() if isinstance(value, str) else value):
        return "names nowhere to go"
    if not isinstance(value, Mapping):
        listed = isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str)
        return numbers(value, len(value)) if listed else None
    targets = [key for key in ("pose", "point") if key in value]
    if len(targets) == 2 or (targets and set(value) - {*targets, *(["frame"] if targets == ["point"] else [])}):
        return f"is a pose, a point in a frame, or joints, not {', '.join(map(repr, value))} together"
    if targets:
        return _prefixed("point", numbers(value["point"], 3)) if targets == ["point"] else None
    wrong = next((joint for joint, v in value.items() if not (_number(v) and math.isfinite(v))), None)
    if wrong is not None and isinstance(value[wrong], (Sequence, Mapping)) and not isinstance(value[wrong], str):
        return f"has no {wrong!r}, {did_you_mean(wrong, ('pose', 'point')) or 'it is a pose, a point, or joints'}"
    return None if wrong is None else f"has a value of {wrong} that is a finite number, not {value[wrong]!r}"


_ROUND = {"cylinder": ("radius", "height"), "sphere": ("radius",), "capsule": ("radius", "length")}


def shape(value: Any) -> str | None:
    """Checks a shape: {box}, {cylinder}, {sphere} or {capsule}, with positive sizes."""
    kinds = [kind for kind in ("box", *_ROUND) if kind in value]
    if len(value) != 1 or len(kinds) != 1:
        return (
            "is {box: [x, y, z]}, {cylinder: {radius, height}}, {sphere: {radius}} or {capsule: {radius, length}}"
        )
    given, wanted = value[kinds[0]], _ROUND.get(kinds[0])
    if wanted is not None and (not isinstance(given, Mapping) or set(given) != set(wanted)):
        return f"has a {kinds[0]} of {' and '.join(wanted)}"
    sizes = given if wanted is None else [given[key] for key in wanted]
    wrong = numbers(sizes, 3 if wanted is None else len(wanted))
    return _prefixed(kinds[0], wrong) if wrong else None if all(v > 0 for v in sizes) else "has sizes above 0"


def turning(value: Any) -> str | None:
    """Checks a horizontal direction: an angle, or a vector that is not vertical."""
    if _number(value):
        return finite(value)
    wrong = numbers(value, 3)
    return wrong or (None if np.any(np.asarray(value, float)[:2]) else "has no horizontal direction")


def spread(value: Any) -> str | None:
    """Checks {count, around, position, rpy} of random poses: empty, or such that the poses differ."""
    if not value:
        return None
    extra = set(value) - {"count", "around", "position", "rpy"}
    if extra:
        return f"has no {min(map(str, extra))!r}; it has count, around, position, rpy"
    count = value.get("count", 1)
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        return f"has a count of at least 1, not {count!r}"
    ranges = [value.get(key, (0.0, 0.0, 0.0)) for key in ("position", "rpy")]
    wrong = next((wrong for wrong in (numbers(each, 3) for each in ranges) if wrong), None)
    return wrong or (None if np.any(ranges) or count == 1 else "has no ranges: all its poses are the same")


def accelerations(value: Any) -> str | None:
    """Checks limits of acceleration: a positive number, or a mapping from joints to positive numbers."""
    given = list(value.values()) if isinstance(value, Mapping) else [value]
    if not given:
        return "names no joint"
    return None if all(_number(v) and math.isfinite(v) and v > 0 for v in given) else "has limits above 0"


def keeping(value: Any) -> str | None:
    """Checks a motion constraint to keep: its name (empty: none), or {object, constraint}."""
    if not isinstance(value, Mapping):
        return None
    if set(value) != {"object", "constraint"}:
        return "is the name of a motion constraint, or {object, constraint}"
    return _prefixed("object", name(value["object"]))


def share(value: Any) -> str | None:
    """Checks that a number is a fraction, above 0 and at most 1."""
    return f"is above 0 and at most 1, not {value:g}" if _number(value) and not 0.0 < value <= 1.0 else None


def any_of(*wrongs: Wrong) -> Wrong:
    """A check that combines several checks and returns the first reason that one of them gives."""
    return lambda value: next((found for found in (wrong(value) for wrong in wrongs) if found), None)


def _number(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and not isinstance(value, bool)


def _named(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip())


def _prefixed(what: str, wrong: str | None) -> str | None:
    return None if wrong is None else f"has a {what} that {wrong}"


def _offsets(given: Any) -> str | None:
    if not isinstance(given, Mapping) or not given:
        return "has no joints to move"
    if not all(_number(v) and math.isfinite(v) for v in given.values()):
        return "has finite offsets of joints"
    return None if any(given.values()) else "has no length: all offsets are 0"


def _stroke(kind: str, feature: Any, distance: Any) -> str | None:
    owner, dot, own = str(feature).partition(".")
    if not (owner and dot and own):
        return f"goes {kind} a feature such as tool.approach, not {feature!r}"
    bounds = list(distance) if isinstance(distance, Sequence) and not isinstance(distance, str) else [distance] * 2
    wrong = None if distance is None else numbers(bounds, 2)
    if wrong or distance is None:
        return wrong
    low, high = bounds
    return None if 0.0 <= low <= high and high > 0.0 else f"has a distance from 0 to above 0, not {distance!r}"
