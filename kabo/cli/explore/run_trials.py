"""`kabo explore run`: makes the trials that an exploration file describes, and writes each into the model."""

import argparse
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Literal

from kabo.budgets import StopFlag
from kabo.cli import exit_codes, rooms
from kabo.cli.argument_types import natural, output_file, require_writable
from kabo.cli.explore.arguments import finding, findings_of, number
from kabo.cli.limits import add_limits
from kabo.cli.own_code import add_stages_argument, execute
from kabo.cli.terminal import answer, clean_standard_output, interruptible, print_json, tell
from kabo.cli.waiting.doing import Doing
from kabo.errors import Diagnostic, InputError

CutOffBy = Literal["time", "memory", "interrupted"]
NAME = "run"
HELP = "make the trials of an exploration file, and write each into a model"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments and options of `kabo explore run` to the parser."""
    parser.add_argument("file", type=Path, metavar="FILE", help="the exploration file")
    parser.add_argument(
        "--trials",
        type=natural,
        required=True,
        metavar="N",
        help="trials in all, those of a resumed model included",
    )
    add_stages_argument(parser)
    parser.add_argument("--seed", type=natural, metavar="N", help="the seed of all random samples (default: 0)")
    parser.add_argument(
        "--invalid-budget",
        metavar="B",
        help="share of trials that may be invalid (default: the file's, else none)",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on with MODEL, or begin it if there is no such file"
    )
    parser.add_argument(
        "-o", dest="model", type=output_file, required=True, metavar="MODEL", help="the model, a journal of trials"
    )
    add_limits(parser)
    parser.set_defaults(cut_off_with_trials=_cut_off)
    parser.add_argument("--json", action="store_true", help="print the result as one JSON object")


def run(options: argparse.Namespace) -> int:
    """Makes trials until the model holds as many as wanted, and returns the exit code: 4 if it ended before."""
    require_writable(options.model)
    with clean_standard_output():
        execute(options.stages)
        file = rooms.load_exploration_file(options.file)
        exploration = _exploration(options, file)
        with interruptible() as interrupted:
            flag = StopFlag(options.surrounding.left(options.timeout) or inf, options.memory or inf, interrupted)
            complete = len(exploration.trials) >= options.trials
            if not complete:
                rooms.require_scikit_learn()
            preparing = options.surrounding.preparing
            trial = (
                None if complete else rooms.trial_of(file, stop=flag, preparing=preparing)
            )  # writes nothing yet
            exists = options.model.exists()
            journal = (
                rooms.Journal.resume(options.model) if exists else rooms.Journal.create(options.model, exploration)
            )
            ended = rooms.ExplorationRun("done", 0) if trial is None else _run(options, journal, trial, flag)
    if ended is None:
        return _cut_off(options, "interrupted", "cut off while trying (interrupted)")
    return _answer(options, journal.exploration, ended, flag)


def _run(
    options: argparse.Namespace, journal: "rooms.Journal", trial: "rooms.TrialFunction", flag: StopFlag
) -> "rooms.ExplorationRun | None":
    """Makes the trials, and returns how the run ended; None: a second Ctrl-C aborted a trial."""
    try:
        report = _reporter(options.surrounding.say)
        return rooms.run_exploration(journal, trial, options.trials, stop=flag, progress=report)
    except KeyboardInterrupt:
        return None


def _exploration(options: argparse.Namespace, file: "rooms.ExplorationDescription") -> "rooms.Exploration":
    """A new exploration, or with --resume that of the model if there is such a file.

    Raises:
        InputError: the model exists without --resume, or was made from another file, seed or budget.
    """
    budget = _budget(options.invalid_budget)
    if not options.model.exists():
        with findings_of(str(options.file)):
            return rooms.exploration_of(file, seed=options.seed or 0, invalid_budget=budget)
    if not options.resume:
        message = "there is such a file already, and no trial is overwritten"
        hint = "--resume goes on with its trials; or name another model with -o"
        raise InputError([Diagnostic(str(options.model), 1, 1, message, hint)])
    exploration = rooms.load_exploration(options.model)
    with findings_of(str(options.file)):
        rooms.require_same(file, exploration, seed=options.seed, invalid_budget=budget)
    return exploration


def _budget(text: str | None) -> float | None:
    if text is None:
        return None
    value = number(text)
    if value is None or not 0.0 < value < 1.0:
        raise InputError([finding("--invalid-budget", "write a share above 0 and below 1, such as 0.2", text)])
    return value


def _reporter(say: Callable[[Doing], None]) -> "Callable[[rooms.TrialReport], None]":
    """A function that shows a trial: `trial 12 of 60: string d4: valid` or the reason why it was not."""

    def report(made: "rooms.TrialReport") -> None:
        result = made.result
        said = "valid" if isinstance(result, rooms.Valid) else result.reason
        case = rooms.described_case(made.question.case)
        text = f"trial {made.number} of {made.trials}: {case}: {said}{f', {result.comment}' if result.comment else ''}"
        say(Doing("trying", text, made.number / made.trials, of_budget=True))

    return report


def _answer(
    options: argparse.Namespace, exploration: "rooms.Exploration", ended: "rooms.ExplorationRun", flag: StopFlag
) -> int:
    """Prints the result of the run, and returns the exit code."""
    stopped, message = _stopped(ended, flag)
    if options.json:
        print_json(rooms.run_answer(exploration, options.model, ended.made, stopped, message))
    else:
        print(rooms.describe_exploration(exploration, rooms.summaries_of(exploration)))
    if message is not None:
        answer(f"{options.model}: {message}")
    elif not options.json:
        tell(f"{options.model}: {rooms.counted(ended.made, 'new trial')}; kabo explore show {options.model}")
    return exit_codes.DONE if stopped is None else exit_codes.NO_PLAN


def _stopped(ended: "rooms.ExplorationRun", flag: StopFlag) -> "tuple[rooms.Stopped | None, str | None]":
    """Why a run ended before it had all trials, as a word and as a sentence; None if it had all."""
    if ended.ended == "done":
        return None, None
    if ended.ended == "no_parameters":
        case, error = ended.refusals[0]
        why: rooms.Stopped = "not_explored" if error.reason == "not_explored" else "nothing_valid"
        return why, f"{rooms.described_case(case)}: {error}"
    reason: rooms.Stopped = "interrupted" if flag.interrupted else "memory" if flag.spent == "memory" else "time"
    said = "interrupted" if reason == "interrupted" else f"{reason} exhausted"
    return reason, f"{said}; all trials are kept: --resume goes on"


def _cut_off(options: argparse.Namespace, why: "CutOffBy | None", message: str) -> int:
    """Reports that the run was aborted within a trial, and returns the exit code.

    `why` is the cause; None: unknown, as when a library ends the process.
    """
    kept = _kept(options.model)
    if kept is None:
        message = f"{message}; nothing was written"
    else:
        trials = rooms.counted(len(kept.trials), "trial")
        message = f"{message}; the model has {trials}, --resume goes on"
    answer(f"{options.model}: {message}")
    if options.json and kept is not None and why is not None:
        print_json(rooms.run_answer(kept, options.model, None, why, message))
    elif options.json:
        print_json({"code": "failed" if why is None else "cut_off", "message": message})
    return exit_codes.DEFECT if why is None else exit_codes.NO_PLAN


def _kept(path: Path) -> "rooms.Exploration | None":
    """The exploration in the model; None if the file does not exist or is no model."""
    try:
        return rooms.load_exploration(path)
    except InputError:
        return None
