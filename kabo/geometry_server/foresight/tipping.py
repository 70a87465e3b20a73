"""Objects that tip over where they are, at the start or as they are put down: the middle of their mass is beside all below.

The mass counts as spread evenly over the object. Told is only what cannot stand: whoever touches the object from the side
or from above may keep it, and the area in which it touches what is below is taken to be as large as it can be.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from kabo.arrays import Array
from kabo.geometry_server.foresight.things import Thing, placed, things_at_start
from kabo.geometry_server.foresight.widths import turn_onto
from kabo.geometry_server.situation import Situation
from kabo.geometry_server.surroundings import SceneSurroundings
from kabo.meshes.soundness import is_closed
from kabo.scene import Scene

NEAR = 1e-3  # [m] within which things may touch, and less than which nothing is told
ROOM = 3e-3  # [m] to the edge of what carries an object that is put down: robots put it as far beside its place,
SHARE = 0.25  # but no more than this share of the way from the edge to the middle of a narrow support


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
    every = _Things.of(things)
    found = (_beside(own, _below(own, every.near(own)), middle_of(own)) for own in things if own.name in loose)
    return [each for each in found if each is not None]


def tips_over(
    surroundings: SceneSurroundings, situation: Situation, name: str, pose: Array, support: str | None = None
) -> Tipping | None:
    """How an object tips over, or falls, if a hand lets go of it at a pose (4, 4) or a little beside; None if it may stand.

    Whatever it may stand on counts, robots do not; `support` is what it should stand on. Of what other objects hang on,
    nothing is said.
    """
    (own_middle,) = surroundings.lasting(
        ("middle", name), lambda: (middle_of(Thing.at(name, surroundings.scene.bodies[name].mesh, np.eye(4))),)
    )
    if own_middle is None or situation.group(name) != (name,):
        return None
    own, middle = Thing.at(name, surroundings.scene.bodies[name].mesh, pose), placed(own_middle, pose)
    others: _Things = surroundings.remembered(
        ("things", name, situation.key), lambda: _Things.of(list(_others(surroundings, situation, name)))
    )
    met = others.near(own)
    # Nothing leans on what it may not touch: only what it stands in may hold it from the side, or what it always touches.
    holding = [other for other in met if other.name == support or surroundings.never_collide(name, other.name)]
    if any(other.high[2] > own.low[2] + NEAR for other in (holding if support is not None else met)):
        return None
    below = [other for other in met if other.high[2] <= own.low[2] + NEAR]
    if not below:
        under = [other for other in others.things if other.name == support]
        away = min((_away(own, other, middle) for other in under), default=0.0)
        return Tipping(name, (str(support),), away) if away > 0.0 else None
    if _surely_stands(surroundings, own, below, middle):
        return None
    if not any(map(len, _shared(own, below))):  # it is over none of them, as beside a round table
        away = min(_over(_carrying(_top(other, own.low[2])), middle) for other in below)
        return Tipping(name, tuple(dict.fromkeys(other.name for other in below)), away)
    return _beside(own, below, middle, 0.0, _carrying)


def _others(surroundings: SceneSurroundings, situation: Situation, name: str) -> Iterator[Thing]:
    """All bodies but one, wherever they may be in a situation."""
    for other, body in surroundings.scene.bodies.items():
        if other != name:
            yield from (Thing.at(other, body.mesh, at) for at in surroundings.poses(situation, other))


def _surely_stands(surroundings: SceneSurroundings, own: Thing, below: list[Thing], middle: Array) -> bool:
    """Whether the middle of an object's mass is over its lowest part, and over one of the things below it.

    Their areas are taken to be convex, so it is over what they share as well.
    """
    up, height = own.pose[2, :3].round(6), round(float(own.low[2]), 4)
    if surroundings.lasting(("base", own.name, up.tobytes()), lambda: _over_its_base(own, up)) > 0.0:
        return False
    for other in below:
        key = "top", other.name, other.pose.tobytes(), height
        sides = surroundings.lasting(key, lambda o=other: _carrying(_top(o, height)))  # type: ignore[misc]
        if _over(sides, middle) <= 0.0:
            return True
    return False


def _over_its_base(own: Thing, up: Array) -> float:
    """How far the middle of an object's mass is beside its lowest part [m], with `up` of its own frame upwards."""
    turn = np.eye(4)
    turn[:3, :3] = turn_onto(up / np.linalg.norm(up), np.array([0.0, 0.0, 1.0]))
    turned = Thing.at(own.name, own.mesh, turn)
    middle = middle_of(turned)
    assert middle is not None, "who asks for it has found it"
    return _over(_sides(_slice(turned.triangles, turned.low[2] + NEAR, 1.0)), middle)


def _over(sides: Array, point: Array) -> float:
    """How far a point is beside an area with these sides (k, 3), seen from above [m]; over it 0 or less."""
    return float((sides[:, :2] @ point[:2] + sides[:, 2]).max())


def _away(own: Thing, other: Thing, middle: Array) -> float:
    """How far the middle of an object is beside the box of another one, seen from above [m]; 0 if anything is over it."""
    if (own.low <= other.high)[:2].all() and (other.low <= own.high)[:2].all():
        return 0.0
    return float(np.linalg.norm(np.maximum(np.maximum(other.low - middle, middle - other.high), 0.0)[:2]))


def _sides(points: Array) -> Array:
    """The sides (k, 3) of the convex hull of points (n, 2); one that all is beside if they are on a line."""
    try:
        return np.asarray(ConvexHull(points).equations)
    except (QhullError, ValueError):
        return np.array([[0.0, 0.0, np.inf]])


def _carrying(points: Array) -> Array:
    """The sides (k, 3) of the area in which points (n, 2) carry the middle of a mass, with room to their convex hull."""
    sides = _sides(points)
    depth = -_over(sides, points.mean(axis=0)) if len(points) else 0.0
    return sides + [0.0, 0.0, min(ROOM, max(0.0, SHARE * depth))]


def middle_of(own: Thing) -> Array | None:
    """The middle (3,) of an object's mass; None if its surfaces enclose nothing."""
    return _middle(own.triangles) if is_closed(own.mesh) else None


def _below(own: Thing, met: list[Thing]) -> list[Thing]:
    """What an object may stand on, of what it meets; nothing if it may be held from the side or from above."""
    return [] if any(other.high[2] > own.low[2] + NEAR for other in met) else met


def _beside(
    own: Thing,
    met: list[Thing],
    middle: Array | None,
    least: float = NEAR,
    area: Callable[[Array], Array] = _sides,
) -> Tipping | None:
    """How an object tips over on things that it meets; None if it may stand, or is beside their area by `least` or less."""
    if not met or middle is None:
        return None
    shared = _shared(own, met)
    metres = _over(area(np.concatenate(shared)), middle)
    if metres == np.inf:  # it stands on an edge, or on nothing
        return None
    carriers = tuple(other.name for other, area in zip(met, shared, strict=True) if len(area))
    return Tipping(own.name, carriers, metres) if metres > least else None


def _shared(own: Thing, met: list[Thing]) -> list[Array]:
    """The corners (n, 2) of the area that an object shares with each thing that it meets, seen from above."""
    base = _slice(own.triangles, own.low[2] + NEAR, 1.0)
    return [_common(base, _top(other, own.low[2])) for other in met]


def _top(other: Thing, height: float) -> Array:
    """The corners (n, 2), seen from above, of what may carry something at a height."""
    return _slice(other.triangles, height - NEAR, -1.0)


@dataclass(frozen=True)
class _Things:
    """Things, and the corners (n, 3) of their boxes."""

    things: list[Thing]
    low: Array
    high: Array

    @classmethod
    def of(cls, things: list[Thing]) -> "_Things":
        low, high = ([getattr(each, name) for each in things] for name in ("low", "high"))
        return cls(things, np.reshape(low, (-1, 3)), np.reshape(high, (-1, 3)))

    def near(self, own: Thing) -> list[Thing]:
        """Those whose boxes are near that of a thing, without itself."""
        met = ((self.low <= own.high + NEAR) & (own.low <= self.high + NEAR)).all(axis=1)
        return [other for other in (self.things[i] for i in np.flatnonzero(met)) if other is not own]


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
