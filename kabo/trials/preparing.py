"""Prepares trials that plan a task: reads task and scene, and reports all at once what a run would refuse."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kabo.errors import Diagnostic, InputError
from kabo.exploration import Case, Parameters
from kabo.language import load_scene_description
from kabo.language.exploration_description import ExplorationDescription, TaskTrial, reference_of, words_of
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.scene_description import SceneDescription
from kabo.language.source import missing_file_reason
from kabo.language.task_description import Input
from kabo.tasks.core import CostTerm, InitialisationError
from kabo.tasks.files import find_task_file
from kabo.tasks.files.building import TaskFile, fits
from kabo.tasks.files.costs import NoCost, cost_of, of_robots
from kabo.tasks.files.running import check_things, located_at_stage, needs_scene
from kabo.tasks.files.values import NoValue
from kabo.trials.explorations import first_parameters
from kabo.trials.running import never
from kabo.trials.task_arguments import arguments_of, value_in_trial, written_for

if TYPE_CHECKING:
    from kabo.scene import Scene  # loads meshes, which tasks without robots do not need

COST = "cost"  # the outcome that is the cost of the whole solution
MAX_EXAMPLES = 200  # trials whose tasks are checked, without planning


@dataclass(frozen=True)
class PreparedTask:
    """A trial that plans a task: the task file, the scene (None: without robots), and the terms of its outcomes."""

    trial: TaskTrial
    file: TaskFile
    scene: "Scene | None"
    terms: dict[str, CostTerm | None]  # None: the cost of the solution

    def arguments(self, case: Case, parameters: Parameters) -> dict[str, Any]:
        """The values of the task's properties in a trial."""
        return arguments_of(self.trial, self.file, case, parameters)


def prepare_task(
    description: ExplorationDescription, trial: TaskTrial
) -> tuple[PreparedTask | None, tuple[Diagnostic, ...]]:
    """The prepared trial, or None if a finding is an error; and all findings.

    Nothing is planned. Whether the stages fit together and accept the values is checked at the corners of the bounds, at
    the start, and for each value of each case variable.
    """
    return _Preparing(description, trial).prepared()


class _Preparing:
    """Collects the findings about one trial that plans a task."""

    def __init__(self, description: ExplorationDescription, trial: TaskTrial) -> None:
        self.description, self.trial = description, trial
        self.findings = Findings()
        self.findings.know(description.source)
        self.others: list[Diagnostic] = []  # findings in the task file and the scene

    def prepared(self) -> tuple[PreparedTask | None, tuple[Diagnostic, ...]]:
        file, scene = self.task_file(), self.scene_description()
        terms = self.terms(file)
        made = None
        if file is not None:
            self.properties(file)
            if not self.failed():
                made = self.made(file, scene, terms)
        found = (*self.findings.diagnostics, *self.others)
        return (None if self.failed() else made), found

    def failed(self) -> bool:
        return any(each.severity == "error" for each in (*self.findings.diagnostics, *self.others))

    # -------------------------------------------------------------------------------------------------- files
    def task_file(self) -> TaskFile | None:
        if not self.exists(self.trial.task, self.trial.task_place):
            return None
        findings = Findings()
        file = find_task_file(self.trial.task, str(self.trial.task), findings)
        self.others += findings.diagnostics
        return file

    def scene_description(self) -> SceneDescription | None:
        path, place = self.trial.scene, self.trial.scene_place
        if path is None or place is None or not self.exists(path, place):
            return None
        try:
            return load_scene_description(path)
        except InputError as error:
            self.others += error.diagnostics
            return None

    def exists(self, path: Path, place: Place) -> bool:
        reason = missing_file_reason(path)
        if reason is not None:
            self.findings.add(place, f'"{path.name}": {reason}', self.findings.near_file(path))
        return reason is None

    # --------------------------------------------------------------------------------------- names and values
    def terms(self, file: TaskFile | None) -> dict[str, CostTerm | None]:
        """The cost term of each outcome."""
        robots = (
            self.trial.scene is not None or file is None or needs_scene(file)
        )  # a missing scene is reported itself
        terms: dict[str, CostTerm | None] = {}
        for outcome in self.description.outcomes:
            if outcome.name == COST:
                terms[COST] = None
                continue
            if of_robots(outcome.name) and not robots:
                message = f'the outcome "{outcome.name}" is a cost of robots, and the trial has no scene'
                self.findings.add(outcome.place, message, f"`{COST}` is the cost of the whole solution")
                continue
            try:
                terms[outcome.name] = cost_of(outcome.name).term
            except NoCost as error:
                message = f'the outcome "{outcome.name}" of a task is `{COST}` or the name of a cost term: {error}'
                self.findings.add(outcome.place, message, error.hint)
        return terms

    def properties(self, file: TaskFile) -> None:
        """Reports properties that the task does not declare or lacks, values of wrong types, and names without effect."""
        declared = {each.name: each for each in file.inputs}
        for name, place in self.trial.keys.items():
            if name not in declared:
                hint = self.findings.near(name, declared) or f"it has {', '.join(declared) or 'none'}"
                self.findings.add(place, f'the task "{file.name}" has no property "{name}"', hint)
        for each in file.inputs:
            self.value(each)
        used: set[tuple[str, str]] = {
            (reference.source, reference.name)
            for written in self.trial.properties.values()
            for word in words_of(written)
            if (reference := reference_of(word)) is not None
        }
        named = [("PARAMETER", each.name, each.place) for each in self.description.parameters]
        named += [("CASE", each.name, each.place) for each in self.description.cases]
        for source, name, place in named:
            direct = name in declared and name not in self.trial.keys
            if not direct and (source, name) not in used:
                overridden = "`properties` gives another value"
                undeclared = f'the task "{file.name}" declares no such property'
                message = f'"{name}" has no effect: {overridden if name in declared else undeclared}'
                hint = f"write <{source}:{name}> in a value of the trial's `properties`"
                self.findings.add(place, message, hint)

    def value(self, declared: Input) -> None:
        """Reports that the value of a property is missing in a trial, or not of its type."""
        for case, parameters in examples(self.description):
            written = written_for(self.trial, declared, case, parameters)
            if written is None:
                if declared.required and declared.name not in self.trial.keys:
                    what = "property" if declared.kind in (None, "any") else declared.kind
                    hint = f"properties: {{{declared.name}: …}}"
                    self.findings.add(self.trial.place, f'the {what} "{declared.name}" must be given', hint)
                return
            try:
                value = value_in_trial(written, declared, case, parameters)
                wrong = None if fits(declared, value) else f'"{declared.name}" cannot be {value!r}'
            except NoValue as error:
                wrong = f'"{declared.name}" must be {error}'
            if wrong is not None:
                self.findings.add(written.place, wrong)
                return

    # ----------------------------------------------------------------------------------------------- the task
    def made(
        self, file: TaskFile, described: SceneDescription | None, terms: dict[str, CostTerm | None]
    ) -> PreparedTask | None:
        """The prepared trial, if the task fits the scene; None after a report."""
        if described is None and needs_scene(file):
            message = f'the task "{file.name}" moves robots and needs a scene'
            self.findings.add(self.trial.place, message, "trial: {task: …, scene: scene.yaml}")
            return None
        scene = None
        if described is not None:
            # Only here, since tasks without a scene need no mesh libraries.
            from kabo.scene.findings import findings_in_scene
            from kabo.scene.scene import load_scene

            self.others += findings_in_scene(described)
            if self.failed():
                return None
            scene = load_scene(described)
        prepared = PreparedTask(self.trial, file, scene, terms)
        for case, parameters in examples(self.description):
            try:
                self.check(prepared, described, case, parameters)
            except InputError as error:
                self.others += error.diagnostics
                return None
        return prepared

    def check(
        self, prepared: PreparedTask, described: SceneDescription | None, case: Case, parameters: Parameters
    ) -> None:
        """Checks the task of one trial without planning it; raises InputError."""
        arguments = prepared.arguments(case, parameters)
        if described is not None:
            check_things(prepared.file, arguments, described)
        task = prepared.file.task(arguments)
        try:
            if prepared.scene is not None:
                from kabo.tasks.files.first_scenes import check_against_scene, first_scene

                check_against_scene(task, first_scene(prepared.scene, 0, never))
            task.initialise()
        except (InitialisationError, ValueError) as error:
            told = located_at_stage(prepared.file, task, error)
            if told is None:
                raise
            raise told from error
        finally:
            task.close()


def examples(description: ExplorationDescription) -> list[tuple[dict[str, str], dict[str, float]]]:
    """Cases and parameters to check: the corners of the bounds with the first case, then `usual_examples`."""
    names = [each.name for each in description.parameters]
    usual = usual_examples(description)
    corners = product(*((each.lower, each.upper) for each in description.parameters))
    return [*((usual[0][0], dict(zip(names, corner, strict=True))) for corner in corners), *usual][:MAX_EXAMPLES]


def usual_examples(description: ExplorationDescription) -> list[tuple[dict[str, str], dict[str, float]]]:
    """The start, or the middle of the bounds, with the first case, and with every other value of each case variable."""
    point = first_parameters(description)
    first = {each.name: each.values[0] for each in description.cases}
    others = [{**first, each.name: value} for each in description.cases for value in each.values[1:]]
    return [(case, dict(point)) for case in (first, *others)]
