"""A scene in the view document: its robots with their joints and links, its bodies and regions, where all stands."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from kabo.arrays import Array
from kabo.language.scene_description import Feature
from kabo.scene import PRISMATIC, Body, GeometricState, Region, Robot, Scene, Sensor
from kabo.viewer.content.arrays import Arrays
from kabo.viewer.content.colours import colour_of_name
from kabo.viewer.content.document import View
from kabo.viewer.content.meshes import Detail, Meshes
from kabo.viewer.content.regions import region_mesh
from kabo.viewer.content.shapes import Shapes

if TYPE_CHECKING:
    from kabo.geometry_server import SceneEnclosures


def scene_view(
    scene: Scene, arrays: Arrays, *, detail: Detail = "low", enclosures: "SceneEnclosures | None" = None
) -> View:
    """The part `scene` of a view document; lengths in m, angles in rad, matrices row by row.

    Args:
        scene: the scene.
        arrays: the arrays of the document, to which meshes are added.
        detail: whether meshes have as many triangles as in their files.
        enclosures: the convex parts that are shown beside the meshes, as far as they are there; None: none are.
    """
    meshes = Meshes(arrays)
    shapes = Shapes(scene, meshes, detail, enclosures)
    return {
        "name": scene.name,
        "epsilon": scene.epsilon,
        "start": state_view(scene, scene.start),
        "robots": [_robot(robot, shapes) for robot in scene.robots.values()],
        "bodies": [_body(scene, body, shapes) for body in scene.bodies.values()],
        "regions": [_region(region, meshes) for region in scene.regions.values()],
        "allowed": sorted(sorted(pair) for pair in scene.allowed),
        "meshes": meshes.listed,
    }


def state_view(scene: Scene, state: GeometricState) -> View:
    """A state: the values of all joints by robot, and the parent and the pose of each movable object."""
    return {
        "robots": {
            name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in state.robots.items()
        },
        "objects": {
            name: {"parent": held.parent, "position": list(held.position), "quaternion": list(held.quaternion)}
            for name, held in state.objects.items()
        },
    }


def _matrix(pose: Array) -> list[float]:
    return [float(value) for value in pose.ravel()]


# ---------------------------------------------------------------------------------------------------------- robots
def _robot(robot: Robot, shapes: Shapes) -> dict[str, Any]:
    return {
        "name": robot.name,
        "joints": [_joint(robot, j) for j in range(1, len(robot.tree.parent))],
        "values": [_value(robot, i) for i in range(len(robot.joint_names))],
        "links": [
            {
                "name": link.name,
                "joint": link.joint - 1,
                "origin": _matrix(link.joint_T_link),
                **shapes.of(f"{robot.name}.{link.name}", link.elements),
            }
            for link in robot.links.values()
        ],
        "configurations": {
            name: dict(zip(robot.planned_joints, values, strict=True))
            for name, values in robot.configurations.items()
        },
        "hand": None
        if robot.gripper is None
        else {"open": dict(robot.gripper.open), "closed": dict(robot.gripper.closed)},
        "tool": None if robot.tool is None else {"frame": robot.tool.frame, **_features(robot.tool.features)},
        "sensors": [_sensor(sensor) for sensor in robot.sensors.values()],
    }


def _joint(robot: Robot, j: int) -> dict[str, Any]:
    """A joint: it takes `ratio` times the value called `source`, and `shift`; its axis is the z of its own frame."""
    tree = robot.tree
    rotation, translation = tree.placement[j, :9].reshape(3, 3), tree.placement[j, 9:]
    origin = [*rotation[0], translation[0], *rotation[1], translation[1], *rotation[2], translation[2], 0, 0, 0, 1]
    moves = tree.ratio[j] != 0.0
    return {
        "name": str(robot.model.names[j]),
        "type": "prismatic" if tree.kind[j] == PRISMATIC else "revolute",
        "parent": int(tree.parent[j]) - 1,
        "origin": [float(each) for each in origin],
        "axis": [0, 0, 1],
        "source": robot.joint_names[int(tree.source[j])] if moves else None,
        "ratio": float(tree.ratio[j]),
        "shift": float(tree.shift[j]),
    }


def _value(robot: Robot, i: int) -> dict[str, Any]:
    """One value of a configuration, with its limits."""
    name = robot.joint_names[i]
    kinds = [int(robot.tree.kind[j]) for j in range(1, len(robot.tree.parent)) if robot.model.names[j] == name]
    return {
        "name": name,
        "planned": i < robot.planned,
        "unit": "m" if kinds and kinds[0] == PRISMATIC else "rad",
        "lower": float(robot.tree.lower[i]),
        "upper": float(robot.tree.upper[i]),
    }


def _sensor(sensor: Sensor) -> dict[str, Any]:
    return {
        "name": sensor.name,
        "link": sensor.link,
        "origin": _matrix(sensor.link_T_sensor),
        "angles": list(sensor.angles),
        "near": sensor.near,
        "far": sensor.far,
    }


# ---------------------------------------------------------------------------------------------- bodies and regions
def _body(scene: Scene, body: Body, shapes: Shapes) -> dict[str, Any]:
    fixed = scene.fixed_poses.get(body.name)
    return {
        "name": body.name,
        "movable": body.movable,
        "colour": colour_of_name(body.name),
        "pose": None if fixed is None else _matrix(fixed),
        "mass": body.mass,
        **shapes.of(body.name, body.elements),
        "grasps": sorted(body.grasps),
        "placements": sorted(body.placements),
        **_features(body.features),
    }


def _features(features: Mapping[str, Feature]) -> dict[str, Sequence[Any]]:
    return {
        "features": [
            {
                "name": name,
                "kind": each.kind,
                "origin": list(each.origin),
                "direction": None if each.direction is None else list(each.direction),
            }
            for name, each in features.items()
        ]
    }


def _region(region: Region, meshes: Meshes) -> dict[str, Any]:
    return {
        "name": region.name,
        "pose": _matrix(region.world_T_region),
        "support": region.support,
        "shapes": {"original": [meshes.shape(region_mesh(region))]},
    }
