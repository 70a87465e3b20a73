"""The immutable scenes that robot stages are given, and stretches of motion, proven when they are made."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal
from weakref import ref

import numpy as np

from kabo.arrays import Array
from kabo.errors import did_you_mean
from kabo.geometry_server import (
    Contacts,
    Extra,
    Pair,
    ProcedureContext,
    Situation,
    Workspace,
    contacts,
    workspace_of,
)
from kabo.scene import Attachment, Component, Configuration, GeometricState, Robot, world_T
from kabo.tasks.robots.timed_paths import TimedPath


def configuration(q: Iterable[float]) -> Configuration:
    """A configuration as states and plans store it: rounded to 1e-9, without negative zeros."""
    numbers = q.tolist() if isinstance(q, np.ndarray) else map(float, q)
    return tuple([round(value, 9) + 0.0 for value in numbers])


@dataclass(frozen=True)
class TaskScene:
    """A situation, with the contacts that earlier stages have permitted and the bodies that they have added.

    A component of the situation may have several values, where branches of a plan have merged; what is proven in the scene
    holds for each of them.
    """

    context: ProcedureContext
    situation: Situation
    permitted: Contacts = frozenset()
    extras: tuple[Extra, ...] = ()
    _known: "Mapping[str, ref[Workspace]]" = field(default_factory=dict, compare=False, repr=False)

    @classmethod
    def of(cls, context: ProcedureContext, state: GeometricState | Situation) -> "TaskScene":
        """The scene of a geometric state or a situation, without permitted contacts or added bodies."""
        return cls(context, Situation.of(state) if isinstance(state, GeometricState) else state)

    def __reduce__(self) -> tuple[type["TaskScene"], tuple[Any, ...]]:
        return TaskScene, (self.context, self.situation, self.permitted, self.extras)

    # ----------------------------------------------------------------------------------------------- questions
    def robot(self, name: str) -> Robot:
        """The robot of that name.

        Raises:
            ValueError: the scene has no robot of that name.
        """
        robots = self.context.scene.robots
        if name not in robots:
            raise ValueError(f"the scene has no robot {name!r}; it has {', '.join(robots) or 'none'}")
        return robots[name]

    def configuration(self, robot: str) -> Array:
        """The configuration (n,) of a robot."""
        return np.array(self.situation.configuration(robot))

    def pose(self, name: str) -> Array:
        """The pose world_T_body (4, 4) of a body whose pose is the same in all values of the situation."""
        (pose,) = self.context.surroundings.poses(self.situation, name)
        return pose

    def frame(self, name: str) -> Array:
        """The pose (4, 4) in the world of a frame: `world`, a body, a region or `robot.link`.

        Raises:
            ValueError: there is no frame of that name.
        """
        try:
            return world_T(self.context.scene, self.situation.first, name)
        except KeyError:
            scene = self.context.scene
            known = {"world": None, **scene.bodies, **scene.regions}
            known |= {f"{robot.name}.{link}": None for robot in scene.robots.values() for link in robot.links}
            hint = did_you_mean(name, known)
            raise ValueError(f"the scene has no frame {name!r}{'' if hint is None else ', ' + hint}") from None

    def holder(self, name: str) -> str | None:
        """The robot that holds an object, directly or through objects attached to it.

        The result is None if no robot holds it.
        """
        if name not in self.situation.objects:
            return None
        robot, dot, _ = self.situation.attachment(self.situation.root(name)).parent.partition(".")
        return robot if dot else None

    def workspace(self, robot: str) -> Workspace:
        """Everything that moves with a robot, and everything that it may collide with.

        Scenes are kept by thousands, so only the last workspaces are kept; others are
        computed again when needed, with the same result.
        """
        known = self._known.get(robot)
        found = None if known is None else known()
        if found is None:
            found = workspace_of(self.context.surroundings, robot, self.situation, self.permitted, self.extras)
            object.__setattr__(self, "_known", {**self._known, robot: ref(found)})
        return found

    def hit(self, robot: str) -> Pair | None:
        """The first pair of things that is not proven apart at the robot's configuration."""
        return self.workspace(robot).first_hit(self.configuration(robot))

    # ------------------------------------------------------------------------------------------------- changes
    def having(self, changes: Mapping[str, Component]) -> "TaskScene":
        """A copy of this scene in which some components have other values."""
        return replace(self, situation=self.situation.replace(changes), _known={})

    def at(self, robot: str, q: Iterable[float]) -> "TaskScene":
        """A copy of this scene with a robot at another configuration; the robot's workspace is reused."""
        situation = self.situation.replace({robot: configuration(q)})
        known = self._known.get(robot)
        kept = {} if known is None else {robot: known}
        return replace(self, situation=situation, _known=kept)

    def placing(self, name: str, attachment: Attachment) -> "TaskScene":
        """A copy of this scene in which an object has another attachment."""
        return self.having({name: attachment})

    def permitting(self, pairs: Iterable[Pair]) -> "TaskScene":
        """A copy of this scene in which the given pairs are also permitted to touch."""
        permitted = self.permitted | contacts(pairs)
        return self if permitted == self.permitted else replace(self, permitted=permitted, _known={})

    def forbidding(self, pairs: Iterable[Pair]) -> "TaskScene":
        """A copy of this scene in which the given pairs are no longer permitted to touch."""
        permitted = self.permitted - contacts(pairs)
        return self if permitted == self.permitted else replace(self, permitted=permitted, _known={})

    def adding(self, *extras: Extra) -> "TaskScene":
        """A copy of this scene with additional bodies, which replace added bodies of the same name."""
        names = {extra.name for extra in extras}
        kept = tuple(extra for extra in self.extras if extra.name not in names)
        return replace(self, extras=(*kept, *extras), _known={})

    def removing(self, *names: str) -> "TaskScene":
        """A copy of this scene without the added bodies of these names."""
        kept = tuple(extra for extra in self.extras if extra.name not in names)
        return replace(self, extras=kept, _known={})


@dataclass(frozen=True)
class Stretch:
    """A piece of motion of one robot, proven free when it was made; it becomes a segment of a plan.

    `waypoints` are configurations of all its joints; those of the other `group` do not move. `attach` (object, link) and
    `detach` take effect at its end. A stretch with one way point lasts `seconds`, mostly 0. `timed` is given for a motion
    that has its times already; others rest at both ends. The shape of an `exact` stretch is kept. `stage` is the path of
    the stage that made it, if a wrapper has taken it over. `since` [s] is the time between the beginning of the previous
    stretch of the same motion and that of this one; None: it begins after all previous ones have ended.
    """

    robot: str
    group: Literal["arm", "gripper"]
    waypoints: tuple[Configuration, ...]
    permitted: Contacts = frozenset()
    constraint: str | None = None
    attach: tuple[tuple[str, str], ...] = ()
    detach: tuple[str, ...] = ()
    seconds: float = 0.0
    timed: TimedPath | None = None
    exact: bool = False
    stage: str | None = None
    since: float | None = None

    @property
    def start(self) -> Configuration:
        """The configuration at which the stretch begins."""
        return self.waypoints[0]

    @property
    def end(self) -> Configuration:
        """The configuration at which the stretch ends."""
        return self.waypoints[-1]

    @property
    def path(self) -> Array:
        """The way points as an array (m, n)."""
        return np.array(self.waypoints)

    def reversed(self) -> "Stretch":
        """The stretch in reverse; its attachments are kept as they are, because other stages reverse them."""
        timed = None if self.timed is None else self.timed.reversed()
        return replace(self, waypoints=self.waypoints[::-1], timed=timed)


def stretch(
    scene: TaskScene,
    robot: str,
    group: Literal["arm", "gripper"],
    waypoints: Iterable[Iterable[float]],
    constraint: str | None = None,
) -> Stretch:
    """A stretch of one robot in a scene, with the scene's permitted contacts that concern its motion."""
    workspace = scene.workspace(robot)
    gripping = {frozenset(pair) for held in workspace.carried for pair in workspace.touching(held)}
    permitted = frozenset(pair for pair in scene.permitted | gripping if _concerns(pair, scene, robot, group))
    return Stretch(robot, group, tuple(map(configuration, waypoints)), permitted, constraint)


def _concerns(pair: frozenset[str], scene: TaskScene, robot: str, group: str) -> bool:
    """Whether a motion may change the distance of a pair; a gripper does not move an object against its support."""
    extras = {extra.name for extra in scene.extras}
    if pair & extras:
        return False
    if any(name.startswith(robot + ".") for name in pair):
        return True
    return group == "arm" and any(name in scene.workspace(robot).carried for name in pair)
