"""Elements of links and bodies: one for each shape, round ones exactly, each in its owner's frame."""

from pathlib import Path

import numpy as np
import pytest

from kabo.errors import InputError
from kabo.language.scene_description import Shape
from kabo.meshes import Rounding, write_mesh
from kabo.scene.elements import Element
from kabo.scene.shapes import element_of, primitive
from kabo.scene.urdf_file import read_urdf

LINK = """<robot name="r">
  <link name="arm">{shapes}</link>
</robot>
"""
TURN = '<origin xyz="0.1 0 0.2" rpy="0 1.5707963267948966 0"/>'


def elements(folder: Path, *shapes: str, tag: str = "collision") -> tuple[Element, ...]:
    """The elements of a link with these geometries, each turned by 90 degrees about y and moved."""
    written = "\n".join(f"<{tag}>{TURN}<geometry>{shape}</geometry></{tag}>" for shape in shapes)
    path = folder / "robot.urdf"
    path.write_text(LINK.format(shapes=written))
    return read_urdf(path, {}, None).elements["arm"]


def test_each_geometry_of_a_link_is_an_element_in_the_frame_of_the_link(tmp_path: Path) -> None:
    block = primitive(Shape("box", size=(0.1, 0.2, 0.3)))
    write_mesh(tmp_path / "block.off", block.vertices, block.faces)
    found = elements(
        tmp_path,
        '<mesh filename="block.off"/>',
        '<box size="0.1 0.2 0.3"/>',
        '<sphere radius="0.05"/>',
        '<cylinder radius="0.05" length="0.4"/>',
        '<capsule radius="0.05" length="0.4"/>',
    )
    assert [made.kind for made in found] == ["mesh", "box", "sphere", "cylinder", "capsule"]
    assert [None if made.corners is None else len(made.corners) for made in found] == [None, 8, 1, 2, 2]
    assert [made.place.line if made.place else None for made in found] == [2, 3, 4, 5, 6]
    ends = np.array([[-0.1, 0.0, 0.2], [0.3, 0.0, 0.2]])
    assert np.allclose(found[3].corners, ends)  # type: ignore[arg-type]
    assert found[3].rounding is not None and found[3].rounding.disc == 0.05 and found[3].rounding.radius == 0.0
    assert np.allclose(found[3].rounding.axis, (1.0, 0.0, 0.0))
    assert np.allclose(found[4].corners, ends) and found[4].rounding.radius == 0.05  # type: ignore[arg-type, union-attr]
    assert np.allclose(found[2].corners, [[0.1, 0.0, 0.2]]) and found[2].rounding.radius == 0.05  # type: ignore[arg-type, union-attr]


def test_without_collision_elements_the_visual_ones_count(tmp_path: Path) -> None:
    assert [made.kind for made in elements(tmp_path, '<sphere radius="0.05"/>', tag="visual")] == ["sphere"]


def test_a_capsule_without_length_is_refused_at_its_place(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="<capsule> has no `length`") as refused:
        elements(tmp_path, '<capsule radius="0.05"/>')
    assert refused.value.diagnostics[0].line == 2


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder"])
def test_the_mesh_of_a_round_element_lies_around_it_and_near(kind: str) -> None:
    made = element_of(Shape(kind, size=(0.1, 0.1, 0.4)), None)  # type: ignore[arg-type]
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    reached = _support(made, directions)
    own = (directions @ made.mesh.vertices.T).max(axis=1)
    assert (own >= reached - 1e-12).all()
    assert (own <= reached + 0.1 * 0.01).all()


def _support(made: Element, directions: np.ndarray) -> np.ndarray:
    """How far an element reaches in each direction [m]."""
    assert made.corners is not None and isinstance(made.rounding, Rounding)
    along = directions @ np.asarray(made.rounding.axis)
    across = np.sqrt(np.maximum(0.0, 1.0 - along**2))
    return (directions @ made.corners.T).max(axis=1) + made.rounding.radius + made.rounding.disc * across
