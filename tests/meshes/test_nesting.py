"""Nested components: what is inside out is found and turned, whatever lies in what."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from kabo.meshes import Mesh, examine, repaired
from kabo.meshes.nesting import winding_number
from tests.meshes.solids import box, together


def winding(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    return np.round(winding_number(points, mesh.vertices, mesh.faces))


def test_winding_numbers_count_what_lies_around_a_point() -> None:
    mesh = together(box(4.0), box(2.0, inverted=True), box(1.0), box(1.0, at=(9.0, 0.0, 0.0)))
    points = np.array([[0.1, 0.2, 0.3], [0.8, 0.1, 0.0], [1.5, 0.3, 0.2], [9.1, 0.1, 0.2], [5.0, 5.0, 5.0]])
    assert winding(mesh, points).tolist() == [1.0, 0.0, 1.0, 1.0, 0.0]


@given(inverted=st.lists(st.booleans(), min_size=1, max_size=5), apart=st.lists(st.booleans(), max_size=3))
def test_a_repaired_nest_never_winds_backwards_and_keeps_what_was_sound(
    inverted: list[bool], apart: list[bool]
) -> None:
    """Cubes in cubes and cubes beside them, each turned either way."""
    nest = [box(2.0 * (len(inverted) - k), inverted=turned) for k, turned in enumerate(inverted)]
    nest += [box(1.0, at=(20.0 + 3.0 * k, 0.0, 0.0), inverted=turned) for k, turned in enumerate(apart)]
    mesh = together(*nest)
    points = np.array([[k + 0.5, 0.1, 0.2] for k in range(len(inverted) + 1)])
    points = np.vstack([points, [[20.0 + 3.0 * k, 0.1, 0.2] for k in range(len(apart) + 1)]])
    sound = bool((winding(mesh, points) >= 0).all())
    assert (examine(mesh).inside_out == 0) == sound
    made, done = repaired(mesh)
    assert (done == []) == sound
    assert (winding(made, points) >= 0).all()
    assert winding(made, points)[len(inverted)] == 0, "outside the nest"
