"""Where a run stands when something happened that no proof covers, and how others may tell it to go on."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, Protocol

import numpy as np

from kabo.arrays import Array
from kabo.execution.belief import Belief
from kabo.execution.displacements import displacement
from kabo.execution.motions import Stretch
from kabo.execution.watching import Surprise
from kabo.plan import ObjectPose, Plan, State, StateChange
from kabo.scene import Attachment, Robot, Scene, attachment, world_T
from kabo.scene.state import GeometricState
from kabo.scene.transforms import transform
from kabo.verify import Report

SAME_PLACE = 5e-4  # [m]: a body so near to its place is where it should be, as far as planning is concerned
WELL_HELD = 3e-3  # [m]: nearer to its place in a hand, a body is held as planned, as far as planning is concerned
STILL_HELD = 0.03  # [m]: a body that is farther from its place in a hand is not held any more
AJAR = 0.02  # share of its range by which a finger's joint stays off its stops
SAME_HEIGHT, SAME_TURN = 1e-3, 0.02  # [m], [rad]: what is less is no other pose, but an error of measuring


class Stop(NamedTuple):
    """Why a run does not go on from here, in a sentence; and what no proof covers, if that is it."""

    reason: str
    surprise: Surprise | None = None


@dataclass(frozen=True)
class Executed:
    """A segment that was followed, to its end, or until a time of its trajectory [s]."""

    node: str
    segment: int
    until: float | None = None

    @classmethod
    def of(cls, stretch: Stretch, plan: Plan, motion_time: float) -> "Executed":
        """A stretch that runs at a time of the motion's clock [s]."""
        own = plan.nodes[stretch.node].motion[stretch.segment].times[0]
        until = None if motion_time >= stretch.end else own + motion_time - stretch.begin
        return cls(stretch.node, stretch.segment, until)


def begun_nodes(plan: Plan, executed: Iterable[Executed]) -> tuple[str, ...]:
    """The nodes of which segments were followed, in the order of the plan."""
    names = {each.node for each in executed}
    found = sorted(names - {plan.nodes[name].next for name in names})
    while found and (following := plan.nodes[found[-1]].next) in names:
        found.append(str(following))
    return tuple(found)


def ended_nodes(plan: Plan, executed: Collection[Executed], unjudged: Collection[str] = ()) -> tuple[str, ...]:
    """The nodes of which all segments were followed to their ends, up to the first one that is not over, or observes.

    Args:
        plan: the plan. executed: what was followed of the nodes that are not done.
        unjudged: robots with a hand that has closed, of which nobody has seen yet whether it holds anything.
    """
    followed = {(each.node, each.segment) for each in executed if each.until is None}
    found = []
    for name in begun_nodes(plan, executed):
        node = plan.nodes[name]
        own = {(name, number) for number in range(len(node.motion))}
        if (
            node.on is not None
            or node.delivers
            or not own <= followed
            or {s.robot for s in node.motion} & {*unjudged}
        ):
            break
        found.append(name)
    return tuple(found)


@dataclass(frozen=True)
class Interruption:
    """Where a run stands after a planned stop.

    Attributes:
        plan: the plan that was carried out.
        state: what was done before, and where everything is, as it was observed.
        executed: what was followed of the nodes that are not done, in order.
        lost: bodies that a hand should hold and does not, each with the robot.
        surprise: what happened.
        expected: where the plan has everything, before the node that is not done.
    """

    plan: Plan
    state: State
    executed: tuple[Executed, ...]
    lost: tuple[tuple[str, str], ...]
    surprise: Surprise
    expected: StateChange | None = None


@dataclass(frozen=True)
class Answer:
    """How a run goes on: with a plan that is proven from where it stands; None: not at all, for the `reason`.

    Attributes:
        kind: `finish` makes the rest of the node's motion, and `undo` goes back to where the node began, after which it is
            asked again; `repair` does the same actions as the rest of the old plan, `replan` others.
        plan: what is to be carried out; with `rest` only its first node has a motion yet.
        reason: why, in a sentence.
        report: of the check of the plan, from which margins are taken.
        rest: waits for the answer with the whole plan, which is made and proven while its first motion is carried out: the
            same nodes and the same first motion, or no plan.
    """

    kind: Literal["finish", "undo", "repair", "replan", "none"]
    plan: Plan | None
    reason: str
    report: Report | None = None
    rest: "Callable[[], Answer] | None" = None


class Recovery(Protocol):
    """Says how a run goes on after a surprise; `kabo.recovery.Replanner` plans anew."""

    def answer(self, interruption: Interruption) -> Answer:
        """A plan from where the run stands, or the reason for having none."""


def observed(
    scene: Scene,
    plan: Plan,
    belief: Belief,
    seen: Mapping[str, Array],
    empty: Mapping[str, Sequence[float]],
    *,
    exact: bool = False,
) -> tuple[StateChange, tuple[tuple[str, str], ...]]:
    """Where everything is, and what is not held any more, with the robot that should hold it.

    Small errors are taken out: no arm of five joints reaches what is said to be tilted by a thousandth. A part that is
    joined to a body is compared with where this body is seen: both may have been pushed, and are joined still.

    Args:
        scene: the scene.
        plan: where it puts bodies, they may stand.
        belief: the state by the plan.
        seen: the poses (4, 4) of bodies in the world.
        empty: hands that hold nothing although they should, with the measured values of their joints, by robot.
        exact: whether small errors stay in: where little is proven to be free, what is taken out may be more than that.
    """
    state, wanted = belief.state, belief.poses()
    robots = {name: dict(zip(scene.robots[name].joint_names, q, strict=True)) for name, q in state.robots.items()}
    for name, values in empty.items():
        robots[name] |= hand_within_limits(scene.robots[name], values)
    objects = {name: ObjectPose(own.parent, own.position, own.quaternion) for name, own in state.objects.items()}
    lost: list[tuple[str, str]] = []
    now = state  # with what was looked at where it is
    for name in sorted(seen, key=lambda each: _joints_to_the_ground(state, each)):
        pose, holder, own = seen[name], belief.holder(name), state.objects[name]
        joined = own.parent in state.objects
        place = (
            world_T(scene, now, own.parent) @ transform(own.position, own.quaternion) if joined else wanted[name]
        )
        off = displacement(place, pose, scene.bodies[name].mesh.box_corners).size
        found: Attachment | None = None
        if holder is not None and (off > STILL_HELD or (holder in empty and not joined)):
            lost.append((name, holder))
            if (given := belief.held_by_giver(name)) is not None:
                found = _still_given(scene, now, name, given, pose, empty)
                lost += [] if found is not None else [(name, given[0])]
            if found is None:
                found = _placed(scene, now, "world", _standing(pose, _stands(scene, plan, name)))
        elif exact and off > SAME_PLACE:
            found = _placed(scene, now, own.parent, pose)
        elif holder is not None and off > WELL_HELD:
            found = _placed(scene, now, own.parent, _unturned(place, pose))
        elif holder is None and own.parent == "world":
            found = _placed(scene, now, "world", _standing(pose, [place, *_stands(scene, plan, name)]))
        elif holder is None and off > SAME_PLACE:
            found = _placed(scene, now, own.parent, _standing(pose, [place]))
        if found is not None:
            objects[name] = ObjectPose(found.parent, found.position, found.quaternion)
            now = now.replace({name: found})
    return StateChange(robots, objects), tuple(lost)


def _still_given(
    scene: Scene,
    state: GeometricState,
    name: str,
    given: tuple[str, Attachment],
    pose: Array,
    empty: Collection[str],
) -> Attachment | None:
    """How the hand that gives a body holds it, which the taking hand has missed; None if it has lost it, too."""
    robot, hold = given
    place = world_T(scene, state, hold.parent) @ transform(hold.position, hold.quaternion)
    off = displacement(place, pose, scene.bodies[name].mesh.box_corners).size
    if robot in empty or off > STILL_HELD:
        return None
    return _placed(scene, state, hold.parent, place if off <= WELL_HELD else _unturned(place, pose))


def hand_within_limits(robot: Robot, hand: Sequence[float]) -> dict[str, float]:
    """The values of a hand's joints, within their limits: stops give way a little, and fingers that touch prove nothing.

    What is beside the way from open to closed by less than that is an error of measuring: a hand that is open is open,
    and joints that no grasp moves have not moved.
    """
    joints, gripper = robot.gripper_joints, robot.gripper
    low, high = robot.tree.lower[robot.planned :], robot.tree.upper[robot.planned :]
    room, found = AJAR * (high - low), np.array(hand, float)
    opened = np.array([gripper.open.get(joint, np.nan) if gripper else np.nan for joint in joints])
    closed = np.array([gripper.closed.get(joint, np.nan) if gripper else np.nan for joint in joints])
    way = np.clip(found, np.fmin(opened, closed), np.fmax(opened, closed))  # NaN where nobody knows it
    found = np.where(np.abs(found - way) <= room, way, found)
    found = np.clip(found, np.fmin(low + room, opened), np.fmax(high - room, opened))
    return dict(zip(joints, map(float, found), strict=True))


def _placed(scene: Scene, state: GeometricState, parent: str, pose: Array) -> Attachment:
    return attachment(parent, np.linalg.inv(world_T(scene, state, parent)) @ pose)


def _joints_to_the_ground(state: GeometricState, name: str) -> int:
    """How many bodies carry a body to which it is joined."""
    parent, count = state.objects[name].parent, 0
    while parent in state.objects:
        parent, count = state.objects[parent].parent, count + 1
    return count


def _stands(scene: Scene, plan: Plan, name: str) -> list[Array]:
    """The poses (4, 4) in which a body stands on something, at the start of the scene or by the plan."""
    changes = [plan.start, *(node.after for node in plan.nodes.values())]
    poses = [change.objects[name] for change in changes if change is not None and name in change.objects]
    standing: list[Attachment | ObjectPose] = [scene.start.objects[name], *poses]
    return [transform(each.position, each.quaternion) for each in standing if each.parent == "world"]


def _standing(found: Array, known: Sequence[Array]) -> Array:
    """The pose that was found; where it is one of the known ones but for an error of measuring, that one.

    If it is such a pose but shifted and turned about the vertical, height and tilt are taken from there.
    """
    for pose in known:
        if float(np.linalg.norm(found[:3, 3] - pose[:3, 3])) <= SAME_PLACE and _angle(pose, found) <= SAME_TURN:
            return pose
    for pose in known:
        tilt = float(np.linalg.norm(np.cross(pose[2, :3], found[2, :3])))  # of the vertical, seen from the body
        if abs(found[2, 3] - pose[2, 3]) > SAME_HEIGHT or tilt > SAME_TURN or pose[2, :3] @ found[2, :3] < 0.0:
            continue
        turn = found[:3, :3] @ pose[:3, :3].T
        angle = float(np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))
        made, c, s = np.eye(4), np.cos(angle), np.sin(angle)
        made[:3, :3] = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ pose[:3, :3]
        made[:3, 3] = found[0, 3], found[1, 3], pose[2, 3]
        return made
    return found


def _unturned(wanted: Array, found: Array) -> Array:
    """The pose that was found in a hand, turned as it should be if it is nearly so."""
    if _angle(wanted, found) > SAME_TURN:
        return found
    made = wanted.copy()
    made[:3, 3] = found[:3, 3]
    return made


def _angle(first: Array, second: Array) -> float:
    turn = first[:3, :3].T @ second[:3, :3]
    return float(np.arctan2(np.linalg.norm(turn - turn.T) / np.sqrt(8.0), 0.5 * (np.trace(turn) - 1.0)))
