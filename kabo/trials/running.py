"""Runs an exploration: asks, tries, and writes each trial down before the next is asked for [T 4.4]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from kabo.errors import CutOff
from kabo.exploration import Case, Journal, NoParametersError, Question, trial_seed
from kabo.trials.calling import call_trial
from kabo.trials.results import TrialFunction, TrialResult, Valid

MAX_REFUSALS = 20  # cases of which it is said why there is nothing to try


def never() -> bool:
    """False: the default for `stop`."""
    return False


@dataclass(frozen=True)
class TrialReport:
    """One trial of a run: its number from 1, how many there are to be in all, what was tried, and what came of it."""

    number: int
    trials: int
    question: Question
    result: TrialResult


@dataclass(frozen=True)
class ExplorationRun:
    """The end of a run.

    Attributes:
        ended: `done`, there are as many trials as wanted; `stopped`, by the caller; `no_parameters`, no case has
            parameters to try.
        made: how many trials this run has made.
        refusals: of `no_parameters`, why each case has none, of the first cases; else empty.
    """

    ended: Literal["done", "stopped", "no_parameters"]
    made: int
    refusals: tuple[tuple[Case, NoParametersError], ...] = ()


def run_exploration(
    journal: Journal,
    trial: TrialFunction,
    trials: int,
    *,
    stop: Callable[[], bool] = never,
    progress: Callable[[TrialReport], None] | None = None,
) -> ExplorationRun:
    """Makes trials until the journal holds `trials` of them; each is in the file before the next is asked for.

    The n-th trial depends on the exploration's seed and the trials before it alone, so a run that was interrupted and is
    resumed writes the same bytes as one that was not.

    Args:
        journal: the exploration, new or resumed.
        trial: the function that makes a trial.
        trials: how many there are to be in all, with those that the journal holds already.
        stop: called between trials; True ends the run. A trial that raises CutOff ends it, too, and is not told.
        progress: called after each trial.

    Raises:
        TrialError: a trial raised an error, or gave something that is no result; all trials before it are kept.
        OSError: the journal cannot be written.
    """
    exploration, made = journal.exploration, 0
    while len(exploration.trials) < trials:
        if stop():
            return ExplorationRun("stopped", made)
        try:
            question = exploration.ask()
        except NoParametersError:
            return ExplorationRun("no_parameters", made, _refusals(journal))
        number = len(exploration.trials) + 1
        seed = trial_seed(exploration.seed, question.case, len(exploration.trials_of(question.case)))
        try:
            result = call_trial(trial, exploration, question, number, seed)
        except CutOff:
            return ExplorationRun("stopped", made)
        if isinstance(result, Valid):
            journal.tell(question.case, question.parameters, True, result.outcomes)
        else:
            journal.tell(question.case, question.parameters, False, reason=result.reason)
        made += 1
        if progress is not None:
            progress(TrialReport(number, trials, question, result))
    return ExplorationRun("done", made)


def _refusals(journal: Journal) -> tuple[tuple[Case, NoParametersError], ...]:
    """Why cases have nothing to try."""
    found = []
    for case in journal.exploration.space.all_cases[:MAX_REFUSALS]:
        try:
            journal.exploration.ask(case)
        except NoParametersError as error:
            found.append((case, error))
    return tuple(found)
