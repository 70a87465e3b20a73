"""Exact geometry of round elements: distances of bodies that are put at known gaps, and what lies inside of them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kabo.geometry import Budget, Enclosure, ExactView, FixedGroup, MovingGroup, exact_collides, exact_distance
from kabo.geometry.collision.exact_surfaces import PRISM_SIDES
from kabo.geometry.collision.motions import WORLD_TREE
from kabo.language.scene_description import Shape
from kabo.scene import Element, element_of
from kabo.scene.elements import one_mesh

KINDS = ("sphere", "capsule", "cylinder", "box")
NOWHERE = Enclosure((np.zeros((1, 3)),), 0.0)
PRISM = 1.0 / np.cos(np.pi / PRISM_SIDES) - 1.0  # of the radius, by which a cylinder's corners lie outside


def element(kind: str, radius: float, length: float) -> Element:
    size = (2 * radius, 2 * radius, length) if kind == "box" else (radius, radius, length)
    return element_of(Shape(kind, size=size), None)  # type: ignore[arg-type]


def group(elements: tuple[Element, ...], rotation: np.ndarray, position: np.ndarray) -> FixedGroup:
    mesh = one_mesh([each.mesh for each in elements])
    assert mesh is not None
    return FixedGroup(np.concatenate([rotation.ravel(), position]), NOWHERE, (mesh.vertices, mesh.faces), elements)


def farthest(own: Element, u: np.ndarray) -> np.ndarray:
    """The point of an element that is farthest along a unit vector."""
    assert own.corners is not None
    corner = own.corners[np.argmax(own.corners @ u)]
    if own.rounding is None:
        return corner
    across = u - (u @ own.rounding.axis) * np.array(own.rounding.axis)
    length = float(np.linalg.norm(across))
    return corner + own.rounding.radius * u + (own.rounding.disc * across / length if length > 1e-12 else 0.0)


@pytest.mark.parametrize("second", KINDS)
@pytest.mark.parametrize("first", KINDS)
def test_the_distance_is_the_gap_and_no_more(first, second):
    rng = np.random.default_rng(KINDS.index(first) * 4 + KINDS.index(second))
    for number in range(25):
        sizes = [rng.uniform((0.01, 0.02), (0.3, 1.0)) for _ in range(2)]
        a, b = (element(kind, *size) for kind, size in zip((first, second), sizes, strict=True))
        R, Q = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))
        u = rng.normal(size=3)
        if number % 3 == 1:  # an end of the first, or its side
            u = R[:, rng.integers(3)].copy()
        if number % 3 == 2:  # parallel faces and edges
            Q = R @ np.eye(3)[[1, 2, 0]]
            u = R[:, rng.integers(3)].copy()
        u /= np.linalg.norm(u)
        gap = 10.0 ** rng.uniform(-4.5, -0.5)
        placed = R @ farthest(a, R.T @ u) + gap * u - Q @ farthest(b, Q.T @ -u)
        ours, theirs = group((a,), R, np.zeros(3)), group((b,), Q, placed)
        outside = PRISM * sum(
            size[0] for size, kind in zip(sizes, (first, second), strict=True) if kind == "cylinder"
        )
        assert gap - outside - 1e-12 <= exact_distance(ours, theirs) <= gap + 1e-12
        assert exact_collides(ours, theirs) == (exact_distance(ours, theirs) == 0.0)
        assert gap < outside or not exact_collides(ours, theirs)


@pytest.mark.parametrize("kind", KINDS)
def test_what_overlaps_by_a_micrometre_or_lies_inside_collides(kind):
    rng = np.random.default_rng(3)
    for _ in range(15):
        a, b = element(kind, *rng.uniform((0.01, 0.02), (0.3, 1.0))), element("box", 0.2, 0.4)
        R, Q = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        placed = R @ farthest(a, R.T @ u) * (1 - 1e-5) - Q @ farthest(b, Q.T @ -u) * (1 - 1e-5)
        assert exact_collides(group((a,), R, np.zeros(3)), group((b,), Q, placed))
    small, large = element(kind, 0.01, 0.02), element("box", 1.0, 3.0)
    big = element(kind, 1.0, 3.0)
    for inner, outer in ((small, large), (small, big), (element("sphere", 0.01, 0.0), big)):
        near = group((inner,), np.eye(3), np.array([0.1, 0.2, 0.3]))
        assert exact_collides(near, group((outer,), np.eye(3), np.zeros(3)))
        assert exact_collides(group((outer,), np.eye(3), np.zeros(3)), near)


def test_a_body_of_several_elements_is_as_near_as_the_nearest_of_them():
    shift = np.eye(4)
    shift[0, 3] = 1.0
    chain = element("box", 0.1, 0.2), element("sphere", 0.05, 0.0).moved(shift), element("capsule", 0.2, 0.3)
    probe = element("sphere", 0.01, 0.0)
    for x, z, gap in ((0.5, 0.0, 0.29), (1.0, 0.2, 0.14), (0.0, 0.5, 0.14)):
        at = group((probe,), np.eye(3), np.array([x, 0.0, z]))
        assert exact_distance(group(chain, np.eye(3), np.zeros(3)), at) == pytest.approx(gap, abs=1e-12)


def test_a_view_lets_a_ball_pass_where_the_mesh_around_it_does_not():
    ball, wall = element("capsule", 0.5, 0.2), element("box", 0.5, 1.0)
    top = float(ball.mesh.vertices[:, 0].max())
    assert top > 0.5 + 2e-4
    still = group((wall,), np.eye(3), np.array([1.0 + 0.5 * (top - 0.5), 0.0, 0.0]))
    pose = np.concatenate([np.eye(3).ravel(), np.zeros(3)])
    arrays = ball.mesh.vertices, ball.mesh.faces
    for elements, hit in (((ball,), -1), ((), 0)):
        moving = MovingGroup(0, pose, NOWHERE, arrays, elements)
        view = ExactView(WORLD_TREE, [moving], [still], np.array([[0, 1]]), Budget.share(1e-5))
        assert view.configuration_hit(np.empty(0)) == hit
