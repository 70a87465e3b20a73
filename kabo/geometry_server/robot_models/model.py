"""Makes the entry of a robot for scenes from its URDF: joints, tool, gripper, home, pairs of links that always touch."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kabo.arrays import Array
from kabo.children import never
from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.geometry_server.preparation.preparing import Preparing
from kabo.geometry_server.robot_models.grippers import GripperModel, measured
from kabo.geometry_server.robot_models.hands import Hand, Tree, hand_at, hands_of
from kabo.geometry_server.robot_models.link_pairs import LinkPair
from kabo.geometry_server.robot_models.overlap_proofs import always_overlap
from kabo.geometry_server.robot_models.self_contacts import SelfContacts, UnenclosedError, rounded_within
from kabo.language.robot_files.srdf import read_srdf
from kabo.language.scene_description import (
    ContactPattern,
    GripperDescription,
    PoseDescription,
    RobotDescription,
    SceneDescription,
)
from kabo.language.semantic_description import SemanticDescription
from kabo.phases import phase
from kabo.scene import Robot, Scene, is_open, load_scene
from kabo.scene.semantics import Groups
from kabo.scene.urdf_file import read_urdf

_LOG = logging.getLogger("kabo.geometry_server")

HOME_WORDS = (
    "home",
    "ready",
    "rest",
    "default",
    "arm_up",
    "half_sitting",
    "folded",
    "tuck",
)  # of states tried first
HAND_STEPS = 9  # of a hand of many fingers, from open to closed
NOT_CLOSED = "the mesh is not closed"


@dataclass(frozen=True)
class AlwaysPair:
    """Two links that touch at every configuration; `depth` is that of a proof [m], None if it was only sampled.

    If `hand`, they belong to a hand, and touch while it is open, or closes.
    """

    first: str
    second: str
    depth: float | None
    hand: bool = False

    @property
    def when(self) -> str:
        """When they touch, and how this is known."""
        known = "sampled" if self.depth is None else "proven"
        return "while the gripper is open, or closes" if self.hand else f"always ({known})"


@dataclass(frozen=True)
class RobotModel:
    """A robot as `kabo robot` found it.

    Args:
        robot: loaded with all of the following.
        hand: the arm and its gripper's joints.
        others: the ends of further arms, which stand still.
        gripper: measured; None without one.
        home: a configuration (n,) without self-collision, the gripper open; None if none was found.
        margin: how far its links are proven to be apart there at least, neighbours aside [m].
        always: pairs that touch always, or while the gripper is open, or closes.
        often: pairs that touch at many configurations, each with the share of these.
        hulls: links that are replaced by their hulls, and why.
        visual: links without collision geometry, whose visual geometry is used.
    """

    name: str
    urdf: Path
    srdf: Path | None
    epsilon: float
    robot: Robot
    hand: Hand
    others: tuple[Hand, ...]
    gripper: GripperModel | None
    home: Array | None
    margin: float
    always: tuple[AlwaysPair, ...]
    often: Mapping[tuple[str, str], float]
    hulls: Mapping[str, str]
    visual: tuple[str, ...]

    @property
    def hull_reasons(self) -> dict[str, list[str]]:
        """The links that are replaced by their hulls, by reason."""
        reasons: dict[str, list[str]] = {}
        for link, why in self.hulls.items():
            reasons.setdefault(why, []).append(link)
        return reasons


@dataclass(frozen=True)
class Wishes:
    """What the user of `kabo robot` chose: the arm's last link, or a group of the SRDF; None: kabo chooses."""

    tip: str | None = None
    group: str | None = None


def make_robot_model(
    urdf: Path,
    srdf: Path | None,
    *,
    name: str,
    epsilon: float,
    wishes: Wishes | None = None,
    look: Callable[[], None] = never,
    told: Callable[[Preparing], None] | None = None,
) -> RobotModel:
    """The model of a robot.

    Args:
        urdf: the URDF file, or a xacro file.
        srdf: its SRDF file, if there is one.
        name: the name of the robot in the scene.
        epsilon: the accuracy [m] with which links are checked.
        wishes: what the user chose.
        look: called now and then; it may raise.
        told: called with what is prepared.

    Raises:
        InputError: a file has errors: all of them; or what the user chose does not exist.
    """
    file = read_urdf(urdf, {}, None)
    semantics = None
    if srdf is not None:
        semantics, found = read_srdf(srdf, None)
        if errors := [each for each in found if each.severity == "error"]:
            raise InputError(errors)
    description = RobotDescription(name, urdf, PoseDescription(), semantics=semantics)
    with phase("loading the robot", log=_LOG):
        names = _scene(description, epsilon, look).robots[name].model.names
    order = list(names)[1:]
    tree = Tree(file.joints, frozenset(file.mimics))
    hands = _hands(tree, order, wishes or Wishes(), semantics)
    if not hands:
        raise InputError([_nothing_moves(urdf)])
    with phase("measuring the gripper", log=_LOG):
        description, gripper = _with_hand(description, hands[0], tree, epsilon, look)
        hulls = _open_links(_scene(description, epsilon, look).robots[name])
    with phase("looking which links touch", log=_LOG):
        robot, always, often, (home, margin) = _checked(description, hulls, gripper, _Asked(epsilon, look, told))
    return RobotModel(
        name, urdf, srdf, epsilon, robot, hands[0], tuple(each for each in hands[1:] if each.is_arm), gripper, home, margin,
        always, often, hulls, file.visual,
    )  # fmt: skip


def _nothing_moves(urdf: Path) -> Diagnostic:
    said = f'robot file "{urdf.name}" has no joint that an arm could move'
    return Diagnostic(
        str(urdf), 1, 1, said, "joints are revolute, continuous or prismatic, and mimic no other one"
    )


def _scene(description: RobotDescription, epsilon: float, look: Callable[[], None]) -> Scene:
    robots = {description.name: description}
    return load_scene(SceneDescription("robot", epsilon, robots, {}, {}, {}, {}, (), {}, description.urdf), look)


def _hands(tree: Tree, order: Sequence[str], wishes: Wishes, semantics: SemanticDescription | None) -> list[Hand]:
    """The ends of all arms, the chosen one first."""
    hands = hands_of(tree, order)
    if wishes.tip is not None:
        chosen = hand_at(tree, order, wishes.tip)
        return [chosen, *(hand for hand in hands if hand.arm != chosen.arm)]
    if wishes.group is None:
        return hands
    groups = Groups.of(semantics, tree.joints)
    if wishes.group not in groups.groups:
        hint = did_you_mean(wishes.group, groups.groups) or "groups are those of the SRDF file: --srdf FILE"
        raise InputError([Diagnostic("--group", 1, 1, f'unknown group "{wishes.group}"', hint)])
    inside = set(groups.joints_of(wishes.group))
    arm = tuple(
        joint for joint in order if joint in inside and joint not in tree.mimics and not tree.is_hand(joint)
    )
    if not arm:
        said = f'group "{wishes.group}" has no joint of an arm'
        raise InputError([Diagnostic("--group", 1, 1, said, "name the group of the arm, not that of the hand")])
    at = next((hand for hand in hands if hand.arm[-1] == arm[-1]), None)
    chosen = (
        replace(at, arm=arm)
        if at is not None
        else replace(hand_at(tree, order, tree.joints[arm[-1]].child), arm=arm)
    )
    return [chosen, *(hand for hand in hands if hand is not at)]


def _with_hand(
    description: RobotDescription, hand: Hand, tree: Tree, epsilon: float, look: Callable[[], None]
) -> tuple[RobotDescription, GripperModel | None]:
    """The description with the joints of an arm and its gripper, and the gripper as measured."""
    described = replace(description, joints=hand.arm, tool_frame=hand.tool)
    if not hand.joints:
        return described, None
    bare = replace(described, gripper=GripperDescription(joints=hand.joints))
    robot = _scene(bare, epsilon, look).robots[description.name]
    moved = [link for link in robot.links if any(joint in hand.moved for joint in tree.way(link))]
    gripper = measured(robot, hand, moved)
    if gripper is None:
        return bare, None
    opened, closed = (
        {j: _rounded(v, robot, j) for j, v in each.items()} for each in (gripper.open, gripper.closed)
    )
    gripper = replace(gripper, open=opened, closed=closed)
    links = GripperDescription(None, None, hand.joints, opened, closed, gripper.touch_links)
    return replace(described, gripper=links), gripper


def _rounded(value: float, robot: Robot, joint: str) -> float:
    """A joint value as it is written: rounded, and within its limits."""
    i = robot.joint_names.index(joint)
    return float(rounded_within(np.array([value]), robot.tree.lower[[i]], robot.tree.upper[[i]])[0])


def _open_links(robot: Robot) -> dict[str, str]:
    """The links whose meshes are open, each with the reason: they have no convex parts."""
    return {link.name: NOT_CLOSED for link in robot.links.values() if any(map(is_open, link.elements))}


def _checked(
    description: RobotDescription, hulls: dict[str, str], gripper: GripperModel | None, asked: "_Asked"
) -> tuple[Robot, tuple[AlwaysPair, ...], Mapping[LinkPair, float], tuple[Array | None, float]]:
    """The robot, the pairs that touch always and often, and a home; `hulls` gets links that cannot be enclosed."""
    while True:
        described = replace(description, hulls=tuple(hulls))
        try:
            contacts = asked.contacts(described)
            always = contacts.always()
            contacts = asked.contacts(_allowing(described, always))
            hand = [] if gripper is None else contacts.inside_hand(_grips(contacts.robot, gripper))
            if hand:
                contacts = asked.contacts(_allowing(described, [*always, *hand]))
            home = _home(contacts, gripper)
            often = contacts.often([*always, *hand])
        except UnenclosedError as error:
            if set(error.links) <= set(hulls):
                raise InputError([_no_hull(description.urdf, *item) for item in error.links.items()]) from None
            hulls.update(error.links)
        else:
            robot = contacts.robot
            proven = [AlwaysPair(*pair, always_overlap(robot, pair)) for pair in always]
            return robot, (*proven, *(AlwaysPair(*pair, None, hand=True) for pair in hand)), often, home


def _allowing(description: RobotDescription, pairs: Sequence[tuple[str, str]]) -> RobotDescription:
    return replace(description, contacts=tuple(ContactPattern(*pair) for pair in pairs))


def _grips(robot: Robot, gripper: GripperModel) -> Array:
    """Configurations (N, n) with the arm at zero and the gripper open; of a hand of many fingers, also closing."""
    q = np.clip(np.zeros(robot.tree.size), robot.tree.lower, robot.tree.upper)
    joints = [robot.joint_names.index(joint) for joint in gripper.open]
    opened, closed = (np.array([each[joint] for joint in gripper.open]) for each in (gripper.open, gripper.closed))
    shares = np.linspace(0.0, 1.0, HAND_STEPS) if gripper.opening is None else np.zeros(1)
    found = np.repeat(q[None], len(shares), axis=0)
    found[:, joints] = opened + shares[:, None] * (closed - opened)
    return found


def _no_hull(urdf: Path, link: str, why: str) -> Diagnostic:
    hint = "give the link a box, a cylinder or a sphere, or a mesh with an inside"
    return Diagnostic(str(urdf), 1, 1, f'link "{link}" cannot be enclosed, nor its hull: {why}', hint)


@dataclass(frozen=True)
class _Asked:
    """The accuracy [m], and who is told of what is done."""

    epsilon: float
    look: Callable[[], None]
    told: Callable[[Preparing], None] | None

    def contacts(self, description: RobotDescription) -> SelfContacts:
        """The self-contacts of a robot."""
        scene = _scene(description, self.epsilon, self.look)
        return SelfContacts(scene, description.name, self.epsilon, self.look, self.told)


def _home(contacts: SelfContacts, gripper: GripperModel | None) -> tuple[Array | None, float]:
    """A configuration without self-collision with the gripper open, and its proven margin [m]."""
    robot = contacts.robot
    zero = np.clip(np.zeros(robot.tree.size), robot.tree.lower, robot.tree.upper)
    middle = 0.5 * (robot.tree.lower + robot.tree.upper)
    named = [robot.configurations[word] for word in HOME_WORDS if word in robot.configurations]
    named += [values for word, values in robot.configurations.items() if word not in HOME_WORDS]
    candidates = [np.concatenate([values, zero[robot.planned :]]) for values in named]
    candidates += [zero, np.where(np.abs(middle) < 1e-3, 0.0, middle)]
    for q in candidates:
        for joint, value in ({} if gripper is None else gripper.open).items():
            q[robot.joint_names.index(joint)] = value
    found = contacts.free_configuration(candidates, contacts.fine.pairs, candidates[-2])
    return (None, 0.0) if found is None else found
