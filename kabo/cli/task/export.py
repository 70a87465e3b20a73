"""`kabo task export`: makes a plan of one solution of a task, for `kabo verify`, `kabo view`, `kabo picture`, executors."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import output_file, whole
from kabo.cli.limits import add_limits
from kabo.cli.terminal import clean_standard_output, tell, warn

NAME = "export"
HELP = "make a plan of one node of a solution in a report, with what grants its contacts and proves it free"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo task export` to the parser."""
    parser.add_argument("report", type=Path, metavar="REPORT", help="a report of `kabo task plan -o`")
    parser.add_argument(
        "--solution",
        type=whole(1),
        metavar="N",
        help="which solution, as the report counts them (default: the cheapest)",
    )
    parser.add_argument(
        "--scene", type=Path, metavar="FILE", help="the scene of the report (default: as it names it)"
    )
    parser.add_argument(
        "--certificate", action=argparse.BooleanOptionalAction, default=True, help="prove that the motion is free"
    )
    parser.add_argument(
        "-o",
        dest="output",
        type=output_file,
        default=Path("plan.json"),
        metavar="FILE",
        help="the plan file (default: plan.json)",
    )
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda _: True)


def run(options: argparse.Namespace) -> int:
    """Writes the plan, and says which solution it is."""
    with clean_standard_output():
        number, plan, _, unknown = rooms.plan_of_report(
            options.report, options.scene, options.solution, certificate=options.certificate
        )
        plan.save(options.output)
    motion = plan.nodes[plan.root].motion
    seconds = max(segment.times[-1] for segment in motion)
    proven = "certified" if plan.certificate else "without a certificate"
    what = f"solution {number}, {rooms.counted(len(motion), 'segment')}, {seconds:.2f} s, {proven}"
    tell(f"{options.output}: {what}; kabo verify SCENE {options.output}")
    if unknown is not None:
        warn(f"{options.output}: {unknown}")
    return exit_codes.DONE
