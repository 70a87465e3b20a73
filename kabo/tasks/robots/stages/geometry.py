"""Stages that add geometry for some stages only: additional bodies, and padding around things [T 3.9]."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kabo.errors import did_you_mean
from kabo.geometry_server import Refusal, Situation, extra, padding
from kabo.language.scene_description import Shape
from kabo.scene import Scene
from kabo.scene.transforms import quaternion
from kabo.tasks.core import Propagator, Property, Result
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
        if self.known("body") in scene.bodies or self.known("body") in scene.robots:
            yield f"the scene has {self.known('body')!r} already: give the added body a new name"
        yield from _unknown(self.known("parent"), scene, ("world",))

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with the added body; a failure if a robot collides with the body."""
        pose = local_pose(properties["pose"])
        position = tuple(float(v) for v in pose[:3, 3])
        shape = shape_of(properties["shape"])
        added = extra(properties["body"], properties["parent"], shape, position, quaternion(pose))  # type: ignore[arg-type]
        after = scene.adding(added)
        return _checked(after, scene.context.scene.robots, Result(after))

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene without the body."""
        return [Result(scene.removing(properties["body"]))]


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
        """Messages for things that the scene lacks."""
        for name in self.known("things") or ():
            yield from _unknown(str(name), scene)

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene with padding; a failure if anything collides with the padding."""
        return self._padded(scene, properties)

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, without the padding."""
        return [Result(scene.removing(*map(padding_name, properties["things"])))]

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

    def forward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene without padding."""
        return [Result(scene.removing(*map(padding_name, properties["things"])))]

    def backward(self, scene: TaskScene, properties: Values, seed: int) -> Answers:
        """The scene before the stage, with the padding."""
        return self._padded(scene, properties)


def _unknown(name: str | None, scene: Scene, others: Sequence[str] = ()) -> Iterator[str]:
    links = [f"{robot.name}.{link}" for robot in scene.robots.values() for link in robot.links]
    known = [*others, *scene.bodies, *links]
    if name is not None and name not in known:
        yield f"nothing is called {name!r}: name a body or `robot.link`, {did_you_mean(name, known) or 'there is none'}"


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
