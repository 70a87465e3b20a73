"""Values of task files: text is converted to the type that the stage's property declares, else by its form.

Quoted text is never converted to a number where text is permitted.
"""

import math
import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from kabo.language.formulas import Place
from kabo.language.task_description import Entries, Items, PropertyReference, Word, Written
from kabo.tasks.core import Interface, Parent, Property
from kabo.tasks.files.kinds import BodyName, GraspName, MotionConstraintName, PlacementName, RegionName, RobotName
from kabo.tasks.learned import Model

_WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
_NUMBER = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)[ \t]*(deg)?")
_WORDS: dict[Any, str] = {
    float: "a number", int: "a whole number", bool: "true or false", str: "a text", list: "a list", tuple: "a list",
    Any: "anything", type(None): "none", dict: "a mapping", Mapping: "a mapping", Sequence: "a list",
    RobotName: "the name of a robot", BodyName: "the name of a body", RegionName: "the name of a region",
    GraspName: "the name of a grasp family", PlacementName: "the name of a placement",
    MotionConstraintName: "the name of a motion constraint", Model: "the path of a model",
}  # fmt: skip
_TRUTH = {"true": True, "false": False}


class NoValue(Exception):  # noqa: N818 - it is caught beside, and told as a finding
    """An error: a text is not of the type that the property declares; the message names the declared type."""


def value_of(written: Written, declared: Property) -> Any:
    """The value that a task file gives for a property, converted to the property's declared type.

    Raises:
        NoValue: the value cannot be converted.
    """
    kinds = declared.type if isinstance(declared.type, tuple) else (declared.type,)
    value = _converted(written, None if Any in kinds or object in kinds else kinds)
    if not isinstance(written, PropertyReference) and not _has_references(written) and not declared.accepts(value):
        raise NoValue(wanted(declared))
    return value


def wanted(declared: Property) -> str:
    """The type that a property declares, in words."""
    kinds = declared.type if isinstance(declared.type, tuple) else (declared.type,)
    return " or ".join(dict.fromkeys(str(_WORDS.get(kind) or getattr(kind, "__name__", kind)) for kind in kinds))


def _has_references(written: Written) -> bool:
    if isinstance(written, Items):
        return any(map(_has_references, written.values))
    if isinstance(written, Entries):
        return any(map(_has_references, written.values.values()))
    return isinstance(written, PropertyReference)


def _converted(written: Written, kinds: Collection[Any] | None) -> Any:
    """The value converted to one of `kinds`; None: to the type it looks like."""
    if isinstance(written, Word):
        return looked_at(written) if kinds is None else _word(written, kinds)
    if isinstance(written, Items):
        values = [_converted(item, None) for item in written.values]
        return tuple(values) if kinds is not None and tuple in kinds and list not in kinds else values
    if isinstance(written, Entries):
        return {key: _converted(value, None) for key, value in written.values.items()}
    return Parent(written.name) if written.source == "PARENT" else Interface(written.name)


def _word(word: Word, kinds: Collection[Any]) -> Any:
    textual = str in kinds or any(not isinstance(kind, type) or isinstance("", kind) for kind in kinds)
    if word.quoted and textual:
        return word.text
    if bool in kinds and word.text in _TRUTH:
        return _TRUTH[word.text]
    if float in kinds or int in kinds:
        number = number_of(word.text)
        if number is not None and (float in kinds or isinstance(number, int)):
            return number
    return word.text


def looked_at(word: Word) -> str | int | float | bool:
    """The value of a word by its form: a truth value, a number, or text."""
    if word.quoted:
        return word.text
    number = number_of(word.text)
    return _TRUTH.get(word.text, word.text) if number is None else number


def number_of(text: str) -> int | float | None:
    """The number that a text denotes (degrees are converted to radians); None if it denotes none."""
    text = text.strip()
    if _WHOLE.fullmatch(text):
        return int(text)
    found = _NUMBER.fullmatch(text)
    if found is None or not math.isfinite(float(found[1])):
        return None
    return math.radians(float(found[1])) if found[2] else float(found[1])


def parent_references(written: Written, name: str) -> list[tuple[str, PropertyReference]]:
    """Every reference to a parent's property in the value of property `name`, with the parent property's name."""
    if isinstance(written, PropertyReference):
        return [(written.name or name, written)] if written.source == "PARENT" else []
    if isinstance(written, Items):
        return [found for item in written.values for found in parent_references(item, name)]
    if isinstance(written, Entries):
        return [found for key, value in written.values.items() for found in parent_references(value, key)]
    return []


def interface_references(written: Written, name: str) -> list[tuple[str, Place]]:
    """Every reference to the interface in the value of property `name`: the interface property, and its place."""
    if isinstance(written, PropertyReference):
        return [(written.name or name, written.place)] if written.source == "INTERFACE" else []
    if isinstance(written, Items):
        return [found for item in written.values for found in interface_references(item, name)]
    if isinstance(written, Entries):
        return [found for key, value in written.values.items() for found in interface_references(value, key)]
    return []


def described(properties: Mapping[str, Property]) -> str:
    """The names of properties as one text, for messages."""
    return ", ".join(properties) or "none"
