"""The motion along a smooth path from rest to rest: time law, knots, pieces, and the way points that it passes."""

from statistics import median
from typing import NamedTuple

import numpy as np

from kabo.arrays import Array, Integers
from kabo.motion.blending import MIN_PIECE_LENGTH, Blended
from kabo.motion.kernels.chords_of_path import way_points_on
from kabo.motion.kernels.grids import grid_of, sampled_speeds, with_rest_cells
from kabo.motion.kernels.laws import law_in_time
from kabo.motion.kernels.pieces import few_pieces, knots_of, states_at, times_at, used_shares
from kabo.motion.limits import Held, MotionLimits
from kabo.motion.rounding import rounded_coefficients
from kabo.motion.s_curves import LIMIT_ROUNDING, LIMIT_SHARE, MAX_LIMIT

SAMPLES_PER_PIECE = 24  # of a path, for its grid
STEP_OF_RAMP = 0.55  # a cell of the grid takes this share of the time in which acceleration is built up
# Cells of equal time, at most: more than this only where a piece of the path needs more than its time.
MAX_CELLS, MAX_CELLS_PER_PIECE = 80, 25
PRECISION = 2e-3  # share by which the law may be slower than the fastest one
MAX_STEPS = 300
# Shares of velocity, acceleration and jerk for the law: pieces between knots may use a little more.
LAW_SHARES = np.array([0.9995, 0.995, 0.97])
LONGEST_PIECE = 1_950_000  # microseconds: rounded coefficients of longer quintic pieces are not precise enough
MIN_TICKS = 2000  # microseconds of a motion with rounded corners, at least
LEAST_GAP = 300  # microseconds between knots, less only in short motions
MAX_ROUNDS = 12  # of making the motion a little slower until all limits are kept
WORTH_SOLVING = 1.002  # where the motion would be slower than this by a few pieces, the law is found again instead
MAX_LAWS = 3
LEAST_SPARE = 1e-6  # [m/s²] beside gravity: what is held with less cannot be moved
# Shares of the way with constant jerk from rest, of a curved and of a straight piece, that the first cell takes.
REST_SHARES = (0.97, 0.15, 0.45)
CURVATURE_SAMPLES = 33


class Section(NamedTuple):
    """A motion from rest to rest: ends of pieces (k + 1,), in whole microseconds from 0, and their coefficients.

    `passing` (m,) are the whole microseconds when it passes way points, and `corners` their indices among these.
    """

    ends: Integers
    coefficients: Array
    passing: Integers
    corners: list[int]


class _Law(NamedTuple):
    times: Array
    pieces: Array  # the parameter in time
    owner: Integers
    path: Array
    borders: Array
    curved: Array


class _Pieces(NamedTuple):
    knots: Integers
    kept: Array
    ends: Integers
    coefficients: Array
    slower: float  # the factor of time by which limits are kept


def section(path: Blended, limits: MotionLimits, chord: float, tolerance: float, held: Held | None) -> Section:
    """The fastest motion along a path with rounded corners, within all limits.

    Args:
        path: it stops only at its ends.
        limits: of the n joints.
        chord: how far the path between way points may be from the blend [rad, L2].
        tolerance: how far joints may leave the blend where pieces are merged [rad or m].
        held: what the robot holds.

    Raises:
        ValueError: what is held cannot even be held at rest.
    """
    full = np.minimum(np.stack(limits.rows), MAX_LIMIT)
    full = full - np.minimum(LIMIT_SHARE * full + LIMIT_ROUNDING, full / 2)
    problem = _Problem.of(path, full, held)
    shares = np.tile(LAW_SHARES, (len(problem.owner), 1))
    for _ in range(MAX_LAWS):
        law, factor = problem.law(shares), 1.0
        made = _pieces(law, full, 1.0, tolerance, held)
        if made.slower <= WORTH_SOLVING or not _tightened(shares, law, made, full):
            break
    for _ in range(MAX_ROUNDS):
        if made.slower <= 1.0:
            break
        factor *= made.slower + 1e-6
        made = _pieces(law, full, factor, tolerance, held)
    wanted, corners = way_points(path, chord)
    ticks = int(made.ends[-1])
    passed = np.round(times_at(law.times, law.pieces, wanted[1:-1]) * (ticks / law.times[-1]))
    inner = _snapped(np.asarray(passed, np.int64), made.knots[made.kept], ticks)
    return Section(made.ends, made.coefficients, np.concatenate([[0], inner, [ticks]]), corners)


def _pieces(law: _Law, full: Array, factor: float, tolerance: float, held: Held | None) -> _Pieces:
    """The pieces of a law that is slower by about `factor`, in whole microseconds."""
    ticks = max(int(np.ceil(law.times[-1] * factor * 1e6)), MIN_TICKS)
    factor = ticks / (law.times[-1] * 1e6)
    gap = max(2, min(LEAST_GAP, ticks // 200))
    knots, kept = knots_of(law.times, law.owner, law.curved, factor, gap)
    states = states_at(knots, law.times, law.pieces, law.owner, law.path, law.borders, factor)
    ends, pieces = few_pieces(knots, kept, states, full, tolerance, LONGEST_PIECE)
    pieces = rounded_coefficients(pieces, np.diff(ends) / 1e6)
    used = used_shares(ends, pieces, full)
    slower = float(max(used[0], np.sqrt(used[1]), np.cbrt(used[2])))
    if held is not None:
        slower = max(slower, held_share(ends, pieces, held))
    return _Pieces(knots, kept, ends, pieces, slower)


def _tightened(shares: Array, law: _Law, made: _Pieces, full: Array) -> bool:
    """Lowers the shares of limits in cells during which pieces exceed them; whether there are any."""
    found = False
    for k in range(len(made.ends) - 1):
        used = used_shares(made.ends[k : k + 2], made.coefficients[k : k + 1], full)
        if used.max() > 1.0:
            begin, end = (np.searchsorted(law.times, made.ends[i] * 1e-6) for i in (k, k + 1))
            shares[max(begin - 1, 0) : end + 1] /= np.maximum(used * 1.002, 1.0)
            found = True
    return found


class _Problem(NamedTuple):
    """What the time law is computed from: path, grid, limits."""

    path: Array
    borders: Array
    curved: Array
    grid: Array
    owner: Integers
    full: Array
    held: Array

    @classmethod
    def of(cls, path: Blended, full: Array, held: Held | None) -> "_Problem":
        """The grid of a path, and what a held body needs on it."""
        pieces, borders, curved = with_rest_cells(
            path.coefficients, path.borders, path.curved, full, REST_SHARES, MAX_LIMIT
        )
        ramp = median((full[1] / np.maximum(full[2], 1e-300)).tolist())
        places, squares, _ = sampled_speeds(pieces, borders, full, SAMPLES_PER_PIECE, 1e-300)
        grid, owner = grid_of(
            places, squares, curved, STEP_OF_RAMP * ramp, MAX_CELLS + MAX_CELLS_PER_PIECE * len(curved)
        )
        return cls(pieces, borders, curved, grid, owner, full, _held_rows(path, grid, held))

    def law(self, shares: Array) -> _Law:
        """The fastest law that uses the shares (N, 3) of the limits of velocity, acceleration and jerk in each cell."""
        given = self.path, self.borders, self.curved, self.grid, self.owner, self.full, shares, self.held
        times, cells, steps = law_in_time(*given, PRECISION, MAX_STEPS)
        if steps < 0:
            raise ValueError("no motion along the path keeps the limits")
        return _Law(times, cells, self.owner, self.path, self.borders, self.curved)


def _held_rows(path: Blended, grid: Array, held: Held | None) -> Array:
    """Rows (N + 1, 2, 3) of X'/2 and X'' over the greatest acceleration; gravity in the first; none without a body."""
    if held is None:
        return np.zeros((1, 2, 3))
    if held.spare <= LEAST_SPARE:
        raise ValueError(
            f"what is held slips even at rest: {held.acceleration:.3g} m/s² at most, gravity is "
            f"{np.linalg.norm(held.gravity):.3g} m/s²"
        )
    most = held.acceleration - 0.02 * held.spare
    step = min(1e-3, path.length / 100)
    middle = np.clip(grid, step, path.length - step)
    before, here, after = (held.places(path.at(middle + d)) for d in (-step, 0.0, step))
    rows = np.stack([(after - before) / (4.0 * step), (after - 2.0 * here + before) / step**2], axis=1) / most
    rows[0, 0] = np.asarray(held.gravity) / most
    return np.ascontiguousarray(rows)


def held_share(ends: Integers, pieces: Array, held: Held) -> float:
    """The factor of time by which all that is held keeps its bound; 1 if it does.

    Accelerations are differences of places every few milliseconds; a hundredth of what is to spare is left for the rest.
    """
    step = min(1e-3, (ends[-1] - ends[0]) * 1e-6 / 20)
    times = np.arange(step, ends[-1] * 1e-6 - step, 4.0 * step)
    knots = ends * 1e-6

    def at(moments: Array) -> Array:
        k = np.clip(np.searchsorted(knots, moments, side="right") - 1, 0, len(pieces) - 1)
        local = (moments - knots[k])[:, None]
        return np.asarray(sum(pieces[k, :, order] * local**order for order in range(pieces.shape[2])))

    rows = [at(times + d) for d in (-step, 0.0, step)]
    shares = [1.0]
    for each in (held, *held.others):
        before, here, after = (each.places(row) for row in rows)
        found, gravity = (after - 2.0 * here + before) / step**2, np.asarray(each.gravity)
        bound = each.acceleration - 0.01 * each.spare
        shares.append(_slower(found, gravity, bound))
    return max(shares)


def _slower(found: Array, gravity: Array, bound: float) -> float:
    """The least factor of time by which accelerations (k, 3) differ from gravity by no more than a bound."""
    along, squares = found @ gravity, (found**2).sum(axis=1)
    along, squares = along[squares > 0.0], squares[squares > 0.0]
    most = (along + np.sqrt(along**2 + squares * (bound**2 - float(gravity @ gravity)))) / squares
    return float(1.0 / np.sqrt(most.min(initial=np.inf)))


def way_points(path: Blended, chord: float) -> tuple[Array, list[int]]:
    """Parameters of the way points, and where the corners are among them: few on blends, none between on straights."""
    found, corners = way_points_on(
        path.places, path.borders, path.coefficients, path.curved, chord, CURVATURE_SAMPLES, MIN_PIECE_LENGTH
    )
    return found, corners.tolist()


def _snapped(passing: Integers, kept: Integers, ticks: int) -> Integers:
    """Times of way points: those within some microseconds of where a blend begins or ends, exactly there."""
    k = np.clip(np.searchsorted(kept, passing), 1, len(kept) - 1)
    nearest = np.where(passing - kept[k - 1] <= kept[k] - passing, kept[k - 1], kept[k])
    close = (np.abs(nearest - passing) <= 2) & (nearest > 0) & (nearest < ticks)
    found = np.where(close, nearest, passing)
    return np.asarray(np.clip(found, np.arange(1, len(found) + 1), ticks - np.arange(len(found), 0, -1)))
