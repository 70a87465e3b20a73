"""Finds the family of poses that rows describe: which turn and which translations their equalities leave free.

It is read off the rows, not off the names of constraints: the frame is projected onto the equalities as a free body, the
null space of their gradients is taken apart into one turn and translations, and the family is kept only if rows hold
all over it. Rows that leave something else free, such as two turns about different lines, have no family here.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from kabo.arrays import Array
from kabo.content_cache import ContentCache
from kabo.kinematics.constraints import Rows, stacked
from kabo.kinematics.joined_trees import FREE_BODY
from kabo.kinematics.kernels import families as kernels
from kabo.kinematics.kernels import rows as columns
from kabo.kinematics.kernels.closed_form import poses_of
from kabo.kinematics.kernels.families import Family
from kabo.kinematics.projection import project
from kabo.scene.transforms import unflat
from kabo.streams import stream_key, uniforms

SEEDS = 16  # poses projected onto the equalities, of which some reach them
MAX_COMPONENTS = 4
POSES_CHECKED = 8  # of each component: rows must hold there
START_TOLERANCE = 1e-12  # [m or rad] of rows at the start of a component
FAMILY_TOLERANCE = 1e-9  # [m or rad] of rows at other poses of a family
DECIMALS = 13  # of axes [m] and directions, far finer than poses have to hold
RANK_CUTOFF = 1e-6  # [m/rad, m/m] of singular values
SAME_POSE = 1e-5  # [m, or of a direction] within which poses belong to one component
ROWS_DECIMALS = 12  # of rows, within which two sets of rows have one family
MIN_GAIN = 0.3  # of the unit normal of a plane that lies along translations still free
_SPREAD = 0.5  # [m] of the seeds about the origin
_ANYWHERE = np.full(FREE_BODY.size, np.inf)
_FAMILIES: ContentCache[Family | None] = ContentCache(1 << 20, lambda _: 0)

UNMOVED: Array = np.eye(4)

Placed = Mapping[
    int, tuple[int, Array]
]  # joint of rows: which of two frames carries it, and its pose (4, 4) there


def between_frames(rows: Rows, placed: Placed) -> Rows | None:
    """The rows with joints replaced by the frame, 0 or 1, that carries them; None if a joint is not among them."""
    moved: Rows = np.array(rows)
    for row in moved:
        for column in (columns.FIRST, columns.SECOND):
            if int(row[column]) not in placed:
                return None
            frame, frame_T_joint = placed[int(row[column])]
            _move(row, column, frame, frame_T_joint)
    return moved


def _move(row: Array, column: int, frame: int, frame_T_joint: Array) -> None:
    """Gives one feature of a row in another frame; an origin that holds a direction only turns."""
    kind = row[columns.KIND]
    origin, direction = slice(column + 1, column + 4), slice(column + 4, column + 7)
    if frame_T_joint is UNMOVED:
        row[column] = frame
        row[origin] += 0.0  # no negative zeros, as where something is added
        return
    turn = frame_T_joint[:3, :3]
    is_direction = (kind == columns.ALIGNED and column == columns.FIRST) or (
        kind == columns.AZIMUTH and column == columns.SECOND
    )
    row[column] = frame
    row[origin] = turn @ row[origin] + (0.0 if is_direction else frame_T_joint[:3, 3])
    row[direction] = turn @ row[direction]


def family_of(rows: Rows, free: Rows | None = None) -> Family | None:
    """The family of poses of frame 1 in frame 0 that rows between these frames describe; None if it has no such form.

    Args:
        rows: (R, W) from `between_frames`, which must hold.
        free: rows that the parameters are spread along, and that need not hold.
    """
    every = np.array(rows) if free is None else stacked([rows, free])
    origin = next((row[at].copy() for row in every for at in _origins(row)), np.zeros(3))
    _shift(every, -origin)
    # Rounded, so that things alike at different places share their family: a family moves along with frame 0.
    known = np.round(every, ROWS_DECIMALS) + 0.0
    key = known.tobytes(), len(rows)
    family = _FAMILIES.get_or_make(key, lambda: _found(known[: len(rows)], known[len(rows) :]))
    return None if family is None else _moved(family, origin)


def _origins(row: Array) -> list[slice]:
    """Where a row has points of frame 0."""
    kind, found = row[columns.KIND], []
    for column, direction in ((columns.FIRST, columns.ALIGNED), (columns.SECOND, columns.AZIMUTH)):
        if row[column] == 0 and kind != direction:
            found.append(slice(column + 1, column + 4))
    return found


def _shift(rows: Rows, by: Array) -> None:
    """Moves all points of frame 0 in place."""
    for row in rows:
        for at in _origins(row):
            row[at] += by


def _moved(family: Family, by: Array) -> Family:
    """The family with everything in frame 0 moved."""
    moved = family._replace(
        starts=family.starts.copy(),
        axes=family.axes.copy(),
        aimed=family.aimed.copy(),
        checked=family.checked.copy(),
        azimuths=family.azimuths.copy(),
    )
    moved.starts[:, 9:] += by
    moved.axes[:, 3:] += by
    for part in (moved.aimed, moved.checked, moved.azimuths):
        _shift(part, by)
    return moved


def _found(rows: Rows, free: Rows) -> Family | None:
    equal = rows[rows[:, columns.LOWER] == rows[:, columns.UPPER]]
    components: list[_Component] = []
    for start in _starts(equal):
        if not any(each.contains(start) for each in components):
            made = _Component.at(equal, start)
            if made is None or len(components) == MAX_COMPONENTS:
                return None
            if components and not components[0].is_like(made):
                return None
            components.append(made)
    if not components:
        return None
    family = _with_aims(components, rows[rows[:, columns.LOWER] < rows[:, columns.UPPER]], free)
    return family if family is not None and _holds(family, equal) else None


def _starts(equal: Rows) -> list[Array]:
    """Poses (12,) at which the equalities hold, from seeds about the origin."""
    seeds = (2.0 * uniforms(stream_key("family"), 0, SEEDS, FREE_BODY.size) - 1.0) * [*[_SPREAD] * 3, *[np.pi] * 3]
    flying = equal.copy()
    sides = (columns.FIRST, columns.SECOND)
    flying[:, sides] = np.where(flying[:, sides] == 0, 0, FREE_BODY.size)
    flying[:, columns.TOLERANCE] = START_TOLERANCE
    found, valid = project(
        FREE_BODY, flying, seeds, -_ANYWHERE, _ANYWHERE, np.ones(FREE_BODY.size, np.bool_), inset=0.0
    )
    return list(poses_of(found[valid], FREE_BODY.size, FREE_BODY))


class _Component:
    """One connected set of poses: a start, the turn about a line or point, and translations (k, 3)."""

    def __init__(self, start: Array, turn: int, axis: Array, slides: Array) -> None:
        self.start, self.turn, self.axis, self.slides = start, turn, axis, slides

    @classmethod
    def at(cls, equal: Rows, start: Array) -> "_Component | None":
        """The component of a pose; None if what is free there is not one turn and translations."""
        _, wrenches = kernels.rows_at(equal, start[None])
        sense = np.where(equal[:, columns.FIRST] == 1, 1.0, 0.0) - (equal[:, columns.SECOND] == 1)
        J = wrenches[0] * (sense * equal[:, columns.SCALE])[:, None]
        slides, twists = _null(J[:, :3]), _null(J)
        across = np.eye(3) - slides.T @ slides
        freedom = len(twists) - len(slides)
        if freedom == 0:
            return cls(start, kernels.FIXED, np.array([0.0, 0.0, 1.0, *start[9:]]), slides)
        _, _, mixed = np.linalg.svd(twists[:, 3:].T)
        turning = mixed[:freedom] @ twists  # those of the twists that turn
        if freedom == 1:
            most = turning[0, 3 + np.argmax(np.round(np.abs(turning[0, 3:]), DECIMALS))]
            unit = np.sign(most) * turning[0] / np.linalg.norm(turning[0, 3:])  # not by LAPACK's sign
            axis = unit[3:]
            shift = across @ unit[:3]
            if abs(axis @ shift) > RANK_CUTOFF:  # a screw
                return None
            return cls(start, kernels.ONE_TURN, np.array([*axis, *np.cross(axis, shift)]), slides)
        if freedom == 3:
            # The point p that stays: p x w = v for each twist, up to translations.
            A = np.concatenate([across @ _crossing(-w) for w in turning[:, 3:]])
            b = np.concatenate([across @ v for v in turning[:, :3]])
            point = np.linalg.lstsq(A, b, rcond=1e-9)[0]
            if np.abs(A @ point - b).max() > RANK_CUTOFF:
                return None
            return cls(start, kernels.ANY_TURN, np.array([0.0, 0.0, 1.0, *point]), slides)
        return None

    def is_like(self, other: "_Component") -> bool:
        """Whether another component has the same freedom, so that both fit into one family."""
        across = np.eye(3) - self.slides.T @ self.slides
        return (
            self.turn == other.turn
            and len(self.slides) == len(other.slides)
            and bool(np.all(np.abs(across @ other.slides.T) < SAME_POSE))
        )

    def contains(self, pose: Array) -> bool:
        """Whether the turn and translations lead from the start to a pose (12,)."""
        goal, begin = unflat(pose), unflat(self.start)
        turn = goal[:3, :3] @ begin[:3, :3].T
        if self.turn == kernels.FIXED and np.abs(turn - np.eye(3)).max() > SAME_POSE:
            return False
        if self.turn == kernels.ONE_TURN and np.abs(turn @ self.axis[:3] - self.axis[:3]).max() > SAME_POSE:
            return False
        shift = goal[:3, 3] - self.axis[3:] - turn @ (begin[:3, 3] - self.axis[3:])
        return bool(np.abs(shift - self.slides.T @ (self.slides @ shift)).max() <= SAME_POSE)


def _null(J: Array) -> Array:
    """An orthonormal basis (k, n) of the null space of a matrix (R, n): the same one on each processor.

    LAPACK gives one of many, by its last bits. All have the same projection onto the space, of which the basis is made
    here: the longest column first, the first of those that are equally long.
    """
    if not len(J):
        return np.eye(J.shape[1])
    _, singular, turned = np.linalg.svd(J, full_matrices=True)
    some = turned[int(np.sum(singular > RANK_CUTOFF)) :]
    left, basis = some.T @ some, np.empty_like(some)
    for row in basis:
        k = int(np.argmax(np.round(np.diag(left), DECIMALS)))
        row[:] = left[k] / np.sqrt(left[k, k])
        left = left - np.outer(row, row)
    return _without_last_bits(basis)


def _without_last_bits(numbers: Array) -> Array:
    """What came through LAPACK without its last bits, which depend on the processor; no zero is negative."""
    return np.asarray(np.round(numbers, DECIMALS) + 0.0)


def _crossing(w: Array) -> Array:
    """The matrix of the product w x p."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def _with_aims(components: Sequence[_Component], intervals: Rows, free: Rows) -> Family | None:
    """The family of components whose parameters aim at intervals and free rows; None if a free row cannot be aimed at."""
    first = components[0]
    aimed: list[Array] = []
    checked: list[Array] = []
    azimuths: list[Array] = []
    for row in intervals:
        (aimed if _is_aim([*aimed, row], first.slides) else checked).append(row)
    for row in free:
        if row[columns.KIND] == columns.AZIMUTH:
            # Any turn is even about every line as it is, and no turn leaves nothing to even out.
            if first.turn == kernels.ONE_TURN:
                azimuths.append(row)
        elif _is_aim([*aimed, row], first.slides):
            aimed.append(row)
        else:
            return None
    zeros = _zeros(components, azimuths)
    if len(azimuths) > 1 or zeros is None:
        return None
    normals = np.array([row[12:15] for row in aimed]).reshape(-1, 3) @ first.slides.T
    gains = np.linalg.pinv(normals).T @ first.slides if aimed else np.empty((0, 3))
    loose = _null(normals) @ first.slides if len(first.slides) else np.empty((0, 3))
    return Family(
        np.ascontiguousarray([each.start for each in components]),
        first.turn,
        np.ascontiguousarray([_without_last_bits(each.axis) for each in components]),
        zeros,
        stacked(_rows(azimuths)),
        stacked(_rows(aimed)),
        np.ascontiguousarray(_without_last_bits(gains)),
        np.ascontiguousarray(_without_last_bits(loose)),
        stacked(_rows(checked)),
    )


def _rows(of: Sequence[Array]) -> list[Array]:
    return [row[None] for row in of]


def _is_aim(rows: Sequence[Array], slides: Array) -> bool:
    """Whether the last of some rows is a height above a plane of frame 0 that translations can choose as well."""
    row = rows[-1]
    if row[columns.KIND] != columns.PLANE or (row[columns.FIRST], row[columns.SECOND]) != (1, 0):
        return False
    if not 0.0 < row[columns.UPPER] - row[columns.LOWER] < np.inf:
        return False
    normals = np.array([each[12:15] for each in rows]) @ slides.T
    return len(rows) <= len(slides) and bool(np.linalg.svd(normals, compute_uv=False)[-1] > MIN_GAIN)


def _zeros(components: Sequence[_Component], azimuths: Sequence[Array]) -> Array | None:
    """The azimuth (C, 2) at each start, and the sense of its change; None if the turn is not about its line."""
    zeros = np.zeros((len(components), 2))
    for row in azimuths:
        for zero, each in zip(zeros, components, strict=True):
            if (row[columns.FIRST], row[columns.SECOND]) == (1, 0):
                along = float(row[12:15] @ each.axis[:3])
            else:
                return None
            if abs(along) < 1.0 - RANK_CUTOFF:
                return None
            zero[:] = kernels.rows_at(row[None], each.start[None])[0][0, 0], round(along)
    return zeros


def _holds(family: Family, equal: Rows) -> bool:
    """Whether the equalities hold at poses all over the family, however it turns and slides."""
    count = POSES_CHECKED * len(family.starts)
    shares = uniforms(stream_key("check"), 0, count, kernels.MOST_SHARES)
    which = np.arange(count) % len(family.starts)
    poses, _ = kernels.poses_drawn(family, which, shares, np.zeros(3), 1.0)
    values, _ = kernels.rows_at(equal, poses)
    return bool(np.all(np.abs(values - equal[:, columns.LOWER]) <= FAMILY_TOLERANCE))
