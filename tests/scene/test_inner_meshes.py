"""Meshes inside round elements lie in them, and as near to them as they claim."""

import numpy as np
import pytest

from kabo.language.scene_description import Shape
from kabo.scene.inner_meshes import inner_mesh
from kabo.scene.shapes import element_of

TURN = np.array([[0.0, 0.0, 1.0, 0.3], [1.0, 0.0, 0.0, -0.2], [0.0, 1.0, 0.0, 0.1], [0.0, 0.0, 0.0, 1.0]])


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_an_inner_mesh_reaches_nowhere_out_of_its_element_and_nowhere_short_of_it_by_more_than_said(
    kind: str, tolerance: float
) -> None:
    element = element_of(Shape(kind, size=(0.2, 0.2, 0.5)), None).moved(TURN)  # type: ignore[arg-type]
    mesh, deviation = inner_mesh(element, tolerance)
    assert 0.0 < deviation <= tolerance
    rng = np.random.default_rng(1)
    directions = rng.normal(size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    assert element.corners is not None and element.rounding is not None
    truth = (directions @ element.corners.T).max(axis=1) + element.rounding.reach(directions)
    reached = (directions @ mesh.vertices.T).max(axis=1)
    assert (reached <= truth + 1e-12).all()
    assert (reached >= truth - deviation - 1e-12).all()


def test_a_box_and_a_mesh_are_their_own_inner_meshes() -> None:
    box = element_of(Shape("box", size=(0.1, 0.2, 0.3)), None)
    assert inner_mesh(box, 0.001) == (box.mesh, 0.0)
