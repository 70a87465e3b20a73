"""What robots handle and stand at: bottle, cup, crate, table, block, tap, panel. Feet at z = 0, z up."""

import math

import numpy as np

from scripts.solids import (
    Detail,
    Solid,
    block,
    bore,
    cut,
    cylinder,
    lofted,
    revolved,
    rounded,
    sharp_block,
    union,
)

BOTTLE_RADIUS, BOTTLE_HEIGHT = 0.03, 0.24
CUP_RADIUS, CUP_HEIGHT, CUP_WALL, CUP_FLOOR = 0.034, 0.1, 0.004, 0.006
BLOCK = 0.04
PANEL, PANEL_HANDLE = (0.24, 0.24, 0.01), (0.02, 0.16, 0.06)  # sides of the plate and of what it is held by
PANEL_FOOT = (0.005, 0.24, 0.04)  # of what it stands on: the handle puts its centre of mass beside the plate
CRATE = (0.36, 0.36, 0.05)  # outer sides and height of the walls
CRATE_WALL, CRATE_FLOOR, CRATE_FILLET = 0.01, 0.01, 0.001


def bottle(d: Detail) -> Solid:
    """A beer bottle: cylindrical up to 0.148 m, shoulder, neck with a ring for the cap; a shallow punt below."""
    outline = revolved(
        [
            (0.01, 0.0, 0.0),
            (BOTTLE_RADIUS, 0.0, 0.004),
            (BOTTLE_RADIUS, 0.155, 0.03),
            (0.0135, 0.19, 0.02),
            (0.0125, 0.225, 0.002),
            (0.0145, 0.2255, 0.0005),
            (0.0145, 0.236, 0.0005),
            (0.0125, BOTTLE_HEIGHT, 0.001),
            (0.006, BOTTLE_HEIGHT, 0.0),
        ],
        d,
    )
    punt = cylinder(0.024, (-0.01, 0.0025), 0.002, d)
    return cut(outline, [punt])


def cup(d: Detail) -> Solid:
    """An open tumbler: straight outside, so that fingers hold it everywhere, with a rounded rim."""
    inner = CUP_RADIUS - CUP_WALL
    outside = [(0.012, 0.0, 0.0), (CUP_RADIUS, 0.0, 0.004), (CUP_RADIUS, CUP_HEIGHT, 0.0019)]
    inside = [(inner, CUP_HEIGHT, 0.0019), (inner, CUP_FLOOR, 0.004), (0.012, CUP_FLOOR, 0.0)]
    outline = rounded([*outside, *inside], d.fillet_steps)
    turns = [2.0 * math.pi * k / d.segments for k in range(d.segments)]
    rings = np.array([[(r * math.cos(a), r * math.sin(a), z) for a in turns] for r, z in outline])
    return lofted(rings)


def crate(d: Detail) -> Solid:
    """A low dishwasher tray: a floor and four walls, with sharp inner edges."""
    x, y, height = CRATE[0] / 2.0, CRATE[1] / 2.0, CRATE[2]
    outer = block((-x, x), (-y, y), (0.0, height), 0.004, d)
    inside = (CRATE_WALL - x, x - CRATE_WALL), (CRATE_WALL - y, y - CRATE_WALL), (CRATE_FLOOR, 2.0 * height)
    return cut(outer, [block(*inside, CRATE_FILLET, d)])


def table(d: Detail) -> Solid:
    """A table of 0.5 x 0.85 m, 0.4 m high: a plate on four legs."""
    plate = block((-0.25, 0.25), (-0.425, 0.425), (0.37, 0.4), 0.004, d)
    legs = [
        cylinder(0.025, (0.0, 0.38), 0.004, d).translate((x, y, 0.0))
        for x in (-0.21, 0.21)
        for y in (-0.385, 0.385)
    ]
    return union([plate, *legs])


def wooden_block(d: Detail) -> Solid:
    """A cube with rounded edges, its middle at the origin."""
    half = BLOCK / 2.0
    return block((-half, half), (-half, half), (-half, half), 0.003, d)


def tap(d: Detail) -> Solid:
    """A beer tap on its column: what stands in the way on a bar."""
    column = revolved(
        [
            (0.02, 0.0, 0.0),
            (0.05, 0.0, 0.003),
            (0.05, 0.015, 0.003),
            (0.028, 0.03, 0.02),
            (0.026, 0.42, 0.008),
            (0.012, 0.42, 0.0),
        ],
        d,
    )
    spout = bore(0.011, (0.0, 0.075), d).rotate((0.0, 90.0, 0.0)).translate((0.0, 0.0, 0.36))
    mouth = bore(0.01, (0.31, 0.368), d).translate((0.07, 0.0, 0.0))
    lever = cylinder(0.009, (0.40, 0.47), 0.003, d, top_radius=0.014)
    return union([column, spout, mouth, lever])


def panel(_: Detail) -> Solid:
    """A square plate with a handle along its middle: a glass cover, flat on its face or upright on the foot at its side."""
    (x, y, thick), (across, along, high), (deep, wide, reach) = PANEL, PANEL_HANDLE, PANEL_FOOT
    plate = sharp_block((-x / 2, x / 2), (-y / 2, y / 2), (0.0, thick))
    handle = sharp_block((-across / 2, across / 2), (-along / 2, along / 2), (thick / 2, high))
    foot = sharp_block((-x / 2, deep - x / 2), (-wide / 2, wide / 2), (0.0, reach))
    return union([plate, handle, foot])
