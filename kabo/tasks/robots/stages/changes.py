"""Changes of the scene that take no time: attaching, releasing, contacts. The changed scene is checked for collisions."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kabo.errors import did_you_mean
from kabo.geometry_server import (
    Pair,
    ProcedureContext,
    Refusal,
    Situation,
    candidate,
    supports,
    tool_frame,
    why_unsupported,
)
from kabo.scene import Scene
from kabo.tasks.core import PARENT, Container, Propagator, Property, Result, Stage
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import OBJECT, RobotStage
from kabo.tasks.robots.motion.groups import hung
from kabo.tasks.robots.motion.held_bodies import too_heavy
from kabo.tasks.robots.motion.questions import along
from kabo.tasks.robots.scenes import Stretch, TaskScene, stretch

SUPPORTS, TOUCH = "supports", "touch"


class Attach(RobotStage, Propagator):
    """Attaches an object to a robot's tool where it is; backward, the object stood there before."""

    MOVES = ("object",)
    PROPERTIES = {
        "object": OBJECT,
        "to": Property(str, PARENT, "the robot to whose tool it is attached, or `robot.link`", meanings.name),
        "of": Property(
            (str, type(None)),
            None,
            "the robot that may hold it now and hands it over; none: nobody may",
            meanings.name,
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a link or a robot that the scene lacks."""
        yield from _no_link(self.known("to"), scene)
        yield from _no_robot(self.known("of"), scene)

    def refute(self, context: ProcedureContext, situation: Situation) -> Refusal | None:
        """A proof that the object is part of the scene, or too heavy for the gripper."""
        name, (robot, _, _) = self.known("object"), str(self.known("to")).partition(".")
        if name in context.scene.bodies and name not in situation.objects:
            return _immovable(name)
        known = name in situation.objects and robot in context.scene.robots
        return too_heavy(context.scene, situation, robot, name) if known else None

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with the object in the hand; everything attached to the object moves with it."""
        name, robot, link = properties["object"], *_link(scene, properties["to"])
        if name not in scene.situation.objects:
            return [_immovable(name)]
        if scene.holder(name) not in (None, properties["of"]):
            return [Refusal("constraint", f"{scene.holder(name)} holds {name} already", reads=frozenset({name}))]
        after = hung(scene, name, f"{robot}.{link}", _link_pose(scene, robot, link))
        heavy = too_heavy(scene.context.scene, after.situation, robot)
        if heavy is not None:
            return [heavy]
        motion = (_still(scene, robot, attach=((name, f"{robot}.{link}"),)),)
        return _checked(_standing(after, name), [robot], Result(after, motion=motion))

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, in which the object stands at the same pose, not yet in the hand."""
        name, robot, link = properties["object"], *_link(scene, properties["to"])
        if scene.holder(name) != robot:
            return [Refusal("constraint", f"{robot} does not hold {name}", reads=frozenset({name}))]
        before = hung(scene, name, "world", np.eye(4))
        motion = (_still(scene, robot, attach=((name, f"{robot}.{link}"),)),)
        return _checked(before, [robot], Result(before, motion=motion))


class Detach(RobotStage, Propagator):
    """Releases an object, which stays where it is; backward, it was in the hand before."""

    MOVES = ("object",)
    PROPERTIES = {
        "object": OBJECT,
        "of": Property(
            (str, type(None)),
            None,
            "the robot (backward: or `robot.link`) that releases it; none: whichever holds it",
            meanings.name,
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for a link or a robot that the scene lacks."""
        yield from _no_robot(self.known("of"), scene)
        yield from _no_link(self.known("of"), scene)

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with the object released into the world.

        If another robot already holds it, it stays in that hand.
        """
        name, given = properties["object"], properties["of"]
        robot = scene.holder(name)
        if robot is None:
            return [Refusal("constraint", f"nobody holds {name}", reads=frozenset({name}))]
        taken = given is not None and robot != given
        after = scene if taken else hung(scene, name, "world", np.eye(4))
        who = given if taken else robot
        return _checked(after, [who], Result(after, motion=(_still(scene, who, detach=(name,)),)))

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, in which the hand still holds the object at the same pose."""
        name, given = properties["object"], properties["of"]
        if given is None or scene.holder(name) is not None:
            return [Refusal("constraint", f"say of which robot {name} is let go", reads=frozenset({name}))]
        robot, link = _link(scene, given)
        if name not in scene.situation.objects:
            return [_immovable(name)]
        before = hung(scene, name, f"{robot}.{link}", _link_pose(scene, robot, link))
        return _checked(
            _standing(before, name), [robot], Result(before, motion=(_still(scene, robot, detach=(name,)),))
        )


class Join(RobotStage, Propagator):
    """Releases the part in a robot's hand, so that it is attached to the part with which it is mated."""

    MOVES = ("object",)
    READS = ("onto",)
    PROPERTIES = {
        "object": OBJECT,
        "onto": Property(str, PARENT, "the other part, which stands or is held by another robot", meanings.name),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """A message for two parts that no mate joins: nothing proves that they hold together."""
        name, onto = self.known("object"), self.known("onto")
        both = name in scene.bodies and onto in scene.bodies and scene.description is not None
        if both and not any(True for _ in scene.mates_between(name, onto)):
            yield f"no mate of the scene joins {name} and {onto}"

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene in which both parts are attached to each other at their present poses."""
        name, onto = properties["object"], properties["onto"]
        robot = scene.holder(name)
        if robot is None or scene.holder(onto) == robot:
            text = f"nobody brings {name} to {onto}"
            return [Refusal("constraint", text, reads=frozenset({name, onto}))]
        after = hung(scene, name, onto, scene.pose(onto))
        holder = after.holder(onto)
        heavy = None if holder is None else too_heavy(scene.context.scene, after.situation, holder)
        if heavy is not None:
            return [heavy]
        still = _still(scene, robot, attach=((name, onto),), detach=(name,))
        return _checked(after, [robot], Result(after, motion=(still,)))


class _Contacts(RobotStage, Propagator):
    PROPERTIES = {
        "pairs": Property(
            (list, tuple),
            doc="pairs of bodies, robots or `robot.link`; `supports`: what carries the other",
            wrong=meanings.pairs,
        ),
        "links": Property(
            str,
            "all",
            "which links a robot's name stands for: `touch` (those of its gripper) or `all`",
            meanings.one_of("all", "touch"),
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Names that the scene lacks, two kinds of supports, or links to touch although no robot has a gripper."""
        added = _added(self)
        for first, second in self.known("pairs") or ():
            for name in (str(first), str(second)):
                yield from _unknown(name, scene, added)
                if SUPPORTS in (first, second) and name != SUPPORTS:
                    yield from _uncarried(name, scene)
                gripper = scene.robots[name].gripper if name in scene.robots else None
                if (
                    name in scene.robots
                    and self.known("links") == TOUCH
                    and (gripper is None or not gripper.touch_links)
                ):
                    yield f"{name} has no gripper with links that touch"

    def _allowed(self, scene: TaskScene, properties: Values) -> Answers:
        carried = _carried(scene, properties, standing=True)
        unsupported = [name for name, pairs in carried.items() if not pairs]
        why = (why_unsupported(scene.context.surroundings, scene.situation, name) for name in unsupported)
        text = next((text for text in why if text is not None), None)
        if text is not None:
            return [Refusal("constraint", text, reads=frozenset(unsupported))]
        return [Result(scene.permitting(_pairs(scene, properties, carried)))]

    def _forbidden(self, scene: TaskScene, properties: Values) -> Answers:
        pairs = _pairs(scene, properties, _carried(scene, properties, standing=False))
        changed = scene.forbidding(pairs)
        robots = [name for pair in pairs for name in _movers(scene, pair)]
        return _checked(changed, dict.fromkeys(robots), Result(changed))


class AllowContact(_Contacts):
    """Permits contacts from here on; backward, they were forbidden before."""

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with more contacts permitted."""
        return self._allowed(scene, properties)

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with these contacts no longer permitted; a failure if things touch that no longer may."""
        return self._forbidden(scene, properties)


class ForbidContact(_Contacts):
    """Forbids contacts from here on; backward, they were permitted before."""

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with these contacts no longer permitted; a failure if things touch that no longer may."""
        return self._forbidden(scene, properties)

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with more contacts permitted."""
        return self._allowed(scene, properties)


def _immovable(name: str) -> Refusal:
    return Refusal("constraint", f"{name} is not movable: nobody takes it or lets it go", proof=True)


def _link(scene: TaskScene, to: str) -> tuple[str, str]:
    name, dot, link = to.partition(".")
    robot = scene.robot(name)
    if not dot and robot.tool is None:
        raise ValueError(f"{name} has no tool: name a link")
    return name, link if dot or robot.tool is None else robot.tool.frame


def _link_pose(scene: TaskScene, robot: str, link: str) -> Any:
    chosen = scene.robot(robot)
    at = candidate(chosen, scene.configuration(robot))
    if chosen.tool is not None and chosen.tool.frame == link:
        return at.pose(tool_frame(chosen))
    (pose,) = (scene.context.surroundings.links(robot, q)[link] for q in scene.situation.robots[robot])
    return pose


def _still(
    scene: TaskScene, robot: str, *, attach: tuple[tuple[str, str], ...] = (), detach: tuple[str, ...] = ()
) -> Stretch:
    there = stretch(scene, robot, "gripper", [scene.situation.configuration(robot)])
    return replace(there, attach=attach, detach=detach)


def _checked(scene: TaskScene, robots: Iterable[str], result: Result) -> Answers:
    for robot in robots:
        hit = scene.hit(robot)
        if hit is not None:
            asked = along(scene, robot, scene.configuration(robot))
            return [Refusal.collision(hit, question=asked)]
    return [result]


def _standing(scene: TaskScene, name: str) -> TaskScene:
    """The scene in which a grasped object may still touch what its group stands on, because nothing has moved yet."""
    return scene.permitting(_supported(scene, name, standing=True))


def _carried(scene: TaskScene, properties: Values, *, standing: bool) -> dict[str, list[Pair]]:
    """The pairs that `supports` stands for, by thing; see `_supported`."""
    names = [str(b if a == SUPPORTS else a) for a, b in properties["pairs"] if SUPPORTS in (a, b)]
    return {name: _supported(scene, name, standing=standing) for name in names}


def _added(stage: Stage) -> frozenset[str] | None:
    """The bodies that stages of the same task may add; None if not known."""
    top = stage
    while top.parent is not None:
        top = top.parent
    stages = top.walk() if isinstance(top, Container) else iter(())
    names = [s.known("body") for s in stages if isinstance(s, RobotStage) and s.properties.has("shape")]
    return None if None in names else frozenset(map(str, names))


def _unknown(name: str, scene: Scene, added: frozenset[str] | None) -> Iterator[str]:
    robot, dot, _ = name.partition(".")
    yield from _no_link(name, scene)
    known = {*scene.bodies, *scene.robots, SUPPORTS, *(added or ())}
    if added is not None and (robot if dot else name) not in (scene.robots if dot else known):
        yield f"nothing is called {name!r}, {did_you_mean(name, known) or 'there are ' + ', '.join(sorted(known))}"


def _uncarried(name: str, scene: Scene) -> Iterator[str]:
    """A message for `supports` of what nothing carries as long as it is in nobody's hand."""
    if name not in scene.movable and name.partition(".")[0] in {*scene.robots, *scene.bodies}:
        others = ", ".join(scene.movable) or "the scene has no object"
        yield f"{name} is no movable object, and {SUPPORTS!r} is what carries one: {others}"


def _no_link(name: str | None, scene: Scene) -> Iterator[str]:
    robot, dot, link = (name or "").partition(".")
    if dot and robot in scene.robots and link not in scene.robots[robot].links:
        links = scene.robots[robot].links
        yield f"{robot} has no link {link!r}, {did_you_mean(link, links) or 'it has ' + ', '.join(links)}"


def _no_robot(name: str | None, scene: Scene) -> Iterator[str]:
    robot = (name or "").partition(".")[0]
    if robot and robot not in scene.robots:
        hint = did_you_mean(robot, scene.robots) or f"it has {', '.join(scene.robots) or 'none'}"
        yield f"the scene has no robot {robot!r}, {hint}"


def _movers(scene: TaskScene, pair: Pair) -> list[str]:
    """The robots that can move one of two things."""
    found = []
    for name in pair:
        robot, dot, _ = name.partition(".")
        holder = robot if dot else scene.holder(name)
        if holder is not None and holder not in found:
            found.append(holder)
    return found


def _pairs(scene: TaskScene, properties: Values, carried: Mapping[str, list[Pair]]) -> list[Pair]:
    """The pairs of things that the property names: robots stand for their links, `supports` for the pairs in `carried`."""
    found: list[Pair] = []
    for first, second in properties["pairs"]:
        if SUPPORTS in (first, second):
            found.extend(carried[str(second if first == SUPPORTS else first)])
            continue
        for a in _things(scene, str(first), properties["links"]):
            found.extend((a, b) for b in _things(scene, str(second), properties["links"]))
    return list(dict.fromkeys(found))


def _supported(scene: TaskScene, name: str, *, standing: bool) -> list[Pair]:
    """Each member of an object's group with what supports it (if `standing`), or with what it is permitted to touch."""
    group: tuple[str, ...] = scene.situation.group(name)
    found: list[Pair] = []
    for member in group:
        if standing:
            others: Iterable[str] = supports(scene.context.surroundings, scene.situation, member)
        else:
            touched = {
                next(iter(pair - {member})) for pair in scene.permitted if member in pair and len(pair) == 2
            }
            others = sorted(thing for thing in touched if "." not in thing)
        found.extend((member, other) for other in others if other not in group)
    return found


def _things(scene: TaskScene, name: str, links: str) -> Sequence[str]:
    robots = scene.context.scene.robots
    if name not in robots:
        return (name,)
    gripper = robots[name].gripper
    if links == TOUCH:
        return () if gripper is None else gripper.touch_links
    return tuple(f"{name}.{link}" for link in robots[name].links)
