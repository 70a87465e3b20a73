"""Python types for the declared properties of a task, which say what values a caller may give.

Names of things in a scene are text; their types say which kind of thing they name, so that calls can be checked.
"""

from typing import Any

from kabo.tasks.core import Property


class _Kind(type):
    """A type whose instances are all texts."""

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
    """The type of any value: used for a declared property if the file gives no type."""


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
    """The word for a declared property's type in files."""
    types = declared.type if isinstance(declared.type, tuple) else (declared.type,)
    for kind, type_ in KIND_TYPES.items():
        if declared.type == type_:
            return kind
    return "number" if set(types) <= {int, float} else "any"
