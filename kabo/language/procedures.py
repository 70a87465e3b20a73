"""The geometric procedures that a domain may call, with their properties in the order of positional arguments.

Plain data: what they do is the geometry server's business. Task files will add to this table.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Property:
    """A property of a procedure; `kind` says what may fill it.

    The last three kinds are names that the scene gives to grasp families, placements and motion constraints.
    """

    name: str
    kind: Literal["robot", "body", "region", "grasp", "placement", "motion_constraint"]
    required: bool = True


_ROBOT = Property("robot", "robot")
_OBJECT = Property("object", "body")
_REGION = Property("region", "region")
_PLACEMENT = Property("placement", "placement", required=False)

PROCEDURES: Mapping[str, tuple[Property, ...]] = {
    "move": (_ROBOT,),
    "pick": (_ROBOT, _OBJECT, Property("grasp", "grasp", required=False)),
    "place": (_ROBOT, _OBJECT, _REGION, _PLACEMENT),
    "transfer": (
        _ROBOT,
        _OBJECT,
        _REGION,
        Property("keep", "motion_constraint", required=False),
        _PLACEMENT,
    ),
    "release": (_ROBOT, _OBJECT, _REGION),
    "restack": (
        _ROBOT,
        Property("this", "body"),
        Property("other", "body"),
        Property("grasp", "grasp", required=False),
        _PLACEMENT,
    ),
    "sense": (_ROBOT, _OBJECT),
    "sense_weight": (_ROBOT, _OBJECT),
}


def spell_signature(name: str, properties: tuple[Property, ...]) -> str:
    """`pick(robot, object, grasp = …)`."""
    return f"{name}({', '.join(each.name if each.required else f'{each.name} = …' for each in properties)})"
