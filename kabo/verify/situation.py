"""The geometric situation at the start of a node: what must be one there, and all that the rest may be."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from kabo.verify.arms import Mount
from kabo.verify.calls import Call
from kabo.verify.components import Components, ComponentValue
from kabo.verify.report import Finding
from kabo.verify.sweep import Thing
from kabo.verify.world import World

Array = npt.NDArray[np.float64]


@dataclass
class Situation:
    """What a motion begins with.

    `q` is the moving robot's configuration; `objects` says where each object is that the robot carries or the call
    names; `standing` is everything else, at every place that it can have.
    """

    q: npt.NDArray[np.float64]
    objects: dict[str, Array | Mount]
    standing: list[Thing] = field(default_factory=list)
    poses: dict[str, Array] = field(default_factory=dict)  # of supports that the call names


class Ambiguous(Exception):
    """A component that a motion moves or refers to has several possible values, or its parent does not exist."""


def situation(node: str, call: Call, world: World, components: Components) -> Situation | None:
    """The situation in which a node's motion begins; None if no way leads there.

    Raises:
        Ambiguous: says which component.
    """
    robot = call.roles["robot"]
    configurations = components.values(node, (robot,))
    if not configurations:
        return None
    q = _only(robot, configurations)
    named = [n for role, n in call.roles.items() if role in ("object", "support") and n in world.scene.movable]
    region = world.scene.regions.get(call.roles.get("region", ""))
    support = call.roles.get("support") or (None if region is None else region.support)
    objects: dict[str, Array | Mount] = {}
    result = Situation(np.asarray(q), objects)
    for name in world.scene.movable:
        placed = _placed(node, name, robot, world, components)
        carried = any(isinstance(where, Mount) for where in placed)
        if name in named or name == support or carried:
            where: Array | Mount = _only(name, placed)
            if isinstance(where, Mount) or name == call.roles.get("object"):
                objects[name] = where
            else:
                result.standing.append(Thing(name, world.surface_of(world.scene.bodies[name].mesh), where))
                result.poses[name] = where
        else:
            own = world.surface_of(world.scene.bodies[name].mesh)
            result.standing.extend(Thing(name, own, where) for where in placed if not isinstance(where, Mount))
    for other in world.scene.robots:
        if other != robot:
            for (value,) in sorted(components.values(node, (other,))):  # type: ignore[type-var]
                result.standing.extend(world.links_at(other, value))  # type: ignore[arg-type]
    result.standing.extend(world.fixed)
    result.poses.update(world.scene.fixed_poses)
    return result


def _only(name: str, values: Collection[Any]) -> Any:
    if len(values) != 1:
        raise Ambiguous(f"{name} can be in {len(values)} different states here, but the motion moves or uses it")
    value = next(iter(values))
    return value[0] if isinstance(value, tuple) else value


def _placed(node: str, name: str, robot: str, world: World, components: Components) -> list[Array | Mount]:
    """The different places where an object can be."""
    supports = components.supports(name)
    result: dict[tuple[int, bytes], Array | Mount] = {}
    for values in sorted(components.values(node, supports), key=repr):
        state: Mapping[str, ComponentValue] = dict(zip(supports, values, strict=True))
        try:
            where = world.placed(name, state, robot)
        except KeyError as error:
            raise Ambiguous(f"{name} hangs on {error.args[0]}, which is nothing in the scene") from None
        except RecursionError:
            raise Ambiguous(f"{name} hangs on itself") from None
        if isinstance(where, Mount):
            result[where.joint, where.joint_T_body.tobytes()] = where
        else:
            result[-1, where.tobytes()] = where
    return list(result.values())


def check_start(components: Components) -> Iterator[Finding]:
    """The plan's `start` is the scene's first state."""
    plan, scene = components.plan, components.scene
    if plan.start is None:
        return
    for name, robot in scene.robots.items():
        recorded = plan.start.robots.get(name, {})
        if set(recorded) != set(robot.joint_names):
            yield Finding(None, f"start: the joints of {name} are not those of its URDF", bodies=(name,))
        elif any(
            abs(recorded[j] - v) > 1e-6 for j, v in zip(robot.joint_names, scene.start.robots[name], strict=True)
        ):
            yield Finding(None, f"start: {name} does not begin where the scene puts it", bodies=(name,))
    for name, first in scene.start.objects.items():
        pose = plan.start.objects.get(name)
        if pose is None:
            yield Finding(None, f"start: {name} is missing", bodies=(name,))
        elif pose.parent != first.parent or not _near(pose, first):
            yield Finding(None, f"start: {name} is not where the scene puts it", bodies=(name,))
    known = set(scene.robots) | set(scene.start.objects)
    for name in sorted((set(plan.start.robots) | set(plan.start.objects)) - known):
        yield Finding(None, f"start: the scene has no {name} that moves", bodies=(name,))


def _near(pose, first) -> bool:  # type: ignore[no-untyped-def]
    """Whether two poses agree to 1e-6; q and -q are the same rotation."""
    turned = abs(abs(float(np.dot(pose.quaternion, first.quaternion))) - 1.0)
    return bool(np.abs(np.subtract(pose.position, first.position)).max() <= 1e-6 and turned <= 1e-12)
