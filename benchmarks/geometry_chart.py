"""Charts as SVG, written by hand: lines over logarithmic axes, nothing to install."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, floor, log10
from pathlib import Path

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 760, 470, 80, 40, 210, 60
COLOURS = ("#1b6ca8", "#d1495b", "#2e8b57", "#8a5a44", "#6a4c93", "#e08e0b", "#444444")
Points = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class _Axis:
    low: float
    high: float
    logarithmic: bool
    start: float
    end: float  # in pixels

    def at(self, value: float) -> float:
        low, high, value = (log10(v) if self.logarithmic else v for v in (self.low, self.high, value))
        return self.start + (self.end - self.start) * (value - low) / (high - low)

    def ticks(self) -> list[float]:
        if self.logarithmic:
            return [10.0**k for k in range(round(log10(self.low)), round(log10(self.high)) + 1)]
        return [self.low + (self.high - self.low) * k / 5 for k in range(6)]


def _axis(values: Sequence[float], logarithmic: bool, start: float, end: float) -> _Axis:
    if logarithmic:
        low, high = floor(log10(min(values))), ceil(log10(max(values)))
        return _Axis(10.0**low, 10.0 ** max(high, low + 1), True, start, end)
    return _Axis(0.0, max(values) * 1.05, False, start, end)


def write_chart(
    path: Path, title: str, x_name: str, y_name: str, lines: Mapping[str, Points], *, log_y: bool = True
) -> None:
    """Draws named lines over a logarithmic x; positive values only on logarithmic axes."""
    xs = _axis([x for points in lines.values() for x, _ in points], True, LEFT, WIDTH - RIGHT)
    ys = _axis([y for points in lines.values() for _, y in points], log_y, HEIGHT - BOTTOM, TOP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" font-family="sans-serif" '
        'font-size="12"><rect width="100%" height="100%" fill="white"/>',
        _text(WIDTH / 2 - RIGHT / 2, 22, title, size=15),
        _text((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 15, x_name),
        f'<g transform="rotate(-90 18 {HEIGHT / 2})">{_text(18, HEIGHT / 2, y_name)}</g>',
    ]
    for x in xs.ticks():
        parts.append(_line([(xs.at(x), HEIGHT - BOTTOM), (xs.at(x), TOP)], "#dddddd", 1.0))
        parts.append(_text(xs.at(x), HEIGHT - BOTTOM + 18, f"{x:g}"))
    for y in ys.ticks():
        parts.append(_line([(LEFT, ys.at(y)), (WIDTH - RIGHT, ys.at(y))], "#dddddd", 1.0))
        parts.append(_text(LEFT - 8, ys.at(y) + 4, f"{y:.3g}", anchor="end"))
    for number, (name, points) in enumerate(lines.items()):
        colour, y = COLOURS[number % len(COLOURS)], TOP + 14 + 20 * number
        parts.append(_line([(xs.at(a), ys.at(b)) for a, b in points], colour, 2.0))
        parts.append(_line([(WIDTH - RIGHT + 12, y - 4), (WIDTH - RIGHT + 34, y - 4)], colour, 3.0))
        parts.append(_text(WIDTH - RIGHT + 40, y, name, anchor="start"))
    path.write_text("\n".join([*parts, "</svg>\n"]))


def _text(x: float, y: float, words: str, *, anchor: str = "middle", size: int = 12) -> str:
    safe = words.replace("&", "&amp;").replace("<", "&lt;")
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="{size}">{safe}</text>'


def _line(points: Points, colour: str, width: float) -> str:
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'
