"""`kabo explain`: says why a problem has no plan, which changes would help, and which parts of it are useless."""

import argparse
from collections.abc import Mapping
from typing import Any

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural
from kabo.cli.limits import add_limits
from kabo.cli.solving import add_options, add_problem_argument, chosen_options, has_geometry
from kabo.cli.terminal import clean_standard_output, complain, interruptible, print_json

NAME = "explain"
HELP = "say why a problem has no plan, what one change would do, and what in it is of no use"

MAX_SAMPLES = 40_000  # as in kabo.explain: samples, if neither the command line nor the problem limits them
EXIT_CODES = {
    "solvable": exit_codes.DONE,
    "proved": exit_codes.PROVEN_NO_PLAN,
    "exhausted": exit_codes.NO_PLAN,
    "invalid": exit_codes.BAD_INPUT,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explain` to the parser."""
    add_problem_argument(parser)
    add_options(parser, NAME, max_samples=MAX_SAMPLES)
    parser.add_argument("--geometry", choices=("bounding", "none"), help="whether to look for motions, too")
    add_limits(parser, "60")
    parser.set_defaults(cut_off=_cut_off, needs_kernels=has_geometry)
    parser.add_argument(
        "--changes", type=natural, metavar="N", help="changes tried at most to see whether they help (default: 6)"
    )
    parser.add_argument("--json", action="store_true", help="print the explanation as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the explanation and returns an exit code with the same meaning as that of `kabo solve`."""
    given: dict[str, Any] = {**chosen_options(options)}
    given["geometry"] = options.geometry != "none"
    if options.changes is not None:
        given["changes"] = options.changes
    keep = _Keeping(options)
    try:
        with clean_standard_output(), interruptible() as stop:
            found, error = rooms.explain_file(
                options.problem,
                domain=options.domain,
                cancelled=stop,
                progress=options.surrounding.planning,
                known=keep,
                **given,
            )
    except KeyboardInterrupt:
        return _cut_off(options, "time", "interrupted by the user", keep.known)
    if error is not None:
        complain(str(error))
    if options.json:
        print_json(rooms.explanation_to_json(found))
    elif found.verdict != "invalid":
        print(found)
    return EXIT_CODES[found.verdict]


class _Keeping:
    """Keeps what is known of an explanation, here and for a parent process: the work may be ended by force."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._keep = options.surrounding.on_known
        self.known: tuple[Mapping[str, Any], str] | None = None

    def __call__(self, found: "rooms.Explanation") -> None:
        self.known = rooms.explanation_to_json(found), str(found)
        self._keep(*self.known)


def _cut_off(
    options: argparse.Namespace, spent: str, message: str, known: tuple[Mapping[str, Any], str] | None
) -> int:
    """Reports what was known when the command was ended by force, and returns the exit code."""
    if known is None:
        said = f"Nothing is explained: {message}."
        known = rooms.explanation_to_json(rooms.Explanation("exhausted", (said,))), said
    elif options.json:
        body, text = known
        known = {**body, "unfinished": [*body.get("unfinished", ()), message]}, text
    else:
        known = known[0], f"{known[1]}\n  - {message}"
    if options.json:
        print_json(known[0])
    else:
        print(known[1])
    return exit_codes.NO_PLAN
