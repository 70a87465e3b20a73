"""What `kabo robot` found, for people: a few lines, and a picture of the robot at home."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from kabo.displays import counted
from kabo.geometry_server.robot_models.model import RobotModel
from kabo.meshes.pictures import PART_COLOURS, draw_bodies
from kabo.scene import link_poses

STANDING_COLOUR, ARM_COLOUR, HAND_COLOUR = "#8c8f94", PART_COLOURS[0], PART_COLOURS[1]


def robot_summary(model: RobotModel) -> Iterator[str]:
    """The lines that tell what was found, and what the user should look at."""
    robot, gripper = model.robot, model.gripper
    shaped = [link for link in robot.links.values() if link.elements]
    visual = f", of {counted(len(model.visual), 'link')} the visual one" if model.visual else ""
    yield f"{model.name}: {counted(len(shaped), 'link')} with geometry{visual}"
    yield f"  plans {counted(len(model.hand.arm), 'joint')}: {', '.join(model.hand.arm)}"
    if gripper is None:
        yield f"  no gripper (a scene can mount one); tool frame {model.hand.tool}: check that its z axis points out"
    elif gripper.opening is None:
        yield f"  gripper {', '.join(model.hand.joints[:4])}: not measured, {gripper.unmeasured}"
    else:
        opened, closed = (f"{round(1000.0 * gap, 1) + 0.0:g}" for gap in gripper.opening)
        yield f"  gripper {', '.join(model.hand.joints)}: {closed} to {opened} mm; tool frame {model.hand.tool}"
    if model.home is None:
        yield "  home: none found without self-collision"
    else:
        yield f"  home: free of itself, {1000.0 * model.margin:.3g} mm and more between links"
    for pair in model.always:
        yield f"  {pair.first} and {pair.second} touch {pair.when}: allowed"
    for why, links in model.hull_reasons.items():
        yield f"  taken as {counted(len(links), 'hull')}, {why}: {', '.join(links)}"
    if model.others:
        yield f"  other arms stand still; choose one by --tip: {', '.join(each.tool for each in model.others)}"


def draw_robot_model(path: Path, model: RobotModel) -> None:
    """Draws the robot at home, or at zero without one: the arm, the gripper, and what stands, in three colours (PNG)."""
    robot = model.robot
    q = (
        np.clip(np.zeros(robot.tree.size), robot.tree.lower, robot.tree.upper)
        if model.home is None
        else model.home
    )
    poses = link_poses(robot, q.tolist())
    touching = () if model.gripper is None else model.gripper.touch_links
    bodies = []
    for link in robot.links.values():
        if link.mesh is not None and len(link.mesh.faces):
            colour = STANDING_COLOUR if robot.stands(link.name) else ARM_COLOUR
            colour = HAND_COLOUR if link.name in touching else colour
            pose = poses[link.name]
            placed = link.mesh.vertices @ pose[:3, :3].T + pose[:3, 3]
            bodies.append(((placed, link.mesh.faces), colour))
    where = "at home" if model.home is not None else "with all joints at zero"
    draw_bodies(path, bodies, title=f"{model.name} {where}: arm blue, gripper orange, what stands grey")
