"""Grippers measured on their meshes: which values open them, how far, and where they hold."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.robot_models.hands import Hand
from kabo.scene import Robot, link_poses
from kabo.scene.transforms import inverse

MAX_JOINTS = 4  # of a gripper that is measured; more are a hand with many fingers
LAST = 0.2  # share of the way, the last one before the gripper is closed, that tells in which direction it closes
STILL = 1e-3  # [m]: a finger that moves less does not close
BAND_SHARE = 0.25  # share of a finger's length, at its end, that holds
MIN_BAND = 0.005  # [m]
SNAP = 0.996  # cosine of about 5 degrees: nearer axes are taken for coordinate axes
GUESS_SNAP = 0.94  # cosine of about 20 degrees, for directions that are only guessed


@dataclass(frozen=True)
class GripperModel:
    """A gripper as measured, in the tool frame.

    Args:
        open, closed: values of its joints [rad or m].
        touch_links: the links that touch a held object.
        opening: the distance between the fingers' ends when open and when closed, along the closing axis [m]; None where
            it cannot be measured, which `unmeasured` explains.
        point: the middle between the fingers' ends (3,).
        approach, closing: directions (3,).
    """

    open: Mapping[str, float]
    closed: Mapping[str, float]
    touch_links: tuple[str, ...]
    opening: tuple[float, float] | None
    point: Array
    approach: Array
    closing: Array
    unmeasured: str = ""


@dataclass(frozen=True)
class Fingers:
    """The points of a gripper's links in the tool frame [m], at one end of its joints, by link.

    `base` is the origin (3,) of the last link before the joints.
    """

    points: Mapping[str, Array]
    base: Array

    def of(self, links: Sequence[str]) -> Array:
        """The points (N, 3) of several links."""
        return np.concatenate([self.points[link] for link in links])

    def middle(self, link: str) -> Array:
        """The middle of a link's box (3,)."""
        return _middle(self.points[link])


def measured(robot: Robot, hand: Hand, moved_links: Sequence[str]) -> GripperModel | None:
    """The gripper of a hand; None if it has no joints, or no links that move.

    Args:
        robot: with all joints of the hand among its joints.
        hand: the arm's end.
        moved_links: the links behind the joints of the gripper.
    """
    links = tuple(name for name in moved_links if robot.links[name].elements)
    if not hand.joints or not links:
        return None
    lower, upper = (_ends(robot, hand, side) for side in ("lower", "upper"))
    if len(hand.joints) > MAX_JOINTS:
        said = f"it has {len(hand.joints)} joints: a hand whose fingers close in many ways"
        zero = {joint: min(max(0.0, lower[joint]), upper[joint]) for joint in hand.joints}
        at = _fingers(robot, hand, zero, links)
        return _unmeasured(zero, upper, links, at, said)
    if len(links) == 1 and len(hand.joints) == 1:
        return _jaw(robot, hand, lower, upper, links[0])
    opened, closed = _opened(robot, hand, lower, upper, links)
    then, now = _fingers(robot, hand, opened, links), _fingers(robot, hand, closed, links)
    nearly = {joint: (1 - LAST) * closed[joint] + LAST * opened[joint] for joint in hand.joints}
    before = _fingers(robot, hand, nearly, links)
    moves = {link: now.middle(link) - before.middle(link) for link in links}
    strongest = max(moves.values(), key=lambda move: float(np.linalg.norm(move)))
    if float(np.linalg.norm(strongest)) < STILL:
        return _unmeasured(opened, closed, links, then, "its fingers do not move")
    return _between(robot, hand, (opened, closed), (then, now), moves, strongest)


def _between(
    robot: Robot,
    hand: Hand,
    values: tuple[Mapping[str, float], Mapping[str, float]],
    fingers: tuple[Fingers, Fingers],
    moves: Mapping[str, Array],
    strongest: Array,
) -> GripperModel:
    then, now = fingers
    along = {link: float(move @ strongest) / float(np.linalg.norm(strongest)) for link, move in moves.items()}
    one = [link for link, step in along.items() if step > STILL / 2]
    other = [link for link, step in along.items() if step < -STILL / 2]
    closing = np.mean([moves[link] for link in one], axis=0)
    if other:  # what both sides do alike, such as an arc forwards, is not closing
        closing = closing - np.mean([moves[link] for link in other], axis=0)
    if not other:
        return _unmeasured(*values, tuple(moves), then, "no two sides of it close towards each other")
    closing = _snapped(closing)
    approach = _approach(now.of([*moves]), then.points.get(hand.mount, then.base[None]), closing)
    gaps, points = zip(*(_gap(each, one, other, closing, approach) for each in (then, now)), strict=True)
    opened, closed = values
    touching = tuple(link for link in moves if robot.links[link].elements)
    if gaps[0] < gaps[1]:
        opened, closed, gaps, points = closed, opened, gaps[::-1], points[::-1]
    if gaps[0] < STILL:
        return _unmeasured(
            opened, closed, touching, then, "its sides overlap along the direction in which they close"
        )
    closing = closing * np.sign(closing[int(np.argmax(np.abs(closing)))])  # it has no sign: written as the axis
    return GripperModel(opened, closed, touching, (gaps[0], gaps[1]), points[0], approach, closing)


def _jaw(
    robot: Robot, hand: Hand, lower: Mapping[str, float], upper: Mapping[str, float], link: str
) -> GripperModel:
    """A gripper of one jaw that closes against the hand: its opening is the distance of the jaw's tip from the hand."""
    both = [_fingers(robot, hand, values, (link,)) for values in (lower, upper)]
    if hand.mount not in both[0].points:
        return _unmeasured(lower, upper, (link,), both[0], "its one jaw closes against nothing")
    joint = hand.joints[0]
    mesh = robot.links[link].mesh
    assert mesh is not None
    tip = int(np.argmax(np.linalg.norm(mesh.vertices, axis=1)))  # farthest from the joint
    body = both[0].points[hand.mount]
    gaps = [float(np.linalg.norm(body - each.points[link][tip], axis=1).min()) for each in both]
    opened, closed = (lower, upper) if gaps[0] > gaps[1] else (upper, lower)
    nearly = {joint: (1 - LAST) * closed[joint] + LAST * opened[joint]}
    half = {joint: 0.5 * (closed[joint] + opened[joint])}
    ends = [_fingers(robot, hand, each, (link,)).points[link][tip] for each in (nearly, closed, half)]
    if float(np.linalg.norm(ends[1] - ends[0])) < STILL:
        return _unmeasured(opened, closed, (link, hand.mount), both[0], "its jaw does not move")
    if min(gaps) > 0.5 * max(gaps):
        return _unmeasured(opened, closed, (link, hand.mount), both[0], "its one jaw does not come near the hand")
    closing = _snapped(ends[1] - ends[0])
    met = body[int(np.argmin(np.linalg.norm(body - ends[1], axis=1)))]
    approach = _approach(np.array([ends[1], ends[2]]), body, closing)
    return GripperModel(
        opened, closed, (link, hand.mount), (max(gaps), min(gaps)), 0.5 * (met + ends[2]), approach, closing
    )


def _unmeasured(
    opened: Mapping[str, float], closed: Mapping[str, float], links: tuple[str, ...], at: Fingers, why: str
) -> GripperModel:
    middle = np.mean([at.middle(link) for link in links], axis=0)
    away = middle - at.base  # bodies of hands are less even than where their frames are
    approach = _snapped(away, GUESS_SNAP) if float(np.linalg.norm(away)) > STILL else np.array([0.0, 0.0, 1.0])
    across = np.array([0.0, 1.0, 0.0]) if abs(approach[1]) < 0.5 else np.array([1.0, 0.0, 0.0])
    closing = across - approach * (across @ approach)
    return GripperModel(opened, closed, links, None, middle, approach, closing / np.linalg.norm(closing), why)


def _ends(robot: Robot, hand: Hand, side: str) -> dict[str, float]:
    values = robot.tree.lower if side == "lower" else robot.tree.upper
    return {joint: float(values[robot.joint_names.index(joint)]) for joint in hand.joints}


def _opened(
    robot: Robot, hand: Hand, lower: Mapping[str, float], upper: Mapping[str, float], links: Sequence[str]
) -> tuple[dict[str, float], dict[str, float]]:
    """The values that open and that close: a joint is open where it holds the fingers farther from each other."""
    opened, closed = {}, {}
    half = {joint: 0.5 * (lower[joint] + upper[joint]) for joint in hand.joints}
    for joint in hand.joints:
        low = _fingers(robot, hand, {**half, joint: lower[joint]}, links)
        high = _fingers(robot, hand, {**half, joint: upper[joint]}, links)
        outward = _spread(high, links) >= _spread(low, links)
        opened[joint], closed[joint] = (upper[joint], lower[joint]) if outward else (lower[joint], upper[joint])
    return opened, closed


def _spread(fingers: Fingers, links: Sequence[str]) -> float:
    """The greatest distance of the middles of two fingers [m]."""
    middles = np.array([fingers.middle(link) for link in links])
    return float(np.linalg.norm(middles[:, None] - middles[None], axis=2).max())


def _fingers(robot: Robot, hand: Hand, values: Mapping[str, float], links: Sequence[str]) -> Fingers:
    q = np.clip(np.zeros(robot.tree.size), robot.tree.lower, robot.tree.upper)
    for joint, value in values.items():
        q[robot.joint_names.index(joint)] = value
    poses = link_poses(robot, q.tolist())
    tool = inverse(poses[hand.tool])
    points = {}
    for name in (*links, hand.mount):
        mesh = robot.links[name].mesh
        if mesh is not None and len(mesh.vertices):
            pose = tool @ poses[name]
            corners = mesh.vertices
            edges = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
            middles = 0.5 * (corners[edges[:, 0]] + corners[edges[:, 1]])
            points[name] = np.concatenate([corners, middles]) @ pose[:3, :3].T + pose[:3, 3]
    return Fingers(points, (tool @ poses[hand.mount])[:3, 3])


def _middle(points: Array) -> Array:
    """The middle (3,) of the box of points (N, 3)."""
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))


def _approach(points: Array, mount: Array, closing: Array) -> Array:
    """The direction (3,) from the hand to the fingers, across the closing axis."""
    middle = _middle(points) - _middle(mount)
    across = middle - closing * (middle @ closing)
    if float(np.linalg.norm(across)) < STILL:
        across = np.array([0.0, 0.0, 1.0]) - closing * closing[2]
    snapped = _snapped(across)
    snapped = snapped - closing * (snapped @ closing)
    return np.asarray(snapped / np.linalg.norm(snapped))


def _snapped(direction: Array, least: float = SNAP) -> Array:
    """The unit direction, or the coordinate axis that it nearly is."""
    unit = direction / np.linalg.norm(direction)
    k = int(np.argmax(np.abs(unit)))
    return np.asarray(np.sign(unit[k]) * np.eye(3)[k] if abs(unit[k]) > least else unit)


def _gap(
    fingers: Fingers, one: Sequence[str], other: Sequence[str], closing: Array, approach: Array
) -> tuple[float, Array]:
    """The distance between the ends of two sides along the closing axis [m], negative if they overlap; and its middle."""
    first, second = fingers.of(one), fingers.of(other)
    top = min(float((first @ approach).max()), float((second @ approach).max()))
    length = max(float(np.ptp(first @ approach)) * BAND_SHARE, MIN_BAND)
    first, second = (side[side @ approach >= top - length] for side in (first, second))
    first, second = (side[side @ approach <= top + 1e-9] for side in (first, second))
    if not len(first) or not len(second):
        first, second = fingers.of(one), fingers.of(other)
    low, high = float((first @ closing).max()), float((second @ closing).min())
    across = np.cross(approach, closing)
    both = np.concatenate([first, second]) @ across
    middle = 0.5 * (low + high) * closing + (top - 0.5 * length) * approach
    return high - low, np.asarray(middle + 0.5 * float(both.min() + both.max()) * across)
