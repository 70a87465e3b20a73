"""Predicates on bodies: what they answer on shapes that need no thought, and what they refuse."""

import numpy as np
import pytest
import trimesh

from kabo.geometry import (
    Budget,
    Enclosure,
    FixedGroup,
    InnerSolid,
    Motion,
    MovingGroup,
    collides,
    distance,
    includes,
    sweep_collides,
)
from tests.geometry.worlds import box, move, slide, three_joints
from tests.support.strategies import IDENTITY

BUDGET = Budget.share(0.01)


def cube(x=0.0, y=0.0, z=0.0, half=0.1, deviation=0.0):
    """A cube that stands in the world."""
    return FixedGroup(move(x, y, z), Enclosure((box([half] * 3),), deviation))


def arm(*waypoints):
    """Three joints that turn about z, with a bar on each, and a tool in the hand."""
    bar = Enclosure((box([0.15, 0.03, 0.03]),), 0.0)
    bodies = [MovingGroup(j, move(0.15, 0, 0), bar) for j in (1, 2, 3)]
    tool = MovingGroup(3, move(0.4, 0, 0), Enclosure((box([0.1, 0.01, 0.01]),), 0.0))
    return Motion(three_joints(), (*bodies, tool), np.array(waypoints, float))


def container(mesh, deviation=0.0, pose=IDENTITY):
    """A solid for inclusion."""
    return InnerSolid(pose, np.asarray(mesh.vertices), np.asarray(mesh.faces), deviation)


def cup():
    """A box of 1 m with a cubic pit of 0.6 m from above: not convex."""
    rim = np.array([[x, y, 0.5] for x, y in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]])
    inner = rim * [0.6, 0.6, 1.0]
    foot, floor = rim * [1, 1, -1], inner * [1, 1, -0.2]
    vertices = np.concatenate([rim, inner, foot, floor])
    faces = []
    for i in range(4):
        k = (i + 1) % 4
        faces += [[i, k, 4 + k], [i, 4 + k, 4 + i]]  # the rim
        faces += [[8 + i, 8 + k, k], [8 + i, k, i]]  # outside
        faces += [[4 + i, 4 + k, 12 + k], [4 + i, 12 + k, 12 + i]]  # inside
    faces += [[8, 10, 9], [8, 11, 10], [12, 13, 14], [12, 14, 15]]
    return trimesh.Trimesh(vertices, faces, process=False)


def test_bodies_collide_at_contact_and_are_free_an_epsilon_away():
    answers = [collides(cube(), cube(z=z), BUDGET) for z in (0.0, 0.15, 0.2, 0.2 + BUDGET.epsilon, 0.5)]
    assert answers == [True, True, True, False, False]


def test_a_body_inside_another_collides_with_it():
    assert collides(cube(half=0.5), cube(half=0.01), BUDGET)


def test_a_motion_collides_with_what_stands_in_its_way_only():
    quarter = arm([0, 0, 0], [np.pi / 2, 0, 0])
    assert sweep_collides(quarter, cube(0.7, 0.7), BUDGET)
    assert sweep_collides(quarter, cube(0.95, 0.95, half=0.01), BUDGET) is False
    assert not sweep_collides(quarter, cube(-0.3, 0.3), BUDGET)
    assert not sweep_collides(quarter, cube(0.5, 0.5, 0.2), BUDGET)


def test_a_tool_in_the_hand_counts():
    touched = cube(1.09, half=0.01)  # the last bar ends at 0.9 m, the tool at 1.1 m
    assert sweep_collides(arm([-0.1, 0, 0], [1, 0, 0]), touched, BUDGET)
    assert sweep_collides(arm([0, 0, 0]), touched, BUDGET)
    assert not sweep_collides(arm([0.1, 0, 0], [1, 0, 0]), touched, BUDGET)


def test_two_motions_collide_wherever_their_volumes_meet_whatever_the_times():
    """One passes a place long before the other: in step they never meet, their volumes do."""
    up = Motion(
        slide(IDENTITY), (MovingGroup(1, IDENTITY, Enclosure((box([0.1] * 3),), 0.0)),), np.array([[0.0], [2.0]])
    )
    later = Motion(slide(move(0.15, 0, 2.0)), up.bodies, np.array([[0.0], [2.0]]))
    aside = Motion(slide(move(0.22, 0, 0.0)), up.bodies, np.array([[0.0], [2.0]]))
    assert sweep_collides(up, later, BUDGET)
    assert sweep_collides(later, up, BUDGET)
    assert not sweep_collides(up, aside, BUDGET)


def test_a_path_of_several_segments_is_swept_whole():
    over = arm([0, 0, 0], [1.0, 0, 0], [2.0, 0, 0])
    assert sweep_collides(over, cube(0.9 * np.cos(1.7), 0.9 * np.sin(1.7)), BUDGET)
    assert not sweep_collides(over, cube(0.9 * np.cos(2.6), 0.9 * np.sin(2.6)), BUDGET)


def test_a_body_is_included_an_epsilon_deep_and_never_with_a_point_outside():
    room = container(trimesh.creation.box((1, 1, 1)))
    answers = [includes(room, cube(z=z), BUDGET) for z in (0.0, 0.4 - BUDGET.epsilon, 0.4, 0.41, 0.6, 0.7)]
    assert answers == [True, True, False, False, False, False]


def test_a_body_that_wraps_the_container_is_not_included():
    assert not includes(container(trimesh.creation.box((1, 1, 1))), cube(half=2.0), BUDGET)


def test_a_container_need_not_be_convex():
    solid = cup()
    assert solid.is_watertight
    assert solid.volume == pytest.approx(1.0 - 0.6 * 0.6 * 0.6)
    walls = container(solid)
    assert includes(walls, cube(x=0.4, half=0.09), BUDGET)
    assert includes(walls, cube(z=-0.3, half=0.15), BUDGET)
    assert not includes(walls, cube(z=0.2, half=0.09), BUDGET), "in the pit"
    bridge = FixedGroup(IDENTITY, Enclosure((box([0.45, 0.02, 0.02]),), 0.0))
    assert not includes(walls, bridge, BUDGET), "both ends inside, the middle not"


def test_a_hollow_inside_the_part_is_noticed():
    outer, hollow = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((0.05,) * 3)
    hollow.invert()
    shell = container(trimesh.util.concatenate([outer, hollow]))
    assert not includes(shell, cube(), BUDGET)
    assert includes(shell, cube(x=0.3), BUDGET)


def test_a_container_is_asked_through_an_inner_bounding_mesh():
    """One-sided: nothing that sticks out of the round room is included; what is epsilon deep is."""
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.5)
    room = InnerSolid.within(IDENTITY, np.asarray(ball.vertices), np.asarray(ball.faces), BUDGET.geometry)
    assert len(room.vertices) < 0.5 * len(ball.vertices)
    assert 0 < room.deviation <= BUDGET.geometry
    corner = np.linalg.norm([0.1, 0.1, 0.1])
    depths = np.linspace(-0.02, 0.03, 21)
    for depth in depths:
        along = np.array([1.0, 1.0, 1.0]) / np.sqrt(3) * (ball_inside(ball) - depth - corner)
        answer = includes(room, cube(*along), BUDGET)
        assert not (answer and depth < 0)
        assert answer or depth < BUDGET.epsilon + 0.5 - ball_inside(ball)


def ball_inside(ball):
    """The radius of the ball inside a mesh of a ball."""
    return float(np.abs(ball.face_normals * ball.triangles[:, 0]).sum(axis=1).min())


def test_containers_turn_with_their_pose():
    turned = np.array([0.0, -1, 0, 1, 0, 0, 0, 0, 1, 0.5, 0, 0])
    room = container(trimesh.creation.box((2, 0.5, 1)), pose=turned)
    assert includes(room, cube(0.5, 0.8, 0.0), BUDGET)
    assert not includes(room, cube(0.5 + 0.8, 0.0, 0.0), BUDGET)


def test_distances_are_enclosed_by_their_bounds():
    apart = distance(cube(), cube(z=0.5))
    assert apart.lower <= 0.3 <= apart.upper
    assert apart.upper - apart.lower < 1e-9
    assert distance(cube(), cube(z=0.1)).lower == 0.0
    loose = distance(cube(deviation=0.003), cube(z=0.5))
    assert loose.upper - loose.lower == pytest.approx(0.003, abs=1e-9)


@pytest.mark.parametrize("deviation", [-1e-12, -1.0, np.nan])
def test_a_deviation_that_is_no_distance_is_refused(deviation):
    with pytest.raises(ValueError, match="no distance"):
        Enclosure((box([0.1] * 3),), deviation)
    with pytest.raises(ValueError, match="no distance"):
        container(trimesh.creation.box(), deviation)


def test_what_breaks_the_budget_is_refused():
    loose = cube(deviation=1.01 * BUDGET.geometry)
    room = container(trimesh.creation.box((1, 1, 1)), 1.01 * BUDGET.geometry)
    for ask in (
        lambda: collides(cube(), loose, BUDGET),
        lambda: sweep_collides(arm([0, 0, 0]), loose, BUDGET),
        lambda: includes(room, cube(), BUDGET),
        lambda: includes(container(trimesh.creation.box((1, 1, 1))), loose, BUDGET),
    ):
        with pytest.raises(ValueError, match="the budget allows"):
            ask()


@pytest.mark.parametrize("waypoints", [[[0, 0]], [[0, 0, np.nan]], [[0, 0, np.inf]], [], [0, 0, 0]])
def test_waypoints_that_are_no_configurations_are_refused(waypoints):
    with pytest.raises(ValueError, match="waypoint"):
        arm(*waypoints)
