"""The possible values of the geometric components at each node of a plan, from its `start` and `after` entries.

A component is one robot's configuration, or one object's parent and pose. At a node where branches meet, a
component may have several values [docs/reference/plans.md#sharing].
Components that together determine a pose are tracked as
combinations.
"""

from collections.abc import Sequence

from kabo.plan import ObjectPose, Plan, StateChange
from kabo.scene import Scene

Value = tuple[float, ...] | ObjectPose
Row = tuple[Value, ...]


class ComponentValues:
    """The possible values of every component at the start of every node; `order` lists the nodes topologically."""

    def __init__(self, plan: Plan, scene: Scene, order: Sequence[str]) -> None:
        self._plan, self._scene, self._order = plan, scene, order
        self._start = plan.start or StateChange()
        self._rows: dict[tuple[str, ...], dict[str, list[Row]]] = {}
        self._parents: dict[str, list[str]] = {name: [] for name in scene.movable}
        for change in (plan.start, *(plan.nodes[name].after for name in order)):
            for name, pose in {} if change is None else change.objects.items():
                if pose.parent not in self._parents[name]:
                    self._parents[name].append(pose.parent)

    def configurations(self, node: str, robot: str) -> list[tuple[float, ...]]:
        """The possible configurations of a robot at the start of a node, sorted by their text form."""
        found = [row[0] for row in self._at(node, (robot,))]
        return sorted((q for q in found if isinstance(q, tuple)), key=repr)

    def states(self, node: str, name: str) -> list[dict[str, Value]]:
        """The possible combinations of values of an object and its possible parents, at a node's start."""
        names = self._supports(name)
        return [dict(zip(names, row, strict=True)) for row in self._at(node, names)]

    def _supports(self, name: str) -> tuple[str, ...]:
        found, ahead = [name], [name]
        while ahead:
            for parent in self._parents.get(ahead.pop(), ()):
                component = parent.partition(".")[0]
                if component not in found and (component in self._scene.robots or component in self._parents):
                    found.append(component)
                    ahead.append(component)
        return tuple(found)

    def _at(self, node: str, names: tuple[str, ...]) -> list[Row]:
        if names not in self._rows:
            self._rows[names] = self._followed(names)
        return self._rows[names][node]

    def _followed(self, names: tuple[str, ...]) -> dict[str, list[Row]]:
        arriving: dict[str, dict[Row, None]] = {name: {} for name in self._order}
        arriving[self._plan.root][tuple(self._changed(name, None, self._start) for name in names)] = None
        for name in self._order:
            node, leaving = self._plan.nodes[name], list(arriving[name])
            if node.after is not None:
                after = node.after
                leaving = [
                    tuple(self._changed(n, v, after) for n, v in zip(names, r, strict=True)) for r in leaving
                ]
            for successor in node.successors:
                arriving[successor].update(dict.fromkeys(leaving))
        return {name: list(rows) for name, rows in arriving.items()}

    def _changed(self, name: str, value: Value | None, change: StateChange) -> Value:
        if name in change.objects:
            return change.objects[name]
        if name in change.robots:
            joints, names = change.robots[name], self._scene.robots[name].joint_names
            before = value if isinstance(value, tuple) else (0.0,) * len(names)
            return tuple(joints.get(joint, old) for joint, old in zip(names, before, strict=True))
        if value is None:
            raise ValueError(f"the plan's start does not say where {name} is")
        return value
