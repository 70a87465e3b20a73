"""Plans carried out by a robot server in another process: to the goal, or to a stop on both sides with a true reason."""

import json
import re
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kabo
from kabo.errors import InputError, ServiceError
from kabo.execution import KnownTruth, Log, RobotFailed, Run, execute, motion_of, parts_of
from kabo.plan import Plan
from kabo.remote import ZenohRobot
from kabo.scene import Scene
from kabo.service import client_config
from tests.remote.conftest import PROBLEM, Observer, Started, until
from tests.service.conftest import free_endpoint

SECONDS = (
    0.3  # of silence after which a stalled process is given up in these tests: long for a machine, soon for a test
)


def carried_out(
    plan: Plan, scene: Scene, endpoint: str, told: Callable[[dict[str, Any]], None] | None = None
) -> Run:
    with ZenohRobot(client_config([endpoint]), scene, patience_s=60.0) as robot:
        return execute(plan, scene, robot, KnownTruth(poses=robot.poses), log=Log(listener=told))


def test_a_whole_plan_reaches_its_goal_and_bodies_are_where_it_puts_them(
    serve: Callable[..., Started], observe: Callable[[str], Observer], stacked_plan: Plan, stacked_scene: Scene
) -> None:
    server = serve()
    run = carried_out(stacked_plan, stacked_scene, server.endpoint)
    assert run.reached_goal, run.reason
    observer = observe(server.endpoint)
    until(lambda: observer.now.driver is None)
    last = stacked_plan.nodes[run.history[-1][0]].after
    assert last is not None and last.objects
    for body, pose in last.objects.items():
        assert np.allclose(np.reshape(observer.now.bodies[body], (4, 4))[:3, 3], pose.position, atol=1e-6)
    counts = [each.count for each in observer.states]
    assert counts == sorted(set(counts))
    times = np.diff([each.time for each in observer.states])
    assert np.allclose(times / np.diff(counts), 0.01)  # 100 Hz on the robots' clock


def test_the_command_ends_with_its_reason_if_the_robots_are_elsewhere(
    serve: Callable[..., Started], kabo_process: Callable[..., Started], plan_file: Path
) -> None:
    server = serve()
    given = (
        "execute",
        PROBLEM,
        plan_file,
        "--no-verify",
        "--no-recover",
        "--on",
        "zenoh",
        "--endpoint",
        server.endpoint,
    )
    code, said = kabo_process(*given).end()
    assert code == 0 and "the goal is reached" in said
    code, said = kabo_process(*given).end()
    assert code == 7 and "from where the plan begins" in said
    code, said = kabo_process(*(each for each in given if each != "--no-recover")).end()
    assert code == 0 and "the goal is reached" in said  # planned anew from where the first run has left everything
    server.process.send_signal(signal.SIGTERM)
    code, said = server.end()
    assert code == 0 and "drives" in said and "has left" in said and "Traceback" not in said


def test_no_server_and_another_scene_are_told_with_the_remedy(serve: Callable[..., Started]) -> None:
    scene = kabo.load_scene(PROBLEM.with_name("n3.yaml"))
    free = free_endpoint()
    with pytest.raises(ServiceError, match=f"no robot server answers at {re.escape(free)};.*--serve"):
        ZenohRobot(client_config([free]), scene, patience_s=0.1)
    server = serve()
    with pytest.raises(InputError, match="has another scene: o3"):
        ZenohRobot(client_config([server.endpoint]), scene)


def test_one_client_drives_at_a_time(serve: Callable[..., Started], stacked_scene: Scene) -> None:
    server = serve()
    config = client_config([server.endpoint])
    with ZenohRobot(config, stacked_scene) as robot:
        with pytest.raises(ServiceError, match="another client drives"):
            ZenohRobot(config, stacked_scene, patience_s=0.1)
        robot.wait(0.1)
    with ZenohRobot(config, stacked_scene) as robot, pytest.raises(RobotFailed, match="no robot 'nobody'"):
        robot.grip("nobody", ())


# ---------------------------------------------------------------------------------------------------------- losses
@pytest.fixture
def driving(
    serve: Callable[..., Started],
    observe: Callable[[str], Observer],
    kabo_process: Callable[..., Started],
    plan_file: Path,
) -> Callable[[float], tuple[Started, Observer]]:
    """A client process whose robot moves just now, at the pace of real time."""

    def start(silence: float) -> tuple[Started, Observer]:
        server = serve(speed=1.0, silence=silence)
        observer = observe(server.endpoint)
        given = ("--no-verify", "--on", "zenoh", "--endpoint", server.endpoint)
        client = kabo_process("execute", PROBLEM, plan_file, *given)
        until(lambda: observer.now.moving and observer.now.motion_time > 0.3)
        return client, observer

    return start


def require_planned_stop(observer: Observer, plan: Plan) -> None:
    """It stands, where the path of its first motion passes, before the end of it."""
    until(lambda: not observer.now.moving)
    state = observer.now
    first = plan.nodes[plan.root].motion[0]
    assert first.trajectory is not None
    assert state.motion_time < first.trajectory.times[-1]
    assert np.allclose(state.positions["mobile"][:5], first.trajectory.at(state.motion_time), atol=1e-6)
    assert np.abs(state.velocities["mobile"]).max() < 1e-2


def test_the_robot_of_a_client_that_dies_stops_on_its_path(
    driving: Callable[[float], tuple[Started, Observer]], stacked_plan: Plan
) -> None:
    client, observer = driving(20.0)
    client.process.kill()
    until(lambda: observer.now.driver is None)
    require_planned_stop(observer, stacked_plan)
    assert observer.now.halted is not None and "the connection to client" in observer.now.halted


def test_the_robot_of_a_client_that_stalls_stops_on_its_path_and_the_client_is_told(
    driving: Callable[[float], tuple[Started, Observer]], stacked_plan: Plan
) -> None:
    client, observer = driving(SECONDS)
    client.send(signal.SIGSTOP)
    until(lambda: observer.now.driver is None)
    require_planned_stop(observer, stacked_plan)
    assert observer.now.halted is not None and "gave no sign of life" in observer.now.halted
    client.send(signal.SIGCONT)
    code, said = client.end()
    assert code == 7 and "the robot server gave up: client" in said and "no sign of life" in said


@pytest.mark.parametrize(
    ("sent", "silence", "reason"),
    [(signal.SIGKILL, 20.0, "is gone"), (signal.SIGSTOP, SECONDS, "no sign of life")],
)
def test_a_client_whose_server_is_lost_ends_with_the_reason(
    sent: signal.Signals,
    silence: float,
    reason: str,
    serve: Callable[..., Started],
    stacked_plan: Plan,
    stacked_scene: Scene,
) -> None:
    server = serve(speed=1.0, silence=silence)
    lose = threading.Timer(0.3, lambda: server.send(sent))
    moving = threading.Event()

    def told(record: dict[str, Any]) -> None:
        if record["event"] == "moving" and not moving.is_set():
            moving.set()
            lose.start()

    run = carried_out(stacked_plan, stacked_scene, server.endpoint, told)
    assert not run.reached_goal and reason in run.reason, run.reason
    assert run.node == stacked_plan.root and run.history == ()
    last = run.log.records[-1]
    assert (last["event"], last["reason"]) == ("stopped", run.reason)
    json.dumps(run.log.records, allow_nan=False)


def test_the_clock_of_a_motion_is_slowed_down_elsewhere(
    serve: Callable[..., Started], stacked_plan: Plan, stacked_scene: Scene
) -> None:
    server = serve(speed=1.0)
    part = parts_of(motion_of(stacked_plan, stacked_plan.root, stacked_scene))[0]
    with ZenohRobot(client_config([server.endpoint]), stacked_scene) as robot:
        robot.follow(part)
        robot.wait(0.2)
        assert robot.pace(0.25)
        robot.wait(0.6)
        first = robot.state()
        robot.wait(0.4)
        last = robot.state()
        assert last.moving and last.motion_time - first.motion_time == pytest.approx(
            0.25 * (last.time - first.time), abs=0.01
        )
        with pytest.raises(RobotFailed, match="refuses to pace.*rate"):
            robot.pace(1.5)
        robot.stop()
        while robot.state().moving:
            robot.wait(0.05)
