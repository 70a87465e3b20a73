"""`kabo motion`: plans one motion of a robot in a scene, without a domain, and writes it as a plan of one node."""

import argparse
import re
from collections.abc import Mapping
from dataclasses import replace
from math import inf, radians
from pathlib import Path
from types import MappingProxyType

from kabo.budgets import StopFlag
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, natural, output_file
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_options, has_scene
from kabo.cli.terminal import answer, clean_standard_output, complain, interruptible, print_json, tell
from kabo.errors import Diagnostic, InputError
from kabo.options import LARGEST_EPSILON, SMALLEST_EPSILON

LENGTHS = ("mm", "m")
# The options that give the arguments of `plan_motion`:
OPTION_OF = {"robot": "--robot", "start": "--from", "goal": "--to", "keep": "--keep", "holding": "--holding"}
NAME = "motion"
HELP = (
    "plan a motion of a robot from one configuration to another, as a plan for verify, view, picture and executors"
)
ENDS = "a configuration of the scene, `start`, or values of the planned joints: 0.1,-45deg,… or joint=0.1,…"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo motion` to the parser."""
    parser.add_argument("scene", type=Path, metavar="SCENE", help="a scene file, or a problem file with a scene")
    parser.add_argument("--robot", metavar="R", help="the robot that moves (default: the only one)")
    parser.add_argument("--from", dest="start", default="start", metavar="WHERE", help=f"{ENDS} (default: start)")
    parser.add_argument("--to", dest="goal", required=True, metavar="WHERE", help=ENDS)
    parser.add_argument("--keep", metavar="C", help="a motion constraint of the scene that holds throughout")
    parser.add_argument(
        "--holding", metavar="BODY", help="a movable body in the robot's hand, as it is placed to it in the scene"
    )
    accuracy = bounded(SMALLEST_EPSILON, LARGEST_EPSILON, "m")
    parser.add_argument(
        "--epsilon", type=accuracy, metavar="E", help="the accuracy in metres (default: the scene's)"
    )
    add_options(parser, NAME)
    parser.add_argument(
        "--seed", type=natural, default=0, metavar="N", help="the seed of all random samples (default: 0)"
    )
    parser.add_argument(
        "--samples", type=natural, metavar="N", help="samples before it gives up (default: 200000)"
    )
    parser.add_argument(
        "--certificate", action=argparse.BooleanOptionalAction, default=True, help="prove that the motion is free"
    )
    parser.add_argument("-o", dest="output", type=output_file, metavar="FILE", help="the plan file")
    parser.add_argument("--json", action="store_true", help="print the trajectory as one JSON object")
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda options: has_scene(options.scene))


def run(options: argparse.Namespace) -> int:
    """Writes the plan, and says how long the motion takes; the exit code is 4 if no way was found."""
    with clean_standard_output():
        scene = rooms.load_scene(options.scene)
        robot = options.robot or _only_robot(scene)
        slides = _slides(scene, robot)
        more = {} if options.samples is None else {"samples": options.samples}
        with interruptible() as stop:
            flag = StopFlag(options.surrounding.left(options.timeout) or inf, options.memory or inf, stop)
            try:
                found = rooms.find_motion(
                    scene,
                    robot,
                    where(options.start, "--from", slides),
                    where(options.goal, "--to", slides),
                    seed=options.seed,
                    keep=options.keep,
                    holding=options.holding,
                    epsilon=options.epsilon,
                    clearance=options.clearance or 0.0,
                    stop=flag,
                    **more,
                )
            except rooms.NoMotionError as error:
                complain(str(error))
                return exit_codes.NO_PLAN
            except InputError as error:
                told = (replace(each, file=OPTION_OF.get(each.file, each.file)) for each in error.diagnostics)
                raise InputError(told) from None
        if options.output is not None:
            found.plan(certificate=options.certificate).save(options.output)
    motion = found.trajectory
    if options.json:
        print_json(
            {
                "robot": robot,
                "joints": motion.joints,
                "waypoints": motion.waypoints,
                "times": motion.times,
                "coefficients": motion.coefficients,
                "deviation": motion.deviation,
                **({"clearance": found.clearance} if found.clearance else {}),
            }
        )
    else:
        kept = f", with a clearance of {1000 * found.clearance:g} mm" if found.clearance else ""
        points = rooms.counted(len(motion.waypoints), "way point")
        answer(f"{robot}: {motion.duration:.2f} s, {points}, proven free of collision{kept}")
        if options.output is not None:
            tell(f"{options.output}: the motion as a plan; kabo verify {options.scene} {options.output}")
    return exit_codes.DONE


def where(
    text: str, option: str, slides: Mapping[str, bool] = MappingProxyType({})
) -> str | list[float] | dict[str, float]:
    """An end of a motion as it is written: a name, values in the order of joints, or values by names of joints.

    Args:
        text: what is written. option: where.
        slides: whether each joint, in their order, has a length as its value; other joints take either unit.

    Raises:
        InputError: a value is no number, or has the unit of another kind of joint.
    """
    parts = [part.strip() for part in text.split(",")]
    if "=" in text:
        found: dict[str, float] = {}
        for name, equals, value in (part.partition("=") for part in parts):
            if not equals or not value.strip():
                message = f"{name.strip()!r} has no value"
                raise InputError([Diagnostic(option, 1, 1, message, "write joint=0.1,joint=-45deg,…")])
            if name.strip() in found:
                message = f"{name.strip()!r} is given twice"
                raise InputError([Diagnostic(option, 1, 1, message, "give each joint once")])
            found[name.strip()] = _value(value, option, name.strip(), slides)
        return found
    if len(parts) > 1 or re.match(r"[-+.\d]", text):
        names = [*slides, *[""] * len(parts)]
        return [_value(part, option, name, slides) for part, name in zip(parts, names, strict=False)]
    return text


def _value(text: str, option: str, joint: str, slides: Mapping[str, bool]) -> float:
    unit = next((each for each in ("deg", "rad", "mm", "m") if text.strip().endswith(each)), "")
    try:
        value = float(text.strip().removesuffix(unit))
    except ValueError:
        hint = "write numbers, as 0.1, -45deg, 20mm"
        raise InputError([Diagnostic(option, 1, 1, f"{text.strip()!r} is no value of a joint", hint)]) from None
    if unit and slides.get(joint, unit in LENGTHS) != (unit in LENGTHS):
        kinds = ("turns", "an angle, as -45deg") if unit in LENGTHS else ("slides", "a length, as 20mm")
        message = f"{joint!r} {kinds[0]}, and {text.strip()!r} is no value of it"
        raise InputError([Diagnostic(option, 1, 1, message, f"write {kinds[1]}")])
    return radians(value) if unit == "deg" else value / 1000.0 if unit == "mm" else value


def _slides(scene: "rooms.Scene", robot: str) -> dict[str, bool]:
    """Whether each joint of a robot slides, by its name; nothing of a robot that the scene does not have."""
    if robot not in scene.robots:
        return {}
    tree, names = scene.robots[robot].tree, scene.robots[robot].joint_names
    sliding = {
        int(tree.source[joint]) for joint in range(1, len(tree.kind)) if tree.kind[joint] == rooms.PRISMATIC
    }
    return {name: number in sliding for number, name in enumerate(names)}


def _only_robot(scene: "rooms.Scene") -> str:
    if len(scene.robots) == 1:
        return next(iter(scene.robots))
    hint = f"it has {', '.join(scene.robots) or 'none'}"
    raise InputError([Diagnostic("--robot", 1, 1, "say which robot of the scene moves", hint)])
