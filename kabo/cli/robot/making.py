"""Arguments and output of `kabo robot`: a scene file with the robot, a summary, a picture."""

import argparse
import math
from pathlib import Path
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file
from kabo.cli.limits import add_limits
from kabo.cli.mesh.meshing import picture_file
from kabo.cli.terminal import clean_standard_output, print_json, tell
from kabo.options import LARGEST_EPSILON, SMALLEST_EPSILON

NAME = "robot"
HELP = "make the entry of a robot for scenes: joints, tool, gripper, a free home, links that always touch"
DEFAULT_EPSILON = 0.01  # [m]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo robot` to the parser."""
    parser.add_argument(
        "urdf", metavar="URDF", help="a URDF or xacro file; package://NAME/… of an installed package"
    )
    parser.add_argument("--srdf", metavar="FILE", help="its SRDF file: disabled pairs, groups, states")
    parser.add_argument("--name", metavar="NAME", help="the name of the robot (default: that in the URDF)")
    parser.add_argument(
        "--tip", metavar="LINK", help="the last link of the arm to plan for (default: the longest)"
    )
    parser.add_argument("--group", metavar="NAME", help="the group of the SRDF whose joints are planned")
    parser.add_argument(
        "--epsilon",
        type=bounded(SMALLEST_EPSILON, LARGEST_EPSILON, "m"),
        default=DEFAULT_EPSILON,
        metavar="E",
        help="the accuracy in metres (default: 0.01)",
    )
    parser.add_argument("--picture", type=picture_file, metavar="PNG", help="draw the robot at home (PNG)")
    parser.add_argument(
        "-o", dest="output", type=output_file, metavar="FILE", help="the scene file to write (YAML)"
    )
    parser.add_argument("--json", action="store_true", help="print what was found as one JSON object")
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda options: True)


def run(options: argparse.Namespace) -> int:
    """Writes the scene file, or prints it, and says what was found."""
    urdf = rooms.existing_file(options.urdf, "URDF")
    srdf = None if options.srdf is None else rooms.existing_file(options.srdf, "--srdf")
    with clean_standard_output():
        name = rooms.robot_name(options.name, urdf, "--name")
        wishes = rooms.Wishes(options.tip, options.group)
        model = rooms.make_robot_model(
            urdf, srdf, name=name, epsilon=options.epsilon, wishes=wishes, told=options.surrounding.preparing
        )
        text = rooms.robot_scene_text(model, None if options.output is None else options.output.parent)
        if options.output is not None:
            rooms.write_atomically(options.output, text.encode())
        if options.picture is not None:  # last: the scene is written even if pictures cannot be drawn
            rooms.require_pictures("--picture")
            rooms.write_atomically(options.picture, rooms.robot_picture(model))
    if options.json:
        print_json(_figures(model, options.output))
    elif options.output is None:
        print(text, end="")
    for line in rooms.robot_summary(model):
        tell(line)
    return exit_codes.DONE


def _figures(model: "rooms.RobotModel", output: Path | None) -> dict[str, Any]:
    gripper, home = model.gripper, model.home
    opening = None if gripper is None or gripper.opening is None else list(gripper.opening)
    return {
        "robot": model.name,
        "output": None if output is None else str(output),
        "joints": list(model.hand.arm),
        "gripper_joints": list(model.hand.joints),
        "tool": model.hand.tool,
        "opening": opening,
        "home": None if home is None else home[: model.robot.planned].tolist(),
        "margin": model.margin if math.isfinite(model.margin) else None,
        "always_touching": [[pair.first, pair.second, pair.depth] for pair in model.always],
        "hulls": dict(model.hulls),
        "visual": list(model.visual),
    }
