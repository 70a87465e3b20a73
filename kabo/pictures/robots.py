"""The picture of a robot that somebody else described: at home, with what is planned, what grasps, and what stands."""

import numpy as np

from kabo.geometry_server import RobotModel
from kabo.pictures.drawing import Drawing, Label, Solid
from kabo.pictures.panels import png, titled
from kabo.pictures.views import ViewWishes, picture_of
from kabo.scene import link_poses

STANDING, ARM, HAND = "#8c8f94", "#3f7fbf", "#f29f3d"


def robot_picture(model: RobotModel) -> bytes:
    """The robot at home, or at zero without one, as PNG: the arm, the gripper, and what stands, in three colours."""
    robot = model.robot
    zero = np.clip(np.zeros(robot.tree.size), robot.tree.lower, robot.tree.upper)
    q = zero if model.home is None else model.home
    poses = link_poses(robot, tuple(q.tolist()))
    touching = () if model.gripper is None else model.gripper.touch_links
    solids = []
    for link in robot.links.values():
        if link.mesh is not None and len(link.mesh.faces):
            colour = STANDING if robot.stands(link.name) else ARM
            colour = HAND if link.name in touching else colour
            solids.append(Solid(link.name, link.mesh.vertices, link.mesh.faces, colour, poses[link.name]))
    where = "at home" if model.home is not None else "with all joints at zero"
    title = f"{model.name} {where}: arm blue, gripper orange, what stands grey"
    frame = model.hand.tool
    labels = (Label(f"tool frame {frame}", poses[frame][:3, 3], HAND),) if frame in poses else ()
    return png(titled(picture_of(Drawing(tuple(solids), labels=labels), ViewWishes(size=(900, 900))), title))
