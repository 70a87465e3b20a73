"""Where everything is by the plan, as far as it has been carried out; the world is compared with it."""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.kinematics import joint_poses
from kabo.plan import Segment, StateChange
from kabo.scene import Attachment, Scene, attachment, with_change, world_T
from kabo.scene.state import GeometricState
from kabo.scene.transforms import transform, unflat


class Belief:
    """The geometric state by the plan; it changes when a segment has ended, and on nothing else [T 3.8].

    Args:
        scene: the scene.
        state: where everything is.
        givers: by the name of a body that another hand has taken, how the hand that gives it holds it until it opens.
    """

    def __init__(
        self, scene: Scene, state: GeometricState, givers: Mapping[str, Attachment] | None = None
    ) -> None:
        self.scene, self.state, self.givers = scene, state, dict(givers or {})
        self._places: dict[str, tuple[Attachment, Array]] = {}  # attachments as matrices

    @classmethod
    def at_start(cls, scene: Scene, start: StateChange | None) -> "Belief":
        """What a plan says of its start; what it does not say is as in the scene."""
        belief = cls(scene, scene.start)
        if start is not None:
            belief.take(start)
        return belief

    def take(self, change: StateChange) -> None:
        """Takes over what a plan says of a state."""
        self.state = with_change(self.scene, self.state, change)
        self.givers.clear()

    def move(self, robot: str, joints: tuple[str, ...], values: Array) -> None:
        """Puts joints of a robot to values."""
        now = dict(zip(self.scene.robots[robot].joint_names, self.state.robots[robot], strict=True))
        now |= dict(zip(joints, values.tolist(), strict=True))
        self.state = self.state.replace({robot: tuple(now.values())})

    def finish(self, segment: Segment) -> None:
        """A segment has ended: its robot is at its end, objects are attached and let go of."""
        self.move(segment.robot, segment.joints, segment.at(segment.times[-1]))
        for body in segment.detach:
            self.let_go(body, segment.robot)
        for body, parent in segment.attach:
            self._take(body, parent)

    def let_go(self, body: str, robot: str) -> None:
        """A robot holds a body no more: it stands in the world where it is, if no other hand holds it."""
        given = self.givers.pop(body, None)
        if self.holder(body) == robot:
            self._hang(body, "world" if given is None else given.parent)

    def _take(self, body: str, parent: str) -> None:
        """Hangs a body on a parent; a hand that holds it does so until it opens."""
        before, had = self.state.objects[body], self.holder(body)
        self._hang(body, parent)
        if had is not None and before.parent not in self.state.objects and self.holder(body) != had:
            self.givers[body] = before

    def _hang(self, body: str, parent: str) -> None:
        place = np.linalg.inv(world_T(self.scene, self.state, parent)) @ world_T(self.scene, self.state, body)
        self.state = self.state.replace({body: attachment(parent, place)})

    def holder(self, body: str) -> str | None:
        """The robot that holds a body, at first hand or by another body; None: it stands."""
        parent = self.state.objects[body].parent
        while parent in self.state.objects:
            parent = self.state.objects[parent].parent
        robot, dot, _ = parent.partition(".")
        return robot if dot and robot in self.scene.robots else None

    def held_by_giver(self, body: str) -> tuple[str, Attachment] | None:
        """The robot that held a body before the one that has taken it, if it has not let go yet, and how it holds it."""
        given = self.givers.get(body)
        return None if given is None else (given.parent.partition(".")[0], given)

    def poses(self, robots: Mapping[str, Sequence[float]] | None = None) -> dict[str, Array]:
        """The poses (4, 4) of all movable bodies, with robots where they are said to be."""
        configurations = self.state.robots if robots is None else {**self.state.robots, **robots}
        found: dict[str, Array] = {}
        for name in self.scene.movable:
            self._put(name, configurations, found)
        return {name: found[name] for name in self.scene.movable}

    def _put(self, name: str, configurations: Mapping[str, Sequence[float]], found: dict[str, Array]) -> None:
        """Adds the pose of a body, and of those to which it is attached."""
        if name in found:
            return
        own = self.state.objects[name]
        known = self._places.get(name)
        if known is None or known[0] is not own:
            known = self._places[name] = own, transform(own.position, own.quaternion)
        if own.parent == "world":
            found[name] = known[1]
            return
        if own.parent in self.state.objects:
            self._put(own.parent, configurations, found)
        elif own.parent not in found:
            found[own.parent] = self._carrier(own.parent, configurations)
        found[name] = found[own.parent] @ known[1]

    def _carrier(self, name: str, configurations: Mapping[str, Sequence[float]]) -> Array:
        """The pose of a `robot.link`, or of what stands."""
        robot, dot, link = name.partition(".")
        if not dot or robot not in self.scene.robots:
            return world_T(self.scene, self.state, name)
        own = self.scene.robots[robot]
        joint = joint_poses(own.tree, own.links[link].joint, np.array([configurations[robot]]))
        return np.asarray(unflat(joint[0]) @ own.links[link].joint_T_link)
