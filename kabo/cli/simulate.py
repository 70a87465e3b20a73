"""`kabo simulate`: writes a scene as a model of physics, in MuJoCo's format."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file
from kabo.cli.limits import add_limits
from kabo.cli.terminal import answer, clean_standard_output

NAME = "simulate"
HELP = "write a scene as a model of physics (MJCF): joints, masses, contacts, motors, grippers"


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
    add_physics(parser)
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda _: True)


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
    """Writes the model, and says what is in it."""
    with clean_standard_output():
        scene = rooms.load_scene(options.scene)
        model = rooms.physics_model(scene, physics_of(options))
    rooms.write_atomically(options.output, model.xml.encode())
    shapes, motors = rooms.counted(len(model.things), "shape"), rooms.counted(len(model.motors), "motor")
    answer(f"{options.output}: {shapes}, {motors}, {rooms.counted(len(scene.movable), 'movable thing')}")
    return exit_codes.DONE
