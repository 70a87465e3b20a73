"""The protocol as it is documented: its schema, its page, and the server of the example, which uses nothing of kabo."""

import json
import re
import signal
from collections.abc import Callable
from pathlib import Path

import jsonschema
import msgspec
import pytest
import zenoh

from kabo.execution import motion_of, parts_of
from kabo.plan import Plan
from kabo.remote import ZenohRobot, motion_message
from kabo.scene import Scene
from kabo.service import client_config
from scripts.robot_messages import FILE, KINDS, schema
from tests.remote.conftest import PROBLEM, REPOSITORY, Observer, Started, until
from tests.service.conftest import free_endpoint

EXAMPLE = REPOSITORY / "examples" / "robot_server" / "server.py"
PAGE = (REPOSITORY / "docs" / "reference" / "robot_servers.md").read_text()


def test_the_schema_is_that_of_the_classes() -> None:
    assert json.loads(FILE.read_text()) == json.loads(json.dumps(schema())), "run python -m scripts.robot_messages"


def test_the_page_names_each_message_and_each_of_its_keys() -> None:
    for kind in KINDS:
        name = "an error" if kind.__name__ == "ErrorReply" else f"`{kind.__name__}`"
        row = re.search(rf"^\| {name} \| .*$", PAGE, flags=re.MULTILINE)
        assert row is not None, name
        known = set(kind.__struct_fields__) - {"retry_after_s"}
        assert known <= set(re.findall(r"`(\w+)`", row[0])), (name, known)


def test_motions_are_as_the_schema_says(stacked_plan: Plan, stacked_scene: Scene) -> None:
    for part in parts_of(motion_of(stacked_plan, stacked_plan.root, stacked_scene)):
        sent = json.loads(msgspec.json.encode(motion_message("a", part)))
        jsonschema.validate(sent, {**schema(), "anyOf": [{"$ref": "#/$defs/MotionMessage"}]})


@pytest.fixture
def example(program: Callable[..., Started]) -> Callable[[float], Started]:
    def start(limit: float) -> Started:
        endpoint = free_endpoint()
        made = program(EXAMPLE, endpoint, limit)
        made.wait_for("serves mobile")
        made.endpoint = endpoint
        return made

    return start


def test_the_server_of_the_example_carries_a_plan_out_and_refuses_what_is_no_message(
    example: Callable[[float], Started],
    kabo_process: Callable[..., Started],
    plan_file: Path,
    stacked_scene: Scene,
) -> None:
    server = example(20.0)
    given = ("--no-verify", "--on", "zenoh", "--endpoint", server.endpoint)
    code, said = kabo_process("execute", PROBLEM, plan_file, *given).end()
    assert code == 0 and "the goal is reached" in said, said
    with ZenohRobot(client_config([server.endpoint]), stacked_scene) as robot:
        only = {"anyOf": [{"$ref": "#/$defs/StateMessage"}]}
        for verb in ("take", "follow", "stop", "grip", "look", "leave"):
            for raw in (b"", b"null", b"{}", b'{"client": "x"}', b"\xff"):
                (reply,) = robot._session.get(f"kabo/v1/{robot.server}/robot/{verb}", payload=raw, timeout=20.0)
                assert reply.err is not None
                assert json.loads(reply.err.payload.to_bytes())["code"] in ("busy", "bad_request")
        (reply,) = robot._session.get(
            f"kabo/v1/{robot.server}/robot/stop", payload=json.dumps({"client": robot.client}), timeout=20.0
        )
        assert isinstance(reply.ok, zenoh.Sample)
        jsonschema.validate(json.loads(reply.ok.payload.to_bytes()), {**schema(), **only})
    assert server.process.poll() is None and not any("Traceback" in line for line in server.said)


@pytest.mark.parametrize(("sent", "limit"), [(signal.SIGSTOP, 0.3), (signal.SIGKILL, 20.0)])
def test_the_server_of_the_example_stops_on_its_path_if_the_client_is_lost(
    sent: signal.Signals,
    limit: float,
    example: Callable[[float], Started],
    observe: Callable[[str], Observer],
    kabo_process: Callable[..., Started],
    plan_file: Path,
    stacked_plan: Plan,
) -> None:
    server = example(limit)
    observer = observe(server.endpoint)
    given = ("--no-verify", "--on", "zenoh", "--endpoint", server.endpoint)
    client = kabo_process("execute", PROBLEM, plan_file, *given)
    until(lambda: observer.now.moving and observer.now.motion_time > 0.3)
    client.send(sent)
    until(lambda: not observer.now.moving)
    state, first = observer.now, stacked_plan.nodes[stacked_plan.root].motion[0].trajectory
    assert first is not None and state.motion_time < first.times[-1] and state.halted
    assert state.positions["mobile"][:5] == pytest.approx(first.at(state.motion_time).tolist(), abs=1e-9)
