"""`kabo explore ask`: prints the parameters to try next, for trials that are made elsewhere, as by a robot."""

import argparse

from kabo.cli import exit_codes, rooms
from kabo.cli.explore.arguments import add_model, add_pairs, findings_of, pairs
from kabo.cli.explore.nothing import answer_nothing
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json

NAME = "ask"
HELP = "say which parameters to try next"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explore ask` to the parser."""
    add_model(parser)
    add_pairs(parser, "--case", "K=V", "the case to try; without it, one near the last with few trials")
    add_limits(parser)
    parser.add_argument("--json", action="store_true", help="print the answer as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the parameters to try next, and returns the exit code: 4 if there are none."""
    case = pairs(options.case, "--case") or None
    exploration = rooms.load_exploration(options.model)
    try:
        with findings_of("--case"):
            question = exploration.ask(case)
    except rooms.NoParametersError as error:
        return answer_nothing(options, "ask", error)
    if options.json:
        print_json(rooms.ask_answer(exploration, question))
    else:
        print(rooms.described_case(question.case))
        print(f"  try {rooms.described_values(question.parameters, exploration.space.units)}")
        print(f"  valid with a probability of {rooms.described_validity(question.validity)}")
    return exit_codes.DONE
