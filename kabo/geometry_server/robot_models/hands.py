"""Which joints of a robot are an arm's and which a gripper's: by the tree of the URDF and by names."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.scene.semantics import JointEnds

LEAST_ARM = 4  # joints of an arm without a gripper
HAND_WORDS = re.compile(r"gripper|finger|hand|jaw|thumb|knuckle|claw|pinch", re.IGNORECASE)
ARM_WORDS = re.compile(r"wrist|arm|elbow|shoulder|roll|pitch|yaw", re.IGNORECASE)
TOOL_WORDS = re.compile(r"tcp|grasp|tool|eef?$|end_?effector", re.IGNORECASE)


@dataclass(frozen=True)
class Hand:
    """The end of an arm.

    Args:
        arm: the joints from the robot's first link on, those that move on their own.
        joints: the joints of the gripper that move on their own.
        moved: all joints of the gripper that move, mimic joints as well.
        mount: the last link before the joints of the gripper.
        tool: the link whose frame is the tool frame.
    """

    arm: tuple[str, ...]
    joints: tuple[str, ...]
    moved: tuple[str, ...]
    mount: str
    tool: str

    @property
    def is_arm(self) -> bool:
        """Whether it holds something, or has joints enough to reach: no wheel, no head."""
        return bool(self.joints) or len(self.arm) >= LEAST_ARM


@dataclass(frozen=True)
class Tree:
    """The joints of a URDF as a tree; `mimics` are those that follow another joint."""

    joints: Mapping[str, JointEnds]
    mimics: frozenset[str]

    @property
    def above(self) -> dict[str, str]:
        """The joint above each link."""
        return {ends.child: name for name, ends in self.joints.items()}

    def moves(self, joint: str) -> bool:
        """Whether a joint moves, on its own or as a mimic."""
        return self.joints[joint].kind != "fixed"

    def is_hand(self, joint: str) -> bool:
        """Whether a joint that moves is a gripper's: by its name, or as one of several that move links of such names.

        Where each joint would be one, none is: a finger or a hand by itself is an arm.
        """
        return joint in self._named_as_hand and not self._named_as_hand.issuperset(self._moving)

    @cached_property
    def _moving(self) -> frozenset[str]:
        return frozenset(name for name in self.joints if self.moves(name) and name not in self.mimics)

    @cached_property
    def _named_as_hand(self) -> frozenset[str]:
        return frozenset(name for name in self.joints if self._is_named_as_hand(name))

    def _is_named_as_hand(self, joint: str) -> bool:
        ends = self.joints[joint]
        if not self.moves(joint):
            return False
        if HAND_WORDS.search(joint):
            return True
        if ARM_WORDS.search(joint) or not HAND_WORDS.search(ends.child):
            return False
        beside = [name for name, other in self.joints.items() if other.parent == ends.parent and self.moves(name)]
        return ends.kind == "prismatic" or len(beside) > 1

    def way(self, link: str) -> list[str]:
        """The joints from the first link to a link."""
        above, found = self.above, []
        while link in above:
            found.append(above[link])
            link = self.joints[found[-1]].parent
        return found[::-1]

    def fixed_to(self, link: str) -> Iterator[str]:
        """A link, and the links behind it that no joint moves."""
        yield link
        for ends in self.joints.values():
            if ends.parent == link and ends.kind == "fixed":
                yield from self.fixed_to(ends.child)


def hands_of(tree: Tree, joint_order: Sequence[str]) -> list[Hand]:
    """The ends of all arms: those with grippers, or without any gripper the longest chains; the longest arm first.

    Args:
        tree: the joints.
        joint_order: all joints that move, in the order in which they are to be listed.
    """
    own = [joint for joint in joint_order if joint not in tree.mimics and not tree.is_hand(joint)]
    groups: dict[str, list[str]] = {}
    for joint in joint_order:
        if tree.is_hand(joint):
            before = [
                each for each in tree.way(tree.joints[joint].parent) if tree.moves(each) and not tree.is_hand(each)
            ]
            if before:
                groups.setdefault(before[-1], []).append(joint)
    if not groups:
        ends = [joint for joint in own if not _moved_behind(tree, joint, own)]
        groups = {joint: [] for joint in ends}
    hands = [_hand(tree, end, tuple(moved)) for end, moved in groups.items()]
    return sorted(hands, key=lambda hand: -len(hand.arm))


def hand_at(tree: Tree, joint_order: Sequence[str], tip: str) -> Hand:
    """The arm that ends at a link.

    Raises:
        InputError: there is no such link, or no joint moves it.
    """
    links = {end for ends in tree.joints.values() for end in (ends.parent, ends.child)}
    if tip not in links:
        raise InputError([Diagnostic("--tip", 1, 1, f'unknown link "{tip}"', did_you_mean(tip, links))])
    way = [joint for joint in tree.way(tip) if tree.moves(joint)]
    arm = tuple(joint for joint in way if joint not in tree.mimics and not tree.is_hand(joint))
    if not arm:
        raise InputError([Diagnostic("--tip", 1, 1, f'no joint of an arm moves the link "{tip}"')])
    near = [hand for hand in hands_of(tree, joint_order) if hand.arm == arm]
    moved, mount = (near[0].moved, near[0].mount) if near else ((), tip)
    return Hand(arm, tuple(joint for joint in moved if joint not in tree.mimics), moved, mount, tip)


def _moved_behind(tree: Tree, joint: str, own: Sequence[str]) -> bool:
    return any(joint in tree.way(tree.joints[other].child)[:-1] for other in own if other != joint)


def _hand(tree: Tree, end: str, moved: tuple[str, ...]) -> Hand:
    way = tree.way(tree.joints[end].child)
    arm = tuple(joint for joint in way if tree.moves(joint) and joint not in tree.mimics)
    rigid = list(tree.fixed_to(tree.joints[end].child))
    mounts = [tree.joints[joint].parent for joint in moved if tree.joints[joint].parent in rigid]
    mount = mounts[0] if mounts else rigid[-1]
    named = [link for link in rigid if TOOL_WORDS.search(link)]
    tool = named[-1] if named else mount
    return Hand(arm, tuple(joint for joint in moved if joint not in tree.mimics), moved, mount, tool)
