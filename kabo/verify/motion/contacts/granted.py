"""Which contacts of a segment are granted: what the plan states of each is checked, one rule for each kind.

grasp: a finger and what its hand takes, holds or lets go, while only the hand moves, between open and the family's grip.
support: what is lifted or lowered and what it stands on, along the stroke of the grasp family; at the end that stands they
touch, and from there on every point of the object gets away. mate: two parts, along the insertion of their mate, likewise.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from kabo.arrays import Array
from kabo.plan import Segment
from kabo.scene import Scene
from kabo.verify.motion.surfaces import mesh_distance
from kabo.verify.motion.sweep import LEAST, Thing

Pair = frozenset[str]

TOUCHING = (1e-5, 1e-4)  # m: how deep what stands may be in what it stands on; the first that suffices is granted
GIVEN = (1e-5, 1e-4, 1e-3)  # m: where it stood so before the plan's motion moved it
HOVERING = 1e-3  # m: what stands is as near as this, as placements may be missed by


@dataclass(frozen=True)
class Permits:
    """What a segment permits: `loose` pairs need no check, `shifted` ones are measured a little apart.

    `shifted`: the body that gets away, and by which vector it is moved before distances are taken. `refused`: what the
    plan claims without right, and the two bodies.
    """

    loose: frozenset[Pair] = frozenset()
    shifted: Mapping[Pair, tuple[str, Array]] = field(default_factory=dict)
    refused: tuple[tuple[str, tuple[str, str]], ...] = ()

    def joined(self, other: "Permits") -> "Permits":
        """What either permits."""
        return Permits(self.loose | other.loose, {**self.shifted, **other.shifted}, self.refused + other.refused)

    @property
    def pairs(self) -> frozenset[Pair]:
        """All pairs whose contact is granted."""
        return self.loose | frozenset(self.shifted)

    def shift(self, first: str, second: str) -> Array | None:
        """By what the first of two bodies is moved before distances are taken."""
        found = self.shifted.get(frozenset((first, second))) if self.shifted else None
        return None if found is None else found[1] if found[0] == first else -found[1]


def unstated(segment: Segment, scene: Scene, together: frozenset[Pair]) -> list[tuple[str, str]]:
    """The permitted contacts of a segment of which it does not say what grants them, though something must.

    Args:
        segment: the segment.
        scene: with the contacts that are always permitted.
        together: pairs of bodies that hang together: they do not move against each other.
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
    moved: Thing, pose: Array, others: Sequence[Thing], away: Array, depths: Sequence[float]
) -> float | None:
    """By how little a body that stands must be moved away to be clear of all that it stands on; None: it is deeper in.

    Args:
        moved: the body.
        pose: where it stands (4, 4).
        others: what it stands on, each at its place.
        away: the direction (3,) in which it is moved.
        depths: what may be tried [m].
    """
    for depth in depths:
        apart = pose.copy()
        apart[:3, 3] += depth * away
        if all(mesh_distance(moved.surface, apart, o.surface, o.pose({})) > LEAST for o in others):
            return depth
    return None


def stands_at(moved: Thing, pose: Array, others: Sequence[Thing]) -> bool:
    """Whether a body is at one of others."""
    return any(mesh_distance(moved.surface, pose, o.surface, o.pose({})) <= HOVERING for o in others)
