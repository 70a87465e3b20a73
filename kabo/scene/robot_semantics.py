"""Robots with what their SRDF file and the scene say beside the URDF: planned joints, configurations, contacts, tool."""

from collections.abc import Collection, Sequence
from dataclasses import replace

from kabo.language.scene_description import RobotDescription
from kabo.scene.robots import Robot, Tool
from kabo.scene.semantics import Groups, configurations, own_contacts
from kabo.scene.urdf_file import refusal


def with_groups(
    description: RobotDescription, groups: Groups, others: Collection[str], names: Sequence[str]
) -> RobotDescription:
    """The description with its planned joints by name, as its group and the passive joints of the SRDF say.

    Args:
        description: of a robot.
        groups: of its SRDF file.
        others: joints that are not planned: those of the gripper, and mimic joints.
        names: all joints that move, in the order of the tree.

    Raises:
        InputError: the group has no joint that can be planned.
    """
    semantics = description.semantics
    if semantics is None or description.joints is not None:
        return description
    candidates = [name for name in names if name in groups.joints and name not in others]
    if description.joint_group is not None:
        chosen = set(groups.joints_of(description.joint_group))
        planned = tuple(name for name in candidates if name in chosen)
        if not planned:
            said = f'group "{description.joint_group}" of {semantics.path.name} has no joint that can be planned'
            raise refusal(description.place, said, "name another group, or list the joints")
    else:
        planned = tuple(name for name in candidates if name not in semantics.passive)
    return replace(description, joints=planned)


def with_semantics(robot: Robot, description: RobotDescription, groups: Groups) -> Robot:
    """The robot with the configurations and the contacts of its SRDF, and the tool frame of its one end effector.

    Raises:
        InputError: `allowed_contacts` of the description name links that the robot does not have.
    """
    semantics = description.semantics
    if semantics is None and not description.contacts:
        return robot
    bounds = zip(robot.tree.lower.tolist(), robot.tree.upper.tolist(), strict=True)
    limits = dict(zip(robot.joint_names, bounds, strict=True))
    tool = robot.tool
    ends = () if semantics is None else semantics.end_effectors
    if tool is None and len(ends) == 1 and ends[0].parent_link in robot.links:
        tool = Tool(ends[0].parent_link, {})
    links = tuple(robot.links)
    return replace(
        robot,
        configurations=configurations(semantics, robot.planned_joints, limits, robot.configurations),
        allowed=own_contacts(description.contacts, semantics, links, groups, robot.name),
        groups=groups,
        tool=tool,
    )
