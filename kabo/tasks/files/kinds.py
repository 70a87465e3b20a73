"""The types of a task's declared properties, as types that values have: what a caller may give [docs/tasks.md#task-files].

The names of things in a scene are text; which kind of thing is meant is kept for whoever checks a call.
"""

from typing import Any

from kabo.tasks.core import Property


class _Kind(type):
    """A type whose values are those of another one."""

    def __instancecheck__(cls, value: object) -> bool:
        return isinstance(value, str)


class RobotName(metaclass=_Kind):
    """The name of a robot."""


class BodyName(metaclass=_Kind):
    """The name of a body."""


class RegionName(metaclass=_Kind):
    """The name of a region."""


class GraspName(metaclass=_Kind):
    """The name of a grasp family, or `any`."""


class PlacementName(metaclass=_Kind):
    """The name of a placement, or `any`."""


class MotionConstraintName(metaclass=_Kind):
    """The name of a motion constraint."""


class _Anything(type):
    def __instancecheck__(cls, value: object) -> bool:
        return True


class Anything(metaclass=_Anything):
    """Any value: where a task file names a property and no more."""


KIND_TYPES: dict[str, Any] = {
    "robot": RobotName,
    "body": BodyName,
    "region": RegionName,
    "grasp": GraspName,
    "placement": PlacementName,
    "motion_constraint": MotionConstraintName,
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
