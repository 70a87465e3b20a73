"""References to interface properties that no stage of a task writes: with them, every job would fail."""

from collections.abc import Iterator

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.task_description import TaskDescription
from kabo.tasks.files.checking import Recipe
from kabo.tasks.files.values import interface_references
from kabo.tasks.learned import Risk


def check_interface(task: TaskDescription, recipe: Recipe, findings: Findings) -> None:
    """Reports references to interface properties that no stage of the task may write.

    Of stages that are not kabo's it is not known what they write; then nothing is reported.
    """
    recipes = list(_below(recipe))
    if not all(each.kind.__module__.startswith("kabo.") for each in recipes):
        return
    known = sorted({name for each in recipes for name in each.kind.writes(each.values)})
    for name, place, by in (*_written(task), *_implied(recipes)):
        if name not in known:
            hint = findings.near(name, known) or f"the stages of the task write {', '.join(known) or 'none'}"
            findings.add(place, f'{by} reads the interface property "{name}", which no stage writes', hint)


def _below(recipe: Recipe) -> Iterator[Recipe]:
    yield recipe
    for child in recipe.children:
        yield from _below(child)


def _written(task: TaskDescription) -> Iterator[tuple[str, Place, str]]:
    """The references that are written in the file: the interface property, the place, and who reads it."""
    for stage in task.root.walk():
        for key, written in stage.properties.items():
            for name, place in interface_references(written, key):
                yield name, place, f'"{key}" of "{stage.name}"'


def _implied(recipes: list[Recipe]) -> Iterator[tuple[str, Place, str]]:
    """The parameters that cost terms `risk` read from the interface because the file gives them no value."""
    for recipe in recipes:
        term = None if recipe.cost is None else recipe.cost.term
        for name in term.implied if isinstance(term, Risk) else ():
            yield name, recipe.place, f'`cost` of "{recipe.name}"'
