"""What overlaps where a problem begins: of two parts that a mate joins it is no fault."""

from dataclasses import replace

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Situation
from kabo.geometry_server.foresight.starts import overlapping
from kabo.scene import Scene, attachment, world_T
from tests.domains.scenes import DOMAINS, scene_of

GEARBOX = scene_of(DOMAINS / "assembly" / "gearbox.yaml")  # o1 and o2 are bearings, o3 is a pipe


def inside(name: str, other: str, height: float) -> Scene:
    """The scene with a part so high above the origin of another one, upright as that is."""
    pose = world_T(GEARBOX, GEARBOX.start, other) @ np.block(
        [[np.eye(3), np.array([[0.0], [0.0], [height]])], [np.zeros((1, 3)), np.ones((1, 1))]]
    )
    start = replace(GEARBOX.start, objects={**GEARBOX.start.objects, name: attachment("world", pose)})
    return replace(GEARBOX, start=start, memory={})


@pytest.mark.parametrize(
    ("name", "other", "height", "faulty"),
    [
        ("o1", "o3", 0.0895, False),
        ("o2", "o3", 0.0895, False),
        ("o1", "o2", 0.0235, True),
    ],
)
def test_parts_may_overlap_if_a_mate_joins_their_models(
    name: str, other: str, height: float, faulty: bool
) -> None:
    """By half a millimetre, as parts do that were pressed in."""
    scene = inside(name, other, height)
    fault = overlapping(GeometryServer(scene).surroundings, Situation.of(scene.start), name)
    assert (fault is not None) == faulty
    if fault is not None:
        assert name in fault.things
