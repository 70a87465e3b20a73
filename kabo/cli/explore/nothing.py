"""The answer of `ask` and `infer` where there are no parameters to offer."""

import argparse
from typing import Literal

from kabo.cli import exit_codes, rooms
from kabo.cli.terminal import answer, print_json


def answer_nothing(
    options: argparse.Namespace, command: Literal["ask", "infer"], error: "rooms.NoParametersError"
) -> int:
    """Prints why there are no parameters, and with --json the nearest ones, and returns the exit code 4."""
    answer(f"{options.model}: {error}")
    if options.json:
        print_json(rooms.nothing_answer(command, error))
    return exit_codes.NO_PLAN
