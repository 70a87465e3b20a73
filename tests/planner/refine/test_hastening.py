"""Ways that are made faster: proven, from the same end to the same end, never slower, the same for the same key."""

from functools import cache

import numpy as np
import pytest

from kabo.geometry_server import GeometryServer, Situation, Success
from kabo.language.formulas import GroundCall
from kabo.planner.refine.freedom import NONE, freedoms
from kabo.planner.refine.hastening import faster, hastened
from kabo.planner.refine.legs import legs_of, proven
from kabo.planner.refine.timing import duration, timed
from kabo.streams import stream_key
from kabo.tasks.procedures import GeometricProcedures
from kabo.tasks.robots.motion.parts import MotionPart
from kabo.tasks.robots.motion.timing import groups_of, timed_group
from tests.tasks.conftest import DOMAINS, scene_of

BARTENDER, ASSEMBLY = "bartender/four_bottles.yaml", "assembly/gearbox.yaml"
PICK = GroundCall("pick", ("left", "bottle_1"))
TRIES = 25


@cache
def server_of(problem: str) -> GeometricProcedures:
    return GeometricProcedures(GeometryServer(scene_of(problem)), (DOMAINS / problem).parent)


def answered(server: GeometricProcedures, call: GroundCall, situation: Situation) -> Success:
    answer = server.call(call, situation)
    assert isinstance(answer, Success), answer
    return answer


@cache
def picked() -> Success:
    return answered(server_of(BARTENDER), PICK, start())


def start() -> Situation:
    return Situation.of(server_of(BARTENDER).scene.start)


@cache
def group() -> tuple[MotionPart, ...]:
    """A free way and the approach after it, without a rest between."""
    legs = legs_of(server_of(BARTENDER).server.context(), start(), picked().motion)
    assert legs is not None
    return tuple(next(each for each in groups_of(leg.part for leg in legs) if len(each) > 1))


def seconds(parts) -> float:
    return parts[-1].times[-1]


@cache
def made(tries: int, key: int):
    return hastened(group(), [0], stream_key(key), tries=tries).parts


def test_a_way_with_the_stroke_after_it_gets_faster() -> None:
    assert seconds(made(TRIES, 0)) < seconds(timed_group(group())) - 1e-3


@pytest.mark.parametrize("key", [0, 1, 2])
def test_more_changes_are_never_slower(key: int) -> None:
    found = [seconds(made(tries, key)) for tries in (0, 8, TRIES)]
    assert found[0] == seconds(timed_group(group()))
    assert found == sorted(found, reverse=True)


def test_the_ends_and_the_stroke_stay() -> None:
    before, after = timed_group(group()), made(TRIES, 0)
    assert before[0].waypoints[0] == after[0].waypoints[0]
    assert before[-1].waypoints[-1] == after[-1].waypoints[-1]
    assert after[0].waypoints != before[0].waypoints
    lasting = np.array(group()[1].rows)
    assert np.abs(np.array(after[1].waypoints)[-1] - lasting[-1]).max() < 1e-9


def test_the_same_key_gives_the_same_motion() -> None:
    assert hastened(group(), [0], stream_key(0), tries=TRIES).parts == made(TRIES, 0)


def test_a_faster_motion_is_proven_and_only_free_ways_change() -> None:
    server, answer = server_of(BARTENDER), picked()
    context = server.server.context()
    known = freedoms(server.stages(PICK), [server.scene.bodies["bottle_1"]])
    plain = timed(context, start(), answer.motion)
    found = faster(context, start(), answer.motion, known)
    assert duration(found) < duration(plain)
    assert proven(context, start(), found)
    assert [each.waypoints for each in found[2:]] == [each.waypoints for each in plain[2:]]
    assert faster(context, start(), answer.motion, NONE) == plain


def test_legs_know_what_a_join_leaves_behind() -> None:
    """Parts that are attached to parts: the situation after the legs is the one that the task found."""
    server = server_of(ASSEMBLY)
    context, situation = server.server.context(), Situation.of(server.scene.start)
    calls = (
        GroundCall("pick", ("robot_1", "o1")),
        GroundCall("insert", ("robot_1", "o1", "o4"), (("mate", "bearing_on_tree"),)),
    )
    for call in calls:
        answer = answered(server, call, situation)
        legs = legs_of(context, situation, answer.motion)
        assert legs is not None and len(legs) == len(answer.motion)
        situation = situation.replace(answer.changes)
    assert situation.nested
    last = legs[-1].part.scene.situation
    assert last.attachment("o1").parent == situation.attachment("o1").parent == "o4"
    ends = (np.array(each.attachment("o1").position) for each in (last, situation))
    assert np.abs(np.subtract(*ends)).max() < 1e-8
    after = answered(server, GroundCall("pick", ("robot_1", "o3")), situation)
    assert legs_of(context, situation, after.motion) is not None
