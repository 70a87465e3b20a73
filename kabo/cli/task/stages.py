"""`kabo task stages`: the stages that task files may name, and the properties of each."""

import argparse

from kabo.cli import exit_codes, rooms
from kabo.cli.limits import add_limits
from kabo.cli.own_code import add_stages_argument, execute
from kabo.cli.terminal import clean_standard_output, print_json
from kabo.errors import Diagnostic, InputError

NAME = "stages"
HELP = "list the stages that task files may name, or the properties of one"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo task stages` to the parser."""
    parser.add_argument("name", nargs="?", metavar="NAME", help="the stage whose properties are shown")
    add_stages_argument(parser)
    parser.add_argument("--json", action="store_true", help="print them as one JSON object")
    add_limits(parser)


def run(options: argparse.Namespace) -> int:
    """Prints all stages, or the properties of the chosen stage, and returns the exit code."""
    from kabo.tasks.files import registry

    with clean_standard_output():
        execute(options.stages)
        wanted = registry.names() if options.name is None else [options.name]
        kinds = {name: registry.find(name) for name in wanted}
    for name, kind in kinds.items():
        if kind is None:
            raise InputError([Diagnostic("NAME", 1, 1, f'unknown stage "{name}"', registry.near(name))])
    pages = {name: rooms.stage_page(kind) for name, kind in kinds.items() if kind is not None}
    if options.json:
        print_json({"stages": pages})
    elif options.name is not None:
        print(rooms.describe_stage(options.name, pages[options.name]))
    else:
        width = max(map(len, pages))
        print("\n".join(f"{name:<{width}}  {page['does']}" for name, page in pages.items()))
    return exit_codes.DONE
