"""Motions of several robots at once: each lane faster for itself, all lanes proven apart, nothing else changed."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

import kabo
from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.refine import at_once
from kabo.planner.refine.at_once import Act, chains, hastened_acts, lanes_of
from kabo.planner.refine.freedom import NONE, Freedoms, freedoms
from kabo.planner.refine.hastening import hastened
from kabo.planner.refine.legs import proven
from kabo.planner.refine.timing import timed
from kabo.scene import load_scene
from kabo.tasks.procedures import GeometricProcedures
from tests.planner.refine.test_junctions import linked, stop_of

TWO_ARMS = Path(__file__).resolve().parents[3] / "examples" / "two_arms" / "problem.yaml"
TAKE = GroundCall("take_both", ("left", "red", "right", "blue"))
PUT = GroundCall("put_both", ("left", "red", "near_left", "right", "blue", "near_right"))


@cache
def server() -> GeometricProcedures:
    scene = kabo.load_problem(TWO_ARMS).scene
    assert scene is not None
    return GeometricProcedures(GeometryServer(load_scene(scene)), TWO_ARMS.parent)


def known(call: GroundCall) -> Freedoms:
    bodies = [server().scene.bodies[name] for name in ("red", "blue")]
    return freedoms(server().stages(call), bodies)


@cache
def acts() -> tuple[Act, ...]:
    """Both nodes of the plan, as their tasks have found them."""
    situation, found = Situation.of(server().scene.start), []
    for call in (TAKE, PUT):
        answer = server().call(call, situation)
        assert isinstance(answer, Success), answer
        lanes = lanes_of(answer.motion)
        assert lanes is not None
        found.append(Act(situation, answer, lanes, known(call)))
        situation = found[-1].after
    return tuple(found)


@pytest.fixture
def plainly(monkeypatch):
    """Lanes are joined and timed, but no way points are changed: that is tested by itself."""
    monkeypatch.setattr(
        at_once, "faster", lambda context, situation, lane, freedoms: timed(context, situation, lane)
    )


def stops():
    situations = [act.situation for act in acts()]
    made = [stop_of(at, call, act.answer) for at, call, act in zip(situations, (TAKE, PUT), acts(), strict=True)]
    goal = stop_of(acts()[-1].after)
    linked((made[0], made[1]), (made[1], goal))
    return made


def test_a_lane_is_what_one_robot_does_from_the_beginning_on() -> None:
    motion = acts()[0].answer.motion
    lanes = lanes_of(motion)
    assert set(lanes) == {"left", "right"}
    assert sorted(map(len, lanes.values())) == [4, 4]
    assert all(segment.trajectory is None for lane in lanes.values() for segment in lane)
    alone = tuple(segment for segment in motion if segment.robot == "left")
    late = tuple(replace(s, times=tuple(t + 1.0 for t in s.times)) if s.robot == "right" else s for s in motion)
    same = tuple(replace(segment, stage="both") for segment in motion)
    assert lanes_of(alone) is lanes_of(late) is lanes_of(same) is lanes_of(()) is None


def test_only_children_of_a_merger_whose_stages_all_permit_changes_are_lanes() -> None:
    first, second = stops()
    every = {first: known(TAKE), second: known(PUT)}
    (chain,) = chains([first, second], every)
    assert [stop for stop, _ in chain] == [first, second]
    assert list(chains([first, second], dict.fromkeys((first, second), NONE))) == []
    without = replace(every[second], mergers=())
    (chain,) = chains([first, second], {**every, second: without})
    assert [stop for stop, _ in chain] == [first]


def test_lanes_get_faster_and_end_in_the_same_state_if_they_must(plainly) -> None:
    context = server().server.context()
    made = hastened_acts(context, acts(), pinned=True)
    assert sum(act.seconds for act in made) < sum(act.seconds for act in acts()) - 0.05
    assert made[0].situation == acts()[0].situation
    assert made[1].situation.key == made[0].after.key
    assert made[1].after.key == acts()[1].after.key
    for act in made:
        for lane in lanes_of(act.answer.motion).values():
            assert proven(context, act.situation, lane)
        assert list(act.answer.motion) == sorted(act.answer.motion, key=lambda segment: segment.times[0])


def test_where_nothing_follows_the_last_stroke_is_as_short_as_may_be(plainly) -> None:
    context = server().server.context()
    pinned, loose = (hastened_acts(context, acts(), pinned=each) for each in (True, False))
    assert loose[1].seconds < pinned[1].seconds - 0.01
    for robot in ("left", "right"):
        assert loose[1].after.values(robot) != acts()[1].after.values(robot)
    for name in ("red", "blue"):
        ends = (act.after.attachment(name) for act in (loose[1], acts()[1]))
        first, last = (end.position for end in ends)
        assert max(abs(a - b) for a, b in zip(first, last, strict=True)) < 1e-6


def test_lanes_that_are_not_proven_apart_stay_as_they_were(plainly, monkeypatch) -> None:
    monkeypatch.setattr(at_once, "met", lambda before, after, tracks: Refusal("no_path", "they meet"))
    assert hastened_acts(server().server.context(), acts(), pinned=False) == list(acts())


def test_a_refined_plan_of_two_arms_is_faster_and_verified(monkeypatch) -> None:
    monkeypatch.setattr(hastened, "__kwdefaults__", {**hastened.__kwdefaults__, "tries": 12})
    problem = kabo.load_problem(TWO_ARMS)
    result = kabo.solve(problem, quality="good", workers=1)
    assert result.statistics["duration"] < 0.9 * result.statistics["duration_found"]
    assert kabo.verify(problem, result.plan).ok
