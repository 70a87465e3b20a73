"""Which states of the world every node of a plan may find, and what its motion does: no more than the file says."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from motion_curves import Curve, curve
from motion_scene import Array, Scene, pose

MOST_STATES = 256  # of a node that are looked at


@dataclass
class State:
    """Joint values of every robot by name, and for every movable object its parent and its pose there."""

    robots: dict[str, dict[str, float]]
    objects: dict[str, tuple[str, Array]]

    def key(self) -> tuple[Any, ...]:
        """The same for equal states."""
        joints = tuple(sorted((r, j, x) for r, values in self.robots.items() for j, x in values.items()))
        things = tuple(
            (name, parent, *at[:3].round(9).ravel()) for name, (parent, at) in sorted(self.objects.items())
        )
        return joints, things

    def changed(self, after: dict[str, Any]) -> "State":
        """The state after a node that says what it changes."""
        robots = {name: dict(values) for name, values in self.robots.items()}
        for name, said in (after.get("robots") or {}).items():
            robots.setdefault(name, {}).update(said["joints"])
        objects = dict(self.objects)
        for name, said in (after.get("objects") or {}).items():
            objects[name] = said["parent"], pose(said["position"], said["quaternion"])
        return State(robots, objects)


def following(node: dict[str, Any]) -> list[str]:
    """The nodes that may come next."""
    return [node["next"]] if "next" in node else list((node.get("branches") or {}).values())


def order(plan: dict[str, Any]) -> list[str]:
    """All nodes, each behind those that lead to it."""
    found: list[str] = []
    waiting = {plan["root"]: 0}
    for node in plan["nodes"].values():
        for name in following(node):
            waiting[name] = waiting.get(name, 0) + 1
    ready = [plan["root"]]
    while ready:
        name = ready.pop()
        found.append(name)
        for after in following(plan["nodes"][name]):
            waiting[after] -= 1
            if waiting[after] == 0:
                ready.append(after)
    return found


def states(plan: dict[str, Any]) -> dict[str, list[State]]:
    """The states that each node may begin in, at most `MOST_STATES` of them."""
    found: dict[str, dict[Any, State]] = {name: {} for name in plan["nodes"]}
    first = State({}, {}).changed(plan["start"])
    found[plan["root"]][first.key()] = first
    for name in order(plan):
        node = plan["nodes"][name]
        for state in list(found[name].values()):
            later = state.changed(node.get("after") or {})
            for after in following(node):
                if len(found[after]) < MOST_STATES:
                    found[after].setdefault(later.key(), later)
    return {name: list(each.values()) for name, each in found.items()}


@dataclass
class Stretch:
    """A part of a node's motion in which the same segments are under way, and the same is carried."""

    begin: float
    end: float
    under_way: list[Curve]
    parents: dict[str, tuple[str, Array]]  # of all movable objects


class Motion:
    """The motion of a node from one of the states that it may begin in."""

    def __init__(self, scene: Scene, node: dict[str, Any], state: State) -> None:
        self.scene, self.state = scene, state
        self.curves = [curve(i, segment) for i, segment in enumerate(node["motion"])]
        self.end = max(each.ends[1] for each in self.curves)

    def values(self, robot: str, times: Array, order: int = 0) -> dict[str, Array]:
        """The values (T,) of a robot's joints at times of the node; a joint stands before, between and after."""
        found = {j: np.full(len(times), x if order == 0 else 0.0) for j, x in self.state.robots[robot].items()}
        for each in sorted((each for each in self.curves if each.robot == robot), key=lambda each: each.ends):
            begin, end = each.ends
            rows = each.at(np.clip(times, begin, end), order)
            begun = times >= begin - 1e-9
            for j, name in enumerate(each.joints):
                if name in found:
                    moved = rows[:, j] if order == 0 else np.where(times <= end + 1e-9, rows[:, j], 0.0)
                    found[name] = np.where(begun, moved, found[name])
        return found

    def stretches(self) -> Iterator[Stretch]:
        """The motion cut where segments begin or end; what is carried changes there."""
        cuts = sorted({t for each in self.curves for t in each.ends})
        parents, done = dict(self.state.objects), set()
        for begin, end in zip(cuts, cuts[1:], strict=False):
            for each in sorted(self.curves, key=lambda each: each.ends[1]):
                if each.ends[1] <= begin + 1e-9 and each.number not in done:
                    done.add(each.number)
                    self._changed(parents, each)
            under_way = [each for each in self.curves if each.ends[0] < end - 1e-9 and each.ends[1] > begin + 1e-9]
            if under_way:
                yield Stretch(begin, end, under_way, dict(parents))

    def _changed(self, parents: dict[str, tuple[str, Array]], each: Curve) -> None:
        """What is let go hangs from the world, what is attached from its new parent, both where they are."""
        at = np.array([each.ends[1]])
        for change in [(name, "world") for name in each.said["detach"]] + [
            (said["object"], said["to"]) for said in each.said["attach"]
        ]:
            name, parent = change
            here = self.world(name, at, parents)[0]
            frame = np.eye(4) if parent == "world" else self.world(parent, at, parents)[0]
            parents[name] = parent, np.linalg.inv(frame) @ here

    def world(self, name: str, times: Array, parents: dict[str, tuple[str, Array]]) -> Array:
        """The poses (T, 4, 4) of an object, a fixed body or a `robot.link` at times of the node."""
        if name in parents:
            parent, own = parents[name]
            return (
                self.world(parent, times, parents) @ own
                if parent != "world"
                else np.repeat(own[None], len(times), 0)
            )
        if name in self.scene.fixed:
            return np.repeat(self.scene.fixed[name][None], len(times), 0)
        robot, _, link = name.partition(".")
        return self.links(robot, [link], times)[link]

    def links(self, name: str, links: list[str], times: Array) -> dict[str, Array]:
        """The poses (T, 4, 4) of some links of a robot."""
        robot = self.scene.robots[name]
        found = {link: np.empty((len(times), 4, 4)) for link in links}
        for k, q in enumerate(robot.full(self.values(name, times))):
            pin.forwardKinematics(robot.model, robot.data, q)
            for link in links:
                frame = robot.model.frames[robot.frames[link]]
                found[link][k] = (robot.data.oMi[frame.parentJoint] * frame.placement).homogeneous
        return found
