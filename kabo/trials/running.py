"""Runs an exploration: asks what to try, makes the trial, and writes it to the journal before asking again [T 4.4]."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

from kabo.errors import CutOff
from kabo.exploration import Case, Journal, NoParametersError, Question, require_scikit_learn, trial_seed
from kabo.trials.calling import call_trial
from kabo.trials.results import TrialFunction, TrialResult, Valid

MAX_REFUSALS = 20  # greatest number of refusals that an ExplorationRun lists


def never() -> bool:
    """False: the default for `stop`."""
    return False


@dataclass(frozen=True)
class TrialReport:
    """One trial of a run: its number from 1, the wanted number of trials, what was tried, and the result."""

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
        refusals: for `no_parameters`, the first cases with the errors that say why they have none; else empty.
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
    """Makes trials until the journal holds `trials` of them; each is in the file before the next question.

    The n-th trial depends on the exploration's options and the trials before it alone, so a run that was interrupted and is
    resumed writes the same bytes as one that was not.

    Args:
        journal: the exploration, new or resumed.
        trial: the function that makes a trial.
        trials: the wanted number in all, including those that the journal holds already.
        stop: called before each trial; True ends the run. A trial that raises CutOff ends it, too, and is not added.
        progress: called after each trial.

    Raises:
        TrialError: a trial raised an error, or returned something that is no result; all trials before it are kept.
        OSError: the journal cannot be written.
        KaboError: scikit-learn is not installed; no trial was made.
    """
    exploration, made = journal.exploration, 0
    if len(exploration.trials) < trials:
        require_scikit_learn()  # else the first trial would be made, and the second could not be asked for
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
    """The first cases that have nothing to try, each with the error that says why."""
    found = []
    for case in journal.exploration.space.all_cases[:MAX_REFUSALS]:
        try:
            journal.exploration.ask(case)
        except NoParametersError as error:
            found.append((case, error))
    return tuple(found)
