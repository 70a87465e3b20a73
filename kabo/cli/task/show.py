"""`kabo task show`: shows the structure of a task file, or the results in a report, as text or as an HTML page."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural, output_file
from kabo.cli.limits import add_limits
from kabo.cli.own_code import add_stages_argument
from kabo.cli.task.plan import read_task_file
from kabo.cli.terminal import clean_standard_output, complain, print_json, tell
from kabo.errors import Diagnostic, InputError

NAME = "show"
HELP = "show the stages of a task file, or what planning found (a report of `kabo task plan -o`)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo task show` to the parser."""
    parser.add_argument("file", type=Path, metavar="FILE", help="a task file, or a report (.json)")
    parser.add_argument(
        "--comments",
        type=natural,
        default=3,
        metavar="N",
        help="show at most N comments of each stage (default: 3)",
    )
    parser.add_argument("--html", type=output_file, metavar="OUT", help="write the page of `kabo view`")
    add_stages_argument(parser)
    parser.add_argument("--json", action="store_true", help="print it as one JSON object")
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Prints the structure of a task file, and its stages that do not fit, or the results of a JSON report."""
    if options.file.suffix.lower() == ".json":
        return _show_report(options)
    if options.html is not None:
        message = "a page shows what planning found"
        hint = f"kabo task plan {options.file} -o report.json, then kabo task show report.json --html …"
        raise InputError([Diagnostic(str(options.file), 1, 1, message, hint)])
    return _show_structure(options)


def _show_report(options: argparse.Namespace) -> int:

    found = rooms.read_report(options.file.read_bytes(), str(options.file))
    if options.html is not None:
        rooms.write_atomically(options.html, rooms.page_of(rooms.document_of_file(options.file)))
    if options.json:
        print_json(found)
    elif options.html is None:
        print(rooms.describe_report(found, options.comments))
    else:
        tell(
            f"{options.html}: {rooms.counted(len(found['stages']), 'stage')}, {rooms.counted(len(found['runs']), 'run')}"
        )
    return exit_codes.DONE


def _show_structure(options: argparse.Namespace) -> int:

    with clean_standard_output():
        file = read_task_file(options)
        task = file.task(partly=True)
        flows, errors = rooms.directions(task)
    if options.json:
        print_json({**rooms.structure(file, task, flows), "errors": errors})
    else:
        print(describe_inputs(file))
        print(rooms.tree(task, flows))
    if errors:
        error = file.located(rooms.InitialisationError(errors, rooms.tree(task, flows)))
        if not options.json:
            complain(str(error))
        return exit_codes.BAD_INPUT
    return exit_codes.DONE


def describe_inputs(file: "rooms.TaskFile") -> str:
    """The task's signature and limits as text, such as `pick(robot, object, grasp = any); 1 solution`."""
    given = (
        each.name if each.required else f"{each.name} = {rooms.shown(rooms.default_of(each))}"
        for each in file.inputs
    )
    limits = []
    if file.max_solutions is not None:
        limits.append(f"{file.max_solutions} solution{'' if file.max_solutions == 1 else 's'}")
    if file.timeout is not None:
        limits.append(f"{file.timeout:g} s")
    return f"{file.name}({', '.join(given)})" + (f"; at most {', '.join(limits)}" if limits else "")
