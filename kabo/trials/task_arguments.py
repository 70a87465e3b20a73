"""The properties of a task in a trial: values of the exploration file, with references replaced."""

from collections.abc import Mapping
from typing import Any

from kabo.exploration import Case, Parameters
from kabo.language.exploration_description import TaskTrial, reference_of
from kabo.language.task_description import Entries, Input, Items, Word, Written
from kabo.tasks.core import Property
from kabo.tasks.files.building import TaskFile
from kabo.tasks.files.kinds import KIND_TYPES
from kabo.tasks.files.values import value_of


def arguments_of(trial: TaskTrial, file: TaskFile, case: Case, parameters: Parameters) -> dict[str, Any]:
    """The values of a task's declared properties in a trial.

    A property that the exploration file sets has that value, with `<PARAMETER:name>` and `<CASE:name>` replaced. Any
    other that is called like a parameter or a case variable has the value of that. All others are left out.

    Raises:
        NoValue: a value is not of the property's type.
    """
    declared = {each.name: each for each in file.inputs}
    values: dict[str, Any] = {}
    for name, each in declared.items():
        written = written_for(trial, each, case, parameters)
        if written is not None:
            values[name] = value_in_trial(written, each, case, parameters)
    return values


def written_for(trial: TaskTrial, declared: Input, case: Case, parameters: Parameters) -> Written | None:
    """The value of a declared property before references are replaced; None: the exploration gives none."""
    name = declared.name
    if name in trial.properties:
        return trial.properties[name]
    if name in parameters:
        return Word(repr(parameters[name]), False, trial.place)
    return Word(case[name], False, trial.place) if name in case else None


def value_in_trial(written: Written, declared: Input, case: Case, parameters: Parameters) -> Any:
    """The value of a declared property in a trial; raises NoValue if it is not of the property's type."""
    return value_of(_filled(written, case, parameters), Property(KIND_TYPES[declared.kind or "any"]))


def _filled(written: Written, case: Case, parameters: Mapping[str, float]) -> Written:
    """The value with all references replaced; numbers keep all digits."""
    if isinstance(written, Items):
        return Items(tuple(_filled(each, case, parameters) for each in written.values), written.place)
    if isinstance(written, Entries):
        values = {key: _filled(each, case, parameters) for key, each in written.values.items()}
        return Entries(values, written.place)
    reference = reference_of(written) if isinstance(written, Word) else None
    if reference is None:
        return written
    text = repr(parameters[reference.name]) if reference.source == "PARAMETER" else case[reference.name]
    return Word(text, False, written.place)
