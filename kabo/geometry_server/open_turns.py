"""The rotation about the object that a grasp family leaves open, along which samples are spread [K 5.2.4].

Projection from random seeds covers this rotation, but unevenly. It is found from the rows alone: the tool is
treated as a free body, and where it fulfils the rows, an azimuth that they leave open has an independent gradient.
"""

import hashlib

import numpy as np

from kabo.arrays import Array
from kabo.content_cache import ContentCache
from kabo.geometry_server.frames import Frame
from kabo.kinematics import FREE_BODY, FrameFeature, jacobian, rows_of, sample, stacked, values
from kabo.kinematics.kernels import rows as columns
from kabo.scene import KinematicTree
from kabo.streams import stream_key

POSES_PROJECTED = 8  # seeds, of which some reach the rows
MIN_SINE = 0.3  # of the angle between the axis and the direction that is rotated about it
MIN_SINGULAR_VALUE = 1e-3  # above which a gradient counts as independent
VERTICAL = (0.0, 0.0, 1.0)


def open_turn(rows: Array, moving: Frame) -> Array | None:
    """A row (1, W) that measures a rotation of a moving frame which the rows do not fix; None if there is none.

    The result is also None if rows depend on joints other than the frame's joint and the world.
    """
    joints = rows[:, (columns.FIRST, columns.SECOND)]
    if not len(rows) or not np.all((joints == 0) | (joints == moving.joint)):
        return None
    flying = rows.copy()
    flying[:, (columns.FIRST, columns.SECOND)] = np.where(joints == 0, 0, FREE_BODY_TWICE.size)
    key = hashlib.sha256(flying.tobytes() + moving.joint_T_frame.tobytes()).digest(), len(flying)
    found = _TURNS.get_or_make(key, lambda: _found(flying, moving.joint_T_frame))
    if found is None:
        return None
    direction, axis = found
    turned = FrameFeature(moving.joint, "line", (0.0, 0.0, 0.0), direction)
    return rows_of("azimuth", turned, FrameFeature(0, "line", (0.0, 0.0, 0.0), axis))


_Direction = tuple[float, float, float]


def _moved_twice() -> KinematicTree:
    """The tree of a free body on a free body: the first sets a pose, the second's six values move it in every direction."""
    tree, n = FREE_BODY, FREE_BODY.size
    count = np.arange(2 * n + 1)
    twice = [np.concatenate([a, a[1:]]) for a in (tree.kind, tree.ratio, tree.shift, tree.placement)]
    limits = [np.concatenate([a, a]) for a in (tree.lower, tree.upper, tree.velocity)]
    before = np.maximum(count - 1, 0)
    return KinematicTree(before, twice[0], before, *twice[1:], *limits)


FREE_BODY_TWICE = _moved_twice()
OUTER_BODY_VALUES = np.arange(FREE_BODY_TWICE.size) < FREE_BODY.size


_TURNS: ContentCache[tuple[_Direction, _Direction] | None] = ContentCache(1 << 20, lambda _: 0)


def _found(rows: Array, pose: Array) -> tuple[_Direction, _Direction] | None:
    """The direction that is rotated, in the joint's frame, and the axis in the world."""
    tree = FREE_BODY_TWICE
    Q, right = sample(
        tree, rows, stream_key("open"), 0, POSES_PROJECTED, tree.lower, tree.upper, OUTER_BODY_VALUES
    )
    if not right.any():
        return None
    turns = [_direction(pose[:3, axis]) for axis in (2, 1, 0)]
    for axis in _axes(rows):
        about = FrameFeature(0, "line", (0.0, 0.0, 0.0), axis)
        moved = [FrameFeature(tree.size, "line", (0.0, 0.0, 0.0), turn) for turn in turns]
        candidates = stacked([rows_of("azimuth", turn, about) for turn in moved])
        cosines = stacked([rows_of("angle", turn, about, 0.5, 0.5) for turn in moved])
        sines = np.min([np.sin(values(cosines, q, tree)) for q in Q[right]], axis=0)
        best = int(np.argmax(np.round(sines, 3)))
        if sines[best] > MIN_SINE and all(_is_new(rows, candidates[best], q) for q in Q[right]):
            return turns[best], axis
    return None


def _axes(rows: Array) -> list[_Direction]:
    """The directions in the world that rows refer to, in their order, then the vertical."""
    found: list[_Direction] = []
    for row in rows:
        aligned = row[columns.KIND] == columns.ALIGNED
        first = row[2:5] if aligned else row[5:8]
        for joint, direction in ((row[columns.FIRST], first), (row[columns.SECOND], row[12:15])):
            if joint == 0 and np.linalg.norm(direction) > 0.5:
                found.append(_direction(direction))
    return list(dict.fromkeys([*found, VERTICAL]))


def _direction(of: Array) -> _Direction:
    x, y, z = (round(float(v), 12) + 0.0 for v in of / np.linalg.norm(of))
    return x, y, z


def _is_new(rows: Array, azimuth: Array, q: Array) -> bool:
    """Whether some motion of the body changes the azimuth and keeps all equalities."""
    equal = rows[rows[:, columns.LOWER] == rows[:, columns.UPPER]]
    gradient = jacobian(azimuth[None], q, FREE_BODY_TWICE)[0, ~OUTER_BODY_VALUES]
    if len(equal):
        _, singular, turned = np.linalg.svd(
            jacobian(equal, q, FREE_BODY_TWICE)[:, ~OUTER_BODY_VALUES], full_matrices=False
        )
        held = turned[singular > MIN_SINGULAR_VALUE]
        gradient = gradient - held.T @ (held @ gradient)
    return bool(np.linalg.norm(gradient) > 100 * MIN_SINGULAR_VALUE)
