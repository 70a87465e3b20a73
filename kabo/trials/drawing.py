"""Plots as SVG without a library: heat maps with contours and dots, and curves.

Colours of lines, text and dots are CSS variables of the page, and heat maps may be transparent, so that one drawing suits
light and dark pages.
"""

import base64
import struct
import zlib
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from math import floor, log10

import numpy as np
from numpy.typing import NDArray

from kabo.arrays import Array

Bytes = NDArray[np.uint8]
Point = tuple[float, float]

SIZE = 250.0  # side of the plotted square, in the units of the drawing
LEFT, RIGHT, TOP, BOTTOM = 58.0, 14.0, 8.0, 40.0  # margins for axes
MAX_TICKS = 5
SMALLEST_STEP, LARGEST_STEP = 1e-300, 1e300  # between ticks; beyond, powers of ten overflow or lose digits
# The colour map viridis: brightness grows evenly, so that it can be read without seeing colours.
_COLOURS = np.array(
    [(68, 1, 84), (71, 44, 122), (59, 81, 139), (44, 113, 142), (33, 144, 141), (39, 173, 129), (92, 200, 99),
     (170, 220, 50), (253, 231, 37)], dtype=np.float64,
)  # fmt: skip


@dataclass(frozen=True)
class Axis:
    """One axis: its label, and the values at its two ends."""

    label: str
    lower: float
    upper: float

    def share(self, value: float) -> float:
        """The position of a value: 0 at the lower end, 1 at the upper end."""
        return (value - self.lower) / (self.upper - self.lower)

    def ticks(self) -> list[float]:
        """Round values along the axis, at most six; the two ends if the range is too small or too large for that."""
        step = _round_step((self.upper - self.lower) / MAX_TICKS)
        if step is None:
            return [self.lower, self.upper]
        first = int(np.ceil(self.lower / step - 1e-9))
        last = int(np.floor(self.upper / step + 1e-9))
        return [k * step for k in range(first, last + 1)]


@dataclass(frozen=True)
class Dot:
    """The mark of one trial: its place, its look (`colour` is CSS), and its tooltip `text`."""

    x: float
    y: float
    colour: str
    text: str
    cross: bool = False
    opacity: float = 1.0


# ------------------------------------------------------------------------------------------------------- colours
def colours(shares: Array) -> Array:
    """RGB colours (…, 3) from 0 to 255 of values between 0 and 1."""
    places = np.clip(shares, 0.0, 1.0) * (len(_COLOURS) - 1)
    low = np.minimum(places.astype(np.int64), len(_COLOURS) - 2)
    part = (places - low)[..., None]
    mixed: Array = (1.0 - part) * _COLOURS[low] + part * _COLOURS[low + 1]
    return mixed


def css_colour(share: float) -> str:
    """The colour of a value between 0 and 1, for CSS."""
    red, green, blue = (round(float(each)) for each in colours(np.array(share)))
    return f"rgb({red},{green},{blue})"


def png(pixels: Bytes) -> bytes:
    """A PNG file of (rows, columns, 4) bytes: red, green, blue and opacity; the first row is the top one."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in np.ascontiguousarray(pixels, dtype=np.uint8))
    header = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )


# ------------------------------------------------------------------------------------------------------ contours
def contours(values: Array, level: float) -> list[list[Point]]:
    """The contour lines of values (rows, columns) at a level, as points (column, row) of the grid."""
    above = values > level
    corners = above[:-1, :-1].astype(int) + above[:-1, 1:] + above[1:, :-1] + above[1:, 1:]
    pieces = [
        piece
        for row, column in zip(*np.nonzero((corners > 0) & (corners < 4)), strict=True)
        for piece in _pieces(values, level, int(row), int(column))
    ]
    return _joined(pieces)


def _pieces(values: Array, level: float, row: int, column: int) -> list[tuple[Point, Point]]:
    """The one or two pieces of contour within a cell, between the points where its edges cross the level."""
    around = [(column, row), (column + 1, row), (column + 1, row + 1), (column, row + 1)]
    passed = [
        _passed(values, level, *sorted((here, there)))
        for here, there in zip(around, around[1:] + around[:1], strict=True)
        if (values[here[::-1]] > level) != (values[there[::-1]] > level)
    ]
    middle = values[row : row + 2, column : column + 2].mean()
    # Of a saddle with four points the middle decides which two corners are connected.
    if len(passed) == 4 and (values[row, column] > level) == (middle > level):
        passed = [*passed[1:], passed[0]]
    return [(passed[k], passed[k + 1]) for k in range(0, len(passed), 2)]


def _passed(values: Array, level: float, here: tuple[int, int], there: tuple[int, int]) -> Point:
    """The point between two neighbours of the grid at the level; the same bits for both cells that share the edge."""
    (x0, y0), (x1, y1) = here, there
    first, second = float(values[y0, x0]), float(values[y1, x1])
    share = (level - first) / (second - first)
    return x0 + share * (x1 - x0), y0 + share * (y1 - y0)


def _joined(pieces: Sequence[tuple[Point, Point]]) -> list[list[Point]]:
    """The pieces joined at common ends to as few lines as possible."""
    at: dict[Point, list[int]] = {}
    for k, piece in enumerate(pieces):
        for point in piece:
            at.setdefault(point, []).append(k)
    left = dict.fromkeys(range(len(pieces)))
    lines = []
    while left:
        first = next(iter(left))
        del left[first]
        line = deque(pieces[first])
        for end, grow in ((-1, line.append), (0, line.appendleft)):
            while (following := next((k for k in at[line[end]] if k in left), None)) is not None:
                del left[following]
                start, stop = pieces[following]
                grow(stop if start == line[end] else start)
        lines.append(list(line))
    return lines


# ------------------------------------------------------------------------------------------------------ drawings
def heat_map(
    x: Axis, y: Axis, pixels: Bytes, lines: Sequence[tuple[Array, float, str]], dots: Iterable[Dot], said: str
) -> str:
    """An SVG of a heat map with contours and dots.

    Args:
        x, y: the axes.
        pixels: (rows, columns, 4) bytes; the first row is at the lower end of `y`, and the outermost pixels are
            centred on the ends of the axes.
        lines: values (rows, columns), the level and the CSS class of each contour.
        dots: the trials.
        said: the description for screen readers.
    """
    rows, columns = pixels.shape[:2]
    data = base64.b64encode(png(pixels[::-1])).decode()
    dx, dy = SIZE / (columns - 1), SIZE / (rows - 1)
    image = (
        f'<svg x="{LEFT}" y="{TOP}" width="{SIZE}" height="{SIZE}"><image x="{-dx / 2:.3f}" y="{-dy / 2:.3f}" '
        f'width="{SIZE + dx:.3f}" height="{SIZE + dy:.3f}" preserveAspectRatio="none" '
        f'href="data:image/png;base64,{data}"/></svg>'
    )
    paths = []
    for values, level, kind in lines:
        drawn = (
            "L".join(f"{LEFT + column * dx:.1f} {TOP + SIZE - row * dy:.1f}" for column, row in line)
            for line in contours(values, level)
        )
        paths.append(f'<path class="{kind}" d="{"".join(f"M{each}" for each in drawn)}"/>')
    return _framed(x, y, image + "".join(paths) + "".join(_dot(x, y, dot) for dot in dots), said)


def curve(
    x: Axis,
    y: Axis,
    at: Array,
    mean: Array,
    spread: Array | None,
    dots: Iterable[Dot],
    levels: Iterable[tuple[float, str]] = (),
) -> str:
    """An SVG of a curve with dots.

    Args:
        x, y: the axes.
        at, mean: (n,); nothing is drawn where `mean` is not a number.
        spread: (n,) the half width of a band around the curve, or None.
        dots: the trials.
        levels: value and CSS class of horizontal lines.
    """
    content = [f'<path class="{kind}" d="M{LEFT} {_down(y, level):.1f}H{LEFT + SIZE}"/>' for level, kind in levels]
    for run in _runs(np.isfinite(mean)):
        if spread is not None:
            upper, lower = (
                zip(at[run], (mean + spread)[run], strict=True),
                zip(at[run], (mean - spread)[run], strict=True),
            )
            content.append(f'<polygon class="band" points="{_points(x, y, [*upper, *reversed(list(lower))])}"/>')
        content.append(f'<polyline class="curve" points="{_points(x, y, zip(at[run], mean[run], strict=True))}"/>')
    return _framed(x, y, "".join([*content, *(_dot(x, y, dot) for dot in dots)]), f"{y.label} along {x.label}")


def _runs(known: NDArray[np.bool_]) -> list[slice]:
    """The maximal slices in which all are true."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], known, [False]]).astype(np.int8)))
    return [slice(int(first), int(last)) for first, last in zip(edges[::2], edges[1::2], strict=True)]


def number(value: float) -> str:
    """A number with four significant digits."""
    return f"{value:.4g}"


def _points(x: Axis, y: Axis, points: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{_across(x, float(a)):.1f},{_down(y, float(b)):.1f}" for a, b in points)


def _across(axis: Axis, value: float) -> float:
    return LEFT + SIZE * axis.share(value)


def _down(axis: Axis, value: float) -> float:
    return TOP + SIZE * (1.0 - min(1.0, max(0.0, axis.share(value))))


def _dot(x: Axis, y: Axis, dot: Dot) -> str:
    across, down = _across(x, dot.x), _down(y, dot.y)
    faded = "" if dot.opacity == 1.0 else f' opacity="{dot.opacity:.2f}"'
    title = f"<title>{escape(dot.text)}</title>"
    if dot.cross:
        path = f"M{across - 3:.1f} {down - 3:.1f}l6 6m0 -6l-6 6"
        return f'<path class="cross" d="{path}" style="stroke:{dot.colour}"{faded}>{title}</path>'
    return f'<circle class="dot" cx="{across:.1f}" cy="{down:.1f}" r="3" style="fill:{dot.colour}"{faded}>{title}</circle>'


def _framed(x: Axis, y: Axis, content: str, said: str) -> str:
    """The content within axes with ticks and labels."""
    width, height = LEFT + SIZE + RIGHT, TOP + SIZE + BOTTOM
    bottom, middle = TOP + SIZE, TOP + SIZE / 2
    ticks = []
    for value in x.ticks():
        at = _across(x, value)
        ticks.append(f'<path class="axis" d="M{at:.1f} {bottom}v4"/>')
        ticks.append(f'<text x="{at:.1f}" y="{bottom + 16}" text-anchor="middle">{number(value)}</text>')
    for value in y.ticks():
        at = _down(y, value)
        ticks.append(f'<path class="axis" d="M{LEFT} {at:.1f}h-4"/>')
        ticks.append(f'<text x="{LEFT - 7}" y="{at + 4:.1f}" text-anchor="end">{number(value)}</text>')
    labels = (
        f'<text x="{LEFT + SIZE / 2}" y="{bottom + 33}" text-anchor="middle">{escape(x.label)}</text>'
        f'<text transform="translate(12 {middle}) rotate(-90)" text-anchor="middle">{escape(y.label)}</text>'
    )
    frame = f'<rect class="axis" x="{LEFT}" y="{TOP}" width="{SIZE}" height="{SIZE}"/>'
    return (
        f'<svg class="map" viewBox="0 0 {width} {height}" width="{width}" role="img" aria-label="{escape(said)}">'
        f"{content}{frame}{''.join(ticks)}{labels}</svg>"
    )


def _round_step(step: float) -> float | None:
    """The least of 1, 2 and 5 times a power of ten that is not below a step; None outside SMALLEST_ to LARGEST_STEP."""
    if not SMALLEST_STEP < step < LARGEST_STEP:
        return None
    power = 10.0 ** floor(log10(step))
    return next(each * power for each in (1.0, 2.0, 5.0, 10.0, 20.0) if each * power >= step * (1.0 - 1e-9))
