"""Stages that add geometry for some stages only: additional bodies, and padding around things [T 3.9]."""

from collections.abc import Iterator, Sequence
from itertools import takewhile
from typing import Any

import numpy as np

from kabo.errors import did_you_mean
from kabo.geometry_server import Refusal, Situation, extra, padding
from kabo.language.scene_description import Shape
from kabo.scene import Link, Scene
from kabo.scene.transforms import quaternion
from kabo.tasks.core import Container, Propagator, Property, Result, Stage
from kabo.tasks.core.model.results import Answers
from kabo.tasks.core.model.stages import Values
from kabo.tasks.robots import meanings
from kabo.tasks.robots.declaring import RobotStage
from kabo.tasks.robots.scenes import TaskScene
from kabo.tasks.robots.stages.changes import _checked
from kabo.tasks.robots.stages.poses import local_pose


class AddGeometry(RobotStage, Propagator):
    """Adds a body `body`, of a shape as in scenes, on `parent` at `pose`.

    Backward, it did not exist before.
    """

    PROPERTIES = {
        "body": Property(str, doc="a new name for it", wrong=meanings.name),
        "shape": Property(dict, doc="{box | cylinder | sphere | capsule: …}", wrong=meanings.shape),
        "parent": Property(str, "world", "`world`, a body or `robot.link`", meanings.name),
        "pose": Property(dict, {}, "{position, quaternion or rpy} in the parent's frame; empty: its origin"),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages if the scene lacks the parent, or has a thing of the new name."""
        name = self.known("body")
        if name in ("world", *scene.bodies, *scene.robots, *scene.regions, *_links(scene)):
            yield f"the scene has {name!r} already: give the added body a new name"
        yield from _unknown(self.known("parent"), scene, ("world",))

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with the added body; a failure if a robot collides with it, or one of its name is there already."""
        name = properties["body"]
        if any(each.name == name for each in scene.extras):
            return [
                Refusal(
                    "constraint",
                    f"a body called {name!r} is there already: give this one another name, or remove that one first",
                )
            ]
        pose = local_pose(properties["pose"])
        position = tuple(float(v) for v in pose[:3, 3])
        shape = shape_of(properties["shape"])
        added = extra(name, properties["parent"], shape, position, quaternion(pose))  # type: ignore[arg-type]
        after = scene.adding(added)
        return _checked(after, scene.context.scene.robots, Result(after))

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene without the body; a failure if it is not there, since nothing would have avoided it."""
        name = properties["body"]
        if all(each.name != name for each in scene.extras):
            text = (
                f"the scene after it has no added body {name!r}, and is planned first: add it before the connector"
            )
            return [Refusal("constraint", text)]
        return [Result(scene.removing(name))]


class RemoveGeometry(RobotStage, Propagator):
    """Removes added bodies, or padding, by name; to plan backward use `AddGeometry` or `Pad`."""

    PROPERTIES = {"bodies": Property((list, tuple), doc="the names of the bodies", wrong=meanings.names())}

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene without the added bodies that the property names; a failure if one is not there."""
        names, there = list(map(str, properties["bodies"])), [extra.name for extra in scene.extras]
        missing = next((name for name in names if name not in there), None)
        if missing is not None:
            hint = did_you_mean(missing, there) or f"there is {', '.join(there) or 'none'}"
            return [Refusal("constraint", f"no added body is called {missing!r}, {hint}")]
        return [Result(scene.removing(*names))]


class Pad(RobotStage, Propagator):
    """Adds a cylinder around each thing, with `distance` [m] on all sides, for the stages up to `Unpad`.

    A thing may touch its padding and what it may touch itself.
    """

    PROPERTIES = {
        "things": Property(
            (list, tuple), doc="bodies or `robot.link`; empty: nothing is padded", wrong=meanings.names(empty=True)
        ),
        "distance": Property(
            float, doc="distance to keep around them [m]", wrong=meanings.at_least(0.0, above=True)
        ),
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """Messages for things that the scene lacks, or that have no shape."""
        for name in map(str, self.known("things") or ()):
            unknown = list(_unknown(name, scene))
            yield from unknown
            if not unknown and "." in name and _link(scene, name).mesh is None:
                yield f"{name} has no geometry: there is nothing to pad"

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with padding; a failure if anything collides with the padding."""
        return self._padded(scene, properties)

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, without the padding; a failure if it is not there."""
        names, there = list(map(str, properties["things"])), {extra.name for extra in scene.extras}
        missing = next((name for name in names if padding_name(name) not in there), None)
        if missing is not None:
            text = (
                f"the scene after it has no padding of {missing}, and is planned first: "
                "let an Unpad follow, or pad before the connector"
            )
            return [Refusal("constraint", text)]
        return [Result(scene.removing(*map(padding_name, names)))]

    @staticmethod
    def _padded(scene: TaskScene, properties: Values) -> Answers:
        padded = [_padding(scene, str(name), properties["distance"]) for name in properties["things"]]
        after = scene.adding(*padded)
        return _checked(after, scene.context.scene.robots, Result(after))


class Unpad(Pad):
    """Removes padding; backward, it existed before, and nothing may collide with it."""

    PROPERTIES = {
        "distance": Property(
            float,
            0.0,
            "backward: distance to keep around them [m]; 0: only their cylinders",
            meanings.at_least(0.0),
        )
    }

    def faults(self, scene: Scene, start: Situation | None = None) -> Iterator[str]:
        """As of `Pad`, and messages for things that no stage before it can have padded."""
        yield from super().faults(scene, start)
        for name in map(str, self.known("things") or ()):
            if not any(_may_pad(stage, name) for stage in _before(self)):
                yield f"nothing before it pads {name!r}: name what a Pad before it names"

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene without padding."""
        return [Result(scene.removing(*map(padding_name, properties["things"])))]

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, with the padding."""
        return self._padded(scene, properties)


def _before(stage: Stage) -> Iterator[Stage]:
    """The stages of the task that come before one, in order of time, with the containers around it."""
    top = stage
    while top.parent is not None:
        top = top.parent
    every = top.walk() if isinstance(top, Container) else iter(())
    return takewhile(lambda each: each is not stage, every)


def _may_pad(stage: Stage, name: str) -> bool:
    """Whether there may be padding around a thing after a stage; of stages of users nothing is known."""
    if isinstance(stage, Pad):
        things = None if isinstance(stage, Unpad) else stage.known("things")
        return things is None or name in map(str, things)
    own = isinstance(stage, (RobotStage, Container)) or type(stage).__module__.startswith("kabo.")
    return not own or stage.properties.has("scene")


def _links(scene: Scene) -> list[str]:
    return [f"{robot.name}.{link}" for robot in scene.robots.values() for link in robot.links]


def _link(scene: Scene, name: str) -> Link:
    robot, _, link = name.partition(".")
    return scene.robots[robot].links[link]


def _unknown(name: str | None, scene: Scene, others: Sequence[str] = ()) -> Iterator[str]:
    known = [*others, *scene.bodies, *_links(scene)]
    if name is not None and name in scene.robots:
        yield f"{name!r} is a robot: name one of its links, as `{name}.{next(iter(scene.robots[name].links))}`"
    elif name in scene.regions:
        yield f"{name!r} is a region: name a body or `robot.link`"
    elif name is not None and name not in known:
        hint = did_you_mean(name, known)
        yield f"nothing is called {name!r}: name a body or `robot.link`{'' if hint is None else f', {hint}'}"


def padding_name(name: Any) -> str:
    """The name that the added body has which pads a thing."""
    return f"padding of {name}"


def _padding(scene: TaskScene, name: str, distance: float) -> Any:
    mesh = scene.context.surroundings.mesh(name)
    if mesh is None:
        raise ValueError(f"{name} has no geometry")
    return padding(padding_name(name), name, mesh.vertices, distance)


def shape_of(given: Any) -> Shape:
    """The shape that {box | cylinder | sphere | capsule: …} describes.

    Raises:
        ValueError: the value describes none of these shapes.
    """
    if isinstance(given, dict) and "box" in given:
        x, y, z = (float(v) for v in np.asarray(given["box"], float))
        return Shape("box", size=(x, y, z))
    if isinstance(given, dict) and "cylinder" in given:
        radius, height = float(given["cylinder"]["radius"]), float(given["cylinder"]["height"])
        return Shape("cylinder", size=(radius, radius, height))
    if isinstance(given, dict) and "capsule" in given:
        radius, length = float(given["capsule"]["radius"]), float(given["capsule"]["length"])
        return Shape("capsule", size=(radius, radius, length))
    if isinstance(given, dict) and "sphere" in given:
        radius = float(given["sphere"]["radius"])
        return Shape("sphere", size=(radius, radius, radius))
    known = "{box: [x, y, z]}, {cylinder: {radius, height}}, {sphere: {radius}} or {capsule: {radius, length}}"
    raise ValueError(f"a shape is {known}, not {given!r}")
