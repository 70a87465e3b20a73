"""Builds tasks from a task file: `load_task` makes one task, a `TaskFile` any number of tasks [T 3.7]."""

from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from kabo.errors import Diagnostic, InputError, did_you_mean
from kabo.given import require_given, require_path
from kabo.language import TASK_LIBRARY, find_task, library_names
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.task_description import Entries, Input, Items, PropertyReference, TaskDescription, Word
from kabo.options import require_seed
from kabo.tasks.core import Container, InitialisationError, Monitor, Property, Stage, Task
from kabo.tasks.files.checking import Recipe, check_task
from kabo.tasks.files.interface_names import check_interface
from kabo.tasks.files.kinds import KIND_TYPES
from kabo.tasks.files.values import NoValue, value_of, wanted

DEPTH_FIRST_JOBS = 3  # jobs per stage that are planned depth first, for a first solution, before round robin


class TaskFile:
    """A task file that was read and checked; `task` makes a new task of it with arguments bound."""

    def __init__(
        self, description: TaskDescription, recipe: Recipe, warnings: tuple[Diagnostic, ...] = ()
    ) -> None:
        self.description, self.recipe, self.warnings = description, recipe, warnings

    @property
    def name(self) -> str:
        """The name of the task."""
        return self.description.name

    @property
    def inputs(self) -> tuple[Input, ...]:
        """The declared properties, in the order of positional arguments."""
        return self.description.inputs

    @property
    def max_solutions(self) -> int | None:
        """The number of solutions at which planning ends, as given in the file; None if it gives none."""
        return self.description.max_solutions

    @property
    def timeout(self) -> float | None:
        """The time [s] after which planning ends with the solutions found so far; None if the file gives none."""
        return self.description.timeout

    @cached_property
    def places(self) -> Mapping[str, Place]:
        """The line and column of each stage in the file, by path.

        If several stages have the same path, the place of the first is given.
        """
        places: dict[str, Place] = {}
        _note_places(self.recipe, (), places)
        return places

    def task(self, arguments: Mapping[str, Any] | None = None, *, seed: int = 0, partly: bool = False) -> Task:
        """A new task with `arguments` bound to its declared properties.

        Args:
            arguments: values by the names of declared properties.
            seed: the seed of all random choices.
            partly: whether required properties may be missing, as for showing the task.

        Raises:
            InputError: lists every argument that is unknown, missing, or of the wrong type.
        """
        bound = self._bound(arguments or {}, partly)
        task = Task(self.name, *map(_made, self.recipe.children), seed=seed)
        for each in self.inputs:
            kind = KIND_TYPES[each.kind or "any"]
            if each.required:
                task.properties.declare(each.name, kind)
            else:
                task.properties.declare(each.name, kind, default_of(each))
            if bound.get(each.name) is not None:
                task.properties.set(each.name, bound[each.name])
        for name, value in self.recipe.values.items():
            task.properties.set(name, value)
        task.cost = self.recipe.cost
        task.depth_first = DEPTH_FIRST_JOBS * sum(1 for _ in task.walk())
        return task

    def _bound(self, arguments: Mapping[str, Any], partly: bool) -> dict[str, Any]:
        declared = {each.name: each for each in self.inputs}
        findings = self._findings()
        for name, value in arguments.items():
            if name not in declared:
                hint = did_you_mean(name, declared) or f"it has {', '.join(declared) or 'none'}"
                findings.add(self.recipe.place, f'the task "{self.name}" has no property "{name}"', hint)
            elif value is not None and not fits(declared[name], value):
                kind = wanted(Property(KIND_TYPES[declared[name].kind or "any"]))
                message = f'"{name}" must be {kind}, not {value!r}'
                findings.add(declared[name].place, message)
        for each in self.inputs:
            if each.required and not partly and arguments.get(each.name) is None:
                what = "property" if each.kind in (None, "any") else each.kind
                message = f'the {what} "{each.name}" must be given'
                findings.add(each.place, message, f"on the command line --set {each.name}=…")
        if findings.errors:
            raise InputError(findings.diagnostics)
        return {each.name: default_of(each) for each in self.inputs if not each.required} | dict(arguments)

    def _findings(self) -> Findings:
        findings = Findings()
        findings.know(self.description.source)
        return findings

    def located(self, error: InitialisationError) -> InputError:
        """The faults of a task as an InputError, each located in the file at the first stage that it names.

        One of a stage inside another task file, as of the library, is located at the stage that takes this file.
        """
        findings = self._findings()
        for message in error.errors:
            path = next((word for word in message.split("'")[1::2] if word in self.places), None)
            place = inside = self.recipe.place if path is None else self.places[path]
            while path and place.file != self.recipe.place.file:
                path = path.rpartition("/")[0]
                place = self.places.get(path, self.recipe.place)
            hint = None if inside == place else f"the stage inside is at {Path(inside.file).name}:{inside.line}"
            findings.add(place, message, hint)
        return InputError(findings.diagnostics)


def default_of(declared: Input) -> Any:
    """The default of a declared property; None if the declaration has no default."""
    if isinstance(declared.default, Word | Items | Entries | PropertyReference):
        return value_of(declared.default, Property())
    return declared.default


def fits(declared: Input, value: Any) -> bool:
    """Whether a value may be given for a declared property."""
    type_ = KIND_TYPES[declared.kind or "any"]
    if type_ is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    return isinstance(value, type_[:1] if isinstance(type_, tuple) else type_)


def _made(recipe: Recipe) -> Stage:
    given: dict[str, Any] = {}
    if recipe.monitors is not None:
        given["monitors"] = recipe.monitors
    if recipe.only is not None:
        given["only"] = recipe.only
    stage = recipe.kind(recipe.name, *map(_made, recipe.children), **given)
    for name, value in recipe.values.items():
        stage.properties.set(name, value)
    stage.cost = recipe.cost
    assert isinstance(stage, Container) or not recipe.children
    assert isinstance(stage, Monitor) or recipe.monitors is None
    return stage


def _note_places(recipe: Recipe, above: tuple[str, ...], places: dict[str, Place]) -> None:
    if above:
        places.setdefault("/".join(above), recipe.place)
    for child in recipe.children:
        _note_places(child, (*above, child.name), places)
    if not above:
        places.setdefault(recipe.name, recipe.place)  # a stage may have the name of the task


def find_task_file(path: Path, name: str, findings: Findings) -> TaskFile | None:
    """The task file at `path`, which messages call `name`.

    The result is None if it has errors, which are added to `findings`.
    """
    description = find_task(path, name, findings)
    if description is None:
        return None
    recipe = check_task(description, findings)
    if recipe is None:
        return None
    check_interface(description, recipe, findings)
    if findings.errors:
        return None
    return TaskFile(
        description, recipe, tuple(each for each in findings.diagnostics if each.severity == "warning")
    )


def load_task_file(path: str | Path) -> TaskFile:
    """The task file at `path`, or the library's of that name (`pick`), checked against the stages that exist.

    Raises:
        ArgumentError: `path` is no path.
        InputError: lists every error: of the YAML, of stages, properties, types, monitored stages, and references
            to properties that no ancestor has.
    """
    path = require_path("path", path)
    if str(path) in library_names() and not Path(path).exists():
        path = TASK_LIBRARY / f"{path}.yaml"
    elif Path(path).name == str(path) and not Path(path).suffix and not Path(path).exists():
        known = did_you_mean(str(path), library_names()) or f"it has {', '.join(sorted(library_names()))}"
        raise InputError(
            [Diagnostic(str(path), 1, 1, "there is no such file, nor such a task of the library", known)]
        )
    findings = Findings()
    found = find_task_file(Path(path), str(path), findings)
    if found is None:
        raise InputError(findings.diagnostics)
    return found


def load_task(path: str | Path, arguments: Mapping[str, Any] | None = None, *, seed: int = 0) -> Task:
    """The task of a file with arguments bound to its declared properties.

    Raises:
        InputError: lists every error of the file, or of the arguments.
        ArgumentError: an argument is of a wrong kind.
    """
    seed, arguments = require_seed(seed), require_arguments(arguments)
    return load_task_file(path).task(arguments, seed=seed)


def require_arguments(arguments: Mapping[str, Any] | None) -> dict[str, Any]:
    """The arguments of a task that a caller gives, by name; None are none.

    Raises:
        ArgumentError: they are no mapping, or a name is no text.
    """
    if arguments is None:
        return {}
    require_given("arguments", arguments, Mapping)
    for name in arguments:
        require_given("the name of an argument", name, str)
    return dict(arguments)


def argument_of(declared: Input, text: str) -> Any:
    """The value of a declared property that was given on the command line as `name=text`.

    Raises:
        NoValue: the text is not of the declared type.
    """
    word = Word(text, False, declared.place)
    value = value_of(word, Property(KIND_TYPES[declared.kind or "any"]))
    if not fits(declared, value):
        raise NoValue(wanted(Property(KIND_TYPES[declared.kind or "any"])))
    return value
