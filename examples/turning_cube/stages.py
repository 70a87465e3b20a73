"""The stages of one's own with which a cube is turned: what is up, how to grip it, how to put it down [T Appendix B].

kabo task plan task.yaml --scene scene.yaml --stages stages.py --set face=blue
"""

from itertools import permutations, product

import numpy as np

from kabo.tasks import PARENT, Failure, Monitor, Property, Result, Wrapper, register
from kabo.tasks.robots.motion.directions import frame_of
from kabo.tasks.robots.motion.targets import frame_for, pose_target
from kabo.tasks.robots.stages.poses import local_pose

UP = np.array([0.0, 0.0, 1.0])
ANY = "any"


def normal(scene, cube, face):
    """The direction (3,) of a face out of the cube, in its own frame."""
    return np.asarray(scene.context.scene.bodies[cube].features[face].direction)


@register
class FaceUp(Wrapper):
    """Lets a success of its child pass if a face of the cube is up."""

    PROPERTIES = {"cube": Property(str, PARENT), "face": Property(str, PARENT)}

    def transform(self, solution, properties, seed):
        scene, cube, face = solution.end.scene, properties["cube"], properties["face"]
        if scene.pose(cube)[:3, :3] @ normal(scene, cube, face) @ UP > 0.99:
            return [Result(cost=solution.cost, comment=f"{face} is up")]
        return [Failure("constraint", f"{face} is not up")]


@register
class CubeGrasps(Monitor):
    """A grasp of the cube, and all that look like it by the cube's symmetry."""

    PROPERTIES = {"robot": Property(str, PARENT), "cube": Property(str, PARENT), "canonical_grasp": Property(dict)}

    def generate(self, scene, properties, seed):
        robot, grasp = properties["robot"], local_pose(properties["canonical_grasp"])
        for turn in symmetries():
            pose = scene.pose(properties["cube"]) @ turn @ grasp
            if (pose[:3, 2] @ UP) < -0.5:  # from above
                target = pose_target(scene, robot, frame_for(scene, robot, "tool.tcp"), pose)
                yield Result(scene, properties={"target": target})


@register
class CubePlaces(Monitor):
    """Ways to put the cube down with a face up; with any one up that is at a side where it was."""

    PROPERTIES = {
        "robot": Property(str, PARENT),
        "cube": Property(str, PARENT),
        "face": Property(str, PARENT, "a face, or `any`"),
        "at": Property(list, doc="where the middle of the cube is to be [m]"),
        "table": Property(str, PARENT),
    }

    def generate(self, scene, properties, seed):
        robot, cube, face = properties["robot"], properties["cube"], properties["face"]
        scene = scene.permitting([(cube, properties["table"])])
        for turn in symmetries():
            if face == ANY or turn[:3, :3] @ normal(scene, cube, face) @ UP > 0.99:
                pose = turn.copy()
                pose[:3, 3] = properties["at"]
                target = pose_target(scene, robot, frame_of(scene, robot, cube), pose)
                yield Result(scene, properties={"target": target})


def symmetries():
    """The 24 turns (4, 4) of a cube."""
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        turn = np.eye(4)
        turn[:3, :3] = np.diag(signs)[:, order]
        if np.linalg.det(turn) > 0.0:
            yield turn
