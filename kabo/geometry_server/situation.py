"""Situations: for every component of the geometric state, the values that this component may have.

Where branches of a plan meet, components that are not moved afterwards may have several values
(docs/reference/plans.md#sharing); a procedure takes all of these values into account. A situation with one value for each
component is a geometric state.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from kabo.plan import ObjectPose, StateChange
from kabo.scene import Attachment, Component, Configuration, GeometricState, Scene
from kabo.scene.transforms import quaternion, transform


@dataclass(frozen=True)
class Situation:
    """The possible values of every robot and movable object, in the scene's order, without repetitions."""

    robots: Mapping[str, tuple[Configuration, ...]]
    objects: Mapping[str, tuple[Attachment, ...]]

    @classmethod
    def of(cls, state: GeometricState) -> "Situation":
        """The situation in which every component has the value of `state`."""
        return cls({n: (q,) for n, q in state.robots.items()}, {n: (a,) for n, a in state.objects.items()})

    def values(self, component: str) -> tuple[Component, ...]:
        """All values that a robot or object may have."""
        return self.robots[component] if component in self.robots else self.objects[component]

    def configuration(self, robot: str) -> Configuration:
        """The configuration of a robot that has exactly one possible configuration."""
        (only,) = self.robots[robot]
        return only

    def attachment(self, name: str) -> Attachment:
        """The attachment of an object that has exactly one possible attachment."""
        (only,) = self.objects[name]
        return only

    def carried(self, robot: str) -> tuple[str, ...]:
        """The objects that the robot may be holding, and those attached to them."""
        return tuple(name for name, holders in self._holders.items() if robot in holders)

    @cached_property
    def _holders(self) -> dict[str, frozenset[str]]:
        """The robots and fixed bodies, or `world`, to which each object may be attached, directly or not."""
        return {
            name: frozenset(end.partition(".")[0] for end in self._ends(name) if "." in end)
            for name in self.objects
        }

    def held(self, name: str) -> Attachment:
        """The root of an object's group (`world`, `robot.link` or a standing body), and the object's pose in its frame."""
        own = self.attachment(name)
        if own.parent not in self.objects:
            return own
        below = self.held(own.parent)
        pose = transform(below.position, below.quaternion) @ transform(own.position, own.quaternion)
        x, y, z = (float(v) for v in pose[:3, 3])
        return Attachment(below.parent, (x, y, z), quaternion(pose))

    def root(self, name: str) -> str:
        """The root of an object's group: the object that stands or is held, to which the others are attached."""
        parent = self.attachment(name).parent
        return self.root(parent) if parent in self.objects else name

    def group(self, name: str) -> tuple[str, ...]:
        """All objects that may be attached, directly or not, to the root of an object, in the scene's order."""
        if not self.nested:
            return (name,)
        root = self.root(name)
        return tuple(other for other in self.objects if root in self._above(other))

    def _above(self, name: str) -> tuple[str, ...]:
        """An object, and all objects to which it may be attached, directly or not."""
        parents = (a.parent for a in self.objects[name] if a.parent in self.objects)
        return (name, *(above for parent in dict.fromkeys(parents) for above in self._above(parent)))

    def _ends(self, name: str) -> tuple[str, ...]:
        """The links, fixed bodies or `world` to which an object is attached, directly or through other objects."""
        ends = (a.parent for each in self._above(name) for a in self.objects[each])
        return tuple(end for end in ends if end not in self.objects)

    def carriers(self, names: Iterable[str]) -> frozenset[str]:
        """All objects and robots to which any of the named objects is attached, directly or not."""
        objects = [name for name in names if name in self.objects]
        above = {carrier for name in objects for carrier in self._above(name)}
        holding = {end.partition(".")[0] for name in objects for end in self._ends(name)}
        return frozenset(above | holding & {*self.robots})

    @cached_property
    def nested(self) -> bool:
        """Whether any object may be attached to another one."""
        return any(a.parent in self.objects for values in self.objects.values() for a in values)

    def replace(self, changes: Mapping[str, Component]) -> "Situation":
        """A copy of this situation with some components set to one value each."""
        robots = {n: (changes[n],) if n in changes else v for n, v in self.robots.items()}
        objects = {n: (changes[n],) if n in changes else v for n, v in self.objects.items()}
        return Situation(robots, objects)  # type: ignore[arg-type]

    def union(self, other: "Situation") -> "Situation":
        """The situation in which every component has its values in both situations, in the order of first appearance."""
        robots = {n: tuple(dict.fromkeys((*v, *other.robots[n]))) for n, v in self.robots.items()}
        objects = {n: tuple(dict.fromkeys((*v, *other.objects[n]))) for n, v in self.objects.items()}
        return Situation(robots, objects)

    @property
    def first(self) -> GeometricState:
        """The geometric state with the first value of every component."""
        return GeometricState(
            {n: v[0] for n, v in self.robots.items()}, {n: v[0] for n, v in self.objects.items()}
        )

    @property
    def key(self) -> tuple[object, ...]:
        """A key by which situations are compared, independent of the order of their values."""
        robots = ((n, frozenset(v)) for n, v in self.robots.items())
        objects = ((n, frozenset(v)) for n, v in self.objects.items())
        return (*robots, *objects)


def whole_state(scene: Scene, components: Mapping[str, Component]) -> StateChange:
    """The components in the format of plans: robots as joint values by name, objects as parent and pose."""
    robots, objects = {}, {}
    for name, value in components.items():
        if isinstance(value, Attachment):
            objects[name] = ObjectPose(value.parent, value.position, value.quaternion)
        else:
            robots[name] = dict(zip(scene.robots[name].joint_names, value, strict=True))
    return StateChange(robots, objects)
