"""Joined motion of tasks in a row: shorter, the same grasps, places and ends, every piece proven, strokes long enough."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Situation, Success, candidate, tool_frame
from kabo.language.formulas import GroundCall
from kabo.planner.refine.freedom import freedoms
from kabo.planner.refine.joining import ActMotion, Effort, joined, lengths
from kabo.planner.refine.legs import legs_of, proven
from kabo.planner.refine.timing import duration, timed
from kabo.scene import motion_limits
from kabo.tasks.procedures import GeometricProcedures
from tests.tasks.conftest import DOMAINS, scene_of

PROBLEM = "bartender/four_bottles.yaml"
CALLS = (
    GroundCall("pick", ("left", "bottle_1")),
    GroundCall("place", ("left", "bottle_1", "anywhere")),
    GroundCall("pick", ("left", "bottle_2")),
)
LEAST = {"approach": 0.05, "lift": 0.03, "lower": 0.03, "retreat": 0.05}  # m: in the scene's families


@cache
def row() -> tuple[GeometricProcedures, tuple[ActMotion, ...]]:
    """Three tasks of one robot, one after the other."""
    return of_calls(*((call, 0) for call in CALLS))


def of_calls(*calls: tuple[GroundCall, int]) -> tuple[GeometricProcedures, tuple[ActMotion, ...]]:
    """Calls with their attempts as acts."""
    server = GeometricProcedures(GeometryServer(scene_of(PROBLEM)), (DOMAINS / PROBLEM).parent)
    situation, acts = Situation.of(server.scene.start), []
    for call, attempt in calls:
        answer = server.call(call, situation, attempt)
        assert isinstance(answer, Success)
        bodies = [server.scene.bodies["bottle_1"]]
        acts.append(ActMotion(answer.motion, answer.changes, freedoms(server.stages(call), bodies)))
        situation = situation.replace(answer.changes)
    return server, tuple(acts)


@cache
def shortened(pinned: bool) -> list[ActMotion]:
    server, acts = row()
    return joined(server.server.context(), start(), acts, Effort(40, 1), pinned=pinned)


def start() -> Situation:
    return Situation.of(row()[0].scene.start)


def end(acts) -> Situation:
    situation = start()
    for act in acts:
        situation = situation.replace(act.changes)
    return situation


def test_joined_acts_are_shorter_and_end_where_they_did():
    acts, made = row()[1], shortened(True)
    assert lengths(made) < lengths(acts)
    assert end(made).key == end(acts).key


def test_what_is_taken_and_let_go_stays_in_its_place():
    for act, other in zip(row()[1], shortened(True), strict=True):
        told = [
            [(s.stage, s.attach, s.detach, s.waypoints[-1]) for s in each.motion if s.attach or s.detach]
            for each in (act, other)
        ]
        assert told[0] == told[1]
        assert {n: v for n, v in act.changes.items() if n != "left"} == {
            n: v for n, v in other.changes.items() if n != "left"
        }


@pytest.mark.parametrize("pinned", [True, False])
def test_every_act_is_proven_from_where_the_one_before_ends(pinned):
    server, situation = row()[0], start()
    for act in shortened(pinned):
        assert proven(server.server.context(), situation, act.motion)
        situation = situation.replace(act.changes)


@pytest.mark.parametrize("pinned", [True, False])
def test_strokes_keep_what_their_family_asks_for_at_least(pinned):
    server, situation, seen = row()[0], start(), set()
    robot = server.scene.robots["left"]
    for act in shortened(pinned):
        for leg in legs_of(server.server.context(), situation, act.motion) or []:
            name = (leg.segment.stage or "").rpartition("/")[2]
            if name in ("approach", "lift", "lower", "retreat"):
                points = [candidate(robot, q).pose(tool_frame(robot))[:3, 3] for q in (leg.path[0], leg.path[-1])]
                assert np.linalg.norm(points[1] - points[0]) > LEAST[name] - 2e-3
                seen.add(name)
        situation = situation.replace(act.changes)
    assert seen == {"approach", "lift", "lower", "retreat"}


def test_where_a_robot_makes_way_is_chosen_anew_but_it_still_moves():
    """The other arm works in between: it is proven with the first one where that now waits."""
    other = GroundCall("pick", ("right", "bottle_3"))
    server, acts = of_calls((GroundCall("move", ("left",)), 1), (other, 0), (CALLS[0], 0))
    context, situation = server.server.context(), Situation.of(server.scene.start)
    made = joined(context, situation, acts, Effort(20, 0))
    assert lengths(made) < 0.8 * lengths(acts)
    assert [segment.stage for segment in made[0].motion] == ["move"]
    assert made[0].changes["left"] != acts[0].changes["left"]
    assert made[2].changes["left"] == acts[2].changes["left"]
    for act in made:
        assert proven(context, situation, act.motion)
        situation = situation.replace(act.changes)


def test_an_end_that_nobody_needs_is_let_go():
    assert lengths(shortened(False)) < lengths(shortened(True))


def test_a_motion_is_not_proven_where_something_stands_in_its_way():
    server, acts = row()
    situation = start()
    (there,) = end(acts[:2]).objects["bottle_1"]
    assert proven(server.server.context(), situation, acts[0].motion)
    (other,) = situation.objects["bottle_1"]
    blocked = situation.replace({"bottle_3": other})
    assert not proven(server.server.context(), blocked, acts[0].motion)
    assert there != other


def test_times_keep_limits_and_nothing_else_changes():
    server, situation = row()[0], start()
    robot = server.scene.robots["left"]
    for act in shortened(True):
        made = timed(server.server.context(), situation, act.motion)
        assert proven(server.server.context(), situation, made)
        assert [(s.stage, s.attach, s.detach) for s in made] == [(s.stage, s.attach, s.detach) for s in act.motion]
        assert made[0].times[0] == 0.0
        for before, after in zip(made, made[1:], strict=False):
            assert after.times[0] == before.times[-1]
        for segment in made:
            assert np.all(np.diff(segment.times) > 0.0)
            for order, limit in enumerate(motion_limits(robot, segment.joints).rows, 1):
                low, high = segment.trajectory.bounds(order)
                assert np.all(np.maximum(-low, high) <= limit)
        assert duration(made) > 0.0
        situation = situation.replace(act.changes)


def test_a_scene_may_set_accelerations():
    robot = row()[0].scene.robots["left"]
    slower = motion_limits(replace(robot, acceleration={robot.planned_joints[1]: 0.5}), robot.planned_joints)
    assert slower.acceleration[1] == 0.5
    assert np.allclose(np.delete(slower.acceleration, 1), np.delete(4.0 * slower.velocity, 1))
    assert np.allclose(slower.jerk, 20.0 * slower.acceleration)
