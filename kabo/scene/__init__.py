"""The scene room: robots, bodies, features, regions, and the immutable geometric state.

The package turns the language's scene description and its files into arrays; it does not depend on collision
checks, sampling or motion.
"""

from kabo.meshes import Mesh, Rounding, load_mesh
from kabo.scene.bounds import MAX_DISTANCE
from kabo.scene.changes import beginning_at, with_change, with_hand_action
from kabo.scene.drives import BASE_VALUES, Drive
from kabo.scene.elements import Element, ElementKind, is_open, one_mesh, with_hulls
from kabo.scene.inner_meshes import inner_mesh
from kabo.scene.kept import KeptScenes, memory_of
from kabo.scene.motion_limits import motion_limits
from kabo.scene.robots import Gripper, Link, Robot, Tool, link_pose, link_poses
from kabo.scene.scene import Body, Region, Scene, attachment, load_scene, world_T
from kabo.scene.sensors import Sensor, beyond_angle
from kabo.scene.shapes import element_of, mesh_of
from kabo.scene.state import Attachment, Component, Configuration, GeometricState
from kabo.scene.structure import NoStructure, Structure, structure_of
from kabo.scene.tree import PRISMATIC, REVOLUTE, KinematicTree

__all__ = [
    "MAX_DISTANCE",
    "BASE_VALUES",
    "Drive",
    "PRISMATIC",
    "REVOLUTE",
    "Attachment",
    "Body",
    "Component",
    "Element",
    "ElementKind",
    "Configuration",
    "GeometricState",
    "Gripper",
    "KinematicTree",
    "Link",
    "Mesh",
    "NoStructure",
    "Region",
    "Robot",
    "Rounding",
    "Scene",
    "Sensor",
    "Structure",
    "Tool",
    "attachment",
    "beginning_at",
    "beyond_angle",
    "element_of",
    "inner_mesh",
    "is_open",
    "link_pose",
    "link_poses",
    "load_mesh",
    "KeptScenes",
    "memory_of",
    "load_scene",
    "mesh_of",
    "motion_limits",
    "one_mesh",
    "structure_of",
    "with_change",
    "with_hand_action",
    "with_hulls",
    "world_T",
]
