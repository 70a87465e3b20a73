"""The geometric state: the configuration of every robot and the placing of every object, as an immutable value."""

from collections.abc import Mapping
from dataclasses import dataclass

Configuration = tuple[
    float, ...
]  # every actuated joint of a robot, planned ones first, then the gripper's; rad or m


@dataclass(frozen=True)
class Attachment:
    """An object's parent (`world`, `robot.link` or an object), and the object's pose in the parent's frame.

    The pose is a position [m] and a quaternion (x, y, z, w).
    """

    parent: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


Component = Configuration | Attachment  # the value of one robot, or of one movable object


@dataclass(frozen=True)
class GeometricState:
    """The value of every component: configurations by robot, attachments by movable object."""

    robots: Mapping[str, Configuration]
    objects: Mapping[str, Attachment]

    def __getitem__(self, component: str) -> Component:
        return self.robots[component] if component in self.robots else self.objects[component]

    def replace(self, changes: Mapping[str, Component]) -> "GeometricState":
        """A copy of this state with some components changed."""
        robots = {name: changes.get(name, value) for name, value in self.robots.items()}
        objects = {name: changes.get(name, value) for name, value in self.objects.items()}
        return GeometricState(robots, objects)  # type: ignore[arg-type]
