"""Task files as stages of other tasks: what is given to their declared properties, and where they begin [T 3.7]."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kabo.language import TASK_LIBRARY, find_task, included_task_names, included_task_path, library_names
from kabo.language.findings import Findings
from kabo.language.task_description import Input, StageDescription, TaskDescription, Word
from kabo.tasks.core import Flow, Property
from kabo.tasks.files import registry
from kabo.tasks.files.kinds import KIND_TYPES
from kabo.tasks.files.values import NoValue, value_of

if TYPE_CHECKING:
    from kabo.tasks.files.checking import Recipe

Report = Callable[..., None]


@dataclass(frozen=True)
class IncludedTask:
    """The task of another file that stands for a stage, and the files that lead to it, the outermost first."""

    description: TaskDescription
    chain: tuple[Path, ...]


def included_task(
    stage: StageDescription, folder: Path, chain: tuple[Path, ...], findings: Findings
) -> IncludedTask | None:
    """The task that a stage's type names: of a file beside the one that names it, else of the library.

    The result is None if there is none of that name, or if it cannot be read or includes itself, which is reported.
    """
    path = None if stage.type is None else included_task_path(stage.type, folder)
    if path is None:
        return None
    if path.resolve() in chain:
        circle = [*chain[chain.index(path.resolve()) :], path.resolve()]
        told = " → ".join(each.stem for each in circle)
        hidden = stage.type in library_names() and path.parent.resolve() != TASK_LIBRARY.resolve()
        hint = f'it hides the task "{stage.type}" of the library: give this file another name' if hidden else None
        findings.add(stage.type_place, f'the task "{stage.type}" would contain itself: {told}', hint)
        return None
    description = find_task(path, str(path), findings)
    return None if description is None else IncludedTask(description, (*chain, path.resolve()))


def near_names(name: str, folder: Path, findings: Findings) -> str | None:
    """A hint for a stage of an unknown type: a similar name of a stage, or of a task that may be included."""
    known = [*registry.names(), *included_task_names(folder)]
    return findings.near(name, known, all_if_few=False) or registry.near(name)


def given_values(stage: StageDescription, task: TaskDescription, findings: Findings) -> dict[str, Any]:
    """The values of an included task's properties: those that are given, else their defaults.

    Unknown properties and values of the wrong type are reported, at their places in the file that includes the task.
    """
    declared = {each.name: each for each in task.inputs}
    values: dict[str, Any] = {}
    for name, written in stage.properties.items():
        if name == "cost":
            continue
        if name not in declared:
            hint = findings.near(name, list(declared)) or f"it has {', '.join(declared) or 'none'}"
            findings.add(stage.keys[name], f'the task "{stage.type}" has no property "{name}"', hint)
            continue
        try:
            values[name] = value_of(written, Property(KIND_TYPES[declared[name].kind or "any"]))
        except NoValue as error:
            found = f', this is "{written.text[:60]}"' if isinstance(written, Word) else ""
            findings.add(written.place, f'"{name}" of "{stage.name}" must be {error}{found}')
    absent = [each for each in task.inputs if not each.required and each.name not in stage.properties]
    return values | {each.name: _default(each) for each in absent}


def _default(declared: Input) -> Any:
    from kabo.tasks.files.building import default_of  # which reads files with this one

    return default_of(declared)


def check_keys(stage: StageDescription, findings: Findings) -> None:
    """Reports keys of a stage that an included task cannot have: its stages stand in its own file."""
    for key, given in (("stages", stage.stages), ("wrapped", stage.wrapped), ("monitors", stage.monitors)):
        if given is not None:
            message = f'"{stage.name}" is the task "{stage.type}" and has no `{key}`'
            findings.add(stage.place, message, "its stages stand in its own file")


def continued(children: tuple["Recipe", ...]) -> tuple["Recipe", ...]:
    """The stages of an included task, which begins in the scene before it instead of the current state, the first one."""
    return (_continued(children[0]), *children[1:]) if children else children


def _continued(recipe: "Recipe") -> "Recipe":
    if recipe.kind is registry.find("CurrentState"):
        nothing = registry.find("NoOp")
        assert nothing is not None
        return replace(recipe, kind=nothing, only=Flow.FORWARD)
    if len(recipe.children) == 1:
        return replace(recipe, children=(_continued(recipe.children[0]),))
    return recipe


def missing_inputs(task: TaskDescription, values: Mapping[str, Any]) -> list[str]:
    """The required properties of an included task to which nothing is given."""
    return [each.name for each in task.inputs if each.required and each.name not in values]
