"""Reparameterisation of pick and place: faster, within limits, proven anew."""

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from kabo.language import load_scene_description
from kabo.scene import Scene, load_scene
from kabo.tasks import Solution, Task, load_task_file
from kabo.tasks.files.first_scenes import first_scene
from kabo.tasks.robots import Reparameterise, Stretch, segments, stretches
from kabo.tasks.robots.motion.smoothing import MotionPart
from tests.tasks.robots.judge import Judge

EXAMPLE = Path(__file__).resolve().parents[4] / "examples" / "pick_and_place"
GROUPS = (
    ("move to pick", "pick/approach"),
    ("pick/lift", "move to place", "place/lower"),
    ("place/retreat", "go home"),
)


@cache
def scene() -> Scene:
    return load_scene(load_scene_description(EXAMPLE / "scene.yaml"))


@cache
def solved() -> Solution:
    task = load_task_file(EXAMPLE / "task.yaml").task({}, seed=0)
    task.plan(first_scene(scene(), 0, lambda: False), 1)
    assert task.best is not None
    return task.best


@cache
def made(**properties: Any) -> Solution:
    stage = Reparameterise("smooth", **properties)
    (result,) = stage.transform(solved(), {name: stage.properties.value(name) for name in stage.PROPERTIES}, 0)
    return Solution(stage, solved().start, solved().end, result.cost, result.comment, result.motion, (solved(),))


def timed(solution: Solution) -> dict[str, Stretch]:
    return {path: each for path, each in stretches(solution) if each.timed is not None}


def distance(q: Any, path: Any) -> float:
    found = []
    for a, b in zip(path, path[1:], strict=False):
        length = max(float((b - a) @ (b - a)), 1e-18)
        found.append(np.linalg.norm(q - a - np.clip((q - a) @ (b - a) / length, 0.0, 1.0) * (b - a)))
    return float(min(found))


def test_phases_keep_their_names_and_ends_of_groups_are_exact() -> None:
    before, after = dict(stretches(solved())), timed(made())
    assert set(after) == {name for group in GROUPS for name in group}
    for group in GROUPS:
        assert after[group[0]].start == before[group[0]].start
        assert after[group[-1]].end == before[group[-1]].end


def test_phases_of_a_group_follow_without_a_jump() -> None:
    after = timed(made())
    for group in GROUPS:
        for first, second in zip(group, group[1:], strict=False):
            assert after[first].end == after[second].start


def test_it_is_shorter_than_with_stops_between_phases() -> None:
    with_stops, without = (sum(e.timed.times[-1] for e in timed(made(across=a)).values()) for a in (False, True))
    assert without < 0.97 * with_stops


def test_it_moves_on_at_borders_of_phases_and_rests_at_those_of_groups() -> None:
    after = timed(made())
    for group in GROUPS:
        for name in group[1:]:
            assert speed(after[name], 0) > 0.02
        assert speed(after[group[0]], 0) < 1e-9
        assert speed(after[group[-1]], -1) < 1e-8
    assert made().comment == "no stops inside"


def speed(each: Stretch, sample: int) -> float:
    """The speed at the beginning (0) or at the end (-1) of a motion [rad/s, L2]."""
    assert each.timed is not None
    return float(np.linalg.norm(each.timed.trajectory.sampled(1000).velocities[sample]))


def test_velocities_and_accelerations_stay_within_their_limits() -> None:
    after, robot = timed(made()), scene().robots["arm"]
    limits = robot.tree.velocity[: robot.planned]
    for group in GROUPS:
        path = np.concatenate([after[group[0]].path[:1], *(after[name].path[1:] for name in group)])[
            :, : robot.planned
        ]
        steps = np.concatenate([np.diff(after[name].timed.times) for name in group])
        velocities = np.diff(path, axis=0) / steps[:, None]
        assert (np.abs(velocities) / limits).max() <= 1.0
        accelerations = np.diff(velocities, axis=0) / ((steps[1:] + steps[:-1]) / 2)[:, None]
        assert (np.abs(accelerations) / (limits / 0.25)).max() <= 1.0


def path_of(each: dict[str, Stretch], group: tuple[str, ...]) -> Any:
    """The path of a group, with points between its way points."""
    path = np.concatenate([each[name].path for name in group])
    return np.concatenate([a + np.linspace(0.0, 1.0, 9)[:, None] * (b - a) for a, b in pairwise(path)])


@pytest.mark.parametrize("deviation", [0.01, 0.05])
def test_both_paths_stay_near_each_other_borders_of_phases_included(deviation: float) -> None:
    before, after = dict(stretches(solved())), timed(made(deviation=deviation))
    for group in GROUPS:
        old, new = path_of(before, group), path_of(after, group)
        assert max(distance(q, old) for q in new) <= deviation + 1e-6
        assert max(distance(q, new) for q in old) <= deviation + 1e-6


@pytest.mark.parametrize("across", [False, True])
def test_without_a_deviation_it_rests_at_every_way_point(across: bool) -> None:
    before, after = dict(stretches(solved())), timed(made(deviation=0.0, across=across))
    assert after
    assert all(max(distance(q, after[name].path) for q in before[name].path) <= 1e-6 for name in after)


def test_the_deviation_is_used_at_borders_of_phases() -> None:
    before, after = dict(stretches(solved())), timed(made(deviation=0.05))
    used = [distance(before[group[-1]].path[0], path_of(after, group)) for group in GROUPS]
    assert min(used) > 0.005  # a stroke keeps to its line at its border, so its round is smaller
    assert max(used) > 0.04


@pytest.mark.parametrize("name", ["pick/lift", "place/lower"])
def test_what_leaves_the_stroke_from_a_support_is_free_without_the_contact(name: str) -> None:
    (solution,) = made(deviation=0.1).parts
    (scene_there,) = [
        leaf.start.scene
        for leaf in solution.leaves
        if leaf.motion and leaf.stage.path.endswith(name) and leaf.start is not None
    ]
    apart = scene_there.forbidding([("object", "table")]).workspace("arm")
    old, new = dict(stretches(solved()))[name].path, timed(made(deviation=0.1))[name].path
    left = [max(distance(a, old), distance(b, old)) > 0.01 + 1e-6 for a, b in pairwise(new)]
    assert any(left)
    assert all(
        apart.segment_hit(a, b) < 0
        or apart.segment_hit(a, (a + b) / 2) < 0
        and apart.segment_hit((a + b) / 2, b) < 0
        for (a, b), gone in zip(pairwise(new), left, strict=True)
        if gone
    )


def test_sliding_on_a_support_is_not_proven_apart_from_it() -> None:
    leaf = next(leaf for leaf in solved().leaves if leaf.motion and leaf.stage.path.endswith("pick/lift"))
    assert leaf.start is not None and leaf.motion is not None
    part = MotionPart(leaf.motion[0], leaf.start.scene, "lift")
    start = part.stretch.path[0]
    aside = start + 0.02 * np.eye(len(start))[0]
    assert part.proven(start, aside)
    assert not part.proven(start, aside, apart=True)


class InnerJudge(Judge):
    """Looks up how things are held in the solution that was wrapped: the wrapper's has no states inside."""

    def _held(self, solution: Solution, name: str, link: str) -> object:
        return super()._held(solved(), name, link)


def test_an_independent_judge_finds_nothing_new() -> None:
    assert InnerJudge(scene()).findings(made()) == InnerJudge(scene()).findings(solved())


def test_segments_have_the_times() -> None:
    found = [each for each in segments(made(), scene(), "x") if each.stage == "move to place"]
    (segment,) = found
    assert np.diff(segment.times) == pytest.approx(np.diff(timed(made())["move to place"].timed.times), abs=2e-6)


def test_hands_and_changes_stay_as_they_were() -> None:
    kept = [(path, each) for path, each in stretches(solved()) if each.group == "gripper"]
    after = [(path, each) for path, each in stretches(made()) if each.group == "gripper"]
    assert [(each.waypoints, each.attach, each.detach) for _, each in after] == [
        (each.waypoints, each.attach, each.detach) for _, each in kept
    ]


def test_as_a_wrapper_it_gives_one_success_for_each_of_its_child() -> None:
    inner = load_task_file(EXAMPLE / "task.yaml").task({}, seed=0)
    children = inner.children
    inner.clear()
    from kabo.tasks import Serial

    names = ("robot", "object", "surface", "destination")
    given = {name: inner.properties.value(name) for name in names}
    task = Task("fast", Reparameterise("smooth", Serial("whole", *children, **given)), seed=0)
    task.plan(first_scene(scene(), 0, lambda: False), 1)
    assert task.best is not None
    assert timed(task.best)
