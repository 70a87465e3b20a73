"""The plan as data: a directed acyclic graph of action, sense, branch and goal nodes with motions (docs/plans.md).

Poses are in the frame of the parent, metres and radians, quaternions (x, y, z, w).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from kabo.plan.certificate import Certificate

Arguments = Mapping[str, "str | float | ValueOf"]


@dataclass(frozen=True)
class ValueOf:
    """A run-time argument: the value of this ground term, as the executor will know it."""

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

    `grasp`: `bodies` are a gripper's link and the object, `by` is the grasp family. `support`: the object that is lifted
    or lowered and its support, `by` is the grasp family whose `lift` the stroke is. `mate`: the moving and the fixed body,
    `by` is the mate. `by` is None where no family declares how the object is held.
    """

    kind: Literal["grasp", "support", "mate"]
    bodies: tuple[str, str]
    by: str | None = None


@dataclass(frozen=True)
class Segment:
    """One stretch of motion: straight between way points and proportional to time between them.

    `waypoints` [m x n] follow `joints` (names in the robot's URDF), `times` [m] s from the start of the node's
    motion; `attach` (object, link to attach to) and `detach` happen at its end. `grants` are the reasons for the
    `allowed_contacts`.
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


@dataclass(frozen=True)
class Node:
    """A node of a plan; `kind` decides which fields are set.

    action: action, arguments, next; sense: action, arguments and `on` with `branches`, or `delivers` with `next`;
    branch: `on`, `branches`; goal: none. `branches` maps outcomes, in their declared order, to node ids.
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

    @property
    def successors(self) -> tuple[str, ...]:
        """The ids of the nodes that may follow, in order."""
        return tuple(self.branches.values()) if self.branches else (() if self.next is None else (self.next,))


@dataclass(frozen=True)
class Plan:
    """A plan; `files` are all files that were read, with their hashes, `options` the resolved options that made it.

    `certificate_gaps`: where a certificate was requested and could not be made, the motions that it cannot prove free.
    """

    problem: str
    files: Mapping[str, str]
    options: Mapping[str, str | float | int | None]
    root: str
    nodes: Mapping[str, Node]
    start: StateChange | None = None
    certificate: Certificate | None = None
    certificate_gaps: tuple[str, ...] = ()
