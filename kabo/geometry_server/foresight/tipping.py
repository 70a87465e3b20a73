"""Objects that tip over at the start, since the middle of their mass is beside all on which they stand.

The mass counts as spread evenly over the object. Told is only what cannot stand: whoever touches the object from the side
or from above may keep it, and the area in which it touches what is below is taken to be as large as it can be.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.geometry_server.foresight.things import Thing, things_at_start
from kabo.geometry_server.situation import Situation
from kabo.meshes.soundness import examine
from kabo.scene import Scene

NEAR = 1e-3  # [m] within which things may touch, and less than which nothing is told


@dataclass(frozen=True)
class Tipping:
    """An object, what is below it, and how far the middle of its mass is beside that [m], at least."""

    name: str
    carriers: tuple[str, ...]
    metres: float


def tipping(scene: Scene) -> list[Tipping]:
    """The objects which tip over at the start, of those that can be grasped, in the scene's order.

    Other movable ones may hang on something, or run on rails.
    """
    situation = Situation.of(scene.start)
    held = {name for name in scene.start.objects if "." in situation.held(name).parent}
    things = things_at_start(scene)
    loose = {body.name for body in scene.bodies.values() if body.movable and body.grasps} - held
    found = (_beside(own, things) for own in things if own.name in loose)
    return [each for each in found if each is not None]


def _beside(own: Thing, things: list[Thing]) -> Tipping | None:
    """How an object tips over; None if it may stand, or has surfaces that enclose nothing."""
    met = [other for other in things if other is not own and _meet(own, other)]
    if not met or any(other.high[2] > own.low[2] + NEAR for other in met) or not examine(own.mesh).is_closed:
        return None
    middle = _middle(own.triangles)
    if middle is None:
        return None
    base = _slice(own.triangles, own.low[2] + NEAR, 1.0)
    shared = [_common(base, _slice(other.triangles, own.low[2] - NEAR, -1.0)) for other in met]
    try:
        sides = ConvexHull(np.concatenate(shared)).equations
    except (QhullError, ValueError):  # it stands on an edge, or on nothing
        return None
    metres = float((sides[:, :2] @ middle[:2] + sides[:, 2]).max())
    carriers = tuple(other.name for other, area in zip(met, shared, strict=True) if len(area))
    return Tipping(own.name, carriers, metres) if metres > NEAR else None


def _meet(first: Thing, second: Thing) -> bool:
    """Whether the boxes of two things are near each other."""
    return bool((first.low <= second.high + NEAR).all() and (second.low <= first.high + NEAR).all())


def _middle(triangles: Array) -> Array | None:
    """The centre of the solid within triangles (T, 3, 3), by tetrahedra from one corner [Tonon 2004]; None: it is flat."""
    origin = triangles[0, 0]
    corners = triangles - origin
    volumes = np.einsum("ti,ti->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    total = float(volumes.sum())
    if total <= 0.0:
        return None
    return np.asarray(origin + np.einsum("t,tci->i", volumes, corners) / (4.0 * total))


def _slice(triangles: Array, height: float, sign: float) -> Array:
    """The corners (n, 2), seen from above, of what triangles have below a height, or above it for the sign -1."""
    over = sign * (triangles[..., 2] - height)
    ends, heights = np.roll(triangles, -1, axis=1), np.roll(over, -1, axis=1)
    cut = over * heights < 0.0
    share = (over[cut] / (over[cut] - heights[cut]))[:, None]
    crossing = triangles[cut] + share * (ends[cut] - triangles[cut])
    return np.asarray(np.concatenate([triangles[over <= 0.0], crossing])[:, :2])


def _common(first: Array, second: Array) -> Array:
    """The corners (n, 2) of what the convex hulls of two sets of points in a plane share."""
    try:
        area, sides = first[ConvexHull(first).vertices], ConvexHull(second).equations
    except (QhullError, ValueError):
        return np.zeros((0, 2))
    for side in sides:
        if not len(area):
            break
        over = area @ side[:2] + side[2]
        ends, heights = np.roll(area, -1, axis=0), np.roll(over, -1)
        kept = []
        for corner, end, here, there in zip(area, ends, over, heights, strict=True):
            kept += [corner] if here <= 0.0 else []
            kept += [corner + here / (here - there) * (end - corner)] if here * there < 0.0 else []
        area = np.array(kept).reshape(-1, 2)
    return np.asarray(area)
