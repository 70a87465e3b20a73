"""`kabo task show`: the structure of a task file, or what planning it found, as text or as a page."""

import argparse
from pathlib import Path

from kabo import plan, tasks
from kabo.cli import exit_codes
from kabo.cli.own_stages import add_stages_argument
from kabo.cli.solving import natural, output_file
from kabo.cli.task_plan import read_task_file
from kabo.cli.terminal import clean_standard_output, print_json, tell
from kabo.errors import Diagnostic, InputError
from kabo.tasks import files

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
    found = files.read_report(options.file.read_bytes(), str(options.file))
    if options.html is not None:
        plan.write_atomically(options.html, files.to_html(found).encode())
    if options.json:
        print_json(found)
    elif options.html is None:
        print(files.describe_report(found, options.comments))
    else:
        tell(
            f"{options.html}: {files.counted(len(found['stages']), 'stage')}, {files.counted(len(found['runs']), 'run')}"
        )
    return exit_codes.DONE


def _show_structure(options: argparse.Namespace) -> int:
    with clean_standard_output():
        file = read_task_file(options)
        task = file.task(partly=True)
        flows, errors = tasks.directions(task)
    if options.json:
        print_json({**files.structure(file, task, flows), "errors": errors})
    else:
        print(describe_inputs(file))
        print(tasks.tree(task, flows))
    if errors:
        error = file.told(tasks.InitialisationError(errors, tasks.tree(task, flows)))
        if not options.json:
            tell(str(error))
        return exit_codes.BAD_INPUT
    return exit_codes.DONE


def describe_inputs(file: "files.TaskFile") -> str:
    """The task's signature, and how much it asks for: `pick(robot, object, grasp = any); 1 solution`."""
    given = (
        each.name if each.required else f"{each.name} = {tasks.shown(files.default_of(each))}"
        for each in file.inputs
    )
    limits = []
    if file.max_solutions is not None:
        limits.append(f"{file.max_solutions} solution{'' if file.max_solutions == 1 else 's'}")
    if file.timeout is not None:
        limits.append(f"{file.timeout:g} s")
    return f"{file.name}({', '.join(given)})" + (f"; at most {', '.join(limits)}" if limits else "")
