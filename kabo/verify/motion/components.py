"""The values that each component of the geometric state can have at every node, computed from `start` and `after`.

A component is one robot's configuration, or one object's parent and pose. Where branches have joined, a component
may have several values. Values of several components are computed together, so that exactly the combinations that
occur are found [docs/reference/plans.md#sharing]. The work grows with the values of the requested components only.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

from kabo.plan import ObjectPose, Plan, StateChange
from kabo.scene import Scene

Configuration = tuple[float, ...]
ComponentValue = Configuration | ObjectPose


class Components:
    """The possible values of components at the nodes of a plan."""

    def __init__(self, plan: Plan, scene: Scene, order: Sequence[str]) -> None:
        self.plan, self.scene, self.order = plan, scene, order
        self._followed: dict[tuple[str, ...], dict[str, frozenset[tuple[ComponentValue, ...]]]] = {}

    def values(self, node: str, names: tuple[str, ...]) -> frozenset[tuple[ComponentValue, ...]]:
        """The combinations of values that the named components can have when a node starts."""
        if names not in self._followed:
            self._followed[names] = self._follow(names)
        return self._followed[names].get(node, frozenset())

    def supports(self, name: str) -> tuple[str, ...]:
        """The components that determine an object's pose: the object, and all that may carry it."""
        result, open_ = [name], [name]
        while open_:
            for parent in self._parents.get(open_.pop(), ()):
                component = parent.partition(".")[0]
                if component not in result and (component in self.scene.robots or component in self._parents):
                    result.append(component)
                    open_.append(component)
        return tuple(result)

    @cached_property
    def _parents(self) -> Mapping[str, list[str]]:
        """For each object every parent that it has anywhere in the plan."""
        result: dict[str, list[str]] = {name: [] for name in self.scene.movable}
        changes = [node.after for node in self.plan.nodes.values()]
        for change in (self.plan.start, *changes):
            for name, pose in {} if change is None else change.objects.items():
                if name in result and pose.parent not in result[name]:
                    result[name].append(pose.parent)
        return result

    def _follow(self, names: tuple[str, ...]) -> dict[str, frozenset[tuple[ComponentValue, ...]]]:
        start = self.plan.start or StateChange()
        first = tuple(self._changed(name, None, start) for name in names)
        if any(value is None for value in first):
            return {}
        arriving: dict[str, set[tuple[ComponentValue, ...]]] = {name: set() for name in self.order}
        arriving[self.plan.root].add(first)  # type: ignore[arg-type]
        for name in self.order:
            node = self.plan.nodes[name]
            leaving = arriving[name]
            if node.after is not None:
                leaving = {self._after(names, values, node.after) for values in leaving}
            for successor in node.successors:
                if successor in arriving:
                    arriving[successor] |= leaving
        return {name: frozenset(values) for name, values in arriving.items()}

    def _after(
        self, names: tuple[str, ...], values: tuple[ComponentValue, ...], change: StateChange
    ) -> tuple[ComponentValue, ...]:
        changed = (self._changed(name, value, change) for name, value in zip(names, values, strict=True))
        return tuple(value for value in changed if value is not None)

    def _changed(self, name: str, value: ComponentValue | None, change: StateChange) -> ComponentValue | None:
        if name in change.objects:
            return change.objects[name]
        if name not in change.robots:
            return value
        joints, names = change.robots[name], self.scene.robots[name].joint_names
        before = value if isinstance(value, tuple) else (0.0,) * len(names)
        return tuple(joints.get(joint, old) for joint, old in zip(names, before, strict=True))
