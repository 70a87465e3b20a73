"""`kabo explore infer`: gives the parameters that are expected to have a wanted outcome."""

import argparse
from typing import Literal

from kabo.cli import exit_codes, rooms
from kabo.cli.explore.arguments import add_model, add_pairs, finding, findings_of, number, numbers, pairs
from kabo.cli.explore.nothing import answer_nothing
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json
from kabo.errors import InputError
from kabo.exploration import INFERRED_ALPHA

NAME = "infer"
HELP = "give the parameters that are expected to have a wanted outcome"
EXTREMES: dict[str, Literal["least", "most"]] = {"least": "least", "most": "most"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explore infer` to the parser."""
    add_model(parser)
    add_pairs(parser, "--target", "O=X", "the wanted outcomes; X is a number, least or most", needed=True)
    add_pairs(parser, "--where", "K=V", "variables of the case; without them, all cases are asked")
    parser.add_argument(
        "--alpha",
        default=str(INFERRED_ALPHA),
        metavar="A",
        help=f"the probability of being valid must be greater (default: {INFERRED_ALPHA})",
    )
    parser.add_argument(
        "--tolerance",
        nargs="+",
        metavar="T",
        help="how far off the expected outcome may be: T for each, or O=T …; none: however far "
        "(default: twice the standard deviation there)",
    )
    add_limits(parser)
    parser.add_argument("--json", action="store_true", help="print the answer as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Prints the parameters, and returns the exit code: 4 if there are none, or none near enough."""
    target, where = _target(options.target), pairs(options.where, "--where")
    alpha, tolerance = number(options.alpha), _tolerance(options.tolerance)
    if alpha is None or not 0.0 < alpha < 1.0:
        raise InputError([finding("--alpha", "write a probability above 0 and below 1", options.alpha)])
    exploration = rooms.load_exploration(options.model)
    with findings_of("--where"):
        exploration.space.matching(where)
    with findings_of("--target"):
        exploration.checked_target(target)
    try:
        with findings_of("--tolerance"):
            found = exploration.infer(target, where, alpha, tolerance)
    except rooms.NoParametersError as error:
        return answer_nothing(options, "infer", error)
    if options.json:
        print_json(rooms.infer_answer(found))
        return exit_codes.DONE
    print(rooms.described_case(found.case))
    print(f"  {rooms.described_values(found.parameters, exploration.space.units)}")
    print(f"  valid with a probability of {rooms.described_validity(found.validity)}")
    for name, expected in found.expected.items():
        unit = exploration.units.get(name, "")
        print(f"  {name} {expected:.4g} ± {found.deviation[name]:.2g} {unit}".rstrip())
    return exit_codes.DONE


def _target(given: list[str]) -> "rooms.Target":
    """The wanted outcomes; raises InputError for values that are no finite number, `least` or `most`."""
    target: dict[str, float | Literal["least", "most"]] = {}
    faults = []
    for name, text in pairs(given, "--target").items():
        value = number(text)
        if text in EXTREMES:
            target[name] = EXTREMES[text]
        elif value is None:
            message = f'"{name}" must be a finite number, least or most, this is "{text}"'
            faults.append(finding("--target", message, f"{name}={text}"))
        else:
            target[name] = value
    if faults:
        raise InputError(faults)
    return target


def _tolerance(given: list[str] | None) -> "float | dict[str, float] | str | None":
    """How far off outcomes may be: for all, by outcome, `deviation` if nothing is said, None for `none`."""
    if given is None:
        return "deviation"
    if given == ["none"]:
        return None
    if len(given) > 1 or "=" in given[0]:
        return numbers(given, "--tolerance")
    value = number(given[0])
    if value is None or value < 0.0:
        raise InputError([finding("--tolerance", "write a number from 0 on, O=T …, or none", given[0])])
    return value
