"""How far a body may be from where it would be on the path, as the joints are off the path by known amounts."""

import numpy as np

from kabo.arrays import Array
from kabo.scene import PRISMATIC, KinematicTree


def farthest_off(tree: KinematicTree, joint: int, radius: float, deviations: Array) -> float:
    """A bound of the distance [m] of any point of a body from its place with the joints on the path.

    Args:
        tree: the robot's.
        joint: the one that carries the body.
        radius: the distance of its farthest point from the origin of that joint's frame [m].
        deviations: how far each value of a configuration may be off, (n,) [rad or m].
    """
    found, reach, here = 0.0, radius, joint
    while here > 0:
        value, ratio = int(tree.source[here]), abs(float(tree.ratio[here]))
        slides = tree.kind[here] == PRISMATIC
        found += ratio * float(deviations[value]) * (1.0 if slides else reach)
        farthest = ratio * max(abs(float(tree.lower[value])), abs(float(tree.upper[value])))
        reach += float(np.linalg.norm(tree.placement[here, 9:]))
        reach += farthest + abs(float(tree.shift[here])) if slides else 0.0
        here = int(tree.parent[here])
    return found
