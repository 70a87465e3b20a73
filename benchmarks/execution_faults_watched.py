"""An independent watcher: replays the log of a run beside the plans that it carried out, and says what was not proven.

It shares no code with the executor's own watch: where everything should be follows from the trajectories, from what
segments attach and let go of, and from forward kinematics; what is proven, from the certificate as it is written. A record
`state` of the log, many a second, says where everything was. What it looks for:

- a robot or a body that is farther from its place than is proven, while the motion goes on for longer than a stop takes
  to begin;
- a motion, or a hand that acts, between a stop and an answer to it, or after the end;
- a plan that `kabo verify` does not prove from the state in which it began, or that began elsewhere;
- a reason that names nothing of what was off when robots were stopped.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import inf
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.plan import Plan, Segment, StateChange
from kabo.scene import Scene, link_poses
from kabo.scene.transforms import transform

NOTICED = 0.05  # [s] within which a stop must begin
UNSEEN = 1.0  # [s] after which a body that nobody sees is a surprise
ROUNDING = 2e-5  # [m]: of numbers in a log
WAYS = ("finish", "undo")
OTHER = ("asked to stop", "nearer to each other than")  # pairs are judged by the executor alone
LATE_STEP, LATE_STEPS = 0.001, 100  # [s]: robots may be late, all by as much
WIDE = 0.05  # share of a hand's stroke


@dataclass
class Cell:
    """Where everything is by a plan: values of joints, and of bodies the parent with their pose (4, 4) in it."""

    scene: Scene
    joints: dict[str, dict[str, float]]
    hung: dict[str, tuple[str, Array]]

    @classmethod
    def of(cls, scene: Scene, start: StateChange) -> "Cell":
        """As a plan begins."""
        cell = cls(scene, {robot: dict(q) for robot, q in start.robots.items()}, {})
        cell.take(start)
        return cell

    def take(self, change: StateChange) -> None:
        """Takes over what a plan says of a state."""
        for robot, q in change.robots.items():
            self.joints[robot] |= q
        for body, own in change.objects.items():
            self.hung[body] = own.parent, transform(own.position, own.quaternion)

    def copy(self) -> "Cell":
        """Another one that is alike."""
        return Cell(self.scene, {robot: dict(q) for robot, q in self.joints.items()}, dict(self.hung))

    def values(self, robot: str) -> list[float]:
        """The values of a robot's joints."""
        return [self.joints[robot][joint] for joint in self.scene.robots[robot].joint_names]

    def pose(self, thing: str, links: Mapping[str, Mapping[str, Array]]) -> Array:
        """The pose (4, 4) of a body, a link or what is fixed, where links are at `links`."""
        if thing in self.hung:
            parent, place = self.hung[thing]
            return self.pose(parent, links) @ place
        robot, dot, link = thing.partition(".")
        if dot and robot in links:
            return links[robot][link]
        if thing == "world":
            return np.eye(4)
        return self.scene.fixed_poses[thing]

    def hang(self, body: str, parent: str) -> None:
        """Attaches a body to something else, where it is."""
        links = {robot: link_poses(self.scene.robots[robot], self.values(robot)) for robot in self.joints}
        self.hung[body] = parent, np.linalg.inv(self.pose(parent, links)) @ self.pose(body, links)


@dataclass
class Watcher:
    """Judges one log.

    Args:
        scene: the scene. plans: that were carried out, in order; each but the first with the kind of the answer.
    """

    scene: Scene
    plans: Sequence[tuple[str, Plan]]
    wrong: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.corners = {  # of boxes around bodies
            name: np.array(list(product(*np.transpose([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)]))))
            for name in self.scene.movable
            if (mesh := self.scene.bodies[name].mesh) is not None
        }

    def replay(self, records: Sequence[Mapping[str, Any]]) -> list[str]:
        """What is wrong, in sentences."""
        if records[-1]["event"] not in ("goal", "stopped"):
            self.wrong.append("the log does not end with the goal or a stop")
        waiting = list(self.plans)
        self.main = waiting.pop(0)[1]
        self.plan, self.cell = self.main, Cell.of(self.scene, self.main.start or StateChange())
        self.nodes: list[str] = []
        self.since: float | None = None  # when something was first farther away than is proven [s]
        self.off: dict[str, str] = {}
        self.reason: str | None = None  # of a stop, which is not judged yet
        self.seen: dict[str, float] = {}
        self.clock = 0.0  # of the motion, at the last record [s]
        halted = ended = False
        for record in records:
            event, time = record["event"], record["time"]
            acts = event in ("gripping", "releasing") and (ended or not self._passes(record["robot"]))
            if (event in ("moving", "goal") or acts) and (halted or ended):
                self.wrong.append(f"{event} at {time:g} s without an answer to the stop before")
            if event == "node":
                self._node(record)
            elif event == "moving":
                self.nodes = list(record["nodes"])
            elif event == "stopping":
                self.reason, halted = record["reason"], True
            elif event == "answer":
                halted = record["kind"] == "none"
                if not halted:
                    self._take(waiting.pop(0), record["kind"])
            elif event == "stopped":
                ended = True
            elif event == "state":
                self._look(record, moving=not halted)
        return self.wrong

    # ---------------------------------------------------------------------------------------------------- plans
    def _take(self, answer: tuple[str, Plan], kind: str) -> None:
        """The plan of an answer is carried out from here on."""
        self.plan = answer[1]
        if kind != answer[0]:
            self.wrong.append(f"an answer {answer[0]} was logged as {kind}")
        self.cell, self.nodes, self.since = Cell.of(self.scene, self.plan.start or StateChange()), [], None
        if kind not in WAYS:
            self.main = self.plan

    def _node(self, record: Mapping[str, Any]) -> None:
        """A node begins: after a way it is one of the main plan again."""
        back = self.plan is not self.main and record["action"] not in WAYS
        if back or record["node"] not in self.nodes:
            self._settle()
            self.nodes = []
        if back:
            self.plan = self.main

    def _settle(self) -> None:
        """The motion has ended: all is as its nodes say."""
        if self.nodes:
            self.cell = self._at(inf)[0]
            for name in self.nodes:
                after = self.plan.nodes[name].after if name in self.plan.nodes else None
                if after is not None:
                    self.cell.take(after)

    # ---------------------------------------------------------------------------------------------------- looks
    def _at(self, time: float) -> tuple[Cell, list[tuple[str, int]]]:
        """Where everything is at a time of the clock of the motion, and the segments that run."""
        cell, running = self.cell.copy(), []
        for begin, until, name, number, segment in self._pieces():
            if begin > time + 1e-9:
                continue
            own = segment.times[0] + min(time, until) - begin
            cell.joints[segment.robot] |= dict(zip(segment.joints, segment.at(own).tolist(), strict=True))
            if time >= until - 1e-9:
                for body in segment.detach:
                    cell.hang(body, "world")
                for body, parent in segment.attach:
                    cell.hang(body, parent)
            if time <= until + 1e-9:
                running.append((name, number))
        return cell, running

    def _pieces(self) -> list[tuple[float, float, str, int, Segment]]:
        """The segments on the clock of the motion, with their beginnings and ends, in order."""
        pieces: list[tuple[float, float, str, int, Segment]] = []
        offset = end = 0.0
        for name in self.nodes:
            node = self.plan.nodes[name]
            offset = end - node.overlap if pieces else 0.0
            for number, segment in enumerate(node.motion):
                pieces.append((segment.times[0] + offset, segment.times[-1] + offset, name, number, segment))
                end = max(end, pieces[-1][1])
        return sorted(pieces, key=lambda each: (each[1], each[0]))

    def _passes(self, robot: str) -> bool:
        """Whether a hand of the robot acts while another robot moves: then it does so in a stop, too."""
        pieces = self._pieces()
        hands = [
            (begin, until) for begin, until, *_, own in pieces if own.robot == robot and (own.attach or own.detach)
        ]
        others = [(begin, until) for begin, until, *_, own in pieces if own.robot != robot]
        return any(begin < when < until for times in hands for when in times for begin, until in others)

    def _look(self, record: Mapping[str, Any], *, moving: bool) -> None:
        """Compares a record with the plan."""
        if not self.seen:
            self.seen.update(dict.fromkeys(self.scene.movable, record["time"]))
        self.seen.update(dict.fromkeys(record["bodies"], record["time"]))
        cell, running = self._at(record["motion_time"]) if self.nodes else (self.cell, [])
        at_once = dict(self._unproven(record, cell, running))
        before, self.off = self.off, dict(at_once)
        if running and any(thing in self.scene.robots for thing in self.off):
            self.off = self._if_late(record)
        if self.reason is not None:
            self._judge_reason({*before, *at_once, *self._wide(record, cell)}, record["time"])
        stands, self.clock = record["motion_time"] == self.clock, record["motion_time"]
        if not moving or not running or stands:  # what rests may be anywhere: nothing is done
            self.since = None
            return
        if not self.off:
            self.since = None
        elif self.since is None:
            self.since = record["time"]
        elif record["time"] - self.since > NOTICED:
            what = "; ".join(self.off.values())
            self.wrong.append(f"at {record['time']:g} s the run goes on, though {what}")
            self.since = inf

    def _if_late(self, record: Mapping[str, Any]) -> dict[str, str]:
        """What is off where all robots are as late, by up to a tenth of a second, if no robot is off then; or as now."""
        for step in range(1, LATE_STEPS + 1):
            found = dict(self._unproven(record, *self._at(record["motion_time"] - step * LATE_STEP)))
            if not any(thing in self.scene.robots for thing in found):
                return found
        return self.off

    def _unproven(
        self, record: Mapping[str, Any], cell: Cell, running: Sequence[tuple[str, int]]
    ) -> Iterator[tuple[str, str]]:
        """Each thing that is farther from its place than is proven, with a sentence."""
        certificate = self.plan.certificate
        near = 0.0 if certificate is None else certificate.near or 0.0
        proven = {
            (each.node, each.segment): near if each.clearance is None else each.clearance
            for each in (() if certificate is None else certificate.segments)
        }
        links = {}
        for robot, values in record["robots"].items():
            own = self.scene.robots[robot]
            links[robot] = link_poses(own, values)
            wanted = cell.values(robot)
            wanted[own.planned :] = values[own.planned :]  # hands close as far as they find room
            planned = link_poses(own, wanted)
            off = max(float(np.linalg.norm(links[robot][k][:3, 3] - planned[k][:3, 3])) for k in planned)
            mine = [proven.get(key, 0.0) for key in running if self._robot(key) == robot]
            if mine and off > min(mine) + ROUNDING:
                yield robot, f"{robot} is {1000 * off:.1f} mm off its path, {1000 * min(mine):.1f} mm are proven"
        least = self._least(proven)
        for body, found in record["bodies"].items():
            pose, wanted = transform(found["position"], found["quaternion"]), cell.pose(body, links)
            moved = self.corners[body] @ (pose[:3, :3] - wanted[:3, :3]).T + pose[:3, 3] - wanted[:3, 3]
            off = float(np.linalg.norm(moved, axis=1).max())
            if off > least + ROUNDING:
                yield body, f"{body} is {1000 * off:.1f} mm from its place, {1000 * least:.1f} mm are proven"
        for body, last in self.seen.items():
            if record["time"] - last > UNSEEN and least < inf:
                yield body, f"{body} has not been seen since {last:g} s"

    def _robot(self, key: tuple[str, int]) -> str:
        return self.plan.nodes[key[0]].motion[key[1]].robot

    def _least(self, proven: Mapping[tuple[str, int], float]) -> float:
        """The least proven clearance of what may still come, from the nodes of the motion on."""
        names, waiting = set(), self.nodes[:1] or [self.plan.root]
        while waiting:
            name = waiting.pop()
            if name not in names:
                names.add(name)
                waiting += self.plan.nodes[name].successors
        each = [proven.get((n, k), 0.0) for n in names for k in range(len(self.plan.nodes[n].motion))]
        return min(each, default=inf)

    def _wide(self, record: Mapping[str, Any], cell: Cell) -> Iterator[str]:
        """Robots with hands that are wider or narrower than planned."""
        for robot, values in record["robots"].items():
            own = self.scene.robots[robot]
            for number, joint in enumerate(own.gripper.joints if own.gripper else (), own.planned):
                stroke = abs(own.gripper.open.get(joint, 0.0) - own.gripper.closed.get(joint, 0.0))
                if abs(values[number] - cell.values(robot)[number]) > WIDE * stroke:
                    yield robot

    def _judge_reason(self, off: set[str], time: float) -> None:
        """Robots were stopped for a reason, which must name something that is off."""
        if not any(thing in self.reason for thing in off) and not any(text in self.reason for text in OTHER):
            self.wrong.append(f"stopped before {time:g} s since {self.reason}, which no record shows")
        self.reason = None
