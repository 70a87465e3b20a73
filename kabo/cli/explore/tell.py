"""`kabo explore tell`: adds a trial that was made elsewhere, as by a robot, to a model."""

import argparse

from kabo.cli import exit_codes, rooms
from kabo.cli.explore.arguments import add_model, add_pairs, findings_of, numbers, pairs
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json, tell

NAME = "tell"
HELP = "add a trial that was made elsewhere: what was tried, whether it was valid, and its outcomes"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explore tell` to the parser."""
    add_model(parser)
    add_pairs(parser, "--case", "K=V", "the case that was tried, all its variables")
    add_pairs(parser, "--set", "P=X", "the parameters that were tried, all of them", needed=True)
    valid = parser.add_mutually_exclusive_group(required=True)
    valid.add_argument("--valid", dest="valid", action="store_true", help="the trial was valid")
    valid.add_argument("--invalid", dest="valid", action="store_false", help="the trial was not valid")
    add_pairs(parser, "--outcome", "O=X", "the outcomes of a valid trial, all of them")
    parser.add_argument("--reason", default="", metavar="R", help="why a trial was invalid, in a word")
    add_limits(parser)
    parser.add_argument("--json", action="store_true", help="print the trial as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Appends the trial to the model, prints it, and returns the exit code."""
    case, parameters = pairs(options.case, "--case"), numbers(options.set, "--set")
    outcomes = numbers(options.outcome, "--outcome")
    exploration = rooms.load_exploration(options.model)
    with findings_of("--case"):
        case = exploration.space.case(case)
    with findings_of("--set"):
        parameters = exploration.space.checked(parameters)
    with findings_of("--outcome" if options.valid else "--invalid"):
        exploration.checked_trial(case, parameters, options.valid, outcomes, options.reason)
    journal = rooms.Journal.resume(options.model)
    trial = journal.tell(case, parameters, options.valid, outcomes, options.reason)
    if options.json:
        print_json(rooms.tell_answer(journal.exploration, trial))
    else:
        tell(f"{options.model}: {rooms.counted(len(journal.exploration.trials), 'trial')}")
    return exit_codes.DONE
