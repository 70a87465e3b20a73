"""`kabo check`: reports everything that is wrong in files of any kind, all at once."""

import argparse
from pathlib import Path

from kabo.cli import exit_codes, rooms
from kabo.cli.limits import add_limits
from kabo.cli.solving import has_scene
from kabo.cli.terminal import answer, clean_standard_output, print_json

NAME = "check"
HELP = "report all errors in files of any kind, with their places and remedies"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo check` to the parser."""
    parser.add_argument(
        "files",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="domain, problem, scene, task or exploration files, or models (.jsonl)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as one JSON object")
    add_limits(parser)
    parser.set_defaults(needs_kernels=lambda options: any(map(has_scene, options.files)))


def run(options: argparse.Namespace) -> int:
    """Prints every finding and returns the exit code: 2 if at least one finding is an error."""
    with clean_standard_output():
        found = rooms.check_files(options.files, options.surrounding.preparing)
    errors = sum(finding.severity == "error" for finding in found)
    if options.json:
        print_json({"valid": errors == 0, "diagnostics": [rooms.diagnostic_to_json(finding) for finding in found]})
    else:
        for finding in found:
            answer(str(finding))
        counts = (_count(errors, "error"), _count(len(found) - errors, "warning"))
        answer(f"{_count(len(options.files), 'file')}: {', '.join(counts)}")
    return exit_codes.BAD_INPUT if errors else exit_codes.DONE


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"
