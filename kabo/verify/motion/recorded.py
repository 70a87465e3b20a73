"""Checks that a node's `after` records its motion's result: configurations, parents and poses of objects."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from kabo.plan import Node, StateChange
from kabo.verify.motion.contacts.attachment_changes import AttachmentChanges
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.limits import CONTINUITY_TOLERANCE
from kabo.verify.motion.scene_model import SceneModel, matrix
from kabo.verify.report import Finding


@dataclass(frozen=True)
class Recorded:
    """The result of a node's motion, to be compared with the node's `after`."""

    node: str
    world: SceneModel
    moved: tuple[str, ...]
    before: AttachmentTree
    changes: AttachmentChanges
    time: float

    def check(self, content: Node) -> Iterator[Finding]:
        """The findings about differences between the node's `after` and the result of its motion."""
        after = StateChange() if content.after is None else content.after
        foreign = after.robots.keys() - set(self.moved)
        for name in sorted(foreign) + sorted(after.objects.keys() - self._changed()):
            yield Finding(self.node, f"records a change of {name}, which its motion does not make", bodies=(name,))
        for robot in self.moved:
            yield from self._check_configuration(robot, after)
        yield from self._check_objects(after)

    def _changed(self) -> set[str]:
        """The objects whose parent has changed, with all objects of their groups."""
        now = self.changes.holding
        changed = [name for name in now.hung if now.hung[name] is not self.before.hung[name]]
        return {other for name in changed for state in (self.before, now) for other in state.group(name)}

    def _check_configuration(self, robot: str, after: StateChange) -> Iterator[Finding]:
        recorded, names = after.robots.get(robot, {}), self.world.scene.robots[robot].joint_names
        now = self.changes.holding.q[robot]
        for joint, value, before in zip(names, now, self.before.q[robot], strict=True):
            told = recorded.get(joint, float(before))
            if abs(told - value) > CONTINUITY_TOLERANCE:
                text = f"records {joint} of {robot} at {told:.9g}, the motion ends at {value:.9g}"
                yield Finding(self.node, text, self.time, (robot,), abs(told - float(value)))
        for joint in sorted(recorded.keys() - set(names)):
            yield Finding(self.node, f"records {joint}, which {robot} does not have")

    def _check_objects(self, after: StateChange) -> Iterator[Finding]:
        now, told = self.changes.holding, self.before.copy()
        told.q = dict(now.q)
        for name, pose in after.objects.items():
            if name in told.hung:
                told.hung[name] = pose.parent, matrix(pose)
        for name in self._in_order(self._changed()):
            try:
                off = float(np.abs(told.pose(name) - now.pose(name)).max())
            except (KeyError, RecursionError):
                parent = told.hung[name][0]
                yield Finding(self.node, f"records {name} on {parent}, which leads nowhere", self.time, (name,))
                continue
            if name not in after.objects and (off > 2 * CONTINUITY_TOLERANCE or self._elsewhere(name, told)):
                text = f"does not record where {name} is afterwards"
            elif self._elsewhere(name, told):
                left = now.hung[name][0]
                text = f"records {name} on {told.hung[name][0]}, the motion leaves it on {left}"
            elif off > 2 * CONTINUITY_TOLERANCE:
                text = f"records {name} {off:.3g} away from where the motion leaves it"
            else:
                continue
            yield Finding(self.node, text, self.time, (name,), off)

    def _elsewhere(self, name: str, told: AttachmentTree) -> bool:
        """Whether an object is recorded in another group than it is in, or its group with another parent.

        In a group that stands it does not matter which member is the root and how the others are attached to it.
        """
        now = self.changes.holding
        if now.parent(name) != told.parent(name) or set(now.group(name)) != set(told.group(name)):
            return True
        return now.holder(name) is not None and now.root(name) != told.root(name)

    def _in_order(self, names: Iterable[str]) -> list[str]:
        wanted = set(names)
        return [name for name in self.changes.holding.hung if name in wanted]
