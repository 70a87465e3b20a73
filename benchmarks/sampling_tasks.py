"""The three constraints of `sampling.py` on Panda arms: as rows of kabo, and as plain cost functions for its peers."""

import sysconfig
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from kabo.arrays import Array
from kabo.kinematics import ClosedArm, FrameFeature, JoinedTree, Rows, joined, rows_of, stacked
from kabo.scene import REVOLUTE, KinematicTree, Structure, structure_of

PANDA = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots/panda_description"
LEVER = 0.15  # metres per radian, as in kabo's rows
REACH = 0.1034  # from the Panda's hand to between its finger tips [m]
CENTRE, RADIUS, RIM = (
    np.array([0.5, 0.1]),
    0.05,
    0.28,
)  # of the cylinder: its axis, and the height of the grasp [m]
APART, HELD = (
    0.9,
    0.1,
)  # between the bases of the two arms; between the finger tips and the middle of what they hold
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class Row:
    """A cost of [K Table 5.1] as plain numpy: from the tools' poses (4, 4) its value, and its gradient.

    The gradient is, for each tool, a force at its centre and a moment: what a velocity and a turn there change.
    """

    value: Callable[[Sequence[Array]], float]
    wrenches: Callable[[Sequence[Array]], Sequence[tuple[Array, Array]]]


@dataclass(frozen=True)
class Task:
    """A constraint on one Panda or two: as kabo's rows, and as costs of its peers; `right` excludes mirror images."""

    name: str
    least: int  # valid samples a second that are promised, evened out
    joined: JoinedTree
    rows: Rows
    costs: tuple[Row, ...]
    right: Callable[[Sequence[Array]], bool]
    free: Rows  # the coordinates that are evened out, with the bounds in between

    @property
    def tree(self) -> KinematicTree:
        """The tree of all arms."""
        return self.joined.tree


def _panda_model() -> Any:
    """Pinocchio's model of the arm, its fingers held open."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(PANDA / "urdf/panda.urdf"))
    q = pin.neutral(model)
    q[7:] = 0.04
    fingers = [model.getJointId(f"panda_finger_joint{i}") for i in (1, 2)]
    return pin.buildReducedModel(model, fingers, q)


def _tree(model: Any, base: Array) -> KinematicTree:
    """The tree of a model whose joints all turn about z."""
    count = model.njoints
    placement = np.array([np.concatenate([m.rotation.ravel(), m.translation]) for m in model.jointPlacements])
    placement[0] = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    placement[1, 9:] += base
    ratio = np.ones(count)
    ratio[0] = 0.0
    return KinematicTree(
        np.array(list(model.parents), np.int64),
        np.full(count, REVOLUTE, np.int64),
        np.array([0, *range(count - 1)], np.int64),
        ratio,
        np.zeros(count),
        placement,
        model.lowerPositionLimit.copy(),
        model.upperPositionLimit.copy(),
        model.velocityLimit.copy(),
    )


@dataclass(frozen=True)
class Panda:
    """Pinocchio's model with the fingers held, and the tool: between the finger tips, in the last joint's frame."""

    model: Any
    joint: int
    joint_T_tool: Array

    @classmethod
    def load(cls) -> "Panda":
        """From example-robot-data."""
        model = _panda_model()
        hand = model.frames[model.getFrameId("panda_hand")]
        tool = hand.placement.homogeneous.copy()
        tool[:3, 3] += REACH * tool[:3, 2]
        return cls(model, hand.parentJoint, tool)

    def arm(self, y: float = 0.0) -> ClosedArm:
        """The arm with its closed form, with its base at y [m]."""
        tree = self.tree(y)
        form = structure_of(tree, tree.size)
        assert isinstance(form, Structure)
        return ClosedArm(tree, form, np.zeros(tree.size))

    def tree(self, y: float = 0.0) -> KinematicTree:
        """Kabo's tree of the arm, with its base at y [m]."""
        return _tree(self.model, np.array([0.0, y, 0.0]))

    def feature(self, kind: str, axis: Array | None = None, ahead: float = 0.0) -> FrameFeature:
        """A feature of the tool: at its centre or ahead of it, along one of its axes."""
        x, y, z = (self.joint_T_tool @ [0.0, 0.0, ahead, 1.0])[:3]
        if axis is None:
            return FrameFeature(self.joint, "point", (x, y, z))
        direction = self.joint_T_tool[:3, :3] @ axis
        return FrameFeature(self.joint, kind, (x, y, z), tuple(direction / np.linalg.norm(direction)))  # type: ignore[arg-type]


def _place(tool: int, normal: Array, height: float) -> Row:
    force = normal, np.zeros(3)
    return Row(lambda poses: float(normal @ poses[tool][:3, 3]) - height, lambda poses: [force])


def _turned(axis: Array, towards: Array) -> Row:
    """The component of the first tool's axis along a direction of the world."""

    def wrenches(poses: Sequence[Array]) -> Sequence[tuple[Array, Array]]:
        return [(np.zeros(3), LEVER * np.cross(poses[0][:3, :3] @ axis, towards))]

    return Row(lambda poses: LEVER * float(poses[0][:3, :3] @ axis @ towards), wrenches)


def _around() -> Row:
    """The distance from the cylinder's axis."""

    def wrenches(poses: Sequence[Array]) -> Sequence[tuple[Array, Array]]:
        away = poses[0][:2, 3] - CENTRE
        return [(np.array([*(away / max(float(np.linalg.norm(away)), 1e-9)), 0.0]), np.zeros(3))]

    return Row(lambda poses: float(np.linalg.norm(poses[0][:2, 3] - CENTRE)) - RADIUS, wrenches)


def _through() -> Row:
    """The cylinder's axis lies in the plane in which the fingers close."""
    middle = np.array([*CENTRE, RIM])

    def wrenches(poses: Sequence[Array]) -> Sequence[tuple[Array, Array]]:
        side, offset = poses[0][:3, 0], middle - poses[0][:3, 3]
        return [(-side, np.cross(side, offset))]

    return Row(lambda poses: float(poses[0][:3, 0] @ (middle - poses[0][:3, 3])), wrenches)


def _together(axis: Array) -> Row:
    """What both tools hold is at one place."""

    def wrenches(poses: Sequence[Array]) -> Sequence[tuple[Array, Array]]:
        arms = [HELD * pose[:3, 2] for pose in poses]
        return [(axis, np.cross(arms[0], axis)), (-axis, -np.cross(arms[1], axis))]

    def value(poses: Sequence[Array]) -> float:
        one, other = (pose[:3, 3] + HELD * pose[:3, 2] for pose in poses)
        return float(axis @ (one - other))

    return Row(value, wrenches)


def _across(first: Array, second: Array) -> Row:
    """Axes of the two tools are perpendicular."""

    def wrenches(poses: Sequence[Array]) -> Sequence[tuple[Array, Array]]:
        moment = LEVER * np.cross(poses[0][:3, :3] @ first, poses[1][:3, :3] @ second)
        return [(np.zeros(3), moment), (np.zeros(3), -moment)]

    return Row(lambda poses: LEVER * float((poses[0][:3, :3] @ first) @ (poses[1][:3, :3] @ second)), wrenches)


def tasks(panda: Panda) -> tuple[Task, ...]:
    """Place on a plane, rim grasp of a cylinder, one thing held by two arms."""
    tip, approach = panda.feature("point"), panda.feature("line", Z)
    closing, side = panda.feature("line", Y), panda.feature("plane", X)
    table = FrameFeature(0, "plane", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    axis = FrameFeature(0, "line", (*CENTRE, RIM), (0.0, 0.0, 1.0))
    place = stacked([rows_of("height", tip, table, 0.1, 0.1), rows_of("opposed", approach, table)])
    rim = stacked(
        [
            rows_of("distance", tip, axis, RADIUS, RADIUS),
            rows_of("height", tip, table, RIM, RIM),
            rows_of("opposed", approach, axis),
            rows_of("coincident", FrameFeature(0, "point", axis.origin), side),
        ]
    )
    one, both = joined([panda.tree()]), joined([panda.tree(), panda.tree(APART)])
    held = panda.feature("point", ahead=HELD)
    two = stacked(
        [
            rows_of("coincident", held, both.feature(1, held)),
            rows_of("opposed", approach, both.feature(1, approach)),
            rows_of("perpendicular", closing, both.feature(1, panda.feature("line", X))),
        ]
    )

    def box(point: FrameFeature, middle: tuple[float, ...], half: tuple[float, ...]) -> Rows:
        """The coordinates of a point, within half the sides of a box about its middle."""
        across = [FrameFeature(0, "plane", middle, tuple(axis)) for axis in np.eye(3)]  # type: ignore[arg-type]
        return stacked([rows_of("height", point, p, -h, h) for p, h in zip(across, half, strict=False)])

    def down(poses: Sequence[Array]) -> bool:
        return bool(poses[0][2, 2] < 0.0)

    upright = (_turned(Z, X), _turned(Z, Y))
    head_on = tuple(_across(Z, other) for other in (X, Y))
    return (
        Task(
            "place on a plane",
            200_000,
            one,
            place,
            (_place(0, Z, 0.1), *upright),
            down,
            box(tip, (0.45, 0.0, 0.0), (0.15, 0.5)),
        ),
        Task(
            "rim grasp of a cylinder",
            100_000,
            one,
            rim,
            (_around(), _place(0, Z, RIM), *upright, _through()),
            down,
            rows_of("azimuth", closing, axis),
        ),
        Task(
            "one thing held by two arms",
            60_000,
            both,
            two,
            (*(_together(v) for v in (X, Y, Z)), *head_on, _across(Y, X)),
            lambda poses: bool(poses[0][:3, 2] @ poses[1][:3, 2] < 0.0),
            box(held, (0.45, 0.5 * APART, 0.4), (0.15, 0.2, 0.2)),
        ),
    )
