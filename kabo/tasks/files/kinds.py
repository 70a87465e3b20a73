"""The types of a task's declared properties, as types that values have: what a caller may give [docs/tasks.md#task-files].

The names of things in a scene are text; which kind of thing is meant is kept for whoever checks a call.
"""

from typing import Any

from kabo.tasks.core import Property


class _Kind(type):
    """A type whose values are those of another one."""

    def __instancecheck__(cls, value: object) -> bool:
        return isinstance(value, str)


class Robot(metaclass=_Kind):
    """The name of a robot."""


class Body(metaclass=_Kind):
    """The name of a body."""


class Region(metaclass=_Kind):
    """The name of a region."""


class Grasp(metaclass=_Kind):
    """The name of a grasp family, or `any`."""


class Placement(metaclass=_Kind):
    """The name of a placement, or `any`."""


class MotionConstraint(metaclass=_Kind):
    """The name of a motion constraint."""


class _Anything(type):
    def __instancecheck__(cls, value: object) -> bool:
        return True


class Anything(metaclass=_Anything):
    """Any value: where a task file names a property and no more."""


KIND_TYPES: dict[str, Any] = {
    "robot": Robot,
    "body": Body,
    "region": Region,
    "grasp": Grasp,
    "placement": Placement,
    "motion_constraint": MotionConstraint,
    "name": str,
    "number": float,
    "boolean": bool,
    "any": (Anything, Any),
}


def kind_of(declared: Property) -> str:
    """The kind that a declared property has in a file."""
    types = declared.type if isinstance(declared.type, tuple) else (declared.type,)
    for kind, type_ in KIND_TYPES.items():
        if declared.type == type_:
            return kind
    return "number" if set(types) <= {int, float} else "any"
