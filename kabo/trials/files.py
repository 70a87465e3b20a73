"""Reads exploration files, and gives the function that makes the trials of such a file."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from kabo.errors import Diagnostic, InputError
from kabo.language import find_exploration
from kabo.language.exploration_description import ExplorationDescription, TaskTrial
from kabo.language.findings import Findings
from kabo.trials import registry
from kabo.trials.results import TrialFunction
from kabo.trials.running import never

if TYPE_CHECKING:
    from kabo.geometry_server import Preparing  # explorations of functions load no geometry


def load_exploration_file(path: str | Path, name: str | None = None) -> ExplorationDescription:
    """The exploration that a file describes; messages call the file `name`. Files that it names are not opened.

    Raises:
        InputError: lists every error of the file.
    """
    findings = Findings()
    found = find_exploration(Path(path), name or os.fspath(path), findings)
    if found is None or findings.errors:
        raise InputError(findings.diagnostics)
    return found


def trial_findings(description: ExplorationDescription) -> tuple[Diagnostic, ...]:
    """All findings about the trials of an exploration: in the task, its properties, the scene.

    A trial that plans a task is run for a few jobs, with the start as parameters. Functions are not looked up: they are
    registered only before a run.
    """
    if not isinstance(description.trial, TaskTrial):
        return ()
    from kabo.trials.planned import findings_in_trials  # explorations of functions load no planner
    from kabo.trials.preparing import prepare_task

    prepared, found = prepare_task(description, description.trial)
    return found if prepared is None else (*found, *findings_in_trials(prepared, description))


def trial_of(
    description: ExplorationDescription,
    *,
    stop: Callable[[], bool] = never,
    workers: int | None = None,
    preparing: "Callable[[Preparing], None] | None" = None,
) -> TrialFunction:
    """The function that makes the trials of an exploration.

    Args:
        description: the exploration.
        stop: called while a task is planned; True ends the trial with CutOff, without a result.
        workers: processes that plan a task; results do not depend on their number.
        preparing: told while the geometry of a task's scene is prepared.

    Raises:
        CutOff: `stop` returned True while geometry was prepared.
        InputError: there is no such function, or the task cannot be planned; lists all findings. Or the file does not
            say how a trial is made.
    """
    trial = description.trial
    findings = Findings()
    findings.know(description.source)
    if isinstance(trial, TaskTrial):
        from kabo.trials.planned import PlannedTrial  # explorations of functions load no planner
        from kabo.trials.preparing import prepare_task

        prepared, found = prepare_task(description, trial)
        if prepared is None:
            raise InputError(found)
        if prepared.scene is not None:
            from kabo.tasks.files.first_scenes import prepare_geometry  # loads kernels

            prepare_geometry(prepared.scene, stop, preparing, workers)
        return PlannedTrial(prepared, stop=stop, workers=workers)
    function = None if trial is None else registry.find(trial.name)
    if trial is None:
        hint = "`trial: NAME` of a registered function, or {task: …}; trials made elsewhere are told"
        findings.add(description.place, f'"{description.name}" does not say how a trial is made', hint)
    elif function is None:
        findings.add(trial.place, f'unknown trial "{trial.name}"', registry.near(trial.name))
    if function is None:
        raise InputError(findings.diagnostics)
    return function
