"""Which contacts a segment may permit: fingers and what they hold; what is held and what it stands on."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from kabo.plan import Segment
from kabo.scene import Scene

RAISED = 2e-3  # [m] held up by this much, an object must be clear of what it is lifted from or lowered to


@dataclass(frozen=True)
class Permits:
    """What a segment permits: `loose` pairs need no check, `raised` ones only that the object stays above."""

    loose: frozenset[frozenset[str]] = frozenset()
    raised: frozenset[frozenset[str]] = frozenset()
    refused: tuple[tuple[str, str], ...] = ()

    def joined(self, other: "Permits") -> "Permits":
        """What either permits."""
        return Permits(self.loose | other.loose, self.raised | other.raised, self.refused + other.refused)


def permits(
    segment: Segment,
    scene: Scene,
    *,
    touched: Iterable[str],
    loose: Iterable[str] = (),
    supports: Iterable[tuple[str, str]] = (),
    mating: Iterable[frozenset[str]] = (),
) -> Permits:
    """What of a segment's allowed contacts is granted.

    Args:
        segment: the segment.
        scene: with the contacts that are always permitted.
        touched: what the robot holds, takes or lets go in this node: its fingers may touch it.
        loose: of these, what moves against the fingers by the gripper's joints only. When an arm moves, fingers do
            not move against what they hold, and must not touch anything else.
        supports: (object, body) that the object stands on at the beginning or end of this segment.
        mating: pairs of bodies that are put together, or hang together already.
    """
    gripper = scene.robots[segment.robot].gripper
    fingers = () if gripper is None else gripper.touch_links
    held = {frozenset((finger, name)) for finger in fingers for name in touched}
    opening = {frozenset((finger, name)) for finger in fingers for name in loose}
    standing, joined = {frozenset(pair) for pair in supports}, set(mating)
    free, raised, refused = set(), set(), []
    for first, second in segment.allowed_contacts:
        pair = frozenset((first, second))
        if pair in held:
            free |= {pair} & opening
        elif pair in joined:
            free.add(pair)
        elif pair in standing:
            raised.add(pair)
        elif not (_exists(scene, first) and _exists(scene, second) and scene.never_collide(first, second)):
            refused.append((first, second))
    return Permits(frozenset(free), frozenset(raised), tuple(refused))


def _exists(scene: Scene, name: str) -> bool:
    robot, dot, link = name.partition(".")
    return link in scene.robots[robot].links if dot and robot in scene.robots else name in scene.bodies


def is_first(segments: Sequence[Segment], i: int) -> bool:
    """Whether no arm segment came between the beginning, or what was taken, and this segment."""
    planned = segments[i].joints
    for segment in reversed(segments[:i]):
        if segment.attach:
            return True
        if segment.joints == planned:
            return False
    return True


def is_last(segments: Sequence[Segment], i: int) -> bool:
    """Whether no arm segment comes between this segment and what is let go, or the end."""
    planned = segments[i].joints
    if segments[i].detach:
        return True
    for segment in segments[i + 1 :]:
        if segment.joints == planned:
            return False
        if segment.detach:
            return True
    return True
