"""What is wrong between a client and a robot server: one clear message, or a refusal that leaves both as they were."""

import json
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import zenoh

import kabo
from kabo.errors import InputError, ServiceError
from kabo.execution import RobotFailed
from kabo.remote import ZenohRobot
from kabo.scene import Scene
from kabo.service import client_config, keys, open_session, server_config
from tests.remote.conftest import PATIENCE_S, PROBLEM, Started, until
from tests.service.conftest import free_endpoint

WAITING = (
    "kabo: working",
    "kabo: compiling",
)  # what is said meanwhile, on slow machines and where nothing is compiled

GARBAGE = (b"", b"\xff\xfe", b"null", b"[]", b"{}", b'{"count": "1"}', b"[" * 3000, b'{"code": 3}')


def execute(kabo_process: Callable[..., Started], plan_file: Path, *more: object) -> tuple[int, str]:
    return kabo_process("execute", PROBLEM, plan_file, "--no-verify", "--on", "zenoh", *more).end()


@pytest.mark.parametrize(
    "endpoint", ["here", "tcp/", "tcp/nowhere.invalid:1", "tcp/127.0.0.1:99999", "", "tcp/127.0.0.1:9"]
)
def test_an_endpoint_that_is_wrong_or_where_nobody_is_ends_with_one_message(
    endpoint: str, kabo_process: Callable[..., Started], plan_file: Path
) -> None:
    code, said = execute(kabo_process, plan_file, "--endpoint", endpoint)
    assert code == 6 and "Traceback" not in said
    assert len([line for line in said.splitlines() if not line.startswith(WAITING)]) <= 2, said
    assert "no robot server answers" in said or "no zenoh session" in said or "cannot be used" in said


def test_a_server_at_an_endpoint_in_use_ends_with_one_message(
    serve: Callable[..., Started], kabo_process: Callable[..., Started]
) -> None:
    endpoint = serve().endpoint
    code, said = kabo_process("simulate", PROBLEM, "--serve", "--kinematic", "--endpoint", endpoint).end()
    assert code == 6 and "no zenoh session can be opened" in said and "Traceback" not in said


def test_a_client_that_is_refused_leaves_the_robots_to_the_next(
    serve: Callable[..., Started], stacked_scene: Scene, kabo_process: Callable[..., Started], plan_file: Path
) -> None:
    server = serve()
    config = client_config([server.endpoint])
    with pytest.raises(InputError, match="has another scene: o3"):
        ZenohRobot(config, kabo.load_scene(PROBLEM.with_name("n3.yaml")))
    with ZenohRobot(config, stacked_scene):
        code, said = execute(kabo_process, plan_file, "--endpoint", server.endpoint)
        assert code == 6 and "another client drives" in said and "Traceback" not in said
    with ZenohRobot(config, stacked_scene) as robot:
        robot.wait(0.05)


def test_other_names_of_joints_are_told(stacked_scene: Scene, fake: Callable[..., str]) -> None:
    taken = taken_of(stacked_scene)
    taken["robots"]["mobile"][0] = "shoulder"
    with pytest.raises(InputError, match=r"mobile.arm_joint_1, mobile.shoulder"):
        ZenohRobot(client_config([fake(take=json.dumps(taken).encode())]), stacked_scene)


def test_a_server_refuses_a_client_of_another_protocol_and_names_both(serve: Callable[..., Started]) -> None:
    server = serve()
    session = open_session(client_config([server.endpoint]))
    until(lambda: bool(list(session.liveliness().get(keys.ALL_ROBOTS))))
    (found,) = session.liveliness().get(keys.ALL_ROBOTS)
    key = keys.robot(keys.server_of(str(found.ok.key_expr)), "take")
    asked = ({"client": "new", "protocol": "kabo-robot/9", "colour": "red"}, {"client": "a/b"}, {"client": ""})
    said = []
    for message in asked:
        (reply,) = session.get(key, payload=json.dumps(message), timeout=20.0)
        assert reply.err is not None
        said.append(json.loads(reply.err.payload.to_bytes()))
    session.close()
    assert all(each["code"] == "bad_request" for each in said)
    assert said[0]["message"] == "this server speaks kabo-robot/1, and the client 'kabo-robot/9'"
    assert all("$.client" in each["message"] for each in said[1:])


def test_a_client_that_took_a_server_and_vanished_without_a_token_drives_no_more(
    serve: Callable[..., Started], stacked_scene: Scene
) -> None:
    server = serve(silence=0.5)
    session = open_session(client_config([server.endpoint]))
    until(lambda: bool(list(session.liveliness().get(keys.ALL_ROBOTS))))
    (found,) = session.liveliness().get(keys.ALL_ROBOTS)
    key = keys.robot(keys.server_of(str(found.ok.key_expr)), "take")
    (reply,) = session.get(key, payload=b'{"client": "stranger"}', timeout=20.0)
    assert reply.ok is not None
    session.close()
    with ZenohRobot(client_config([server.endpoint]), stacked_scene, patience_s=60.0) as robot:
        robot.wait(0.05)
    assert any("client stranger gave no sign of life" in line for line in server.said)


# ------------------------------------------------------------------------------------------------- servers that lie
def state_of(scene: Scene, count: int = 1, **changed: Any) -> dict[str, Any]:
    positions = {name: list(scene.start.robots[name]) for name in scene.robots}
    velocities = {name: [0.0] * len(values) for name, values in positions.items()}
    own = {"count": count, "time": 0.01 * count, "motion_time": 0.0, "moving": False}
    return own | {"positions": positions, "velocities": velocities} | changed


def taken_of(scene: Scene, **changed: Any) -> dict[str, Any]:
    robots = {name: list(robot.joint_names) for name, robot in scene.robots.items()}
    return {"limit_s": 5.0, "robots": robots, "bodies": list(scene.movable), "state": state_of(scene)} | changed


@pytest.fixture
def fake() -> Iterator[Callable[..., str]]:
    """Starts servers that reply with given bytes to each verb."""
    opened: list[Any] = []

    def start(**replies: bytes) -> str:
        endpoint, name = free_endpoint(), f"fake-{os.getpid()}-{len(opened)}"
        session = open_session(server_config([endpoint]))

        def answer(query: zenoh.Query, raw: bytes) -> None:
            with query:
                query.reply(query.key_expr, raw, encoding="application/json")

        opened.append(session)
        for verb, raw in replies.items():
            opened.append(
                session.declare_queryable(keys.robot(name, verb), lambda query, raw=raw: answer(query, raw))
            )
        opened.append(session.liveliness().declare_token(keys.robot(name, "alive")))
        return endpoint

    yield start
    for each in opened:
        if isinstance(each, zenoh.Session):
            each.close()


def test_a_server_of_another_protocol_or_of_none_is_told(stacked_scene: Scene, fake: Callable[..., str]) -> None:
    other = fake(take=b'{"protocol": "kabo-robot/2", "all": "else"}')
    with pytest.raises(ServiceError, match="speaks kabo-robot/2, and this is kabo-robot/1"):
        ZenohRobot(client_config([other]), stacked_scene)
    for raw in GARBAGE[:7]:
        with pytest.raises(ServiceError, match="no message of kabo-robot/1"):
            ZenohRobot(client_config([fake(take=raw)]), stacked_scene)


@pytest.mark.parametrize("raw", GARBAGE)
def test_a_reply_that_is_no_message_ends_a_run_with_its_reason(
    raw: bytes, stacked_scene: Scene, fake: Callable[..., str]
) -> None:
    config = client_config(
        [fake(take=json.dumps(taken_of(stacked_scene)).encode(), stop=raw, leave=raw, look=raw)]
    )
    with ZenohRobot(config, stacked_scene) as robot, pytest.raises(RobotFailed, match="no message|no sign"):
        robot.stop()


def test_states_of_another_scene_end_a_run_and_strange_poses_are_not_seen(
    stacked_scene: Scene, fake: Callable[..., str]
) -> None:
    scene = stacked_scene
    strange = state_of(scene, 2, bodies={"o1": [1.0], "nothing": [0.0] * 16, "o2": [*[0.0] * 15, 1.0]})
    short = state_of(scene, 3, positions={"mobile": [0.0]})
    replies = {"take": taken_of(scene), "stop": strange, "leave": short, "grip": short}
    config = client_config([fake(**{verb: json.dumps(told).encode() for verb, told in replies.items()})])
    with ZenohRobot(config, scene) as robot:
        robot.stop()
        assert set(robot.poses()) == {"o2"}
        robot.grip("mobile", ())
        with pytest.raises(RobotFailed, match="states that are not of this scene"):
            robot.wait(0.1)


def test_garbage_on_the_keys_of_states_and_heartbeats_changes_nothing(
    serve: Callable[..., Started], stacked_scene: Scene
) -> None:
    server = serve(speed=1.0)
    with ZenohRobot(client_config([server.endpoint]), stacked_scene) as robot:
        stranger = open_session(client_config([server.endpoint]))
        for raw in GARBAGE:
            stranger.put(keys.robot(robot.server, "state"), raw)
            stranger.put(keys.driver(robot.server, "somebody"), raw)
            stranger.put(keys.driver(robot.server, robot.client), raw)
        begun = time.monotonic()
        robot.wait(0.3)
        assert time.monotonic() - begun < PATIENCE_S
        stranger.close()
    assert server.process.poll() is None and not any("Traceback" in line for line in server.said)
