"""`kabo simulate`: writes a scene as a model of physics, in MuJoCo's format, or serves its robots over zenoh."""

import argparse
import signal
import threading
from pathlib import Path
from typing import Any

from kabo import service
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file
from kabo.cli.limits import add_limits
from kabo.cli.solving import has_scene
from kabo.cli.terminal import answer, clean_standard_output, tell
from kabo.cli.truth import add_truth, truth_of

NAME = "simulate"
HELP = "write a scene as a model of physics (MJCF), or serve its robots to `kabo execute --on zenoh`"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo simulate` to the parser."""
    parser.add_argument("scene", type=Path, metavar="SCENE", help="a scene file, or a problem file with a scene")
    parser.add_argument(
        "-o",
        dest="output",
        type=output_file,
        default=Path("model.xml"),
        metavar="FILE",
        help="the model (default: model.xml)",
    )
    parser.add_argument(
        "--serve", action="store_true", help="write no model, but be a robot server, until Ctrl-C or SIGTERM"
    )
    add_connection(parser, "where it listens")
    parser.add_argument(
        "--kinematic", action="store_true", help="with --serve: robots without forces, in place of physics"
    )
    parser.add_argument(
        "--speed",
        type=bounded(0.01, 1000.0, ""),
        default=1.0,
        metavar="N",
        help="with --serve: how many seconds pass on the robots' clock in one second, at most (default: 1)",
    )
    parser.add_argument(
        "--silence",
        type=bounded(0.01, 60.0, "s"),
        default=0.035,
        metavar="S",
        help="with --serve: robots stop if a client gives no sign of life for so many seconds (default: 0.035)",
    )
    add_truth(parser)
    add_physics(parser)
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda options: has_scene(options.scene))


def add_connection(parser: argparse.ArgumentParser, what: str) -> None:
    """Adds the options of a connection to or of a robot server, for `simulate` and `execute`."""
    parser.add_argument(
        "--endpoint",
        metavar="ENDPOINT",
        help=f"of a robot server: {what} (default: tcp/127.0.0.1:7448)",
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="of a robot server: a zenoh configuration (JSON5): TLS, passwords",
    )


def endpoints_of(options: argparse.Namespace) -> list[str]:
    """The endpoints that were given; the usual one without an endpoint and a configuration."""
    if options.endpoint is not None:
        return [options.endpoint]
    return [] if options.config is not None else [rooms.ROBOT_ENDPOINT]


def add_physics(parser: argparse.ArgumentParser) -> None:
    """Adds the options of the model of physics, for `simulate` and `execute`."""
    positive = bounded(1e-6, 1e6, "")
    parser.add_argument(
        "--friction", type=positive, default=0.8, metavar="MU", help="between bodies (default: 0.8)"
    )
    parser.add_argument(
        "--grip-force",
        type=positive,
        default=100.0,
        metavar="N",
        help="of grippers whose scene gives no force, in newtons (default: 100)",
    )
    parser.add_argument(
        "--contact-precision",
        type=bounded(1e-5, 1.0, "m"),
        metavar="M",
        help="how far contact shapes may bridge hollows, in metres (default: as the parts that are stored, drawn tight)",
    )
    parser.add_argument(
        "--welds", action=argparse.BooleanOptionalAction, default=False, help="fix what is gripped to the hand"
    )


def physics_of(options: argparse.Namespace) -> "rooms.PhysicsSettings":
    """The settings of physics that a command was given."""
    return rooms.PhysicsSettings(
        friction=options.friction,
        grip_force=options.grip_force,
        contact_precision=options.contact_precision,
        welds=options.welds,
    )


def run(options: argparse.Namespace) -> int:
    """Writes the model, and says what is in it; or serves its robots."""
    if options.serve:
        return _serve(options)
    with clean_standard_output():
        scene = rooms.load_scene(options.scene)
        model = rooms.physics_model(scene, physics_of(options))
    rooms.write_atomically(options.output, model.xml.encode())
    shapes, motors = rooms.counted(len(model.things), "shape"), rooms.counted(len(model.motors), "motor")
    answer(f"{options.output}: {shapes}, {motors}, {rooms.counted(len(scene.movable), 'movable thing')}")
    return exit_codes.DONE


def _serve(options: argparse.Namespace) -> int:
    """Is a robot server until Ctrl-C, SIGTERM or the limit of time."""
    with clean_standard_output():
        scene = rooms.load_scene(options.scene)
        robot, sensors = _served(options, scene)
        ended = threading.Event()
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: ended.set())
        settings = rooms.RobotServerSettings(options.silence, options.speed)
        config = service.server_config(endpoints_of(options), [], options.config)
        server = rooms.RobotServer(
            config, robot, scene, settings, lambda sentence: tell(f"kabo: {sentence}"), sensors
        )
        tell(f"kabo: {server.name} serves {', '.join(scene.robots)}; Ctrl-C ends it")
        options.surrounding.rest()
        left = options.surrounding.left(options.timeout)
        until = None if left is None else threading.Timer(left, ended.set)
        try:
            if until is not None:
                until.start()
            server.run(ended.is_set)
        finally:
            if until is not None:
                until.cancel()
            server.close()
    return exit_codes.DONE


def _served(options: argparse.Namespace, scene: "rooms.Scene") -> tuple[Any, "rooms.ServedSimulation | None"]:
    """The robot in a world where all is as the truth says, and its sensors, if there is a file of them."""
    sensors, hidden = truth_of(options, options.scene, None)
    start = rooms.true_start(scene, scene.start, hidden, options.seed)
    robot: Any
    if options.kinematic:
        robot = rooms.KinematicRobot(scene, start)
    else:
        robot = rooms.SimulatedRobot(scene, physics_of(options), start, masses=hidden.masses)
    if sensors is None:
        return robot, None
    instruments: Any
    if options.kinematic:
        instruments = rooms.KinematicInstruments(robot, hidden)
    else:
        instruments = rooms.PhysicsInstruments(robot, sensors)
    return robot, rooms.ServedSimulation(rooms.SimulatedSensors(sensors, instruments, hidden, options.seed))
