"""The parts of a gearbox: a ball bearing, a pipe that seats one, and a mechanical tree: a shaft with a gear.

Each stands with its foot at z = 0, its axis along z. A bearing fits the seat at the top of the pipe and the journal
of the tree with 0.2 mm to spare; where parts pass each other without being mated there are at least 6 mm of air.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from scripts.solids import Box, Detail, Solid, bolt_circle, cut, cylinder, lofted, revolved, union

BEARING, BORE, THICKNESS = 0.035, 0.018, 0.024  # outer and inner radius, height of a bearing
PIPE, PIPE_HEIGHT, HOLLOW = 0.046, 0.118, 0.041  # outer radius, height, and radius of the wide bore below
SEAT, STEP, STEP_BORE = 0.090, 0.006, 0.028  # where the bearing sits, on a step of that thickness and bore
FIT = 0.0002  # between a bearing and what it sits in or on
COLLAR, SHOULDER, TREE_HEIGHT = 0.030, 0.070, 0.140  # of the tree: where the pipe stands, the bearing, the end
FLANGE, COLLAR_RADIUS, SHAFT = 0.055, 0.050, 0.009


def bearing(d: Detail) -> Solid:
    """Two rings with rounded rims, and balls in the groove between them."""
    rings = cut(cylinder(BEARING, (0.0, THICKNESS), 0.0015, d), [_flared(BORE, 0.0, THICKNESS, 0.002, d)])
    middle, half, depth = (BEARING + BORE) / 2.0, 0.0025, 0.0085
    grooves = [
        cut(
            _plain(middle + half, span, d),
            [_plain(middle - half, (span[0] - 0.001, span[1] + 0.001), d)],
        )
        for span in ((-0.001, depth), (THICKNESS - depth, THICKNESS + 0.001))
    ]
    balls = [
        _ball(0.0055, d).translate((middle * math.cos(a), middle * math.sin(a), THICKNESS / 2.0))
        for a in (2.0 * math.pi * k / 10 for k in range(10))
    ]
    return union([cut(rings, grooves), *balls])


def pipe(d: Detail) -> Solid:
    """A housing: wide below, a step near the top with the seat of a bearing on it, a thread outside, tapped holes."""
    outside = _grooved(
        [
            (0.020, 0.0, 0.0),
            (PIPE, 0.0, 0.002),
            (PIPE, 0.097, 0.0),
        ],
        (0.097, 0.111),
        PIPE,
        0.0008,
        0.002,
        [(PIPE, 0.111, 0.0), (PIPE, PIPE_HEIGHT, 0.0015), (0.020, PIPE_HEIGHT, 0.0)],
        d,
    )
    top = SEAT - STEP
    tools = [
        _funnel(HOLLOW, -0.001, top, 0.0015, d),
        _plain(STEP_BORE, (0.0, PIPE_HEIGHT), d),
        _mouth(BEARING + FIT, SEAT, PIPE_HEIGHT + 0.001, 0.001, d),
        bolt_circle(0.0405, 6, 0.0015, (PIPE_HEIGHT - 0.012, PIPE_HEIGHT + 0.01), d),
    ]
    return cut(outside, tools)


def tree(d: Detail) -> Solid:
    """A flange with bolt holes, a collar for the pipe, a gear, a journal for a bearing, and a threaded end."""
    shaft = _grooved(
        [
            (0.020, 0.0, 0.0),
            (FLANGE, 0.0, 0.002),
            (FLANGE, 0.014, 0.002),
            (COLLAR_RADIUS, 0.016, 0.0),
            (COLLAR_RADIUS, COLLAR, 0.0015),
            (0.026, COLLAR, 0.002),
            (0.024, SHOULDER, 0.001),
            (BORE - FIT, SHOULDER, 0.0),
            (BORE - FIT, SHOULDER + THICKNESS, 0.001),
            (SHAFT, SHOULDER + THICKNESS + 0.002, 0.001),
            (SHAFT, 0.118, 0.0),
        ],
        (0.118, 0.137),
        SHAFT,
        0.0007,
        0.002,
        [(SHAFT, 0.137, 0.0), (SHAFT - 0.0015, TREE_HEIGHT, 0.0005), (0.004, TREE_HEIGHT, 0.0)],
        d,
    )
    holes = bolt_circle(0.0525, 8, 0.0012, (0.004, 0.03), d)
    return cut(union([shaft, _gear(0.034, 0.030, 20, (0.038, 0.054), d)]), [holes])


def _turned(
    outline: Sequence[tuple[float, float]], d: Detail, radius: Callable[[float, float, float], float]
) -> Solid:
    """A solid around z with an outline of (r, z), where `radius` says what r becomes at (r, z, angle)."""
    turns = [2.0 * math.pi * k / d.segments for k in range(d.segments)]
    rings = [[(radius(r, z, a), a, z) for a in turns] for r, z in outline]
    points = np.array([[(r * math.cos(a), r * math.sin(a), z) for r, a, z in ring] for ring in rings])
    return lofted(points)


def _grooved(
    below: Sequence[tuple[float, float, float]],
    span: Box,
    radius: float,
    depth: float,
    pitch: float,
    above: Sequence[tuple[float, float, float]],
    d: Detail,
) -> Solid:
    """A solid of revolution that bears a helical thread over `span`; the corners are those of `revolved`."""
    steps = round((span[1] - span[0]) / pitch * d.fillet_steps)
    heights = [span[0] + (span[1] - span[0]) * k / steps for k in range(1, steps)]
    whole = revolved([*below, *above], d)

    def cutting(r: float, z: float, a: float) -> float:
        run = min(z - span[0], span[1] - z, pitch) / pitch  # the thread runs out at both ends
        turn = (z / pitch - a / (2.0 * math.pi)) % 1.0
        return r if z in (span[0], span[1]) else radius - depth * max(run, 0.0) * (1.0 - abs(2.0 * turn - 1.0))

    outline = [(radius, z) for z in (span[0], *heights, span[1])]
    band = cut(_plain(radius * 1.2, span, d), [_turned(outline, d, cutting)])
    return cut(whole, [band])


def _gear(tip: float, root: float, teeth: int, span: Box, d: Detail) -> Solid:
    """A spur gear with trapezoidal teeth."""
    corners = []
    for k in range(teeth):
        for share, r in ((0.0, root), (0.3, root), (0.45, tip), (0.85, tip)):
            a = 2.0 * math.pi * (k + share) / teeth
            corners.append((r * math.cos(a), r * math.sin(a)))
    inset = 0.0008
    rings = [
        [(x * (tip - cut_back) / tip, y * (tip - cut_back) / tip, z) for x, y in corners]
        for z, cut_back in (
            (span[0], inset),
            (span[0] + inset, 0.0),
            (span[1] - inset, 0.0),
            (span[1], inset),
        )
    ]
    return lofted(np.array(rings))


def _ball(radius: float, d: Detail) -> Solid:
    """A sphere."""
    count = max(6, d.segments // 6)
    heights = [math.pi * (k + 0.5) / count for k in range(count)]
    outline = [(radius * math.sin(a), -radius * math.cos(a)) for a in heights]
    few = Detail(max(8, d.segments // 4), d.fillet_steps)
    return _turned(outline, few, lambda r, z, a: r)


def _plain(radius: float, span: Box, d: Detail) -> Solid:
    """A cylinder with sharp rims, as round as the outsides are."""
    low, high = span
    return revolved([(radius / 2, low, 0.0), (radius, low, 0.0), (radius, high, 0.0), (radius / 2, high, 0.0)], d)


def _flared(radius: float, low: float, high: float, rim: float, d: Detail) -> Solid:
    """What is cut out for a bore that is rounded at both rims."""
    wide = radius + rim
    return revolved(
        [
            (radius / 2, low - rim, 0.0),
            (wide + rim, low - rim, 0.0),
            (wide, low, 0.0),
            (radius, low + rim, rim),
            (radius, high - rim, rim),
            (wide, high, 0.0),
            (wide + rim, high + rim, 0.0),
            (radius / 2, high + rim, 0.0),
        ],
        d,
    )


def _funnel(radius: float, low: float, high: float, rim: float, d: Detail) -> Solid:
    """What is cut out for a blind bore from below with a chamfered rim at z = 0 and a fillet at its end."""
    return revolved(
        [
            (radius / 2, low, 0.0),
            (radius + rim - low, low, 0.0),
            (radius, rim, 0.0005),
            (radius, high, 0.001),
            (radius / 2, high, 0.0),
        ],
        d,
    )


def _mouth(radius: float, low: float, high: float, rim: float, d: Detail) -> Solid:
    """What is cut out for a blind bore from above with a chamfered rim."""
    top = high - 0.001
    return revolved(
        [
            (radius / 2, low, 0.0),
            (radius, low, 0.0),
            (radius, top - rim, 0.0005),
            (radius + rim + 0.001, high, 0.0),
            (radius / 2, high, 0.0),
        ],
        d,
    )
