"""Distances that coal measured, remembered from one verification to the next: a plan's mutants move mostly as it does.

The verifier computes nothing else than without: a distance depends on the two bodies and their poses alone, which are
the key to it, bit by bit. Two thirds of the time of verifying again go into the same distances.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import pytest

from kabo.arrays import Array
from kabo.scene import Element, Mesh
from kabo.verify.motion import overlaps, scene_model, surfaces, sweep
from kabo.verify.motion.contacts import granted
from kabo.verify.motion.surfaces import Surface

Distance = Callable[[Surface, Array, Surface, Array], float]


@contextmanager
def remembered_distances() -> Iterator[None]:
    """While it lasts, no distance of two bodies at equal poses is measured twice, and no body's surface is made twice."""
    with pytest.MonkeyPatch.context() as patch:
        mesh_distance, hull_gap = _once(surfaces.mesh_distance), _once(surfaces.hull_gap)
        for user in (granted, overlaps, sweep):
            patch.setattr(user, "mesh_distance", mesh_distance)
        for user in (overlaps, sweep):
            patch.setattr(user, "hull_gap", hull_gap)
        patch.setattr(scene_model, "surface", _made_once(surfaces.surface))
        yield


def _once(measure: Distance) -> Distance:
    known: dict[tuple[bytes, bytes, bytes, bytes], float] = {}

    def remembering(first: Surface, world_T_first: Array, second: Surface, world_T_second: Array) -> float:
        key = (first.identity, world_T_first.tobytes(), second.identity, world_T_second.tobytes())
        if key not in known:
            known[key] = measure(first, world_T_first, second, world_T_second)
        return known[key]

    return remembering


def _made_once(make: Callable[..., Surface]) -> Callable[..., Surface]:
    known: dict[bytes, Any] = {}

    def remembering(mesh: Mesh, elements: Sequence[Element] = ()) -> Surface:
        key = surfaces.identity(mesh, elements)
        if key not in known:
            known[key] = make(mesh, elements)
        return known[key]

    return remembering
