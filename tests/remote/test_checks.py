"""What a robot server refuses: whatever is sent, it decodes it or says why not, and moves nothing beyond its limits."""

import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from kabo.execution import KinematicRobot, Motion, motion_of, parts_of
from kabo.motion import Trajectory
from kabo.plan import Plan
from kabo.remote import MotionMessage, ZenohRobot, check_begin, check_motion, motion_from, motion_message
from kabo.scene import Scene
from kabo.service import Unreadable, client_config, keys, read
from tests.remote.conftest import Started

STRANGE: list[Any] = [
    None,
    True,
    -1,
    0,
    1e308,
    -1e308,
    1e-300,
    2**70,
    "",
    "mobile",
    "x" * 5000,
    [],
    {},
    [[]],
    [1.0],
    {"a": 1},
]
RAW = [
    b"",
    b"\0",
    b"null",
    b"[]",
    b"{}",
    b'{"client": 1}',
    b"\xff\xfe",
    b"[" * 5000,
    b'{"client": "a", "client": "b"}',
]


@pytest.fixture(scope="module")
def part(stacked_plan: Plan, stacked_scene: Scene) -> Motion:
    return parts_of(motion_of(stacked_plan, stacked_plan.root, stacked_scene))[0]


def sent(part: Motion) -> Motion:
    """A motion as the server has it."""
    return motion_from(read(MotionMessage, msgspec.json.encode(motion_message("a", part))))


def test_every_motion_of_a_plan_arrives_as_it_is_and_is_not_refused(
    stacked_plan: Plan, stacked_scene: Scene
) -> None:
    for name, node in stacked_plan.nodes.items():
        for part in parts_of(motion_of(stacked_plan, name, stacked_scene)) if node.motion else ():
            found = sent(part)
            check_motion(found, stacked_scene)
            assert (found.begin, found.end, found.nodes) == (part.begin, part.end, part.nodes)
            for one, other in zip(found.stretches, part.stretches, strict=True):
                assert one.trajectory.coefficients == other.trajectory.coefficients
                assert (one.robot, one.trajectory.times) == (other.robot, other.trajectory.times)


def changed(part: Motion, how: Callable[[Trajectory], Trajectory], number: int = 0) -> Motion:
    stretches = list(part.stretches)
    stretches[number] = replace(stretches[number], trajectory=how(stretches[number].trajectory))
    return replace(part, stretches=tuple(stretches), end=max(each.end for each in stretches))


def moved(trajectory: Trajectory, by: float) -> Trajectory:
    """All of it, by so many rad, in its first joint."""
    padded = trajectory.padded.copy()
    padded[:, 0, 0] += by
    return Trajectory.of_arrays(trajectory.joints, trajectory.waypoints, trajectory.times, padded)


@pytest.mark.parametrize(
    ("how", "reason"),
    [
        (lambda t: t.scaled(0.9), "exceeds its limit of"),
        (lambda t: moved(t, 100.0), "leaves its range"),
        (
            lambda t: replace(t, coefficients=(t.coefficients[0][:1] * 5, *t.coefficients[1:])),
            "jumps between two pieces",
        ),
        (
            lambda t: t.split(t.times[0] + 0.5 * t.duration)[0],
            "ends in motion|jumps between two trajectories|apart in time",
        ),
        (lambda t: t.split(t.times[0] + 0.5 * t.duration)[1], "begins in motion"),
        (lambda t: replace(t, joints=("elbow", *t.joints[1:])), "has no joint 'elbow'"),
        (lambda t: replace(t, joints=(t.joints[1], *t.joints[1:])), "named twice"),
        (lambda t: t.shifted(-1.0), "begins before its motion"),
    ],
)
def test_a_motion_beyond_limits_or_with_jumps_is_refused(
    how: Callable[[Trajectory], Trajectory], reason: str, part: Motion, stacked_scene: Scene
) -> None:
    with pytest.raises(Unreadable, match=reason):
        check_motion(changed(part, how), stacked_scene)


def test_a_motion_that_begins_elsewhere_is_refused(part: Motion, stacked_scene: Scene) -> None:
    state = KinematicRobot(stacked_scene).state()
    check_begin(part, state, stacked_scene)
    near = changed(part, lambda t: moved(t, 0.009))
    check_begin(near, state, stacked_scene)
    with pytest.raises(Unreadable, match="is at .*, and the motion begins at"):
        check_begin(changed(part, lambda t: moved(t, 0.011)), state, stacked_scene)
    with pytest.raises(Unreadable, match="two trajectories at once"):
        check_motion(replace(part, stretches=(part.stretches[0], *part.stretches)), stacked_scene)


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The ways to all values of a tree."""
    yield path
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in pairs:
        yield from places(each, (*path, key))


def with_value(tree: Any, path: tuple[Any, ...], value: Any) -> Any:
    made = json.loads(json.dumps(tree))
    if not path:
        return value
    at = made
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return made


@given(data=st.data())
def test_a_changed_message_is_read_or_refused_and_what_is_let_through_is_within_limits(
    data: st.DataObject, part: Motion, stacked_scene: Scene
) -> None:
    tree = json.loads(msgspec.json.encode(motion_message("a", part)))
    path = data.draw(st.sampled_from(sorted(places(tree), key=str)))
    raw = json.dumps(with_value(tree, path, data.draw(st.sampled_from(STRANGE)))).encode()
    for _ in range(data.draw(st.integers(0, 2))):
        at = data.draw(st.integers(0, len(raw)))
        raw = raw[:at] + data.draw(st.binary(max_size=2)) + raw[at + data.draw(st.integers(0, 2)) :]
    try:
        motion = motion_from(read(MotionMessage, raw))
        check_motion(motion, stacked_scene)
    except Unreadable:
        event("refused")
        return
    event("let through")
    for stretch in motion.stretches:
        robot = stacked_scene.robots[stretch.robot]
        index = [robot.joint_names.index(joint) for joint in stretch.trajectory.joints]
        speeds = np.abs(stretch.trajectory.at(np.linspace(stretch.begin, stretch.end, 200), 1))
        assert (speeds <= 1.002 * np.asarray(robot.tree.velocity)[index]).all()


def test_mutated_messages_on_all_keys_leave_the_server_as_it_was(
    serve: Callable[..., Started], part: Motion, stacked_scene: Scene
) -> None:
    server = serve()
    draw = random.Random(1)  # noqa: S311
    with ZenohRobot(client_config([server.endpoint]), stacked_scene) as robot:
        tree = json.loads(msgspec.json.encode(motion_message(robot.client, part)))
        ways = list(places(tree))
        payloads = [*RAW, *(with_json(tree, draw.choice(ways), draw.choice(STRANGE)) for _ in range(150))]
        verbs = ("take", "leave", "stop", "grip", "release", "follow")
        answers = 0
        for number, raw in enumerate(payloads):
            asked = verbs if raw in RAW else (("follow", "follow", *verbs)[number % 8],)
            for verb in asked:
                key = keys.robot(robot.server, verb)
                answers += sum(1 for _ in robot._session.get(key, payload=raw, timeout=20.0))
        assert answers == len(RAW) * len(verbs) + len(payloads) - len(RAW)
        robot.wait(0.1)
        assert server.process.poll() is None
    assert not any("Traceback" in line for line in server.said), server.said


def with_json(tree: Any, path: tuple[Any, ...], value: Any) -> bytes:
    return json.dumps(with_value(tree, path, value)).encode()
