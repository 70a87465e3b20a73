"""`kabo task plan`: plans the task of a file, once or with several seeds, and reports what each stage found."""

import argparse
from math import inf
from pathlib import Path
from typing import Any

from kabo.budgets import StopFlag
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural, output_file
from kabo.cli.limits import add_limits
from kabo.cli.own_code import add_stages_argument, blamed, execute
from kabo.cli.solving import add_options
from kabo.cli.terminal import clean_standard_output, interruptible, print_json, tell, warn
from kabo.errors import Diagnostic, InputError, did_you_mean

NAME = "plan"
# Kept of --timeout for making and writing the report: as a share, and at most [s]. A killed command writes nothing.
REPORT_SHARE, MOST_FOR_REPORT_S = 0.1, 2.0
HELP = "plan the task of a file, and report what each stage found"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo task plan` to the parser."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the task file")
    parser.add_argument("--scene", type=Path, metavar="FILE", help="a scene file, or a problem file with a scene")
    parser.add_argument(
        "--set",
        dest="given",
        nargs="+",
        action="extend",
        default=[],
        metavar="NAME=VALUE",
        help="values of the properties that the task declares",
    )
    parser.add_argument(
        "--max-solutions", type=natural, metavar="N", help="stop after N solutions (default: the file's, else all)"
    )
    parser.add_argument(
        "--seed", type=natural, default=0, metavar="N", help="the seed of all random samples (default: 0)"
    )
    parser.add_argument(
        "--repeat",
        type=natural,
        default=1,
        metavar="N",
        help="number of runs, with the seeds from --seed on (default: 1)",
    )
    parser.add_argument(
        "--workers", type=natural, metavar="N", help="processes; solutions do not depend on their number"
    )
    parser.add_argument(
        "--from",
        dest="known",
        type=Path,
        metavar="REPORT",
        help="try the solutions of a report first, proven anew in this scene",
    )
    add_options(parser, f"task {NAME}")
    add_stages_argument(parser)
    add_limits(parser, "the file's, for each run, else none")
    parser.set_defaults(needs_kernels=lambda options: options.scene is not None, cut_off=_cut_off)
    parser.add_argument("-o", dest="output", type=output_file, metavar="FILE", help="the report, as JSON")
    parser.add_argument("--json", action="store_true", help="print the report as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Plans the task, writes and prints the report, and returns the exit code: 4 if no run found a solution."""
    with clean_standard_output():
        file = read_task_file(options)
        arguments = given_arguments(file, options.given)
        scene = _scene(file, arguments, options.scene)
        if options.clearance and scene is None:
            hint = "add the scene after the task file"
            raise InputError([Diagnostic("--clearance", 1, 1, "without a scene nothing has a distance", hint)])
        with interruptible() as stop:
            flag = StopFlag(options.surrounding.left(options.timeout) or inf, options.memory or inf, stop)
            flag.reserve = min(REPORT_SHARE * (options.timeout or 0.0), MOST_FOR_REPORT_S)
            settings = rooms.PlanningOptions(
                options.max_solutions or file.max_solutions,
                file.timeout if options.timeout is None else None,
                options.seed,
                max(1, options.repeat),
                options.workers or None,
                rooms.known_solutions(options.known),
                options.clearance or 0.0,
                flag,
                options.surrounding.preparing,
            )
            with blamed(options.stages):
                runs = rooms.plan_file(file, arguments, scene, settings)
        for why in (each for one in runs for each in one.left_out):
            tell(f"{options.known}, {why}")
        kept = options.clearance or 0.0
        given = None if options.scene is None else str(options.scene)
        made = rooms.report(
            runs, file=str(options.file), arguments=arguments, scene=scene, scene_file=given, clearance=kept
        )
        if options.output is not None:
            rooms.write_atomically(options.output, rooms.report_bytes(made))
    code = exit_codes.DONE if any(one.found for one in runs) else exit_codes.NO_PLAN
    if options.output is not None:
        options.surrounding.on_known({"exit_code": code}, str(options.output))
    if options.json:
        print_json(made)
    else:
        print(rooms.describe_report(made))
        if options.output is not None:
            tell(_written(options.output))
    return code


def _written(output: Path | str) -> str:
    return f"{output}: the report; kabo task show {output}"


def _cut_off(
    options: argparse.Namespace, spent: str, message: str, known: tuple[dict[str, Any], str] | None
) -> int | None:
    """The exit code of a command that was ended by force after its report was written, which is told; else None."""
    if known is None or options.json:
        return None
    tell(_written(known[1]))
    return int(known[0]["exit_code"])


def read_task_file(options: argparse.Namespace) -> "rooms.TaskFile":
    """The task file, read after the files with user-defined stages; prints its warnings.

    Raises:
        InputError: the task file has errors, all of which are listed; or a file with stages cannot be executed.
    """
    execute(options.stages)
    file = rooms.load_task_file(options.file)
    if not options.json:
        for warning in file.warnings:
            warn(str(warning))
    return file


def given_arguments(file: "rooms.TaskFile", given: list[str]) -> dict[str, Any]:
    """The values given by `--set name=value`, converted to the types that the task declares.

    Raises:
        InputError: properties are unknown, or values are of the wrong type; the message lists all of them.
    """
    declared = {each.name: each for each in file.inputs}
    values: dict[str, Any] = {}
    found = []
    for text in given:
        name, sign, value = text.partition("=")
        hint = None
        if not sign:
            problem, hint = "write --set name=value", None
        elif name not in declared:
            problem = f'the task "{file.name}" has no property "{name}"'
            hint = did_you_mean(name, declared) or f"it has {', '.join(declared) or 'none'}"
        elif name in values:
            problem = f'"{name}" is given twice'
        else:
            try:
                values[name] = rooms.argument_of(declared[name], value)
                continue
            except rooms.NoValue as error:
                problem = f'"{name}" must be {error}, this is "{value}"'
        found.append(Diagnostic("--set", 1, 1, problem, hint, len(text), "error", text))
    if found:
        raise InputError(found)
    return values


def _scene(file: "rooms.TaskFile", arguments: dict[str, Any], path: Path | None) -> "rooms.Scene | None":

    if path is None:
        if rooms.needs_scene(file):
            place = file.recipe.place
            message = f'the task "{file.name}" moves robots and needs a scene'
            raise InputError(
                [Diagnostic(place.file, place.line, place.column, message, "--scene FILE", place.length)]
            )
        return None

    description = rooms.load_scene_description(path)
    rooms.check_things(file, arguments, description)
    return rooms.load_scene(description)
