"""What `solve` and `request` share: the options of a search, and how its answer is shown and written."""

import argparse
import math
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, cast

from kabo.cli import exit_codes
from kabo.cli.limits import add_limits
from kabo.cli.terminal import print_json, tell
from kabo.errors import Diagnostic, InputError
from kabo.options import OPTIONS, Option, SolveOptions

TOLD = 2  # details beside the sentence that says why there is no plan: the first ones tell most


def add_search_arguments(parser: argparse.ArgumentParser, command: str = "solve") -> None:
    """The options that say how to search; each that is not given is left to the problem and the scene."""
    add_problem_argument(parser)
    add_options(parser, command)
    add_limits(parser, "the problem's, else 600")
    parser.set_defaults(cut_off=told_cut_off)
    parser.add_argument(
        "-o",
        dest="output",
        type=output_file,
        default=Path("plan.json"),
        metavar="FILE",
        help="the plan file (default: plan.json)",
    )
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")


def add_options(parser: argparse.ArgumentParser, command: str, **defaults: object) -> None:
    """The options of a solve that a command has, from the table; `defaults` are those that differ for this command."""
    for option in OPTIONS.values():
        if command not in option.commands:
            continue
        given: dict[str, Any] = {"help": _help(option, defaults.get(option.name, option.default)), "default": None}
        if option.choices:
            given["choices"] = option.choices
        elif option.kind is bool:
            given["action"] = argparse.BooleanOptionalAction
        else:
            given |= {"type": _parser(option), "metavar": "N" if option.kind is int else option.name[0].upper()}
        parser.add_argument(argument_of(option), **given)


def argument_of(option: Option) -> str:
    """An option as it is written on the command line."""
    return "--" + option.name.replace("_", "-")


def _help(option: Option, default: object) -> str:
    """What an option means, and what it is if it is not given."""
    last = option.otherwise or ("yes" if default is True else f"{default}")
    first = "" if option.problem_key is None else "the problem's, else "
    return f"{option.help} (default: {first}{last})".replace("`", "").replace("%", "%%")


def _parser(option: Option) -> Callable[[str], Any]:
    """What reads the value of an option that is a number."""
    if option.kind is int:
        return natural
    if option.at_least is None or option.at_most is None:
        return positive
    least, most = option.at_least, option.at_most

    def bounded(text: str) -> float:
        value = float(positive(text))
        if not least <= value <= most:
            wanted = "a length" if option.unit == "m" else "a number"
            span = f"{least:g} to {most:g} {option.unit}".rstrip()
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted} from {span}")
        return value

    return bounded


def add_problem_argument(parser: argparse.ArgumentParser) -> None:
    """The problem, in one file or two."""
    parser.add_argument(
        "problem",
        type=Path,
        nargs="+",
        action=_OneOrTwo,
        metavar="PROBLEM",
        help="the problem file (YAML, PDDL, PKS); for PDDL and PKS its domain file may stand beside it: DOMAIN PROBLEM",
    )


class _OneOrTwo(argparse.Action):
    """Takes one file or two: `problem`, and `domain` or None."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: Any,
        option_string: str | None = None,
    ) -> None:
        if len(values) > 2:
            parser.error(f"one problem file, or a domain and a problem file, not {len(values)} files")
        namespace.problem = values[-1]
        namespace.domain = values[0] if len(values) == 2 else None


def chosen_options(options: argparse.Namespace) -> SolveOptions:
    """The options of a solve that were given; `timeout` is what is left of it."""
    given = {name: getattr(options, name, None) for name in OPTIONS}
    chosen = {name: value for name, value in given.items() if value is not None}
    if options.timeout is not None:
        chosen["timeout"] = options.door.left(options.timeout)
    return cast("SolveOptions", chosen)


def told_cut_off(options: argparse.Namespace, spent: Any, message: str) -> int:
    """Shows that a search was ended by force before there was a plan; the exit code."""
    said = f"{message}; no file was written"
    if options.json:
        from kabo.planner.result import Reason, Result, result_to_json

        print_json(result_to_json(Result("exhausted", None, {}, Reason(None, spent, said))))
    tell(f"kabo: {said}")
    return exit_codes.NO_PLAN


def finish(body: Mapping[str, Any], plan: bytes | None, options: argparse.Namespace) -> int:
    """Writes the plan if there is one, shows the answer, and returns the exit code.

    Without `--json` the plan's tree goes to standard output, and why there is no plan to standard error.
    """
    if plan is not None:
        from kabo.plan import write_atomically

        write_atomically(options.output, plan)
        body = {**body, "plan": str(options.output)}
    if options.json:
        print_json(body)
    elif plan is not None:
        from kabo.plan import describe, plan_from_json

        print(describe(plan_from_json(plan)).rstrip("\n"))
        tell(f"{options.output}: {_size(body['statistics'])}")
        gaps = body["statistics"].get("certificate_gaps", ())
        if gaps:
            more = f" (and {len(gaps) - 1} more)" if len(gaps) > 1 else ""
            tell(f"the plan has no certificate: {gaps[0]}{more}; `kabo verify` measures distances instead")
    if not options.json and body["reason"] is not None:
        tell(_no_plan(body))
    for sentence in body.get("cut_off", ()):
        tell(f"kabo: {sentence}")
    return exit_codes.BY_STATUS[body["status"]]


def _size(statistics: Mapping[str, Any]) -> str:
    outcomes = statistics["plan_leaves"]
    return (
        f"{statistics['plan_nodes']} nodes, {outcomes} outcome{'' if outcomes == 1 else 's'}, "
        f"{statistics['plan_actions']} actions on the longest branch, solved in {statistics['total_s']:.1f} s"
    )


def _no_plan(body: Mapping[str, Any]) -> str:
    reason = body["reason"]
    said = {
        "no_plan": f"no plan (proved by {reason['proved']}): ",
        "exhausted": f"no plan found ({reason.get('budget')} exhausted): ",
    }.get(body["status"], "")
    said = "no plan found, " if reason.get("budget") == "reasoning" else said
    details = reason["details"]
    more = ["  kabo explain says more, and what would help"] if len(details) > TOLD else []
    return "\n".join([said + reason["message"], *(f"  - {detail}" for detail in details[:TOLD]), *more])


def _number(kind: Callable[[str], float], least: float, wanted: str) -> Callable[[str], Any]:
    def parsed(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not (math.isfinite(value) and value >= least) or (kind is float and value == 0):
            raise argparse.ArgumentTypeError(f"{text!r} is not {wanted}")
        return value

    return parsed


def output_file(text: str) -> Path:
    """A file to write, in a folder that exists: better said now than after the search."""
    path = Path(text)
    try:
        fits = path.parent.is_dir() and not path.is_dir()
    except (OSError, ValueError):  # too long a name, or a null byte in it
        fits = False
    if not fits:
        raise argparse.ArgumentTypeError(f"{text!r} is no file in a folder that exists")
    return path


def require_writable(path: Path) -> None:
    """Nothing, for a file that can be written: tried with an empty file beside it, which goes again.

    Raises:
        InputError: it cannot; says why.
    """
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", suffix=".part" + 16 * "0"):
            pass
    except OSError as error:
        hint = "name another file to write"
        raise InputError([Diagnostic(str(path), 1, 1, f"cannot be written: {error.strerror}", hint)]) from None


natural = _number(int, 0, "a whole number from 0 on")
positive = _number(float, 0.0, "a number above 0")
