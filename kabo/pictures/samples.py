"""Samples of a grasp as a picture: hands where constraints allow them, as glass around the object."""

from dataclasses import replace

import numpy as np

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.pictures.drawing import Drawing, Glass, Solid
from kabo.pictures.scenes import ORANGE, carried_by_tool, scene_drawing
from kabo.scene import Robot, Scene, link_poses

OPTION = "--samples"
FORM = "write ROBOT:OBJECT.GRASP, as left:bottle_1.side"
SHOWN, OPACITY = 10, 0.55  # hands that are drawn


def samples_drawing(scene: Scene, wanted: str) -> tuple[Drawing, str]:
    """The scene with the robot's hand at many samples of a grasp, and a line of figures.

    Samples fulfil the constraints of the grasp; whether they are free of collision is not asked.

    Args:
        scene: the scene. wanted: `ROBOT:OBJECT.GRASP`.

    Raises:
        InputError: one of these does not exist, or the constraints cannot be fulfilled.
    """
    robot, thing, grasp = _parsed(scene, wanted)
    from kabo.geometry_server import GeometryServer  # compiles kernels: only this picture needs them

    family = scene.bodies[thing].grasps[grasp]
    try:
        found = GeometryServer(scene).sample(family.constraints, robot.name, this=thing)
    except ValueError as error:
        raise _refusal(str(error), FORM) from None
    if not len(found):
        hint = "look at it: `kabo view`; `kabo check` says what is out of reach"
        raise _refusal(f'{robot.name} finds no sample of "{grasp}" of {thing} where it stands', hint)
    shown = found[np.linspace(0, len(found) - 1, min(SHOWN, len(found))).astype(int)]
    # Each hand is glass of its own: its outline stays visible behind that of others.
    hands = tuple(Glass(_hand(robot, tuple(q.tolist()), number), OPACITY) for number, q in enumerate(shown))
    drawing = scene_drawing(scene)
    # The picture holds the hands and what they grasp; the rest is there as far as there is room.
    solids = tuple(replace(each, weight=1.0 if each.name == thing else 0.0) for each in drawing.solids)
    around = tuple(
        replace(each, solids=tuple(replace(s, weight=0.0) for s in each.solids)) for each in drawing.glass
    )
    glass = (*around, *hands)
    figures = f"{robot.name} grasps {thing} by {grasp}: {len(found)} samples, {len(shown)} drawn"
    return Drawing(solids, glass, labels=drawing.labels), figures


def _parsed(scene: Scene, wanted: str) -> tuple[Robot, str, str]:
    name, colon, rest = wanted.partition(":")
    thing, dot, grasp = rest.partition(".")
    if not (colon and dot):
        raise _refusal(f'"{wanted}" does not name a robot and a grasp', FORM)
    _require(name, list(scene.robots), "robot")
    with_grasps = [body for body in scene.bodies if scene.bodies[body].grasps]
    _require(thing, with_grasps, "object with grasps")
    _require(grasp, list(scene.bodies[thing].grasps), f"grasp of {thing}")
    return scene.robots[name], thing, grasp


def _require(name: str, known: list[str], what: str) -> None:
    if name not in known:
        listed = f"there are {', '.join(known)}" if known else "name a problem: its objects stand in its scene"
        hint = did_you_mean(name, known) or listed
        raise _refusal(f'there is no {what} "{name}"', hint)


def _refusal(message: str, hint: str) -> InputError:
    return InputError([Diagnostic(OPTION, 1, 1, message, hint)])


def _hand(robot: Robot, q: tuple[float, ...], number: int) -> tuple[Solid, ...]:
    """The links of the hand in one configuration; of a robot without a tool, all links."""
    poses = link_poses(robot, q)
    names = carried_by_tool(robot)
    found = []
    for name in names:
        mesh = robot.links[name].mesh
        if mesh is not None and len(mesh.faces):
            found.append(Solid(f"sample {number} {name}", mesh.vertices, mesh.faces, ORANGE, poses[name], 0.02))
    return tuple(found)
