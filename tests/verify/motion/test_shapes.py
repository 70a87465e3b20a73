"""Distances of spheres, capsules and cylinders, for bodies put at known gaps: what coal says of them is not trusted."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kabo.language.scene_description import Shape as Described
from kabo.scene import Element
from kabo.scene.elements import one_mesh
from kabo.scene.shapes import element_of
from kabo.verify.motion.surfaces import DISTANCE_ERROR, ROUND_ERROR, Surface, encloses, mesh_distance, surface

KINDS = ("sphere", "capsule", "cylinder", "box")
ROUND = KINDS[:3]


def element(kind: str, radius: float, length: float) -> Element:
    size = (2 * radius, 2 * radius, length) if kind == "box" else (radius, radius, length)
    return element_of(Described(kind, size=size), None)


def body(*elements: Element) -> Surface:
    mesh = one_mesh([each.mesh for each in elements])
    assert mesh is not None
    return surface(mesh, elements)


def posed(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, position
    return pose


def farthest(own: Element, u: np.ndarray) -> np.ndarray:
    """The point of an element that is farthest along a unit vector."""
    assert own.corners is not None
    corner = own.corners[np.argmax(own.corners @ u)]
    if own.rounding is None:
        return corner
    across = u - (u @ own.rounding.axis) * np.array(own.rounding.axis)
    length = float(np.linalg.norm(across))
    rim = own.rounding.disc * across / length if length > 0.0 else 0.0
    return corner + own.rounding.radius * u + rim


@pytest.mark.parametrize("second", KINDS)
@pytest.mark.parametrize("first", ROUND)
def test_the_distance_is_at_most_the_gap_and_hardly_less(first, second):
    """Bodies between two planes that both touch have the planes' distance."""
    rng = np.random.default_rng(KINDS.index(first) * 4 + KINDS.index(second))
    for number in range(30):
        a, b = (element(kind, *rng.uniform((0.01, 0.02), (0.3, 1.0))) for kind in (first, second))
        R, Q = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))
        u = rng.normal(size=3)
        if number % 3 == 1:  # an end of the first, or its side
            u = R[:, rng.integers(3)].copy()
        if number % 3 == 2:  # parallel faces and edges
            Q = R @ np.eye(3)[[1, 2, 0]]
            u = R[:, rng.integers(3)].copy()
        u /= np.linalg.norm(u)
        gap = 10.0 ** rng.uniform(-5.0, -0.5)
        start = R @ farthest(a, R.T @ u)
        placed = start + gap * u - Q @ farthest(b, Q.T @ -u)
        ours, theirs = (body(a), posed(R, np.zeros(3))), (body(b), posed(Q, placed))
        for distance in (mesh_distance(*ours, *theirs), mesh_distance(*theirs, *ours)):
            assert gap - ROUND_ERROR - 1e-9 <= distance <= gap


@pytest.mark.parametrize("kind", ROUND)
def test_true_contacts_are_not_overlooked(kind):
    """A point of the round shape, a micrometre inside of it, lies in the box."""
    rng = np.random.default_rng(7)
    for _ in range(20):
        a, b = element(kind, *rng.uniform((0.01, 0.02), (0.3, 1.0))), element("box", 0.2, 0.4)
        R, Q = (Rotation.random(random_state=rng).as_matrix() for _ in range(2))
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        met = R @ farthest(a, R.T @ u) * (1.0 - 1e-5)
        placed = met - Q @ farthest(b, Q.T @ -u) * (1.0 - 1e-5)
        assert mesh_distance(body(a), posed(R, np.zeros(3)), body(b), posed(Q, placed)) <= 0.0


def test_a_cylinder_whose_mesh_is_in_a_box_is_a_third_of_a_millimetre_beside_it():
    can, box = element("cylinder", 0.5, 0.2), element("box", 0.1, 0.5)
    still = np.eye(4)
    edge = posed(Rotation.from_euler("z", np.pi / 4).as_matrix(), np.array([0.5003 + 0.1 * 2**0.5, 0.0, 0.0]))
    assert mesh_distance(surface(can.mesh), still, body(box), edge) <= 0.0  # a corner of the prism
    assert 2.97e-4 <= mesh_distance(body(can), still, body(box), edge) <= 3.0e-4


def test_a_ball_in_a_corner_is_as_far_from_all_walls_as_it_was_put():
    walls = [element("box", 0.5, 1.0).moved(posed(np.eye(3), np.eye(3)[k] * -0.5)) for k in range(3)]
    shifts = [posed(np.eye(3), np.where(np.eye(3)[k] > 0, 0.0, 0.5)) for k in range(3)]
    corner = body(*(wall.moved(shift) for wall, shift in zip(walls, shifts, strict=True)))
    ball = body(element("sphere", 0.2, 0.0))
    for gap in (1e-5, 3e-4, 0.05):
        where = posed(np.eye(3), np.full(3, 0.2 + gap))
        assert gap - ROUND_ERROR - 1e-9 <= mesh_distance(corner, np.eye(4), ball, where) <= gap
    assert mesh_distance(corner, np.eye(4), ball, posed(np.eye(3), np.full(3, 0.2 - 1e-6))) <= 0.0


def test_a_body_of_several_elements_is_as_near_as_the_nearest_of_them():
    chain = body(
        element("box", 0.1, 0.2),
        element("sphere", 0.05, 0.0).moved(posed(np.eye(3), np.array([1.0, 0.0, 0.0]))),
        element("capsule", 0.05, 0.3).moved(posed(np.eye(3), np.array([2.0, 0.0, 0.0]))),
    )
    probe = body(element("sphere", 0.01, 0.0))
    for x, z, gap in ((0.5, 0.0, 0.39), (1.0, 0.2, 0.14), (2.0, 0.4, 0.19)):
        found = mesh_distance(chain, np.eye(4), probe, posed(np.eye(3), np.array([x, 0.0, z])))
        assert found == pytest.approx(gap, abs=3e-6)
    plain = body(element("box", 0.1, 0.2))
    assert mesh_distance(plain, np.eye(4), plain, posed(np.eye(3), np.array([0.5, 0.0, 0.0]))) == pytest.approx(
        0.3 - DISTANCE_ERROR, abs=1e-9
    )


@pytest.mark.parametrize("kind", ROUND)
def test_what_lies_in_a_round_shape_is_noticed_and_what_lies_in_the_mesh_around_it_is_not(kind):
    outer, tiny = body(element(kind, 0.5, 1.0)), body(element("box", 1e-5, 2e-5))
    beyond = np.array([0.5 * (1 + 4e-4), 0.0, 0.0])
    assert encloses(outer, np.eye(4), tiny, posed(np.eye(3), np.array([0.3, 0.2, 0.1])))
    assert not encloses(outer, np.eye(4), tiny, posed(np.eye(3), beyond))
    assert encloses(body(element("box", 1.0, 4.0)), np.eye(4), outer, np.eye(4))


def test_equal_meshes_of_other_elements_are_other_bodies():
    """A mesh file may hold the very prism that lies around a cylinder."""
    can = element("cylinder", 0.1, 0.2)
    prism = Element("mesh", can.mesh)
    assert body(can).digest == body(prism).digest
    assert body(can).identity != body(prism).identity
