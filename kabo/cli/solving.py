"""Arguments and output shared by `solve`, `request` and `explain`; `motion` and `task plan` take options from here."""

import argparse
from collections.abc import Callable, Mapping
from math import inf
from pathlib import Path
from typing import Any, cast

from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import bounded, output_file, positive, whole
from kabo.cli.limits import add_limits
from kabo.cli.terminal import answer, clean_standard_output, complain, interruptible, print_json, tell, warn
from kabo.errors import InputError
from kabo.options import OPTIONS, WITHOUT_PROBLEM, Option, SolveOptions

SHOWN_DETAILS = 2  # of the reason why there is no plan: the first ones say most


def add_search_arguments(parser: argparse.ArgumentParser, command: str = "solve") -> None:
    """Adds the arguments of `solve` and `request`; absent options are taken from the problem or the scene."""
    add_problem_argument(parser)
    add_options(parser, command)
    add_limits(parser, "the problem's, else 600")
    parser.set_defaults(cut_off=report_cut_off, write_found=finish)  # at a limit, without a plan or with one
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
    """Adds the options of `kabo.options` that a command accepts; `defaults` are specific to this command."""
    for option in OPTIONS.values():
        if command not in option.commands:
            continue
        default = defaults.get(option.name, option.default)
        text = _help(option, default, from_problem=command not in WITHOUT_PROBLEM)
        given: dict[str, Any] = {"help": text, "default": None}
        if option.choices:
            given["choices"] = option.choices
        elif option.kind is bool:
            given["action"] = argparse.BooleanOptionalAction
        else:
            given |= {"type": _reader(option), "metavar": "N" if option.kind is int else option.name[0].upper()}
        parser.add_argument(argument_of(option), **given)


def has_geometry(options: argparse.Namespace) -> bool:
    """Whether the problem of a command has a scene whose geometry is asked."""
    return options.geometry != "none" and has_scene(options.problem)


def has_scene(path: Path) -> bool:
    """Whether a file is a scene, or a problem with one, without errors."""
    try:
        rooms.load_scene_description(path, whole=False)
    except (InputError, OSError):  # no scene, or errors that the command reports
        return False
    return True


def argument_of(option: Option) -> str:
    """The name of an option's argument on the command line."""
    return "--" + option.name.replace("_", "-")


def _help(option: Option, default: object, *, from_problem: bool) -> str:
    """The help text of an option: its meaning and its default."""
    last = option.otherwise or ("yes" if default is True else f"{default}")
    first = "" if option.problem_key is None or not from_problem else "the problem's, else "
    return f"{option.help} (default: {first}{last})".replace("`", "").replace("%", "%%")


def _reader(option: Option) -> Callable[[str], Any]:
    """The function that reads the value of an option that is a number."""
    if option.kind is int:
        return whole(int(option.at_least or 0))
    if not option.at_least and option.at_most is None:
        return positive
    return bounded(option.at_least or 0.0, inf if option.at_most is None else option.at_most, option.unit)


def add_problem_argument(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments for a problem, which is in one file, or in two: the problem file and its domain file."""
    parser.add_argument(
        "problem",
        type=Path,
        nargs="+",
        action=_OneOrTwo,
        metavar="PROBLEM",
        help="the problem file (YAML, PDDL, PKS); for PDDL and PKS its domain file may stand beside it: DOMAIN PROBLEM",
    )


class _OneOrTwo(argparse.Action):
    """Stores one or two files: as `problem`, and as `domain` or None."""

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
    """The options of `kabo.options` that were given; `timeout` is reduced by the time that has already passed."""
    given = {name: getattr(options, name, None) for name in OPTIONS}
    chosen = {name: value for name, value in given.items() if value is not None}
    if options.timeout is not None:
        chosen["timeout"] = options.surrounding.left(options.timeout)
    return cast("SolveOptions", chosen)


def solve_and_finish(options: argparse.Namespace, **more: Any) -> int:
    """Solves the problem, prints the plan or why there is none, and writes the plan file if there is one.

    `more` are further arguments of `kabo.requests.solve_file`.
    """
    try:
        with clean_standard_output(), interruptible() as stop:
            found = rooms.solve_file(
                options.problem,
                chosen_options(options),
                domain=options.domain,
                progress=options.surrounding.planning,
                cancelled=stop,
                on_found=options.surrounding.on_found(),
                on_refused=lambda body: options.surrounding.on_known(body, ""),
                **more,
            )
    except KeyboardInterrupt:  # a second Ctrl-C ended the search at once
        return report_cut_off(options, "time", "interrupted by the user")
    if found.error is not None and not options.json:
        complain(str(found.error))
    return finish(found.body, found.plan, options)


def report_cut_off(options: argparse.Namespace, spent: Any, message: str, known: Any = None) -> int:
    """Reports that a search was killed before it found a plan, and what was refused by then; returns the exit code."""
    said = f"{message}; no file was written"
    body = rooms.result_to_json(rooms.Result("exhausted", None, reason=rooms.Reason(None, spent, said)))
    details = [] if known is None else known[0]["reason"]["details"]
    if options.json:
        kept = {} if known is None else {"statistics": known[0]["statistics"]}
        print_json({**body, **kept, "reason": {**body["reason"], "details": details}})
    answer("\n".join([f"kabo: {said}", *(f"  - {each}" for each in details[:SHOWN_DETAILS])]))
    return exit_codes.NO_PLAN


def finish(body: Mapping[str, Any], plan: bytes | None, options: argparse.Namespace) -> int:
    """Writes the plan if there is one, shows the answer, and returns the exit code.

    Without `--json`, standard output receives the tree of the plan; if there is no plan, standard error receives
    the reason.
    """
    if plan is not None:
        rooms.write_atomically(options.output, plan)
        body = {**body, "plan": str(options.output)}
    if options.json:
        print_json(body)
    elif plan is not None:
        print(rooms.describe(rooms.plan_from_json(plan)).rstrip("\n"))
        tell(f"{options.output}: {_size(body['statistics'])}")
        gaps = body["statistics"].get("certificate_gaps", ())
        if gaps and not body.get("cut_off"):  # which says the same below
            more = f" (and {len(gaps) - 1} more)" if len(gaps) > 1 else ""
            warn(f"the plan has no certificate: {gaps[0]}{more}; `kabo verify` measures distances instead")
    if not options.json and body["reason"] is not None:
        answer(_no_plan(body))
    for sentence in body.get("cut_off", ()):
        warn(f"kabo: {sentence}")
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
    refused = body["status"] == "exhausted" and any(
        row["failures"] for row in body["statistics"]["procedures"].values()
    )
    more = ["  kabo explain says more, and what would help"] if refused or len(details) > SHOWN_DETAILS else []
    return "\n".join([said + reason["message"], *(f"  - {detail}" for detail in details[:SHOWN_DETAILS]), *more])
