"""The plan as data: a directed acyclic graph of action, sense, branch and goal nodes with motions.

Source: docs/reference/plans.md.

Poses are in the frame of the parent, in metres and radians; quaternions are (x, y, z, w).
"""

import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.displays import counted, display
from kabo.given import require_output
from kabo.motion import Trajectory
from kabo.plan.certificate import Certificate

if TYPE_CHECKING:  # imports this file
    from kabo.plan.statistics import PlanStatistics

Arguments = Mapping[str, "str | float | ValueOf"]


@dataclass(frozen=True)
class ValueOf:
    """An argument that is known only at run time: the value of a ground term, as the executor then knows it."""

    term: str


@dataclass(frozen=True)
class ObjectPose:
    """The pose of an object in the frame of its `parent`: `world`, `robot.link` or an object."""

    parent: str
    position: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]


@dataclass(frozen=True)
class StateChange:
    """A geometric state (`start`), or only the part of it that a node changes (`after`)."""

    robots: Mapping[str, Mapping[str, float]] = field(default_factory=dict)  # robot -> joint -> value
    objects: Mapping[str, ObjectPose] = field(default_factory=dict)


@dataclass(frozen=True)
class Grant:
    """The reason why a contact is permitted: a claim that the verifier checks against the scene.

    For the kind `grasp`, `bodies` are a link of the gripper and the object, and `by` is the grasp family. For
    `support`, `bodies` are the object that is lifted or lowered and its support, and `by` is the grasp family that
    declares the lifting motion. For `mate`, `bodies` are the moving and the fixed body, and `by` is the mate. `by`
    is None if no grasp family describes how the object is held.
    """

    kind: Literal["grasp", "support", "mate"]
    bodies: tuple[str, str]
    by: str | None = None


@dataclass(frozen=True)
class Segment:
    """One stretch of motion: a path that is linear in joint space between consecutive way points, and its trajectory.

    `waypoints` is an array of m way points with n values, in the order of `joints` (names in the robot's URDF).
    `times` are the m times at which the trajectory passes the way points, counted from the start of the node's motion
    [s]; without a trajectory (format `kabo-plan/1`) velocities are constant between them. At the end of the
    segment, the objects in `attach` are attached to the given links, and those in `detach` are released. `grants`
    are the reasons for the `allowed_contacts`.
    """

    robot: str
    joints: tuple[str, ...]
    waypoints: tuple[tuple[float, ...], ...]
    times: tuple[float, ...]
    procedure: str
    stage: str | None = None
    attach: tuple[tuple[str, str], ...] = ()
    detach: tuple[str, ...] = ()
    allowed_contacts: tuple[tuple[str, str], ...] = ()
    constraint: str | None = None
    grants: tuple[Grant, ...] = ()
    trajectory: Trajectory | None = None

    def at(self, times: ArrayLike) -> Array:
        """The values (…, n) of the joints at `times` [s]: on the trajectory, or else straight between way points."""
        if self.trajectory is not None:
            return self.trajectory.at(times)
        columns = zip(*self.waypoints, strict=True)
        wanted = np.asarray(times, np.float64)
        return np.stack([np.interp(wanted, self.times, column) for column in columns], axis=-1)

    def __repr__(self) -> str:
        seconds = f"{self.times[-1] - self.times[0]:.1f} s" if self.times else "no time"
        return f"<Segment {self.robot}, {self.procedure}: {counted(len(self.waypoints), 'way point')}, {seconds}>"


@dataclass(frozen=True)
class Learned:
    """Parameters that the motion of a node uses and that were learned by trying, not derived from geometry.

    `model` is the file of the model, relative to the problem. `validity` is the probability that the parameters are
    valid in this case, by the model, and `expected` has the expected outcomes.
    """

    model: str
    case: Mapping[str, str]
    parameters: Mapping[str, float]
    validity: float
    expected: Mapping[str, float]


@dataclass(frozen=True)
class Node:
    """A node of a plan; `kind` decides which fields are set.

    Kind `action`: action, arguments, next. Kind `sense`: action, arguments, and either `on` and `branches` or
    `delivers` and `next`. Kind `branch`: `on` and `branches`. Kind `goal`: no fields. `branches` maps outcomes, in
    their declared order, to node ids.
    """

    kind: Literal["action", "sense", "branch", "goal"]
    action: str | None = None
    arguments: Arguments = field(default_factory=dict)
    next: str | None = None
    on: str | None = None
    branches: Mapping[str, str] = field(default_factory=dict)
    delivers: tuple[str, ...] = ()
    motion: tuple[Segment, ...] = ()
    after: StateChange | None = None
    overlap: float = 0.0  # [s] by which its motion begins before the motion of its only predecessor ends
    learned: tuple[Learned, ...] = ()

    @property
    def successors(self) -> tuple[str, ...]:
        """The ids of the nodes that may follow this node, in the order of the branches."""
        return tuple(self.branches.values()) if self.branches else (() if self.next is None else (self.next,))


@dataclass(frozen=True)
class Done:
    """A step of a run: an action that was carried out, and what was observed of a fact after it; either may be missing."""

    action: str | None
    arguments: Arguments = field(default_factory=dict)
    on: str | None = None
    outcome: str | None = None


@dataclass(frozen=True)
class Plan:
    """A plan: `nodes` by id, to be followed from `root`; `kabo.policy` gives it as a function, `kabo.unfold` as a tree.

    Attributes:
        problem: the name of the problem.
        files: all files that were read, by path from the problem's folder, with their hashes.
        options: the options on which the plan depends.
        root: the id of the first node.
        nodes: the nodes by id; branches that meet share nodes.
        start: where everything is at first; None without geometry.
        done: what was done and observed before the plan begins, if it begins in the state of a run (`kabo.after`) and not
            where the problem does; None otherwise.
        certificate: the proofs that the motions are free of collision; None if there are none.
        certificate_gaps: the motions that a requested certificate cannot prove to be free of collision.
    """

    problem: str
    files: Mapping[str, str]
    options: Mapping[str, str | float | int | None]
    root: str
    nodes: Mapping[str, Node]
    start: StateChange | None = None
    certificate: Certificate | None = None
    certificate_gaps: tuple[str, ...] = ()
    done: tuple[Done, ...] | None = None

    @property
    def statistics(self) -> "PlanStatistics":
        """The counts of actions, nodes, leaves and way points.

        Raises:
            ValueError: the plan has a cycle, which no plan of kabo has.
        """
        from kabo.plan.statistics import plan_statistics

        return plan_statistics(self)

    def print(self) -> None:
        """Writes the plan as an indented tree on standard output, as `kabo solve` does."""
        from kabo.plan.description import describe

        sys.stdout.write(describe(self))

    def save(self, path: str | Path) -> str:
        """Writes the plan's file, completely or not at all; returns its hash, `sha256:…`. `kabo.load_plan` reads it.

        Raises:
            InputError: `path` is no file in a folder that exists.
            OSError: the file cannot be written.
        """
        from kabo.plan.writing import write_plan

        return write_plan(self, require_output("path", path))

    def to_dot(self) -> str:
        """The plan in Graphviz's language DOT, for `dot -Tsvg`: a box for each action, outcomes on the edges."""
        from kabo.plan.graphviz import plan_to_dot

        return plan_to_dot(self)

    def __repr__(self) -> str:
        return f"<Plan {self.problem}: {summary(self)}>"

    def _repr_html_(self) -> str:
        return display(f"Plan of {self.problem}", plan_figures(self), self)


def summary(plan: Plan) -> str:
    """The size of a plan: `36 nodes, 16 outcomes, 18 actions at most`."""
    nodes = counted(len(plan.nodes), "node")
    try:
        figures = plan.statistics
    except ValueError:
        return f"{nodes}, with a cycle"
    return f"{nodes}, {counted(figures.plan_leaves, 'outcome')}, {counted(figures.plan_actions, 'action')} at most"


def plan_figures(plan: Plan) -> dict[str, str]:
    """What a notebook shows of a plan: its size, its motion, its certificate, the options that made it."""
    made = {"size": summary(plan)}
    moving = sum(1 for node in plan.nodes.values() if node.motion)
    if moving:
        points = sum(len(segment.waypoints) for node in plan.nodes.values() for segment in node.motion)
        gaps = len(plan.certificate_gaps)
        made["motion"] = f"{counted(moving, 'node')} with motion, {counted(points, 'way point')}"
        made["certificate"] = (
            "yes" if plan.certificate else f"none, {counted(gaps, 'motion')} cannot be proven" if gaps else "none"
        )
    options = {name: value for name, value in plan.options.items() if value is not None}
    made["options"] = ", ".join(f"{name} {value}" for name, value in options.items())
    return made
