"""What sensors answer and what is true, as options of commands that simulate sensors: `execute` and `simulate --serve`."""

import argparse
from dataclasses import replace
from pathlib import Path

from kabo.cli import rooms
from kabo.cli.argument_types import natural
from kabo.errors import Diagnostic, InputError


def add_truth(parser: argparse.ArgumentParser) -> None:
    """Adds the options of simulated sensors and of the truth."""
    parser.add_argument("--seed", type=natural, default=0, metavar="N", help="of what sensors find (default: 0)")
    parser.add_argument(
        "--truth",
        action="append",
        default=[],
        metavar="FORMULA=OUTCOME",
        help="what a sensor finds, in place of the seed; may be given several times",
    )
    parser.add_argument(
        "--sensors", type=Path, metavar="FILE", help="what answers the questions of the plan, and how well"
    )
    parser.add_argument(
        "--truth-file",
        type=Path,
        metavar="FILE",
        help="what is true and neither plan nor controller knows: masses, places, answers",
    )


def truth_of(
    options: argparse.Namespace, problem: Path, domain: Path | None, plan: "rooms.Plan | None" = None
) -> tuple["rooms.SensorsDescription | None", "rooms.TruthDescription"]:
    """The sensors, if there is a file of them, and what is true: by its file, and by the answers of the command.

    Raises:
        InputError: an answer is to no question that `plan` or the problem knows, or a file has errors.
    """
    answers = dict(map(_pair, options.truth))
    if not answers and options.sensors is None and options.truth_file is None:
        return None, rooms.TruthDescription()
    if not rooms.is_imported(problem) and rooms.kind_of_file(problem) == "scene":
        text = "sensors and truths speak of a problem's objects, and this is a scene"
        raise InputError([Diagnostic(str(problem), 1, 1, text, "give the problem file")])
    loaded = rooms.load_problem(problem, domain)
    asked = () if plan is None else {name for node in plan.nodes.values() for name in (node.on, *node.delivers)}
    answers = {
        name if name in asked else rooms.question_of(name, loaded, "--truth"): answer
        for name, answer in answers.items()
    }
    sensors = None if options.sensors is None else rooms.load_sensors(options.sensors, loaded)
    if options.truth_file is None:
        return sensors, rooms.TruthDescription(answers=answers)
    hidden = rooms.load_truth(options.truth_file, loaded)
    return sensors, replace(hidden, answers={**hidden.answers, **answers})


def _pair(text: str) -> tuple[str, str]:
    formula, sign, outcome = text.rpartition("=")
    if not sign or not formula.strip() or not outcome.strip():
        hint = "write --truth 'empty(bottle_1)=true'"
        raise InputError([Diagnostic("--truth", 1, 1, f"{text!r} is no formula with its outcome", hint)])
    return formula.strip(), outcome.strip()
