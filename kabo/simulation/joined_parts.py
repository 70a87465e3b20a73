"""Parts that hold together: a mate with `holds`, once it has come together, fixes one part to the other in physics."""

from collections.abc import Callable, Collection, Iterator
from itertools import combinations

import numpy as np

from kabo.arrays import Array
from kabo.geometry_server.frames import fits, rows, standing_frame
from kabo.kinematics import missed
from kabo.language.scene_description import Mate
from kabo.scene import Scene

IN_PLACE = 2e-3  # [m]: a part that is so near to where its mate has it has come into its fit, or caught
TURNED = 0.02  # [rad], or of a cosine: 1 degree that it may still be tilted


def holding_mates(scene: Scene) -> Iterator[tuple[Mate, str, str]]:
    """The mates that hold of all pairs of bodies, each with the body that it moves and the one to which it is fixed."""
    for pair in combinations(scene.bodies, 2):
        for mate, moving, fixed in scene.mates_between(*pair):
            if mate.holds and scene.bodies[moving].movable:
                yield mate, moving, fixed


def joined(scene: Scene, bodies: Collection[str], pose: Callable[[str], Array]) -> Iterator[tuple[str, str]]:
    """The parts that have come together by a mate that holds: what is fixed, and what has been brought to it.

    Args:
        scene: the scene.
        bodies: the bodies of which one at least is of the pair.
        pose: gives the pose (4, 4) of a body in the world.
    """
    tree = next((robot.tree for robot in scene.robots.values()), None)
    for mate, moving, fixed in holding_mates(scene) if tree is not None else ():
        if moving not in bodies and fixed not in bodies:
            continue
        roles = {
            role: standing_frame(scene.bodies[name], pose(name))
            for role, name in (("moving", moving), ("fixed", fixed))
        }
        if fits(mate.constraints, roles) and tree is not None:
            lengths, turns = missed(rows(mate.constraints, roles), np.zeros(len(tree.lower)), tree)
            if lengths <= IN_PLACE and turns <= TURNED:
                yield fixed, moving
