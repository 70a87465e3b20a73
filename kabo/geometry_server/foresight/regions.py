"""Regions that can never contain an object, whatever the robot does: proven by the object's own widths.

A placement family may leave the object's rotation open; then the least width over all rotations that it permits
counts. Where the family puts a plane of the object onto its support, the heights of both are known as well.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.foresight.measures import Measure, millimetres
from kabo.geometry_server.foresight.widths import Excess, corners, excess_about, excess_at_any, fits_about
from kabo.geometry_server.frames import WORLD_FEATURES
from kabo.language.scene_description import Constraint, Feature, FeatureName, PlacementFamily
from kabo.scene import Body, Region, Scene

NEGLIGIBLE = 1e-5  # [m]: constraints hold within less
ALIGNING = {"aligned": (1.0,), "opposed": (-1.0,), "parallel": (1.0, -1.0), "coincident": (1.0, -1.0)}  # signs
SIGNED = ("aligned", "opposed")  # kinds that compare directions, of lines and of planes alike
ALONG = ("x", "y", "z")


def uncontained(
    scene: Scene, body: Body, region: Region, support: str | None, wanted: str = "any"
) -> Measure | None:
    """The proof that no placement family puts a body inside a region; None if one may, or does not ask for it.

    Args:
        scene: the scene.
        body: the body that is to be placed.
        region: the region that is to contain it.
        support: the body that it is placed on; only one that never moves says anything about heights.
        wanted: the only placement family that counts; `any`: all of the body's.
    """
    least: Measure | None = None
    for family in body.placements.values():
        if wanted in ("any", family.name):
            found = _Placing(scene, body, region, support, family).proof()
            if found is None:
                return None
            least = found if least is None or found.missing < least.missing else least
    return least


@dataclass(frozen=True)
class _Directed:
    """A point of a feature and its unit direction, in the frame that is asked for."""

    origin: Array
    direction: Array


@dataclass(frozen=True)
class _Placing:
    """A body that is to be placed inside a region, by one placement family."""

    scene: Scene
    body: Body
    region: Region
    support: str | None
    family: PlacementFamily

    def proof(self) -> Measure | None:
        """The greatest excess that is proven; None if there is none, or if the family does not ask for `inside`."""
        if not any(constraint.kind == "inside" for constraint in self.family.constraints):
            return None
        return max((*self._too_high(), *self._too_wide()), key=lambda each: each.missing, default=None)

    # ------------------------------------------------------------------------------------------------- heights
    def _too_high(self) -> Iterator[Measure]:
        """The proof that the body, standing on its support, reaches out of the region's top or bottom."""
        for constraint, own, other in self._pairs():
            ground = self._known(other) if constraint.kind == "coincident" and other.owner == "support" else None
            base = self.body.features.get(own.feature or "")
            if base is not None and ground is not None and base.kind != "line" and self._is_plane(other):
                yield from self._beyond_ends(np.asarray(base.origin, dtype=np.float64), ground)

    def _beyond_ends(self, base: Array, ground: _Directed) -> Iterator[Measure]:
        """How far the body, with its point `base` (3,) in the support's plane, reaches beyond faces along that plane."""
        ups = [(own, sign) for own, world in self._aligned_axes() if (sign := _sign(world, ground.direction))]
        spans = [_reaches(sign * ((self.body.mesh.vertices - base) @ own)) for own, sign in ups]
        for normal, offset in zip(self._normals, self.region.offsets, strict=True):
            sign = _sign(normal, ground.direction)
            if sign and spans:
                room = float(offset - normal @ (ground.origin - self.region.world_T_region[:3, 3]))
                need = min(high if sign > 0 else -low for low, high in spans)
                if need > room + NEGLIGIBLE:
                    yield self._height_measure(sign > 0, room, need)

    def _height_measure(self, above: bool, room: float, need: float) -> Measure:
        region, body = self.region.name, self.body.name
        if above and room <= 0.0:
            said = f"{region} ends {millimetres(-room)} below where {body} stands on {self.support}"
        elif above:
            said = (
                f"{body} stands {millimetres(need)} high on {self.support}, where {region} is "
                f"{millimetres(room)} high: {region} is {millimetres(need - room)} too low"
            )
        else:
            said = f"{region} begins {millimetres(need - room)} above where {body} stands on {self.support}"
        return Measure(self._name, said, room, need, proven=True)

    # -------------------------------------------------------------------------------------------------- widths
    def _too_wide(self) -> Iterator[Measure]:
        """The proof that the body is wider than the region at every rotation that the family permits."""
        directions, rooms, labels = self._opposite_faces()
        if not len(rooms):
            return
        points = self.body.mesh.vertices
        if any(fits_about(points, own, world, directions, rooms) for own, world in self._aligned_axes()):
            return
        excess = self._least_excess(corners(points), directions, rooms)
        if excess.proven and excess.metres > NEGLIGIBLE:
            said = (
                f"{self.body.name} is at least {millimetres(excess.width)} wide along {labels[excess.direction]} of "
                f"{self.region.name}, which has {millimetres(excess.room)}: {millimetres(excess.metres)} too much"
            )
            yield Measure(self._name, said, excess.room, excess.width, proven=True)

    def _least_excess(self, points: Array, directions: Array, rooms: Array) -> Excess:
        """The excess at the rotation where the body exceeds its room least, of those that the family permits."""
        axes = self._aligned_axes()
        if not axes:
            return excess_at_any(points, rooms)
        found = [excess_about(points, own, world, directions, rooms) for own, world in axes]
        return min(found, key=lambda each: (each.proven, each.metres))

    def _aligned_axes(self) -> list[tuple[Array, Array]]:
        """A direction of the body and the one that a constraint aligns it with, for every sign that it permits."""
        found: list[tuple[Array, Array]] = []
        for constraint, own, other in self._pairs():
            ours, theirs, signs = self._own(own), self._known(other), ALIGNING.get(constraint.kind)
            alike = constraint.kind in SIGNED or self._kind(own) == self._kind(other)
            if signs is not None and ours is not None and theirs is not None and alike:
                axes = [(ours.direction, sign * theirs.direction) for sign in signs]
                found = axes if not found or len(axes) < len(found) else found
        return found

    def _opposite_faces(self) -> tuple[Array, Array, list[str]]:
        """Directions (D, 3) in the world across which the region has two parallel faces, the room between, and names."""
        normals, offsets = self._normals, self.region.offsets
        directions, rooms, labels = [], [], []
        for i, normal in enumerate(normals):
            across = np.flatnonzero(normals[i + 1 :] @ normal < -1.0 + 1e-9)
            if len(across):
                directions.append(normal)
                rooms.append(float(offsets[i] + offsets[i + 1 + across[0]]))
                labels.append(_label(self.region.normals[i]))
        return np.array(directions).reshape(-1, 3), np.array(rooms), labels

    # ------------------------------------------------------------------------------------------------ features
    @property
    def _name(self) -> str:
        return f"inside({self.body.name}, {self.region.name})"

    @property
    def _normals(self) -> Array:
        """The normals (H, 3) of the region's faces in the world."""
        return np.asarray(self.region.normals @ self.region.world_T_region[:3, :3].T)

    def _pairs(self) -> Iterator[tuple[Constraint, FeatureName, FeatureName]]:
        """The constraints between the body and another thing, with the body's feature and the other one."""
        for constraint in self.family.constraints:
            first, second = constraint.first, constraint.second
            if constraint.kind != "inside" and first.owner == "this" and second.owner != "this":
                yield constraint, first, second
            elif constraint.kind != "inside" and second.owner == "this" and first.owner != "this":
                yield constraint, second, first

    def _kind(self, name: FeatureName) -> str | None:
        """Whether a feature is a line or a plane."""
        features: Mapping[str, Feature]
        if name.owner == "this":
            features = self.body.features
        elif name.owner == "world":
            features = WORLD_FEATURES
        else:
            features = {} if self.support is None else self.scene.bodies[self.support].features
        feature = features.get(name.feature or "")
        return None if feature is None else feature.kind

    def _is_plane(self, name: FeatureName) -> bool:
        return self._kind(name) == "plane"

    def _own(self, name: FeatureName) -> _Directed | None:
        return _placed(self.body.features.get(name.feature or ""), np.eye(4))

    def _known(self, name: FeatureName) -> _Directed | None:
        """A directed feature of the world, or of a support that never moves, in the world."""
        if name.owner == "world":
            return _placed(WORLD_FEATURES.get(name.feature or ""), np.eye(4))
        if name.owner != "support" or self.support is None or self.support not in self.scene.fixed_poses:
            return None
        features = self.scene.bodies[self.support].features
        return _placed(features.get(name.feature or ""), self.scene.fixed_poses[self.support])


def _placed(feature: Feature | None, pose: Array) -> _Directed | None:
    if feature is None or feature.direction is None:
        return None
    direction = pose[:3, :3] @ np.asarray(feature.direction, dtype=np.float64)
    origin = pose[:3, :3] @ np.asarray(feature.origin, dtype=np.float64) + pose[:3, 3]
    return _Directed(origin, direction / np.linalg.norm(direction))


def _sign(first: Array, second: Array) -> float:
    """1 or -1 for two unit directions that are equal or opposite, else 0."""
    cosine = float(first @ second)
    return float(np.sign(cosine)) if abs(cosine) > 1.0 - 1e-9 else 0.0


def _reaches(heights: Array) -> tuple[float, float]:
    return float(heights.min()), float(heights.max())


def _label(normal: Array) -> str:
    """The name of a direction in its frame."""
    axis = int(np.argmax(np.abs(normal)))
    if abs(normal[axis]) > 1.0 - 1e-9:
        return f"the {ALONG[axis]} axis"
    x, y, z = (round(float(v), 3) + 0.0 for v in normal)
    return f"the direction ({x:g}, {y:g}, {z:g})"
