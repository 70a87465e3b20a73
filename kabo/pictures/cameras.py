"""Cameras: where a picture is taken from, chosen so that what is drawn fills it."""

from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array

VIEW_ANGLE = np.deg2rad(28.0)  # from the bottom to the top of a picture, where nobody asked for another
MARGIN = 1.06  # how much wider a picture is than what it shows
ASPECTS = (0.95, 2.3)  # of pictures whose size is free: width by height
AZIMUTHS, ELEVATIONS = (
    16,
    (22.0, 32.0, 44.0),
)  # the sides that are tried: so many around, and degrees above the floor
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Camera:
    """A perspective camera: position and focus (3,) [m], and the angle from bottom to top of the picture [rad]."""

    position: Array
    focus: Array
    angle: float = float(VIEW_ANGLE)

    @property
    def axes(self) -> Array:
        """Rows (3, 3): right, up, and from the focus to the camera."""
        return axes_of(self.position - self.focus)

    def seen(self, points: Array, size: tuple[int, int]) -> Array:
        """Pixels (N, 2) at which points (N, 3) are seen in a picture of some width and height, and depths: (N, 3)."""
        x, y, z = self.axes @ (points - self.position).T
        depth = np.maximum(-z, 1e-9)
        scale = size[1] / 2.0 / np.tan(self.angle / 2.0)
        return np.stack([size[0] / 2.0 + scale * x / depth, size[1] / 2.0 - scale * y / depth, depth], axis=1)


def axes_of(away: Array) -> Array:
    """Rows (3, 3) right, up, away of a camera that looks against `away`; its picture is upright."""
    away = away / np.linalg.norm(away)
    side = np.cross(UP, away)
    right = np.array([1.0, 0.0, 0.0]) if np.linalg.norm(side) < 1e-9 else side / np.linalg.norm(side)
    return np.array([right, np.cross(away, right), away])


def directions() -> list[Array]:
    """Directions (3,) away from what is looked at: the sides of which the best is taken."""
    found = []
    for elevation in np.deg2rad(ELEVATIONS):
        for azimuth in np.arange(AZIMUTHS) * 2.0 * np.pi / AZIMUTHS + np.pi / AZIMUTHS:
            flat = np.cos(elevation) * np.array([np.cos(azimuth), np.sin(azimuth)])
            found.append(np.array([*flat, np.sin(elevation)]))
    return found


def fitted(points: Array, away: Array, aspect: float) -> Camera:
    """The nearest camera that sees all points (N, 3) when it looks against `away` (3,).

    Args:
        points: [m]. away: from what is seen to the camera. aspect: of the picture, width by height.
    """
    axes = axes_of(away)
    local = points @ axes.T
    top = np.tan(VIEW_ANGLE / 2.0) / MARGIN
    (x, wide), (y, high) = (
        _between(local[:, k], local[:, 2], slope) for k, slope in ((0, top * aspect), (1, top))
    )
    # At least as far away as the drawing is large: a single small thing is not looked at from within.
    z = max(wide, high, float(local[:, 2].max()) + 0.02 * _extent(points))
    focus = axes.T @ np.array([x, y, float(local[:, 2].mean())])
    return Camera(axes.T @ np.array([x, y, z]), focus)


def natural_aspect(points: Array, away: Array, narrowest: float = ASPECTS[0]) -> float:
    """The width by height of a picture that the points fill when looked at against `away`, within some limits."""
    width, height = 1500, 1000
    seen = fitted(points, away, width / height).seen(points, (width, height))
    across, along = np.ptp(seen[:, :2], axis=0)
    return float(np.clip(across / max(along, 1e-9), narrowest, ASPECTS[1]))


def _between(values: Array, depths: Array, slope: float) -> tuple[float, float]:
    """Where a camera stands across, and how far away, so that all points lie between two planes of some slope."""
    one, other = float((values + slope * depths).max()), float((-values + slope * depths).max())
    return (one - other) / 2.0, (one + other) / (2.0 * slope)


def _extent(points: Array) -> float:
    return float(np.linalg.norm(np.ptp(points, axis=0)))
