"""Writes names into pictures: each beside what it names, with a line to it, and none over another."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.pictures.cameras import Camera
from kabo.pictures.drawing import Drawing, Label, Line, Solid
from kabo.pictures.rendering import Numbers, Pixels

INK, PAPER = "#20242b", "#ffffff"
DISTANCES = (0, 16, 34, 56, 84, 120, 165, 220)  # of a label from its anchor [pixels]
ANGLES = 16
MIN_SEEN = 12  # pixels of a thing: less of it is not named
COVERED, COVERED_OWN = 90.0, 200.0  # prices of a box that lies on bodies only, and of one that hides its own thing
COVERED_OTHER, OUTSIDE = 1e6, 1e6  # of one that hides another label, and of one that leaves the picture


@dataclass(frozen=True)
class Placed:
    """A label on a picture: the box of its text (left, top, right, bottom) and its anchor, in pixels."""

    label: Label
    box: tuple[float, float, float, float]
    anchor: tuple[float, float]


@cache
def font(size: int, *, bold: bool = False) -> Any:
    """The font of all texts: DejaVu Sans, which comes with the library that pyvista draws its colours with."""
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def labelled(pixels: Pixels, seen: Numbers, camera: Camera, drawing: Drawing, size: int = 15) -> Pixels:
    """The picture (H, W, 3) with the labels of a drawing written into it.

    Args:
        pixels: as `Stage.shot` gives them. seen: as `Stage.visible` does. camera: of both. size: of the font in pixels.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image)
    placed = place(drawing, camera, seen, size)
    for each in placed:
        _leader(draw, each)
    for each in placed:
        left, top, right, bottom = (round(side) for side in each.box)
        draw.rounded_rectangle(
            (left, top, right, bottom), radius=4, fill=PAPER, outline=each.label.colour, width=2
        )
        draw.text((left + 6, top + 3), each.label.text, font=font(size), fill=INK)
    return np.asarray(image)


def place(drawing: Drawing, camera: Camera, seen: Numbers, size: int) -> list[Placed]:
    """The labels where they cover least: other labels never, bodies as little as may be.

    Args:
        drawing: its labels are placed. camera: of the picture. seen: (H, W), the number of the solid, or -1. size: of
            the font in pixels.
    """
    height, width = seen.shape
    # Sums over all pixels above and to the left: what a box covers is then four look-ups.
    prices_of = np.array([*(_price_of(solid) for solid in drawing.solids), 0.0])  # the last is that of nothing, -1
    sums = np.pad(prices_of[seen].cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    found: list[Placed] = []
    for label in drawing.labels:
        own = _own(label, drawing, seen)
        hidden = label.about and own.sum() < MIN_SEEN
        if hidden and not label.always:
            continue
        shown = replace(label, text=f"{label.text} (hidden)") if hidden else label
        anchor = _anchor(shown, camera, own, hidden=bool(hidden))
        if not (0.0 <= anchor[0] < width and 0.0 <= anchor[1] < height):
            continue
        wide, high = font(size).getlength(shown.text) + 12, size + 9
        boxes = _boxes(*anchor, wide, high)
        prices = [_price(box, anchor, found, sums) + _own_price(box, own) for box in boxes]
        best = int(np.argmin(prices))
        if prices[best] < OUTSIDE:
            found.append(Placed(shown, boxes[best], anchor))
    return found


def _price_of(solid: Solid) -> float:
    """The price of covering a solid, as a share: small things must stay visible, tables need not."""
    return min(1.0, 0.25 + solid.weight / 2.0) if solid.weight >= 1.0 else 0.3


def _own(label: Label, drawing: Drawing, seen: Numbers) -> npt.NDArray[np.bool_]:
    """The pixels (H, W) at which what a label names is seen."""
    numbers = [number for number, solid in enumerate(drawing.solids) if solid.name in label.about]
    return np.isin(seen, numbers)


def _anchor(label: Label, camera: Camera, own: npt.NDArray[np.bool_], *, hidden: bool) -> tuple[float, float]:
    """The pixel that a label points to: a seen one of its thing, else where the thing would be."""
    height, width = own.shape
    if not label.about or hidden:
        (x, y, _), *_ = camera.seen(label.anchor[None], (width, height))
        return float(x), float(y)
    rows, columns = np.nonzero(own)
    # The seen pixel nearest to the middle of all that are seen: never beside a thing with a hole.
    away = (rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2
    nearest = int(np.argmin(away))
    return float(columns[nearest]), float(rows[nearest])


def _own_price(box: tuple[float, float, float, float], own: npt.NDArray[np.bool_]) -> float:
    """The price of covering the thing itself: all of a small one, little of a large one."""
    left, top, right, bottom = (max(0, round(side)) for side in box)
    return COVERED_OWN * float(own[top:bottom, left:right].sum()) / max(float(own.sum()), 1.0)


def with_lines(pixels: Pixels, camera: Camera, lines: Sequence[Line]) -> Pixels:
    """The picture (H, W, 3) with lines of the world drawn over it."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image)
    size = (pixels.shape[1], pixels.shape[0])
    for line in lines:
        points = [(float(x), float(y)) for x, y, _ in camera.seen(line.points, size)]
        draw.line(points, fill=line.colour, width=3, joint="curve")
    return np.asarray(image)


def _boxes(x: float, y: float, wide: float, high: float) -> list[tuple[float, float, float, float]]:
    found = []
    for distance in DISTANCES:
        for angle in np.arange(ANGLES) * 2.0 * np.pi / ANGLES - np.pi / 2.0:  # straight up first
            cosine, sine = float(np.cos(angle)), float(np.sin(angle))
            # The box lies beside the anchor on that side: its middle is farther away where it is wide.
            middle = x + cosine * (distance + wide / 2.0), y + sine * (distance + high / 2.0)
            left, top = middle[0] - wide / 2.0, middle[1] - high / 2.0
            found.append((left, top, left + wide, top + high))
    return found


def _price(
    box: tuple[float, float, float, float], anchor: tuple[float, float], others: Sequence[Placed], sums: Array
) -> float:
    left, top, right, bottom = (round(side) for side in box)
    height, width = sums.shape
    if left < 3 or top < 3 or right > width - 5 or bottom > height - 5:
        return OUTSIDE
    middle = ((left + right) / 2.0, (top + bottom) / 2.0)
    nearest = (min(max(anchor[0], left), right), min(max(anchor[1], top), bottom))
    away = float(np.hypot(nearest[0] - anchor[0], nearest[1] - anchor[1]))
    price = away
    for other in others:
        if _overlap(box, other.box, 3.0) or _near(other.anchor, box, 4.0):
            return COVERED_OTHER
        price += 60.0 * _cross(anchor, middle, other) + 40.0 * _through(anchor, nearest, other.box)
    inside = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    return price + COVERED * float(inside) / ((right - left) * (bottom - top))


def _overlap(one: Sequence[float], other: Sequence[float], gap: float) -> bool:
    return (
        one[0] < other[2] + gap and other[0] < one[2] + gap and one[1] < other[3] + gap and other[1] < one[3] + gap
    )


def _near(point: tuple[float, float], box: Sequence[float], gap: float) -> bool:
    return box[0] - gap <= point[0] <= box[2] + gap and box[1] - gap <= point[1] <= box[3] + gap


def _through(start: tuple[float, float], end: tuple[float, float], box: Sequence[float]) -> bool:
    """Whether a line passes through a box, seen at a few of its points."""
    return any(
        _near((start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])), box, 2.0)
        for t in np.linspace(0.0, 1.0, 9)
    )


def _cross(start: tuple[float, float], end: tuple[float, float], other: Placed) -> bool:
    """Whether the lines of two labels cross."""
    a, b = np.array(start), np.array(end)
    c, d = np.array(other.anchor), np.array([(other.box[0] + other.box[2]) / 2, (other.box[1] + other.box[3]) / 2])

    def side(p: Array, q: Array, r: Array) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) < 0 and side(c, d, a) * side(c, d, b) < 0


def _leader(draw: Any, placed: Placed) -> None:
    """The line from a label to what it names, with a dot at its end."""
    x, y = placed.anchor
    left, top, right, bottom = placed.box
    nearest = (min(max(x, left), right), min(max(y, top), bottom))
    if np.hypot(nearest[0] - x, nearest[1] - y) > 1.0:
        draw.line([nearest, (x, y)], fill=INK, width=1)
        draw.ellipse([x - 2.5, y - 2.5, x + 2.5, y + 2.5], fill=INK)
