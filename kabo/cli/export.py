"""`kabo export`: writes a plan in the format of another executor or reader, or checks such a file against its plan."""

import argparse
from pathlib import Path
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file, whole
from kabo.cli.limits import add_limits
from kabo.cli.terminal import answer, clean_standard_output, tell
from kabo.errors import Diagnostic, InputError

NAME = "export"
HELP = "write a plan for other executors: BehaviorTree.CPP, py_trees, ROS 2, URScript, CSV; or as a graph"
FORMATS = ("bt", "py_trees", "trajectory", "moveit", "dot", "mermaid", "csv", "urscript", "up")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo export` to the parser."""
    parser.add_argument("plan", type=Path, metavar="PLAN", help="the plan file")
    parser.add_argument("--to", required=True, metavar="FORMAT", help=f"the format: {', '.join(FORMATS)}")
    parser.add_argument(
        "-o", dest="output", type=output_file, metavar="FILE", help="the file (default: standard output)"
    )
    parser.add_argument(
        "--branch",
        metavar="OUTCOMES",
        help="outcomes separated by commas: the branch, for formats that hold one (trajectory, moveit, csv, urscript)",
    )
    parser.add_argument(
        "--problem", type=Path, metavar="FILE", help="of up: the problem of the plan, which is written, too"
    )
    parser.add_argument("--node", metavar="N", help="in place of a branch, the motion of one node")
    parser.add_argument("--robot", metavar="R", help="the only robot whose motion is exported")
    parser.add_argument(
        "--rate",
        type=bounded(1e-3, 1e4, "Hz"),
        metavar="HZ",
        help="points or setpoints a second (default: csv 100, urscript 500; trajectory and moveit: where pieces end)",
    )
    parser.add_argument(
        "--way-points", action="store_true", help="of urscript: movej from way point to way point, not servoj"
    )
    parser.add_argument(
        "--cdr", action="store_true", help="of trajectory and moveit: one message as the bytes that DDS sends"
    )
    parser.add_argument(
        "--message",
        type=whole(1),
        metavar="K",
        help="with --cdr: which of several messages, from 1 on in their order",
    )
    parser.add_argument(
        "--check",
        type=Path,
        metavar="FILE",
        help="write nothing; compare a file of this format, exported with the same options, with the plan",
    )
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Writes the file, or compares one; the exit code is 5 if it says something else than the plan."""
    file = str(options.plan)
    with clean_standard_output():
        plan = rooms.load_plan(options.plan)
        chosen: dict[str, Any] = {
            "branch": options.branch,
            "node": options.node,
            "robot": options.robot,
            "rate": options.rate,
            "file": file,
        }
        if options.to == "up":
            content = _with_problem(options, plan).encode()
        elif options.problem is not None:
            raise _refusal("--problem", "only up needs the problem of the plan", "leave it out")
        elif options.message is not None and not options.cdr:
            raise _refusal("--message", "it chooses one of several messages as bytes", "--cdr, or leave it out")
        elif options.cdr:
            content = _one_message(options, plan, chosen)
        elif options.check is None:
            content = rooms.export(plan, options.to, way_points=options.way_points, **chosen).encode()
        else:
            return _checked(options, plan, chosen)
    if options.output is None:
        if options.cdr:
            raise _refusal("--cdr", "bytes are not printed", "name a file: -o message.cdr")
        print(content.decode(), end="")
    else:
        rooms.write_atomically(options.output, content)
        tell(f"{options.output}: {options.to}, {len(content) / 1000:.1f} kB")
    return exit_codes.DONE


def _with_problem(options: argparse.Namespace, plan: "rooms.Plan") -> str:
    """The plan and its problem as source for unified-planning.

    Raises:
        InputError: the problem is not given or another one, or an option is of other formats.
    """
    others = ("branch", "node", "robot", "rate", "way_points", "cdr", "message", "check")
    given = next((name for name in others if getattr(options, name)), None)
    if given is not None:
        raise _refusal(f"--{given.replace('_', '-')}", "up has the whole plan and no motions", "leave it out")
    if options.problem is None:
        raise _refusal(
            "--problem", "it is missing: up writes the problem, too", "--problem FILE, of which the plan is"
        )
    return rooms.export_up(rooms.load_problem(options.problem), plan)


def _one_message(options: argparse.Namespace, plan: "rooms.Plan", chosen: dict[str, Any]) -> bytes:
    """The bytes of the only message, or of that which is chosen.

    Raises:
        InputError: the format has no such bytes, or there is no such message, or there are several and none is chosen.
    """
    if options.to not in ("trajectory", "moveit") or options.way_points or options.check is not None:
        raise _refusal("--cdr", "it is of trajectory and moveit, to write a file", "leave it out")
    messages = rooms.ros_trajectories(plan, options.to, **chosen)
    if not messages:
        raise _refusal("--cdr", "nothing moves, so there is no message", "leave it out")
    if options.message is None and len(messages) > 1:
        hint = f"--message 1 to {len(messages)} chooses one, and --node and --robot choose fewer"
        raise _refusal("--cdr", f"{len(messages)} messages, and a file holds the bytes of one", hint)
    number = options.message or 1
    if number > len(messages):
        raise _refusal("--message", f"{number} is beyond the last one", f"1 to {len(messages)}")
    return messages[number - 1].to_cdr()


def _checked(options: argparse.Namespace, plan: "rooms.Plan", chosen: dict[str, Any]) -> int:
    try:
        text = options.check.read_bytes().decode()
    except UnicodeDecodeError:
        answer(f"{options.check}: it is no text in UTF-8")
        return exit_codes.VERIFICATION_FAILED
    found = rooms.check_export(plan, options.to, text, way_points=options.way_points, **chosen)
    if found is not None:
        answer(f"{options.check} is not {options.plan} as {options.to}: {found}")
        return exit_codes.VERIFICATION_FAILED
    answer(f"{options.check} says what {options.plan} says")
    return exit_codes.DONE


def _refusal(option: str, message: str, hint: str) -> InputError:
    return InputError([Diagnostic(option, 1, 1, message, hint)])
