"""`kabo task show`: the structure of a task file, or what planning it found, as text or as a page."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from kabo.cli import exit_codes
from kabo.cli.own_stages import add_stages_argument
from kabo.cli.solving import natural, output_file
from kabo.cli.task_plan import read_task_file
from kabo.cli.terminal import clean_standard_output, print_json, tell
from kabo.errors import Diagnostic, InputError

if TYPE_CHECKING:
    from kabo.tasks.files.building import TaskFile

NAME = "show"
HELP = "show the stages of a task file, or what planning found (a report of `kabo task plan -o`)"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of `kabo task show`."""
    parser.add_argument("file", type=Path, metavar="FILE", help="a task file, or a report (.json)")
    parser.add_argument(
        "--comments", type=natural, default=3, metavar="N", help="of each stage at most (default: 3)"
    )
    parser.add_argument("--html", type=output_file, metavar="OUT", help="write a page that needs no other file")
    add_stages_argument(parser)
    parser.add_argument("--json", action="store_true", help="print it as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the tree; bad input is told with its place, and a structure that does not fit together as well."""
    if options.file.suffix.lower() == ".json":
        return _show_report(options)
    if options.html is not None:
        message = "a page shows what planning found"
        hint = f"kabo task plan {options.file} -o report.json, then kabo task show report.json --html …"
        raise InputError([Diagnostic(str(options.file), 1, 1, message, hint)])
    return _show_structure(options)


def _show_report(options: argparse.Namespace) -> int:
    from kabo.plan import write_atomically
    from kabo.tasks.files.describing import counted, describe_report
    from kabo.tasks.files.html import to_html
    from kabo.tasks.files.report_form import read_report

    found = read_report(options.file.read_bytes(), str(options.file))
    if options.html is not None:
        write_atomically(options.html, to_html(found).encode())
    if options.json:
        print_json(found)
    elif options.html is None:
        print(describe_report(found, options.comments))
    else:
        tell(f"{options.html}: {counted(len(found['stages']), 'stage')}, {counted(len(found['runs']), 'run')}")
    return exit_codes.DONE


def _show_structure(options: argparse.Namespace) -> int:
    from kabo.tasks.core import InitialisationError, directions, tree
    from kabo.tasks.files.reports import structure

    with clean_standard_output():
        file = read_task_file(options)
        task = file.task(partly=True)
        flows, errors = directions(task)
    if options.json:
        print_json({**structure(file, task, flows), "errors": errors})
    else:
        print(describe_inputs(file))
        print(tree(task, flows))
    if errors:
        error = file.located(InitialisationError(errors, tree(task, flows)))
        if not options.json:
            tell(str(error))
        return exit_codes.BAD_INPUT
    return exit_codes.DONE


def describe_inputs(file: "TaskFile") -> str:
    """The task's signature, and how much it asks for: `pick(robot, object, grasp = any); 1 solution`."""
    from kabo.tasks.core import shown
    from kabo.tasks.files.building import default_of

    given = (each.name if each.required else f"{each.name} = {shown(default_of(each))}" for each in file.inputs)
    limits = []
    if file.max_solutions is not None:
        limits.append(f"{file.max_solutions} solution{'' if file.max_solutions == 1 else 's'}")
    if file.timeout is not None:
        limits.append(f"{file.timeout:g} s")
    return f"{file.name}({', '.join(given)})" + (f"; at most {', '.join(limits)}" if limits else "")
