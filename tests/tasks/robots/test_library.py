"""Solutions of the library's tasks: continuous, free under a judge that shares no code, and right in the end."""

from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st

from kabo.geometry_server import lies_inside
from kabo.tasks.binding import library_task
from kabo.tasks.core import Solution, Task
from kabo.tasks.robots import TaskScene, segments
from tests.tasks.robots.conftest import first
from tests.tasks.robots.judge import Judge

BARTENDER, FORCE, STACKED = "bartender/four_bottles.yaml", "force_sensing/n2.yaml", "stacked/n4.yaml"
First = Callable[..., TaskScene]


def task(name: str, *, lazy: bool = True, **arguments: str) -> Task:
    made = library_task(name).task(arguments)
    made.lazy = lazy
    return made


def solve(scene: TaskScene, name: str, count: int = 1, *, lazy: bool = True, **arguments: str) -> list[Solution]:
    found = task(name, lazy=lazy, **arguments).plan(scene, count)
    assert found, f"{name} found nothing"
    return found


def end(solution: Solution) -> TaskScene:
    """The scene in which the next task begins."""
    assert solution.end is not None
    scene: TaskScene = solution.end.scene
    return TaskScene(scene.context, scene.situation)


CASES = st.sampled_from([("left", "bottle_1"), ("left", "bottle_2"), ("right", "bottle_3"), ("right", "bottle_4")])


@pytest.mark.slow
@settings(max_examples=6, suppress_health_check=list(HealthCheck))
@given(who=CASES, seed=st.integers(0, 1000), attempt=st.integers(0, 2), lazy=st.booleans())
def test_what_is_picked_and_placed_moves_freely_and_without_a_jump(
    who: tuple[str, str], seed: int, attempt: int, lazy: bool
) -> None:
    robot, name = who
    start = first(BARTENDER, seed=seed)
    judge = Judge(start.context.scene)
    picked = solve(start, "pick", attempt + 1, lazy=lazy, robot=robot, object=name)[-1]
    assert judge.findings(picked) == []
    held = end(picked)
    assert held.holder(name) == robot
    placed = solve(held, "place", lazy=lazy, robot=robot, object=name, region="anywhere")[-1]
    assert judge.findings(placed) == []
    after = end(placed)
    assert after.holder(name) is None
    region = start.context.scene.regions["anywhere"]
    assert lies_inside(start.context.surroundings, name, after.pose(name), region)
    event(f"{robot} {'lazily' if lazy else 'in rounds'}")


def test_cups_are_weighed_carried_and_let_go_without_a_jump(first_scene: First) -> None:
    scene = first_scene(FORCE)
    judge = Judge(scene.context.scene)
    steps = [
        ("pick", {}),
        ("sense_weight", {}),
        ("transfer", {"region": "target", "keep": "upright"}),
        ("release", {"region": "target"}),
    ]
    for name, arguments in steps:
        (solution,) = solve(scene, name, robot="arm", object="cup_1", **arguments)
        assert judge.findings(solution) == []
        scene = end(solution)
    assert scene.holder("cup_1") is None


def test_a_block_is_restacked_without_a_jump(first_scene: First) -> None:
    scene = first_scene(STACKED)
    found = solve(scene, "restack", 2, robot="mobile", this="o4", other="stack_3")
    for solution in found:
        assert Judge(scene.context.scene).findings(solution) == []
    pad = scene.context.scene.fixed_poses["stack_3"][:3, 3]
    assert end(found[0]).pose("o4")[:2, 3] == pytest.approx(pad[:2], abs=0.003)


def test_segments_are_timed_one_after_the_other_and_name_their_stages(first_scene: First) -> None:
    scene = first_scene(BARTENDER)
    (solution,) = solve(scene, "pick", robot="right", object="bottle_4")
    made = segments(solution, scene.context.scene, "pick")
    assert [s.stage for s in made] == ["reach", "grasp/approach", "grasp/close", "grasp/lift"]
    for before, after in zip(made, made[1:], strict=False):
        assert before.times[-1] == after.times[0]
    assert made[2].attach == (("bottle_4", "right.tool0"),)
    assert made[0].allowed_contacts == ()
    assert ("bottle_4", "table") in made[3].allowed_contacts


@pytest.mark.parametrize("workers", [1, 2])
def test_workers_find_the_same_grasps(first_scene: First, workers: int) -> None:
    found = []
    for count in (None, workers):
        scene = first_scene(BARTENDER)
        solutions = task("pick", lazy=False, robot="right", object="bottle_4").plan(scene, 2, workers=count)
        found.append({end(s).situation.attachment("bottle_4") for s in solutions})
    assert found[0] & found[1]


def test_the_judge_sees_a_path_through_a_body(first_scene: First) -> None:
    """It can fail: the straight way between both ends of a reach that had to go around something."""
    from dataclasses import replace

    scene = first_scene(BARTENDER)
    (solution,) = solve(scene, "pick", robot="right", object="bottle_4")
    lift = next(leaf for leaf in solution.leaves if leaf.stage.name == "lift")
    wrong = replace(lift.motion[0], permitted=frozenset(), waypoints=lift.motion[0].waypoints[:1])
    lift.motion = (wrong,)
    assert Judge(scene.context.scene).findings(solution)
