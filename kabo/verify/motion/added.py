"""Bodies that only planning knows: what stages of a task add, and padding. A report tells them, and when they are there.

A plan knows neither, and its certificate proves nothing of them; here all that moves is proven not to touch them.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any, Literal, get_args

import numpy as np

from kabo.arrays import Array
from kabo.language.scene_description import Shape
from kabo.plan import ObjectPose, Segment
from kabo.scene import element_of
from kabo.verify.motion.collision import Tally, check_pairs
from kabo.verify.motion.components import Components
from kabo.verify.motion.contacts.attachment_tree import AttachmentTree
from kabo.verify.motion.contacts.granted import Permits
from kabo.verify.motion.scene_model import SceneModel, matrix
from kabo.verify.motion.surfaces import Surface, surface
from kabo.verify.motion.sweep import Path, SweptBody
from kabo.verify.motion.windows import TIME_TOLERANCE, Window
from kabo.verify.report import Finding

Kind = Literal["box", "cylinder", "capsule", "sphere"]
KINDS: tuple[Kind, ...] = get_args(Kind)
SIZES = 3  # numbers of each kind of shape, as in scenes' meshes
Names = frozenset[str]
Changes = Sequence[Mapping[str, Any]]


class NoBodyError(ValueError):
    """What a report adds is no body, or is attached to nothing of the scene."""


@dataclass(frozen=True)
class AddedBody:
    """A body at a pose in the frame of `parent` (`world`, a body or `robot.link`), from one time to another [s]."""

    name: str
    parent: str
    parent_T: Array  # (4, 4)
    surface: Surface
    pads: bool
    begins: float
    ends: float

    def within(self, window: Window) -> bool:
        """Whether it is there while a window lasts."""
        return self.begins <= window.start + TIME_TOLERANCE and self.ends >= window.end - TIME_TOLERANCE


@dataclass
class AddedBodies:
    """The bodies of one motion, the pairs that may touch from one time to another, and the figures of their checks."""

    bodies: tuple[AddedBody, ...]
    permitted: tuple[tuple[Names, float, float], ...]
    tally: Tally = field(default_factory=Tally)
    begins_at: Mapping[str, Array] = field(default_factory=dict)  # of all robots; those that never move stay there

    @classmethod
    def of(cls, changes: Changes, segments: Sequence[Segment]) -> "AddedBodies":
        """What the changes of a report add to a motion of these segments; each takes effect at a segment's end.

        Raises:
            NoBodyError: a body has no possible shape or pose, or a segment does not exist.
        """
        bodies: list[AddedBody] = []
        open_: dict[tuple[str, bool], tuple[Mapping[str, Any], float]] = {}
        allowed: dict[Names, float] = {}
        permitted: list[tuple[Names, float, float]] = []
        for change in changes:
            kind, time = change["change"], _time(change["segment"], segments)
            if kind in ("add", "pad"):
                key = _key(change["body"], kind == "pad")
                if key in open_:
                    bodies.append(_body(*open_.pop(key), key[1], time))
                open_[key] = change["body"], time
            elif kind in ("remove", "unpad") and (key := (change["object"], kind == "unpad")) in open_:
                bodies.append(_body(*open_.pop(key), key[1], time))
            elif kind == "permit":
                allowed.update({frozenset(pair): time for pair in change["pairs"]})
            elif kind == "forbid":
                known = [frozenset(pair) for pair in change["pairs"]]
                permitted += [(pair, allowed.pop(pair), time) for pair in known if pair in allowed]
        bodies += [_body(*found, key[1], inf) for key, found in open_.items()]
        return cls(tuple(bodies), (*permitted, *((pair, time, inf) for pair, time in allowed.items())))

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the bodies, each once."""
        return tuple(dict.fromkeys(body.name for body in self.bodies))

    def check(
        self,
        node: str,
        window: Window,
        paths: tuple[Path, Path],
        things: tuple[Sequence[SweptBody], Sequence[SweptBody]],
        touching: Permits,
        world: SceneModel,
        holding: AttachmentTree,
    ) -> Iterator[Finding]:
        """The findings about added bodies that something touches in a window.

        Args:
            node: the id of the node.
            window: the window of time.
            paths: that of the robots that move, and a finer one.
            things: what moves along it, and what stands.
            touching: what the segments permit to touch.
            world: the scene. holding: where robots and objects are.
        """
        free = {pair for pair, begins, ends in self.permitted if begins <= window.start and ends >= window.end}
        free |= touching.pairs
        pairs: list[tuple[SweptBody, SweptBody]] = []
        for body in self.bodies:
            if not body.within(window):
                continue
            placed = _placed(body, paths[0], world, holding, {**self.begins_at, **holding.q})
            others = things[0] if placed.mount is None else (*things[0], *things[1])
            pairs += [(placed, other) for other in others if _meets(body, placed, other, free, world)]
        if pairs:
            yield from check_pairs(node, paths, pairs, Permits(), self.tally)


def _meets(body: AddedBody, placed: SweptBody, other: SweptBody, free: set[Names], world: SceneModel) -> bool:
    """Whether contact of an added body with another would be a fault: not where its parent may touch, too."""
    if other.name == body.parent or frozenset((body.name, other.name)) in free:
        return False
    if body.parent == "world":
        return True
    if (
        body.pads
        and placed.mount is not None
        and other.mount is not None
        and placed.mount.robot == other.mount.robot
    ):
        return False
    return frozenset((body.parent, other.name)) not in free and world.may_meet(body.parent, other.name)


def _placed(
    body: AddedBody, path: Path, world: SceneModel, holding: AttachmentTree, q: Mapping[str, Array]
) -> SweptBody:
    """The body where it stands, or on the robot that moves it."""
    robot, dot, link = body.parent.partition(".")
    mount, pose = None, np.eye(4)
    if dot:
        own = world.arms[robot].mounts[link]
        mount = own if robot in path.arms else None
        pose = world.arms[robot].pose(q[robot].tolist(), own)
    elif body.parent in holding.hung:
        mount = holding.mount(body.parent) if holding.holder(body.parent) in path.arms else None
        pose = holding.pose(body.parent)
    elif body.parent != "world":
        pose = world.scene.fixed_poses[body.parent]
    if mount is not None:
        return SweptBody(body.name, body.surface, mount=mount.carrying(body.parent_T))
    return SweptBody(body.name, body.surface, pose @ body.parent_T)


def configurations(components: Components, node: str) -> dict[str, Array]:
    """The configuration of every robot at a node, if it has one alone there."""
    found = {robot: components.values(node, (robot,)) for robot in components.scene.robots}
    return {robot: np.array([*values][0][0]) for robot, values in found.items() if len(values) == 1}


def require_known(added: AddedBodies, world: SceneModel) -> None:
    """Checks that the scene has what bodies are attached to.

    Raises:
        NoBodyError: it has not.
    """
    scene = world.scene
    for body in added.bodies:
        robot, dot, link = body.parent.partition(".")
        known = (
            link in world.arms[robot].mounts
            if dot and robot in world.arms
            else body.parent in {"world", *scene.bodies}
        )
        if not known:
            raise NoBodyError(f"{body.name} is attached to {body.parent}, which the scene does not have")


def _key(body: Mapping[str, Any], pads: bool) -> tuple[str, bool]:
    return (body["parent"] if pads else body["name"]), pads


def _time(segment: int | None, segments: Sequence[Segment]) -> float:
    if segment is None:
        return 0.0
    if not 0 <= segment < len(segments):
        raise NoBodyError(f"a change takes effect after segment {segment}, and there are {len(segments)}")
    return segments[segment].times[-1]


def _body(told: Mapping[str, Any], begins: float, pads: bool, ends: float) -> AddedBody:
    name, shape = told["name"], told["shape"]
    kind = next((each for each in KINDS if each in shape), None)
    size = () if kind is None or len(shape) > 1 else tuple(shape[kind])
    numbers = (*size, *told["position"], *told["quaternion"])
    possible = len(size) == SIZES and min(size) > 0.0 and any(told["quaternion"]) and all(map(isfinite, numbers))
    if kind is None or not possible:
        raise NoBodyError(f"{name} is no body: a shape has sizes above 0, a pose finite numbers")
    element = element_of(Shape(kind, size=(size[0], size[1], size[2])), None)
    pose = ObjectPose(told["parent"], tuple(told["position"]), tuple(told["quaternion"]))
    return AddedBody(name, told["parent"], matrix(pose), surface(element.mesh, (element,)), pads, begins, ends)
