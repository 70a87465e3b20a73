"""The contacts that a segment is granted: the plan's claim about each is checked, with one rule for each kind.

- grasp: a finger may touch the object that its hand takes, holds or releases while only the hand moves, between
  its open position and the family's grip.
- support: an object that is lifted or lowered may touch its support along the stroke of the grasp family. They
  touch at the end of the stroke where the object stands, and from there every point of the object moves away.
- mate: two parts may touch along the insertion of their mate under the same conditions as for a support.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.scene import Scene
from kabo.verify.motion.surfaces import mesh_distance
from kabo.verify.motion.sweep import CONTACT_DISTANCE, SweptBody

BodyNames = frozenset[str]

CONTACT_DEPTHS = (1e-5, 1e-4)  # [m] how deep an object may be in its support; the first that suffices is granted
INITIAL_CONTACT_DEPTHS = (1e-5, 1e-4, 1e-3)  # [m] the same for an object that no motion has moved before
MAX_SUPPORT_GAP = 1e-3  # [m] between an object and its support; placements may be missed by as much


@dataclass(frozen=True)
class Permits:
    """The contacts that a segment permits: `loose` pairs are not checked, `shifted` ones with one body shifted.

    `shifted` names the body that moves away and the vector by which it is shifted before distances are measured.
    `refused` are the claims of the plan that do not hold, each with its two bodies.
    """

    loose: frozenset[BodyNames] = frozenset()
    shifted: Mapping[BodyNames, tuple[str, Array]] = field(default_factory=dict)
    refused: tuple[tuple[str, tuple[str, str]], ...] = ()

    def joined(self, other: "Permits") -> "Permits":
        """The union of two sets of permits: the contacts and the refused claims of both."""
        return Permits(self.loose | other.loose, {**self.shifted, **other.shifted}, self.refused + other.refused)

    @property
    def pairs(self) -> frozenset[BodyNames]:
        """All pairs whose contact is granted."""
        return self.loose | frozenset(self.shifted)

    def shift(self, first: str, second: str) -> Array | None:
        """The vector by which the first body is shifted before distances are measured; None for no shift."""
        found = self.shifted.get(frozenset((first, second))) if self.shifted else None
        return None if found is None else found[1] if found[0] == first else -found[1]


def unstated(segment: Segment, scene: Scene, together: frozenset[BodyNames]) -> list[tuple[str, str]]:
    """The contacts that a segment permits without a grant in the plan, although they need one.

    Args:
        segment: the segment.
        scene: the scene, with the contacts that are always permitted.
        together: pairs of bodies that are attached to each other, so that they do not move against each other.
    """
    stated = {frozenset(grant.bodies) for grant in segment.grants}
    missing = []
    for first, second in segment.allowed_contacts:
        pair = frozenset((first, second))
        known = _exists(scene, first) and _exists(scene, second)
        if pair not in stated and pair not in together and not (known and scene.never_collide(first, second)):
            missing.append((first, second))
    return missing


def _exists(scene: Scene, name: str) -> bool:
    robot, dot, link = name.partition(".")
    return link in scene.robots[robot].links if dot and robot in scene.robots else name in scene.bodies


def touching(
    moved: SweptBody, pose: Array, others: Sequence[SweptBody], away: Array, depths: Sequence[float]
) -> float | None:
    """The first of `depths` such that the body, shifted by it along `away`, is clear of its supports; else None.

    Args:
        moved: the body.
        pose: the pose (4, 4) of the body.
        others: the body's supports, each in its pose.
        away: the direction (3,) of the shift.
        depths: the distances to try [m].
    """
    for depth in depths:
        apart = pose.copy()
        apart[:3, 3] += depth * away
        if all(mesh_distance(moved.surface, apart, o.surface, o.pose({})) > CONTACT_DISTANCE for o in others):
            return depth
    return None


def stands_at(moved: SweptBody, pose: Array, others: Sequence[SweptBody]) -> bool:
    """Whether at least one of the other bodies is so near that the body can stand on it."""
    return any(mesh_distance(moved.surface, pose, o.surface, o.pose({})) <= MAX_SUPPORT_GAP for o in others)
