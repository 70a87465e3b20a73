"""Watertight solids as a CAD system would export them: fillets, bores, flanges, from a few numbers.

A solid is a closed shell in metres. Rings of points are lofted into shells, shells are united and cut by exact
booleans, so that each result is one closed, orientable 2-manifold.
Coordinates of the rings are rounded to a nanometre before any boolean sees them, and angles come from `math`: the
same parameters give the same triangles, whatever the processor.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import manifold3d
import numpy as np
from numpy.typing import NDArray

Circle = tuple[float, float, float]  # centre (u, v) and radius [m]
Box = tuple[float, float]  # an interval [m]


@dataclass(frozen=True)
class Detail:
    """How finely curves are cut into straight pieces."""

    segments: int  # of a full circle, a multiple of 4
    fillet_steps: int  # of a quarter fillet


@dataclass(frozen=True)
class Solid:
    """A closed shell [m]."""

    shell: manifold3d.Manifold

    def translate(self, by: tuple[float, float, float]) -> "Solid":
        """The solid moved [m]."""
        return Solid(self.shell.translate(by))

    def rotate(self, degrees: tuple[float, float, float]) -> "Solid":
        """The solid turned around x, then y, then z."""
        return Solid(self.shell.rotate(degrees))


HIGH = Detail(segments=96, fillet_steps=6)
LOW = Detail(segments=16, fillet_steps=2)


def lofted(rings: NDArray[np.float64]) -> Solid:
    """The solid between rings of points, closed by a fan over the first and over the last ring.

    Args:
        rings: (L, N, 3) [m]; each ring counter-clockwise seen from where the rings come to an end.
    """
    count, size, _ = rings.shape
    caps = rings[[0, -1]].mean(axis=1)
    vertices = np.round(np.concatenate([rings.reshape(-1, 3), caps]), 9)
    index = np.arange(count * size).reshape(count, size)
    here, right = index[:-1].ravel(), np.roll(index, -1, axis=1)[:-1].ravel()
    above, diagonal = index[1:].ravel(), np.roll(index, -1, axis=1)[1:].ravel()
    bottom, top = index[0], index[-1]
    faces = [np.c_[here, right, diagonal], np.c_[here, diagonal, above]]
    faces += [np.c_[np.full(size, count * size), np.roll(bottom, -1), bottom]]
    faces += [np.c_[np.full(size, count * size + 1), top, np.roll(top, -1)]]
    mesh = manifold3d.Mesh64(vertices, np.concatenate(faces).astype(np.uint64))
    mesh.merge()
    shell = manifold3d.Manifold(mesh)
    assert shell.status() == manifold3d.Error.NoError, shell.status()
    return Solid(shell)


def rounded(corners: Sequence[tuple[float, float, float]], steps: int) -> list[tuple[float, float]]:
    """An open polyline with its inner corners rounded.

    Args:
        corners: (r, z, fillet radius) [m]; the radius of the first and last is ignored.
        steps: pieces of each arc.
    """
    points = [corners[0][:2]]
    for before, (r, z, radius), after in zip(corners, corners[1:], corners[2:], strict=False):
        points += _arc(before[:2], (r, z), after[:2], radius, steps) if radius > 0.0 else [(r, z)]
    return [*points, corners[-1][:2]]


def _arc(
    before: Sequence[float], corner: Sequence[float], after: Sequence[float], radius: float, steps: int
) -> list[tuple[float, float]]:
    """Points on the circle that touches both sides of a corner."""
    first = np.subtract(before, corner) / math.dist(before, corner)
    second = np.subtract(after, corner) / math.dist(after, corner)
    half = math.acos(max(-1.0, min(1.0, float(first @ second)))) / 2.0
    bisector = (first + second) / np.linalg.norm(first + second)
    centre = np.asarray(corner) + bisector * radius / math.sin(half)
    start, end = (np.asarray(corner) + side * radius / math.tan(half) - centre for side in (first, second))
    turn = math.atan2(start[0] * end[1] - start[1] * end[0], float(start @ end))
    angles = [turn * k / steps for k in range(steps + 1)]
    return [
        (
            float(centre[0] + math.cos(a) * start[0] - math.sin(a) * start[1]),
            float(centre[1] + math.sin(a) * start[0] + math.cos(a) * start[1]),
        )
        for a in angles
    ]


def revolved(corners: Sequence[tuple[float, float, float]], detail: Detail) -> Solid:
    """The solid of revolution around z of an outline of (r, z, fillet radius) corners, r > 0, bottom to top."""
    outline = rounded(corners, detail.fillet_steps)
    turns = [2.0 * math.pi * k / detail.segments for k in range(detail.segments)]
    rings = np.array([[(r * math.cos(a), r * math.sin(a), z) for a in turns] for r, z in outline])
    return lofted(rings)


def cylinder(radius: float, span: Box, fillet: float, detail: Detail, top_radius: float | None = None) -> Solid:
    """A cylinder (or cone) around z over `span`, with both rims rounded."""
    low, high = span
    top = radius if top_radius is None else top_radius
    inner, inner_top = (radius - fillet) * 0.5, (top - fillet) * 0.5
    return revolved(
        [(inner, low, 0.0), (radius, low, fillet), (top, high, fillet), (inner_top, high, 0.0)], detail
    )


def bore(radius: float, span: Box, detail: Detail) -> Solid:
    """A plain cylinder around z, to be cut out of something."""
    segments = max(8, detail.segments // 4)
    shell = manifold3d.Manifold.cylinder(span[1] - span[0], radius, radius, segments)
    return Solid(shell.translate((0.0, 0.0, span[0])))


def bolt_circle(radius: float, count: int, bolt: float, span: Box, detail: Detail) -> Solid:
    """`count` bores of radius `bolt` on a circle around z."""
    one = bore(bolt, span, detail).translate((radius, 0.0, 0.0))
    return union([one.rotate((0.0, 0.0, 360.0 * k / count)) for k in range(count)])


def slab(circles: Sequence[Circle], span: Box, fillet: float, detail: Detail) -> Solid:
    """The hull of circles in the x-y plane, extruded over `span` in z, with rounded edges; convex.

    All its rings share their directions: an inset by d is the same outline with every radius less d.
    """
    turns = [2.0 * math.pi * k / detail.segments for k in range(detail.segments)]
    low, high = span

    def ring(z: float, inset: float) -> list[tuple[float, float, float]]:
        points = []
        for a in turns:
            u, v = math.cos(a), math.sin(a)
            x, y, r = max(circles, key=lambda c: c[0] * u + c[1] * v + c[2])
            points.append((x + (r - inset) * u, y + (r - inset) * v, z))
        return points

    steps = [(math.pi / 2.0) * k / detail.fillet_steps for k in range(detail.fillet_steps + 1)]
    depths = [(fillet * (1.0 - math.sin(a)), fillet * (1.0 - math.cos(a))) for a in steps]
    rings = [ring(low + rise, inset) for inset, rise in depths]
    rings += [ring(high - rise, inset) for inset, rise in reversed(depths)]
    return lofted(np.array(rings))


def block(x: Box, y: Box, z: Box, fillet: float, detail: Detail) -> Solid:
    """A box with all edges and corners rounded."""
    corners = [(a, b, fillet) for a in (x[0] + fillet, x[1] - fillet) for b in (y[0] + fillet, y[1] - fillet)]
    return slab(corners, z, fillet, detail)


def along_y(solid: Solid) -> Solid:
    """The solid with its z axis turned to y (and its y axis to -z): slabs in x-y come to stand in x-z."""
    return solid.rotate((-90.0, 0.0, 0.0))


def upright_slab(circles: Sequence[Circle], span: Box, fillet: float, detail: Detail) -> Solid:
    """A slab whose circles lie in the x-z plane: centres (x, z), extruded over `span` in y."""
    return along_y(slab([(x, -z, r) for x, z, r in circles], span, fillet, detail))


def hub(centre: tuple[float, float], radius: float, span: Box, fillet: float, detail: Detail) -> Solid:
    """A cylinder around an axis along y through (x, z) = `centre`, over `span` in y."""
    return along_y(cylinder(radius, span, fillet, detail)).translate((centre[0], 0.0, centre[1]))


def union(solids: Sequence[Solid]) -> Solid:
    """All solids as one."""
    shell = manifold3d.Manifold.batch_boolean([solid.shell for solid in solids], manifold3d.OpType.Add)
    return Solid(shell)


def cut(solid: Solid, tools: Sequence[Solid]) -> Solid:
    """The solid less all tools."""
    shells = [solid.shell, *(tool.shell for tool in tools)]
    shell = manifold3d.Manifold.batch_boolean(shells, manifold3d.OpType.Subtract)
    return Solid(shell)


def sharp_block(x: Box, y: Box, z: Box) -> Solid:
    """A box with sharp edges, whose faces are exactly where they are said to be."""
    sides = [high - low for low, high in (x, y, z)]
    return Solid(manifold3d.Manifold.cube(sides).translate((x[0], y[0], z[0])))
