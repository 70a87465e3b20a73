"""The geometric situation at the start of a node: the components that must have one value, and all values of the others.

The components that must have one value are those of the robots that move, the objects that they carry, the bodies
that the call names, and all that is attached to any of them. Every other body stands still, in every pose that it
may have.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from kabo.plan import ObjectPose
from kabo.verify.motion.calls import Call
from kabo.verify.motion.components import Components, ComponentValue
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.scene_model import SceneModel, matrix
from kabo.verify.motion.sweep import SweptBody
from kabo.verify.report import Finding

_Value = TypeVar("_Value")


@dataclass
class Situation:
    """The start of a motion: robots' configurations, objects that have one pose, and the standing bodies."""

    holding: AttachmentTree
    standing: list[SweptBody] = field(default_factory=list)


class Ambiguous(Exception):
    """A component that a motion moves or refers to has several possible values, or its parent does not exist."""


def situation(
    node: str, call: Call, moved: Sequence[str], world: SceneModel, components: Components
) -> Situation | None:
    """The situation in which a node's motion begins; None if the plan never reaches the node.

    Args:
        node: the node's id.
        call: the node's call.
        moved: the robots that the node's motion moves.
        world: the scene.
        components: the possible values of components at the plan's nodes.

    Raises:
        Ambiguous: a robot that moves, or an object that the motion carries or refers to, has several possible
            values; or an object's parent does not exist. The message names the robot or object.
    """
    scene = world.scene
    states = {name: _holdings(node, name, world, components) for name in scene.movable}
    holding = AttachmentTree(world.arms, scene.fixed_poses)
    for robot in moved:
        configurations = components.values(node, (robot,))
        if not configurations:
            return None
        holding.q[robot] = np.asarray(_only(robot, [value for (value,) in configurations]))
    result = Situation(holding)
    followed = _followed(call, moved, world, states)
    for name in scene.movable:
        if name in followed:
            _follow(name, states[name], holding)
        else:
            own = world.surface_of(scene.bodies[name])
            places = {where.tobytes(): where for where in (state.pose(name) for state in states[name])}
            result.standing.extend(SweptBody(name, own, where) for where in places.values())
    for robot in scene.robots:
        if robot not in moved:
            for (value,) in sorted(components.values(node, (robot,))):
                result.standing.extend(world.links_at(robot, value))  # type: ignore[arg-type]
    result.standing.extend(world.fixed)
    return result


def _followed(
    call: Call, moved: Sequence[str], world: SceneModel, states: dict[str, list[AttachmentTree]]
) -> set[str]:
    """The objects that are followed: those named or carried, and all that may be attached to them."""
    region = world.scene.regions.get(call.roles.get("region", ""))
    result = {name for name in (*call.bodies, region.support if region else None) if name in states}
    result |= {name for name, all_ in states.items() for state in all_ if state.holder(name) in moved}
    edges = [(name, state.hung[name][0]) for name, all_ in states.items() for state in all_]
    joined = [pair for pair in edges if pair[1] in states]
    while True:
        more = {name for pair in joined for name in pair if result & set(pair)} - result
        if not more:
            return result
        result |= more


def _follow(name: str, states: Sequence[AttachmentTree], holding: AttachmentTree) -> None:
    """Copies the parent of one object from the states into `holding`.

    Raises:
        Ambiguous: it may have several parents or poses.
    """
    values = {
        (state.hung[name][0], state.hung[name][1].tobytes(), state.pose(name).tobytes()): state for state in states
    }
    state = _only(name, list(values.values()))
    holding.hung[name] = state.hung[name]
    robot = state.holder(name)
    if robot is not None:
        holding.q.setdefault(robot, state.q[robot])


def _only(name: str, values: Collection[_Value]) -> _Value:
    if len(values) != 1:
        raise Ambiguous(f"{name} can be in {len(values)} different states here, but the motion moves or uses it")
    return next(iter(values))


def _holdings(node: str, name: str, world: SceneModel, components: Components) -> list[AttachmentTree]:
    """All attachment trees that an object may be part of, with the robots' configurations."""
    supports = components.supports(name)
    result = []
    for values in sorted(components.values(node, supports), key=repr):
        holding = _holding(dict(zip(supports, values, strict=True)), world)
        try:
            holding.pose(name)
        except KeyError as error:
            raise Ambiguous(f"{name} hangs on {error.args[0]}, which is nothing in the scene") from None
        except RecursionError:
            raise Ambiguous(f"{name} hangs on itself") from None
        result.append(holding)
    return result


def _holding(state: dict[str, ComponentValue], world: SceneModel) -> AttachmentTree:
    holding = AttachmentTree(world.arms, world.scene.fixed_poses)
    for name, value in state.items():
        if isinstance(value, ObjectPose):
            holding.hung[name] = value.parent, matrix(value)
        else:
            holding.q[name] = np.asarray(value)
    return holding


def check_start(components: Components, *, anywhere: bool = False) -> Iterator[Finding]:
    """The findings about differences between the plan's `start` and the initial state of the scene.

    Args:
        components: those of the plan.
        anywhere: whether things may be elsewhere than in the scene, as long as none is missing.
    """
    plan, scene = components.plan, components.scene
    if plan.start is None:
        return
    for name, robot in scene.robots.items():
        recorded = plan.start.robots.get(name, {})
        if set(recorded) != set(robot.joint_names):
            yield Finding(None, f"start: the joints of {name} are not those of its URDF", bodies=(name,))
        elif not anywhere and any(
            abs(recorded[j] - v) > 1e-6 for j, v in zip(robot.joint_names, scene.start.robots[name], strict=True)
        ):
            yield Finding(None, f"start: {name} does not begin where the scene puts it", bodies=(name,))
    for name, first in scene.start.objects.items():
        pose = plan.start.objects.get(name)
        if pose is None:
            yield Finding(None, f"start: {name} is missing", bodies=(name,))
        elif not anywhere and (pose.parent != first.parent or not _near(pose, first)):
            yield Finding(None, f"start: {name} is not where the scene puts it", bodies=(name,))
    known = set(scene.robots) | set(scene.start.objects)
    for name in sorted((set(plan.start.robots) | set(plan.start.objects)) - known):
        yield Finding(None, f"start: the scene has no {name} that moves", bodies=(name,))


def _near(pose, first) -> bool:  # type: ignore[no-untyped-def]
    """Whether two poses agree to 1e-6; q and -q are the same rotation."""
    ours, theirs = np.asarray(pose.quaternion), np.asarray(first.quaternion)
    turned = min(np.abs(ours - theirs).max(), np.abs(ours + theirs).max())
    return bool(np.abs(np.subtract(pose.position, first.position)).max() <= 1e-6 and turned <= 1e-6)
