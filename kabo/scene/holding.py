"""Whether grippers can hold what they may grasp: by force and friction, at rest [docs/reference/scenes.md#motion]."""

from collections.abc import Iterator

from kabo.errors import About, Diagnostic
from kabo.language.formulas import Place
from kabo.language.scene_description import RobotDescription, SceneDescription
from kabo.scene.robots import GRAVITY, Gripper
from kabo.scene.scene import Body, Scene

SHOWN_BODIES = 4  # that are named in a warning


def weak_grippers(scene: Scene, description: SceneDescription) -> Iterator[Diagnostic]:
    """A warning for each gripper whose force cannot hold all bodies that it may grasp, even at rest."""
    for name, robot in scene.robots.items():
        if robot.gripper is None or robot.gripper.force is None:
            continue
        heavy = [
            body for body in scene.bodies.values() if _may_grasp(body, name) and not robot.gripper.holds(body.mass)
        ]
        if heavy:
            yield _warning(description.robots[name], robot.gripper, heavy)


def _may_grasp(body: Body, robot: str) -> bool:
    return body.movable and any(each.robots is None or robot in each.robots for each in body.grasps.values())


def _warning(robot: RobotDescription, gripper: Gripper, heavy: list[Body]) -> Diagnostic:
    given = robot.gripper
    at = (None if given is None else given.force_place or given.place) or robot.place or Place("scene", 1, 1)
    names = ", ".join(f'"{body.name}"' for body in heavy[:SHOWN_BODIES])
    more = f" and {len(heavy) - SHOWN_BODIES} more" if len(heavy) > SHOWN_BODIES else ""
    mass = max(body.mass or 0.0 for body in heavy)
    text = f'"{robot.name}" cannot hold {names}{more}, even at rest: {gripper.too_weak_for(mass)}'
    hint = f"write a force of at least {mass * GRAVITY / gripper.friction:.3g} N, or the true mass and friction"
    about = About((robot.name, *(body.name for body in heavy)))
    return Diagnostic(at.file, at.line, at.column, text, hint, at.length, "warning", about=about)
