"""Checks that a node's motion fits its action: it moves what the call names, and ends as the node records."""

from collections.abc import Iterator

from kabo.plan import Node
from kabo.verify.motion.added import AddedBodies
from kabo.verify.motion.calls import Call, Calls
from kabo.verify.motion.collision import Tally
from kabo.verify.motion.components import Components
from kabo.verify.motion.overlaps import Motion
from kabo.verify.motion.scene_model import SceneModel
from kabo.verify.motion.situation import Ambiguous, Situation, situation
from kabo.verify.motion.views import check_view
from kabo.verify.motion.walk import Walk, is_at
from kabo.verify.report import Finding


def check_motion(
    node: str,
    content: Node,
    calls: Calls,
    world: SceneModel,
    components: Components,
    tally: Tally,
    walked: dict[str, Motion] | None = None,
    added: AddedBodies | None = None,
) -> Iterator[Finding]:
    """The findings about a node's motion, in the order of time; adds the checked motion to `walked`, if given.

    `added` are the bodies that only planning knows, if there are any.
    """
    try:
        call = calls.of(content)
    except ValueError as error:
        yield Finding(node, str(error))
        return
    if call is None:
        if content.motion or content.after is not None:
            yield Finding(node, f'"{content.action}" has no geometry, but the node moves something')
        return
    unknown = _unknown(call, world)
    if unknown:
        text = f"{call}: {', '.join(unknown)} cannot play this role in the scene"
        yield Finding(node, text, bodies=tuple(unknown))
        return
    moved = tuple(dict.fromkeys(segment.robot for segment in content.motion))
    foreign = [robot for robot in moved if robot not in call.robots]
    if foreign:
        yield Finding(node, f"{call} moves {foreign[0]}, which it does not name", bodies=(foreign[0],))
        return
    try:
        start = situation(node, call, moved or call.robots[:1], world, components)
    except Ambiguous as error:
        yield Finding(node, str(error))
        return
    if start is not None and content.motion:
        walk = Walk(node, call, world, start, content.motion, tally, added)
        yield from walk.check(content)
        if walked is not None:
            walked[node] = walk.motion()
    elif start is not None:
        yield from _check_motionless(node, content, call, world, start)


def _unknown(call: Call, world: SceneModel) -> list[str]:
    """The names in the call that the scene does not have, or that it has as bodies that cannot be moved."""
    scene = world.scene
    has = {"robot": scene.robots, "body": scene.bodies, "region": scene.regions}
    missing = [name for kind, names in call.things.items() for name in names if name not in has[kind]]
    still = [name for name in (call.role("object"),) if name in scene.bodies and name not in scene.movable]
    return [*missing, *(str(name) for name in still)]


def _check_motionless(
    node: str, content: Node, call: Call, world: SceneModel, start: Situation
) -> Iterator[Finding]:
    """The findings about a node without motion: that is right only for sensing in the present configuration."""
    robot = next(iter(call.robots), None)
    if robot is None and call.spec is None:
        return
    if call.looks(world.scene):
        yield from check_view(node, call, world, start.holding, start.standing, 0.0)
        if content.after is not None:
            yield Finding(node, "records a change, but nothing moves")
        return
    wanted = world.scene.robots[str(robot)].configurations.get(call.at or "")
    if call.at is None or (
        wanted is not None and not is_at(world, str(robot), start.holding.q[str(robot)], wanted)
    ):
        yield Finding(node, f"{call} has no motion")
    elif content.after is not None:
        yield Finding(node, "records a change, but nothing moves")
