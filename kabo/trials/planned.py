"""Trials that plan a task: valid if there is a solution within a number of jobs, with its costs as outcomes."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from kabo.errors import CutOff, Diagnostic, InputError
from kabo.exploration import Question, trial_seed
from kabo.free_memory import give_back
from kabo.language.exploration_description import ExplorationDescription
from kabo.tasks.core import Explanation, InitialisationError, Solution, Task
from kabo.tasks.files.running import located_at_stage
from kabo.trials.calling import call_trial
from kabo.trials.explorations import exploration_of
from kabo.trials.preparing import PreparedTask, usual_examples
from kabo.trials.results import Invalid, TrialResult, Valid
from kabo.trials.running import never

JOBS_SPENT = "jobs spent"  # the reason if no stage is to blame when the jobs ran out
# The reason if no stage is to blame when everything was tried, or if the stage to blame has no failures.
NOTHING_FOUND = "nothing found"
PROBED_JOBS, PROBED_TRIALS = 40, 20  # of `kabo check`: enough to call most stages once


class PlannedTrial:
    """The trial function that plans a task.

    A job is one call of one stage. The result, and the number of jobs that it takes, depend on the task, its properties
    and the seed alone, not on the clock, the machine, or the number of workers.
    """

    def __init__(
        self, prepared: PreparedTask, *, stop: Callable[[], bool] = never, workers: int | None = None
    ) -> None:
        """The trial function of a prepared task.

        Args:
            prepared: task, scene and properties.
            stop: called while planning; True ends the trial without a result.
            workers: processes that plan; results do not depend on their number.
        """
        self.prepared, self.stop, self.workers = prepared, stop, workers

    def __call__(self, case: Mapping[str, str], parameters: Mapping[str, float], seed: int) -> TrialResult:
        """The result of one trial.

        Raises:
            CutOff: `stop` returned True before there was a result.
            InputError: the stages refuse these parameters; with the place in the task file.
        """
        prepared = self.prepared
        task = prepared.file.task(prepared.arguments(case, parameters), seed=seed)
        try:
            solutions = self._plan(task, seed)
        except (InitialisationError, ValueError) as error:
            told = located_at_stage(prepared.file, task, error)
            if told is None:
                raise
            raise told from error
        finally:
            task.close()
            give_back()  # else memory grows: 0.72 instead of 0.44 GB after 36 trials of examples/pick_and_place/reach.yaml
        if not solutions:
            return _invalid(task, prepared.trial.jobs)
        best = min(solutions, key=lambda each: each.cost)
        outcomes = {name: _cost(best, prepared, name) for name in prepared.terms}
        return Valid(outcomes, f"{len(solutions)} solutions" if len(solutions) > 1 else "")

    def _plan(self, task: Task, seed: int) -> list[Solution]:
        """The solutions found within the jobs of the trial; raises CutOff if it was stopped before."""
        trial, scene = self.prepared.trial, self.prepared.scene
        first = None
        if scene is not None:
            from kabo.tasks.files.first_scenes import check_against_scene, first_scene  # loads kernels

            first = first_scene(scene, seed, self.stop)
            check_against_scene(task, first)
        solutions = task.plan(first, trial.max_solutions, jobs=trial.jobs, stop=self.stop, workers=self.workers)
        if len(solutions) < trial.max_solutions and self.stop():
            raise CutOff  # the best of fewer solutions would depend on the clock
        return solutions[: trial.max_solutions]


def findings_in_trials(prepared: PreparedTask, description: ExplorationDescription) -> tuple[Diagnostic, ...]:
    """What the stages refuse in trials with the parameters of the start, in the first case where they refuse anything.

    Some stages check values only while they plan, so a few jobs of each trial are executed.
    """
    if prepared.scene is not None:
        from kabo.tasks.files.first_scenes import prepare_geometry  # as above

        try:
            prepare_geometry(prepared.scene, never, None)
        except InputError as error:
            return error.diagnostics
    few = replace(prepared, trial=replace(prepared.trial, jobs=min(prepared.trial.jobs, PROBED_JOBS)))
    exploration = exploration_of(description)
    for case, parameters in usual_examples(description)[:PROBED_TRIALS]:
        try:
            call_trial(PlannedTrial(few), exploration, Question(case, parameters, 0.5), 1, trial_seed(0, case, 0))
        except InputError as error:
            return error.diagnostics
    return ()


def _cost(solution: Solution, prepared: PreparedTask, name: str) -> float:
    term = prepared.terms[name]
    cost = solution.cost if term is None else term(solution)
    return float(cost[0] if isinstance(cost, tuple) else cost)


def _invalid(task: Task, jobs: int) -> Invalid:
    """Why there is no solution: the stage that is to blame, and its most frequent reason."""
    found = task.explain()
    limit = "everything was tried" if task.exhausted else f"{jobs} jobs are spent"
    comment = f"{found.text} ({limit})"
    if found.stage is None:
        return Invalid(JOBS_SPENT if not task.exhausted else NOTHING_FOUND, comment)
    return Invalid(f"{found.stage.name}: {_most_frequent(found)}", comment)


def _most_frequent(found: Explanation) -> str:
    reasons = found.failures or found.mismatches
    return next(iter(reasons), NOTHING_FOUND)
