"""Constraints over several robots, what they hold, and bodies that may be anywhere; judged by pinocchio's poses."""

from collections.abc import Callable

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Team, TeamStream
from kabo.language.scene_description import Constraint, FeatureName
from kabo.scene import Attachment, GeometricState, link_poses, world_T
from kabo.scene.transforms import transform
from kabo.streams import stream_key

Servers = Callable[..., GeometryServer]
BARTENDER = "bartender/four_bottles.yaml"


def constraint(kind: str, first: str, second: str, *bounds: float | None) -> Constraint:
    """A constraint between features by their full names."""
    (a, _, one), (b, _, other) = first.rpartition("."), second.rpartition(".")
    return Constraint(kind, FeatureName(a, one), FeatureName(b, other), *bounds)


def tool_poses(asked: GeometryServer, q: np.ndarray) -> list[np.ndarray]:
    """world_T_tool of both arms."""
    found, first = [], 0
    for robot in asked.scene.robots.values():
        found.append(link_poses(robot, q[first : first + robot.tree.size])[robot.tool.frame])
        first += robot.tree.size
    return found


def test_two_tools_meet_head_on(server: Servers) -> None:
    asked = server(BARTENDER)
    found = asked.sample(
        [
            constraint("coincident", "left.tool.tcp", "right.tool.tcp"),
            constraint("opposed", "left.tool.approach", "right.tool.approach"),
            constraint("height", "left.tool.tcp", "world.floor", 0.2, 0.6),
        ],
        ("left", "right"),
    )
    assert len(found) >= 10
    tip = np.array([0.0, 0.0, 0.13, 1.0])
    for q in found:
        left, right = tool_poses(asked, q)
        assert np.allclose(left @ tip, right @ tip, atol=3e-6)
        assert left[:3, 2] @ right[:3, 2] < -1.0 + 1e-9
        assert 0.2 - 3e-6 <= (left @ tip)[2] <= 0.6 + 3e-6


def test_a_stream_is_the_same_whichever_way_it_is_cut(server: Servers) -> None:
    asked = server(BARTENDER)
    team = Team.of(asked.scene, ("left", "right"))
    wanted = (constraint("coincident", "left.tool.tcp", "right.tool.tcp"),)
    stream = TeamStream.of(team, wanted, asked.scene.start, stream_key(1))
    whole = stream.samples(0, 60)
    parts = [*stream.samples(0, 7), *stream.samples(7, 53)]
    assert [c.q.tobytes() for c in whole] == [c.q.tobytes() for c in parts]
    split = team.configurations(whole[0].q)
    assert list(split) == ["left", "right"]
    assert np.allclose(np.concatenate([split["left"], split["right"]]), whole[0].q)
    for c in whole:
        grippers = c.q[~team.moving]
        assert np.array_equal(grippers, team.base(asked.scene.start)[~team.moving])


def held_by_left(asked: GeometryServer) -> GeometricState:
    """Bottle 1 hangs on the left arm, bottle 2 on bottle 1."""
    robot = asked.scene.robots["left"]
    hold = Attachment(f"left.{robot.tool.frame}", (0.0, 0.0, 0.13), (0.5, 0.5, 0.5, 0.5))
    beside = Attachment("bottle_1", (0.1, 0.0, 0.05), (0.0, 0.0, 0.0, 1.0))
    return asked.scene.start.replace({"bottle_1": hold, "bottle_2": beside})


def test_what_hangs_on_an_arm_moves_with_it_also_through_another_body(server: Servers) -> None:
    """Object to object: the bottle on the bottle in the left hand stands on what the right hand points at."""
    asked = server(BARTENDER)
    state = held_by_left(asked)
    found = asked.sample(
        [
            constraint("coincident", "part.axis", "right.tool.approach"),
            constraint("angle", "bottle_1.axis", "bottle_3.axis", None, 0.5),
        ],
        ("left", "right"),
        state=state,
        names={"part": "bottle_2"},
    )
    assert len(found) >= 10
    for q in found:
        left, right = tool_poses(asked, q)
        held, beside = state.objects["bottle_1"], state.objects["bottle_2"]
        first = left @ transform(held.position, held.quaternion)
        second = first @ transform(beside.position, beside.quaternion)
        tip = right[:3, :3] @ [0, 0, 0.13] + right[:3, 3]
        assert np.linalg.norm(np.cross(second[:3, 2], tip - second[:3, 3])) <= 5e-6
        assert np.linalg.norm(np.cross(second[:3, 2], right[:3, 2])) <= 5e-6
        assert np.arccos(np.clip(first[2, 2], -1, 1)) <= 0.5 + 1e-5


def test_who_is_not_in_the_team_stands_still(server: Servers) -> None:
    asked = server(BARTENDER)
    state = held_by_left(asked)
    wanted = [
        constraint("parallel", "right.tool.approach", "bottle_1.axis"),
        constraint("height", "right.tool.tcp", "bottle_1.base", -1.0, 0.0),
    ]
    found = asked.sample(wanted, "right", state=state)
    pose = world_T(asked.scene, state, "bottle_1")
    assert len(found) >= 5
    for q in found:
        right = link_poses(asked.scene.robots["right"], q)[asked.scene.robots["right"].tool.frame]
        tip = np.linalg.inv(pose) @ right @ [0, 0, 0.13, 1]
        assert np.linalg.norm(np.cross(pose[:3, 2], right[:3, 2])) <= 3e-6
        assert -1.0 - 3e-6 <= tip[2] <= 3e-6


def test_a_free_body_is_where_both_arms_can_have_it(server: Servers) -> None:
    asked = server(BARTENDER)
    team = Team.of(asked.scene, ("left", "right"), ["bottle_1"])
    wanted = (
        constraint("coincident", "left.tool.tcp", "bottle_1.axis"),
        constraint("height", "left.tool.tcp", "bottle_1.base", 0.05, 0.07),
        constraint("coincident", "right.tool.tcp", "bottle_1.axis"),
        constraint("height", "right.tool.tcp", "bottle_1.base", 0.15, 0.2),
        constraint("aligned", "bottle_1.axis", "world.up"),
    )
    found = TeamStream.of(team, wanted, asked.scene.start, stream_key("free")).batch(0)
    assert len(found) >= 10
    for at in found:
        pose = team.poses(at)["bottle_1"]
        assert pose[2, 2] > 1.0 - 1e-9
        for tool, low, high in zip(tool_poses(asked, at.q), (0.05, 0.15), (0.07, 0.2), strict=True):
            tip = np.linalg.inv(pose) @ tool @ [0, 0, 0.13, 1]
            assert np.hypot(tip[0], tip[1]) <= 3e-6
            assert low - 3e-6 <= tip[2] <= high + 3e-6


def test_the_call_for_one_robot_and_one_object_is_as_it_was(server: Servers) -> None:
    asked = server(BARTENDER)
    family = asked.scene.bodies["bottle_4"].grasps["side"].constraints
    old = asked.sample(family, "right", "bottle_4", batches=2)
    new = asked.sample(family, ("right",), names={"tool": "right.tool"}, this="bottle_4", batches=2)
    assert len(old) > 5
    assert np.array_equal(old, new)


@pytest.mark.parametrize(
    ("robots", "first", "message"),
    [
        (("left", "middle"), "left.tool.tcp", "has no 'middle'"),
        (("left", "left"), "left.tool.tcp", "each once"),
        ((), "left.tool.tcp", "at least one"),
        (("left",), "left.elbow.tcp", "no link 'elbow'"),
        (("left",), "left.tool.thumb", "no feature 'thumb'; it has tcp"),
        (("left",), "bottle_9.axis", "nothing is called 'bottle_9'"),
        (("left", "right"), "tool.tcp", "nothing is called 'tool'"),
    ],
)
def test_what_does_not_exist_is_named(server: Servers, robots: tuple[str, ...], first: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        server(BARTENDER).sample([constraint("coincident", first, "world.up")], robots)
