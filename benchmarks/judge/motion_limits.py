"""Whether a motion keeps its limits, is smooth, is at rest where it must be, and follows its path: by samples."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from motion_curves import Curve, distances
from motion_scene import KINDS, Array, pose
from motion_states import Motion

RATE = 1000.0  # samples a second
SLACK = 1e-9  # of a limit, relative: rounding of this program
JOIN = 1e-9  # position, velocity and acceleration agree to this at borders
GRAVITY = np.array([0.0, 0.0, -9.81])


@dataclass
class Fault:
    """What is wrong where: a figure and what it may be at most."""

    node: str
    segment: int
    kind: str
    figure: float
    bound: float
    where: str

    def line(self) -> dict[str, Any]:
        """It as JSON."""
        return {**self.__dict__, "figure": float(f"{self.figure:.9g}"), "bound": float(f"{self.bound:.9g}")}


def instants(each: Curve) -> Array:
    """Samples of a curve at a fixed rate, counted from the node's beginning, and all its borders."""
    begin, end = each.ends
    regular = np.arange(np.ceil(begin * RATE), np.floor(end * RATE) + 1) / RATE
    return np.unique(np.concatenate([each.times, regular[(regular >= begin) & (regular <= end)]]))


def greatest(motion: Motion, each: Curve) -> dict[str, Array]:
    """Of each derivative the greatest share of its limit by joint: samples, both sides of borders, and exact extremes."""
    limits, at = motion.scene.robots[each.robot].limits, instants(each)
    found = {}
    for order, kind in enumerate(KINDS, 1):
        bound = np.array([limits[name][kind] for name in each.joints])
        sampled = np.maximum(*(np.abs(each.at(at, order, left=left)).max(axis=0) for left in (False, True)))
        found[kind] = sampled / bound
        found[f"{kind}_exact"] = each.greatest(order) / bound
    return found


def sampled_differences(motion: Motion, robot: str) -> dict[str, tuple[float, str]]:
    """The greatest shares of the limits that differences of a robot's positions at a fixed rate reach, and of which joint.

    The robot stands before and behind the motion; so this sees every step of velocity, whatever polynomials say.
    """
    at = np.arange(-4, np.ceil(motion.end * RATE) + 5) / RATE
    found = dict.fromkeys(KINDS, (0.0, ""))
    for name, values in motion.values(robot, at).items():
        for order, kind in enumerate(KINDS, 1):
            share = float(np.abs(np.diff(values, order)).max()) * RATE**order
            share = share / motion.scene.robots[robot].limits[name][kind] if share else 0.0
            if share > found[kind][0]:
                found[kind] = share, name
    return found


def joins(each: Curve) -> Array:
    """The greatest differences of position, velocity and acceleration at the inner borders of a curve."""
    inner = each.times[1:-1]
    if not len(inner):
        return np.zeros(3)
    return np.array([np.abs(each.at(inner, k) - each.at(inner, k, left=True)).max() for k in range(3)])


def borders(motion: Motion) -> Iterator[tuple[Curve, Array, bool]]:
    """For every beginning and end of a segment: jumps of (position, velocity, acceleration), and whether it must rest.

    A segment is joined to the one of its robot that ends when it begins, if both have the same joints and nothing is
    attached or let go in between; else each of them is at rest there.
    """
    for each in motion.curves:
        begin, end = each.ends
        before = joined(motion, each, begin, 1)
        after = joined(motion, each, end, 0)
        here = np.array([each.at(np.array([begin]), k)[0] for k in range(3)])
        known = motion.values(each.robot, np.array([begin - 1e-6]))
        stood = np.array([known[name][0] for name in each.joints])
        if before is None or not begin > 0.0:
            jumps = np.array([np.abs(here[0] - stood).max(), np.abs(here[1]).max(), np.abs(here[2]).max()])
            yield each, jumps, True
        else:
            there = np.array([before.at(np.array([begin]), k, left=True)[0] for k in range(3)])
            yield each, np.abs(here - there).max(axis=1), False
        if after is None:
            there = np.array([each.at(np.array([end]), k, left=True)[0] for k in range(3)])
            yield each, np.array([0.0, np.abs(there[1]).max(), np.abs(there[2]).max()]), True


def joined(motion: Motion, each: Curve, at: float, end: int) -> Curve | None:
    """The segment that each is joined to: which begins (`end` 0) or ends (1) then; None where there must be a rest."""
    for other in motion.curves:
        same = other.robot == each.robot and other.joints == each.joints and other is not each
        if same and abs(other.ends[end] - at) < 1e-9:
            first = other if end else each
            return None if first.said["attach"] or first.said["detach"] else other
    return None


def tool(motion: Motion, node: str) -> tuple[float, float, list[Fault]]:
    """The greatest share of its grip's limit that a held object needs; how far differences are from exact; faults."""
    worst, doubt, faults = 0.0, 0.0, []
    for stretch in motion.stretches():
        for name, (parent, own) in stretch.parents.items():
            robot_name, _, link = parent.partition(".")
            robot = motion.scene.robots.get(robot_name)
            mass = motion.scene.masses.get(name)
            movers = [each for each in stretch.under_way if each.robot == robot_name]
            if robot is None or not link or robot.grip is None or mass is None or not movers:
                continue
            at = np.unique(
                np.concatenate([t[(t >= stretch.begin) & (t <= stretch.end)] for t in map(instants, movers)])
            )
            if len(at) == 0:
                continue
            exact = accelerations(motion, robot_name, link, own, at)
            force = mass * np.linalg.norm(exact - GRAVITY, axis=1)
            worst = max(worst, float(force.max()) / robot.grip)
            doubt = max(doubt, _difference(motion, robot_name, link, own, stretch, at, exact))
            if force.max() > robot.grip * (1 + SLACK):
                k = int(force.argmax())
                where = f"{name} at {at[k]:.6f} s"
                faults.append(Fault(node, movers[0].number, "tool", float(force[k]), robot.grip, where))
    return worst, doubt, faults


def accelerations(motion: Motion, name: str, link: str, own: Array, at: Array) -> Array:
    """The accelerations (T, 3) of the origin of something held, exactly, in the world."""
    robot = motion.scene.robots[name]
    model, data = robot.model, robot.model.createData()
    q, v, a = (robot.full(motion.values(name, at, k), k) for k in range(3))
    frame = model.frames[robot.frames[link]]
    held = model.copy() if hasattr(model, "copy") else pin.Model(model)
    index = held.addFrame(
        pin.Frame("judge_held", frame.parentJoint, 0, frame.placement * pin.SE3(own), pin.FrameType.OP_FRAME)
    )
    data = held.createData()
    found = np.empty((len(at), 3))
    for k in range(len(at)):
        pin.forwardKinematics(held, data, q[k], v[k], a[k])
        pin.updateFramePlacement(held, data, index)
        found[k] = pin.getFrameClassicalAcceleration(held, data, index, pin.LOCAL_WORLD_ALIGNED).linear
    return found


def _difference(motion: Motion, name: str, link: str, own: Array, stretch: Any, at: Array, exact: Array) -> float:
    """How far second differences of positions (at a millisecond) are from the exact accelerations [m/s²]."""
    step = 1 / RATE
    inner = (at > stretch.begin + step) & (at < stretch.end - step)
    if not inner.any():
        return 0.0
    positions = [
        (motion.links(name, [link], at[inner] + shift * step)[link] @ own)[:, :3, 3] for shift in (-1.0, 0.0, 1.0)
    ]
    second = (positions[0] - 2 * positions[1] + positions[2]) / step**2
    return float(np.abs(second - exact[inner]).max())


def after_differs(motion: Motion, node: dict[str, Any]) -> float:
    """How far the end of the motion is from what the node says about it: joints, and poses of what it moved."""
    at, worst = np.array([motion.end]), 0.0
    said = node.get("after") or {}
    for robot, values in (said.get("robots") or {}).items():
        here = motion.values(robot, at)
        worst = max([worst, *(abs(here[name][0] - value) for name, value in values["joints"].items())])
    parents = dict(motion.state.objects)
    for each in sorted(motion.curves, key=lambda each: each.ends[1]):
        motion._changed(parents, each)
    stated = {
        name: (one["parent"], pose(one["position"], one["quaternion"]))
        for name, one in (said.get("objects") or {}).items()
    }
    for name in stated:
        here, there = (motion.world(name, at, each)[0] for each in (parents, {**parents, **stated}))
        worst = max(worst, float(np.abs(here - there).max()))
    return worst


def off_path(each: Curve) -> tuple[float, float]:
    """How far samples are from the path at most [rad or m], and by how much that is above the stated deviation."""
    far = float(distances(each.at(instants(each)), each.waypoints).max())
    return far, far - each.deviation
