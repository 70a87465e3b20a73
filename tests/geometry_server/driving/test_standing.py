"""Where bases stand: on their floor, clear of the room, near what they reach; each sample a function of its index."""

from functools import cache

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, GraspStream, Situation, Workspace, grasp_stream, standing_of
from kabo.kinematics import satisfied
from kabo.kinematics.kernels import rows as columns
from kabo.scene import BASE_VALUES, Robot, world_T
from tests.domains.scenes import DOMAINS, scene_of

SCENE = scene_of(DOMAINS / "waiter" / "two_cups.yaml")
ROBOT: Robot = SCENE.robots["waiter"]


@cache
def server() -> GeometryServer:
    """A server of the waiter's scene."""
    return GeometryServer(SCENE)


@cache
def grasps(standing: bool = True) -> GraspStream:
    """The side grasps of a cup, with the base put where the arm reaches, or not."""
    cup = SCENE.bodies["cup_1"]
    hand = SCENE.start.robots["waiter"][ROBOT.planned :]
    placed = standing_of(server().surroundings, ROBOT) if standing else None
    pose = world_T(SCENE, SCENE.start, "cup_1")
    made = grasp_stream(ROBOT, cup, cup.grasps["side"], pose, hand, 0, placed)
    assert made is not None
    return made


def test_candidates_hold_the_cup_from_a_base_on_its_floor() -> None:
    found = grasps().stream.batch(0, along=grasps().turn)
    assert len(found) > 20
    drive = ROBOT.drive
    assert drive is not None
    for candidate in found:
        assert satisfied(grasps().stream.rows, candidate.q, ROBOT.tree)
        assert drive.outside(candidate.q[None, :BASE_VALUES])[0] <= 1e-8
        assert np.all(candidate.q >= ROBOT.tree.lower - 1e-9) and np.all(candidate.q <= ROBOT.tree.upper + 1e-9)


def test_the_base_stands_on_all_sides_of_the_cup_and_clear_of_the_table() -> None:
    found = [c for number in range(6) for c in grasps().stream.batch(number, along=grasps().turn)]
    workspace = Workspace.of(server().surroundings, "waiter", Situation.of(SCENE.start))
    free = np.array([c.q for c in found])[workspace.hits(np.array([c.q for c in found])) < 0]
    assert len(free) > 0.3 * len(found)
    away = free[:, :2] - world_T(SCENE, SCENE.start, "cup_1")[:2, 3]
    sides = np.unique(np.floor(np.arctan2(away[:, 1], away[:, 0]) / (np.pi / 4)))
    assert len(sides) >= 5  # the wall side of the cup has no floor
    assert np.linalg.norm(away, axis=1).max() < 1.0


def test_a_sample_depends_on_its_index_alone() -> None:
    stream, turn = grasps().stream, grasps().turn
    standing = stream.standing
    assert standing is not None
    whole, some = standing.starts(stream.rows, turn, stream.key, 0, 24, stream.hand)  # type: ignore[misc]
    for first, count in ((0, 5), (5, 1), (6, 18)):
        part, usable = standing.starts(stream.rows, turn, stream.key, first, count, stream.hand)  # type: ignore[misc]
        assert np.array_equal(part[usable], whole[first : first + count][usable])
        assert np.array_equal(usable, some[first : first + count])


def test_rows_of_two_frames_are_left_to_projection() -> None:
    stream = grasps().stream
    joints = {ROBOT.links[name].joint for name in ("arm_link_1", "gripper_base")}
    rows = np.concatenate([_on(stream.rows, joint) for joint in sorted(joints)])
    assert stream.standing is not None
    assert stream.standing.starts(rows, None, stream.key, 0, 4, stream.hand) is None


def _on(rows: np.ndarray, joint: int) -> np.ndarray:
    made = rows.copy()
    for column in (columns.FIRST, columns.SECOND):
        made[:, column] = np.where(rows[:, column] > 0, joint, 0)
    return made


@pytest.mark.parametrize("pose", [(-1.2, 0.0, 0.0), (0.0, 0.0, 0.0)])
def test_a_pose_on_the_floor_and_clear_of_the_room_is_free(pose: tuple[float, float, float]) -> None:
    standing = standing_of(server().surroundings, ROBOT)
    assert standing is not None and standing.free(np.array([pose]))[0]


@pytest.mark.parametrize("pose", [(-1.7, 0.25, 0.0), (0.75, -0.2, 0.0), (2.0, 0.0, 0.0), (0.0, 1.5, 1.57)])
def test_a_pose_in_a_table_leg_a_column_or_over_the_edge_is_not(pose: tuple[float, float, float]) -> None:
    standing = standing_of(server().surroundings, ROBOT)
    assert standing is not None and not standing.free(np.array([pose]))[0]


def test_robots_that_stand_have_no_places() -> None:
    scene = scene_of(DOMAINS / "stacked" / "n3.yaml")
    assert standing_of(GeometryServer(scene).surroundings, scene.robots["mobile"]) is None
