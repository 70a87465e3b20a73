"""The trajectory as data: polynomial pieces in time for each joint, beside the path that they follow."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain, pairwise
from math import inf, isfinite
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kabo.arrays import Array
from kabo.given import refuse, require_given, require_number, shown
from kabo.motion.bernstein import MAX_DEGREE, derivative, ranges, recentred, values
from kabo.motion.following import Rows, divided_path, require_way_points
from kabo.motion.rounding import rounded_coefficients

TIME_DECIMALS = 9  # of times that are computed from others: whole microseconds stay whole
SAME_TIME = 1e-12  # [s]: a time that is so near such a number is that number; others stay as they are
SAME_PLACE = 1e-9  # [rad or m]: two trajectories can be joined if their ends differ by less
FACTORS = 1e-6, 1e6  # of time, by which a motion can be scaled
MAX_SAMPLES = 10**8  # of one motion

_SEQUENCES = "joints", "waypoints", "times", "coefficients"
_NESTED = "coefficients must be a tuple of numbers for each joint of each piece"
_OF_ARRAYS = {np.ndarray: "`Trajectory.of_arrays` takes arrays"}

Coefficients = tuple[tuple[tuple[float, ...], ...], ...]


class Samples(NamedTuple):
    """A trajectory as a controller reads it: times (k,) [s], and for each time the values (k, n) of all joints."""

    times: Array
    positions: Array
    velocities: Array
    accelerations: Array


@dataclass(frozen=True)
class Trajectory:
    """The motion of some joints: piece k is a polynomial in the time since `times[k]`, for each joint.

    Attributes:
        joints: the names of the n joints, in the order of the way points.
        waypoints: the path that is followed, m configurations of n values, straight in joint space between them; none
            where nobody asks for one.
        times: the k + 1 ends of the k pieces [s], strictly increasing, counted as in the node's motion.
        coefficients: for each piece and each joint at most six numbers, in increasing powers of the time since the
            beginning of the piece [rad or m, and s].
        deviation: no joint is ever farther than this from the path [rad or m]; 0 if it is followed exactly.

    Raises:
        ArgumentError: something is of another kind; whether the numbers make a motion is seen in `padded`.
    """

    joints: tuple[str, ...]
    waypoints: Rows
    times: tuple[float, ...]
    coefficients: Coefficients
    deviation: float = 0.0

    def __post_init__(self) -> None:
        """Looks at kinds alone, and at no coefficient: planning makes thousands of motions."""
        for name in _SEQUENCES:
            given = getattr(self, name)
            if not isinstance(given, (tuple, list)):
                refuse(name, f"{name} must be a tuple, not {shown(given)}", _OF_ARRAYS.get(type(given)))
        _require_kind("joints", self.joints, str, "names of joints")
        _require_kind("times", self.times, Real, "numbers")
        _require_kind("waypoints", self.waypoints, (tuple, list), "tuples of numbers")
        _require_kind("waypoints", chain.from_iterable(self.waypoints), Real, "tuples of numbers")
        _require_kind("deviation", (self.deviation,), Real, "a number")

    @classmethod
    def linear(
        cls, joints: Sequence[str], waypoints: Sequence[Sequence[float]], times: Sequence[float]
    ) -> "Trajectory":
        """The motion at constant velocity between way points (m, n), which are reached at m `times` [s].

        Velocities jump at way points: it is what plans of the format `kabo-plan/1` say, and no controller follows it.

        Raises:
            ArgumentError: something is of another kind.
            ValueError: there are not as many times as way points, or times do not increase.
        """
        rows, times = _rows(waypoints), _array("times", times, 1).tolist()
        if len(times) != len(rows) or not rows:
            raise ValueError(f"{len(times)} times for {len(rows)} way points: each is reached at one")
        _require_increasing(times)
        steps = list(zip(rows, rows[1:], times, times[1:], strict=False))
        pieces = tuple(
            tuple((a, (b - a) / (t1 - t0)) for a, b in zip(row, after, strict=True))
            for row, after, t0, t1 in steps
        )
        return cls(_names(joints), rows, tuple(times), pieces)

    @classmethod
    def of_arrays(
        cls, joints: Sequence[str], waypoints: ArrayLike, times: ArrayLike, padded: Array, deviation: float = 0.0
    ) -> "Trajectory":
        """The motion from arrays: way points (m, n), times (k + 1,), coefficients (k, n, up to 6).

        Raises:
            ArgumentError: something is of another kind, or an array has another number of axes.
        """
        coefficients = _trimmed(_array("coefficients", padded, 3))
        own = tuple(_array("times", times, 1).tolist())
        _require_kind("deviation", (deviation,), Real, "a number")
        return cls(_names(joints), _rows(waypoints), own, coefficients, float(deviation))

    @property
    def duration(self) -> float:
        """The time from the beginning to the end [s]."""
        return self.times[-1] - self.times[0]

    @cached_property
    def padded(self) -> Array:
        """The coefficients as an array (pieces, joints, 6), with zeros for powers that a piece does not have.

        Whoever asks for values or bounds needs it, so here it is seen whether the motion is one.

        Raises:
            ArgumentError: a coefficient is no number, or tuples are not nested as they must be.
            ValueError: times do not increase, numbers are not finite, or there are not a piece between two times each, a
                polynomial of degree 5 or less for each joint, a value of each joint in each way point, and no
                deviation below 0.
        """
        try:
            self._require_form()
            found = np.zeros((len(self.coefficients), len(self.joints), MAX_DEGREE + 1))
            rows = list(chain.from_iterable(self.coefficients))
            lengths = np.fromiter(map(len, rows), np.int64, len(rows)).reshape(found.shape[:2])
        except TypeError:  # e.g. a number where a tuple must be
            refuse("coefficients", _NESTED)
        try:
            numbers = np.fromiter(chain.from_iterable(rows), np.float64, int(lengths.sum()))
        except (TypeError, ValueError):  # e.g. a text
            refuse("coefficients", _NESTED)
        found[np.arange(MAX_DEGREE + 1) < lengths[..., None]] = numbers
        if not np.isfinite(found).all():
            raise ValueError("a coefficient is not a finite number")
        return found

    def _require_form(self) -> None:
        pieces, joints = len(self.coefficients), len(self.joints)
        if pieces < 1 or len(self.times) != pieces + 1:
            times = f"{len(self.times)} times for {pieces} pieces"
            raise ValueError(f"{times}: a motion has one piece or more, each between two times")
        _require_increasing(self.times)
        require_way_points(self.waypoints)
        for what, rows in (("a way point", self.waypoints), ("a piece", self.coefficients)):
            wrong = next((length for length in map(len, rows) if length != joints), None)
            if wrong is not None:
                raise ValueError(f"{what} is of {wrong} joints, and the motion is of {joints}")
        degree = max(map(len, chain.from_iterable(self.coefficients)), default=1) - 1
        if degree > MAX_DEGREE:
            raise ValueError(f"a piece has degree {degree}: {MAX_DEGREE} is the highest")
        if not 0.0 <= self.deviation < inf:
            raise ValueError(f"a deviation is a distance, never {self.deviation}")

    @cached_property
    def knots(self) -> Array:
        """The ends (k + 1,) of the pieces [s]."""
        return np.array(self.times)

    @property
    def spans(self) -> Array:
        """The durations (k,) of the pieces [s]."""
        return np.diff(self.knots)

    def at(self, times: ArrayLike, order: int = 0) -> Array:
        """The values (…, n) of the joints at `times` [s], or their derivatives of the given order.

        Before the beginning and after the end the motion stands still. At a border of pieces the later piece counts.

        Raises:
            ArgumentError: a time is no number, or the order none from 0 on.
        """
        wanted = _numbers("times", times)
        clipped = np.minimum(np.maximum(wanted, self.times[0]), self.times[-1])
        k = np.minimum(np.searchsorted(self.knots, clipped, side="right"), len(self.coefficients)) - 1
        value = values(derivative(self.padded[k], order), (clipped - self.knots[k])[..., None])
        return value if order == 0 else np.where((wanted == clipped)[..., None], value, 0.0)

    def sampled(self, rate: float) -> Samples:
        """Times, positions, velocities and accelerations `rate` times a second [Hz], from the beginning to the end.

        The last sample is the end of the motion: its distance from the one before may be shorter.

        Raises:
            ArgumentError: the rate is no positive number, or there would be more than 10^8 samples.
        """
        rate = require_number("rate", rate, above=0.0, endless=True, unit="Hz")
        if self.duration * rate > MAX_SAMPLES:
            refuse("rate", f"at {rate} Hz this motion has more than {MAX_SAMPLES} samples")
        steps = np.arange(np.ceil(self.duration * rate - 1e-9))
        times = np.append(self.times[0] + steps / rate, self.times[-1])
        return Samples(times, *(self.at(times, order) for order in range(3)))

    def bounds(self, order: int = 0, *, halvings: int = 3) -> tuple[Array, Array]:
        """The least and the greatest value (n,) of each joint over the whole motion, or of a derivative.

        They are bounds by Bernstein coefficients: the true range is within them, and they are wider by little. With more
        `halvings` of the pieces they are tighter.

        Raises:
            ArgumentError: the order is no whole number from 0 on, or `halvings` none from 0 to 12.
        """
        low, high = self.piece_bounds(order, halvings=halvings)
        return low.min(axis=0), high.max(axis=0)

    def piece_bounds(self, order: int = 0, *, halvings: int = 3) -> tuple[Array, Array]:
        """As `bounds`, (pieces, n) for each piece."""
        durations = np.broadcast_to(self.spans[:, None], self.padded.shape[:2])
        return ranges(derivative(self.padded, order), durations, halvings=halvings)

    def shifted(self, seconds: float) -> "Trajectory":
        """The same motion, `seconds` later.

        Raises:
            ArgumentError: it is no finite number of seconds.
        """
        seconds = require_number("seconds", seconds, unit="s")
        return replace(self, times=tuple(_whole(t + seconds) for t in self.times))

    def scaled(self, factor: float) -> "Trajectory":
        """The same motion, slower by `factor` (faster below 1), from the same beginning.

        Raises:
            ArgumentError: the factor is no number from 1e-6 to 1e6.
        """
        factor = require_number("a factor of time", factor, *FACTORS)
        start = self.times[0]
        times = tuple(start + (t - start) * factor for t in self.times)
        padded = self.padded / factor ** np.arange(MAX_DEGREE + 1)
        return replace(self, times=times, coefficients=_trimmed(padded))

    def reversed(self) -> "Trajectory":
        """The motion back, in the same span of time."""
        signs = (-1.0) ** np.arange(MAX_DEGREE + 1)
        back = recentred(self.padded, np.broadcast_to(self.spans[:, None], self.padded.shape[:2])) * signs
        ends = self.times[0] + self.times[-1]
        times = tuple(_whole(ends - t) for t in self.times[::-1])
        return replace(self, waypoints=self.waypoints[::-1], times=times, coefficients=_trimmed(back[::-1]))

    def split(self, time: float) -> tuple["Trajectory", "Trajectory"]:
        """The motion until `time` [s] and the motion from then on; each follows its part of the path.

        Raises:
            ValueError: the time is not between the beginning and the end.
        """
        time = require_number("time", time, unit="s")
        if not self.times[0] < time < self.times[-1]:
            raise ValueError(f"no time between {self.times[0]} s and {self.times[-1]} s: {time} s")
        k = int(np.searchsorted(self.times, time, side="left"))
        on_border = self.times[k] == time
        inner = k if on_border else k - 1
        later = self.padded[inner:].copy()
        if not on_border:
            later[0] = recentred(later[0], np.full(len(self.joints), time - self.times[inner]))
        first, second = divided_path(self.padded, self.knots, self.waypoints, time)
        before = replace(
            self,
            waypoints=first,
            times=(*self.times[:k], float(time)),
            coefficients=self.coefficients[:k],
        )
        after = replace(
            self,
            waypoints=second,
            times=(float(time), *self.times[k + on_border :]),
            coefficients=_trimmed(later),
        )
        return before, after

    def joined(self, other: "Trajectory") -> "Trajectory":
        """This motion and then another one of the same joints, which begins when and where this one ends.

        Velocities and accelerations are not compared: both may rest there, or pass.

        Raises:
            ArgumentError: the other one is no trajectory.
            ValueError: joints differ, or time or place of the border.
        """
        require_given("other", other, Trajectory)
        if self.joints != other.joints:
            raise ValueError(f"motions of different joints: {self.joints} and {other.joints}")
        if abs(self.times[-1] - other.times[0]) > SAME_PLACE:
            raise ValueError(
                f"one motion ends at {self.times[-1]} s and the other begins at {other.times[0]} s; `shifted` moves it"
            )
        end = np.array([values(own, self.spans[-1]) for own in self.padded[-1]])
        apart = float(np.abs(end - other.padded[0, :, 0]).max(initial=0.0))
        if apart > SAME_PLACE:
            raise ValueError(f"the second motion begins {apart:.2g} rad or m away from the end of the first")
        same = self.waypoints[-1:] == other.waypoints[:1] != ()
        return replace(
            self,
            waypoints=self.waypoints + other.waypoints[same:],
            times=self.times + other.times[1:],
            coefficients=self.coefficients + other.coefficients,
            deviation=max(self.deviation, other.deviation),
        )

    def rounded(self) -> "Trajectory":
        """The motion as plans keep it: each coefficient with as many decimals as its effect needs.

        Position, velocity and acceleration at borders of pieces stay equal to 3e-10.
        """
        padded = rounded_coefficients(self.padded, self.spans)
        made = replace(self, coefficients=_trimmed(padded))
        made.__dict__["padded"] = padded  # whoever goes on with it asks for them first
        return made


def _whole(time: float) -> float:
    """A time that was computed from others, without the dust of rounding where it is a whole nanosecond."""
    near = round(time, TIME_DECIMALS)
    return near if abs(time - near) <= SAME_TIME else time


def _require_increasing(times: Sequence[float]) -> None:
    """Checks the times of a motion.

    Raises:
        ValueError: one is not finite, or not after the one before.
    """
    for before, after in pairwise(times):
        if not (before < after and isfinite(before) and isfinite(after)):
            raise ValueError(f"times are finite and increase, but {after} s follows {before} s")


def _require_kind(name: str, given: Iterable[object], kind: Any, called: str) -> None:
    """Checks what a sequence holds.

    Raises:
        ArgumentError: something is of another kind.
    """
    for own in set(map(type, given)):  # mostly one
        if not issubclass(own, kind):
            refuse(name, f"{name} must be {called}, and there is one of type {own.__name__}")


def _names(joints: Sequence[str]) -> tuple[str, ...]:
    """The names of joints that a caller gives.

    Raises:
        ArgumentError: they cannot be gone through.
    """
    if not isinstance(joints, Iterable):
        refuse("joints", f"joints must be names of joints, not {shown(joints)}")
    return tuple(joints)


def _rows(waypoints: ArrayLike) -> Rows:
    """Way points as tuples.

    Raises:
        ArgumentError: they are no array of numbers with two axes.
    """
    return tuple(map(tuple, _array("waypoints", waypoints, 2).tolist()))


def _trimmed(padded: Array) -> Coefficients:
    """Coefficients (k, n, 6) as tuples without zeros at the end; the first one always stays."""
    lengths = np.where(padded[..., 1:] != 0.0, np.arange(2, padded.shape[-1] + 1), 1).max(axis=-1, initial=1)
    rows = (padded + 0.0).tolist()  # no negative zeros
    return tuple(
        tuple(tuple(own[:length]) for own, length in zip(piece, counts, strict=True))
        for piece, counts in zip(rows, lengths.tolist(), strict=True)
    )


def _numbers(name: str, given: ArrayLike) -> Array:
    """As `_array`, without NaN."""
    numbers = _array(name, given)
    if np.isnan(numbers).any():
        refuse(name, f"{name} must be numbers, and one is NaN")
    return numbers


def _array(name: str, given: ArrayLike, axes: int | None = None) -> Array:
    """An array of what a caller gives, with so many axes.

    Raises:
        ArgumentError: something is no number, or there are more axes, or fewer.
    """
    try:
        numbers = np.asarray(given, np.float64)
    except (TypeError, ValueError, OverflowError):
        refuse(name, f"{name} must be numbers, not {shown(given)}")
    if axes is not None and numbers.ndim != axes and numbers.size:
        refuse(name, f"{name} must have {'one axis' if axes == 1 else f'{axes} axes'}, not {numbers.ndim}")
    return numbers
