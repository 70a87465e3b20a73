"""Planners of ways: straight in the joints, straight for the tool, sampled; asked in order, and cut off in time."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from kabo.geometry_server import LINE_DEVIATION, Refusal, candidate, tool_frame
from kabo.motion import Trajectory
from kabo.scene import load_scene
from kabo.tasks.core import Result, Task
from kabo.tasks.files import load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.files.motions import motion_of
from kabo.tasks.robots import Connect, CurrentState, FixedState, MoveTo, Stretch, TaskScene
from kabo.tasks.robots.motion.planners import planned_way, tool_line

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "pick_and_place"


@cache
def scene(name: str = "scene") -> TaskScene:
    return first_scene(load_scene(EXAMPLE / f"{name}.yaml"), 0, lambda: False)


def moved(here: TaskScene, **properties) -> list:
    stage = MoveTo("there", **properties)
    values = {key: each.default for key, each in MoveTo.PROPERTIES.items()} | {"robot": "arm"} | properties
    return stage.forward(here, values, 0)


def near(here: TaskScene, by: float = 0.2) -> np.ndarray:
    q = here.configuration("arm")
    n = here.robot("arm").planned
    return q + np.array([*(by * (-1.0) ** np.arange(n)), *np.zeros(len(q) - n)])


@pytest.mark.parametrize("name", ["scene", "panda"])
def test_the_tool_moves_on_a_straight_line_and_turns_evenly(name: str):
    """Measured at 200 places of the path, by other code than that which made it."""
    here = scene(name)
    robot, start, goal = here.robot("arm"), here.configuration("arm"), near(here)
    path = tool_line(robot, start, goal)
    assert path is not None
    assert np.array_equal(path[0], start) and np.array_equal(path[-1], goal)
    frame = tool_frame(robot)
    first, last = (candidate(robot, q).pose(frame) for q in (start, goal))
    along = (last - first)[:3, 3] / np.linalg.norm((last - first)[:3, 3])
    turn = np.arccos((np.trace(last[:3, :3] @ first[:3, :3].T) - 1) / 2)
    worst = 0.0
    for a, b in zip(path, path[1:], strict=False):
        for share in np.linspace(0, 1, 200 // len(path)):
            pose = candidate(robot, a + share * (b - a)).pose(frame)
            off = pose[:3, 3] - first[:3, 3]
            worst = max(worst, float(np.linalg.norm(off - along * (along @ off))))
            angles = [
                np.arccos(np.clip((np.trace(pose[:3, :3] @ e[:3, :3].T) - 1) / 2, -1, 1)) for e in (first, last)
            ]
            assert sum(angles) == pytest.approx(turn, abs=0.03), "it turns about one axis"
    assert worst < 1.1e-3  # noqa: PLR2004


def test_a_pose_is_reached_straight_and_the_end_is_the_pose():
    here = scene()
    start = candidate(here.robot("arm"), here.configuration("arm")).pose(tool_frame(here.robot("arm")))
    point = (start[:3, 3] + (0.05, 0.1, -0.1)).tolist()
    found = [each for each in moved(here, goal={"point": point}, straight=True) if isinstance(each, Result)]
    assert found
    (made,) = found[0].motion
    end = candidate(here.robot("arm"), np.array(made.waypoints[-1])).pose(tool_frame(here.robot("arm")))
    assert end[:3, 3] == pytest.approx(point, abs=1e-5)
    assert end[:3, :3] == pytest.approx(start[:3, :3], abs=1e-4)
    assert here.workspace("arm").path_hit(made.path) is None


def test_a_straight_motion_is_timed_so_that_the_tool_keeps_its_line_and_comes_to_its_goal():
    """Between two other motions no corner of it is rounded: neither the line's ends, nor those of its pieces."""
    here = scene()
    robot, frame = here.robot("arm"), tool_frame(here.robot("arm"))
    first = candidate(robot, here.configuration("arm")).pose(frame)[:3, 3]
    goal, joint = (first + (0.05, 0.15, -0.1)).tolist(), robot.planned_joints[0]
    task = Task(
        "t",
        CurrentState("now"),
        MoveTo("aside", goal={joint: 0.3}, robot="arm"),
        MoveTo("line", goal={"point": goal}, straight=True, robot="arm"),
        MoveTo("back", goal={joint: -0.3}, robot="arm"),
    )
    (found,) = task.plan(here, 1)
    motion = motion_of(found, here.context.scene)
    assert motion is not None
    line = next(each for each in motion["segments"] if each["stage"] == "line")
    pieces = tuple(tuple(map(tuple, piece)) for piece in line["trajectory"]["coefficients"])
    times, rows = tuple(line["trajectory"]["times"]), tuple(map(tuple, line["waypoints"]))
    timed = Trajectory(tuple(line["joints"]), rows, times, pieces, line["trajectory"]["deviation"])
    hand = here.configuration("arm")[robot.planned :]
    tools = [
        candidate(robot, np.concatenate([timed.at(time), hand])).pose(frame)[:3, 3]
        for time in np.linspace(times[0], times[-1], 200)
    ]
    along = (tools[-1] - tools[0]) / np.linalg.norm(tools[-1] - tools[0])
    off = [float(np.linalg.norm(each - tools[0] - along * (along @ (each - tools[0])))) for each in tools]
    assert tools[-1] == pytest.approx(goal, abs=1e-5)
    assert max(off) < LINE_DEVIATION + 1e-3  # the joints pass by way points of the line within 1 mrad


def test_straight_for_the_hand_is_a_fault():
    stage = MoveTo("open", robot="arm", goal="open", straight=True)
    assert list(stage.faults(scene().context.scene)) == ["`straight` is for the arm, and only the gripper moves"]


@pytest.mark.parametrize("planner", ["rrt_connect", "straight", ["tool_line", "rrt_connect"]])
def test_a_straight_motion_leaves_no_choice_of_a_planner(planner: str | list[str]):
    stage = MoveTo("line", robot="arm", goal={"joint1": 0.1}, straight=True, planner=planner)
    told = list(stage.faults(scene().context.scene))
    assert "`straight` leaves no choice of a planner: leave one of the two out" in told


def test_straight_in_the_joints_is_one_piece_or_names_what_is_in_the_way():
    here = scene()
    found = planned_way(here, "arm", near(here), "test", planners="straight")
    assert isinstance(found, Stretch) and len(found.waypoints) == 2  # noqa: PLR2004
    q = here.configuration("arm")
    lower = (np.concatenate([[0.0, tilt, 0.0, -0.5, 0.0, 0.5, 0.0], q[7:]]) for tilt in np.arange(0.5, 2.5, 0.1))
    down = next(each for each in lower if here.at("arm", each).hit("arm") is not None)
    refused = planned_way(here, "arm", down, "test", planners="straight")
    assert isinstance(refused, Refusal) and refused.reason == "collision"


def test_planners_are_asked_in_order_until_one_finds_a_way():
    here = scene()
    goal = near(here)
    both = planned_way(here, "arm", goal, "test", planners=["straight", "rrt_connect"])
    assert both == planned_way(here, "arm", goal, "test", planners="straight")


def test_an_attempt_is_cut_off_after_its_time_and_the_next_planner_is_asked():
    here = scene()
    task = Task(
        "t",
        CurrentState("now"),
        Connect("reach", robot="arm", attempt_timeout=1e-9),
        FixedState("there", configurations={"arm": [1.2, 0.9, 0.3, 1.0, 0.2, 0.9, 0.1]}),
    )
    before = here.context.surroundings.look
    assert task.plan(here) == []
    (reach,) = (stage for stage in task.walk() if stage.name == "reach")
    reasons = set(task.figures(reach).failures)
    assert reasons == {"timed_out"}
    assert here.context.surroundings.look is before


def test_unknown_planners_are_told_with_their_place(tmp_path: Path):
    (tmp_path / "t.yaml").write_text(
        "name: t\nproperties: {robot: robot}\nstages:\n  - {name: a, stage: CurrentState}\n"
        "  - {name: b, stage: Connect, planner: rrt_conect}\n  - {name: c, stage: SampleConfiguration}\n"
    )
    with pytest.raises(Exception, match='did you mean "rrt_connect"') as refused:
        load_task_file(tmp_path / "t.yaml")
    assert "t.yaml:5:" in str(refused.value)
