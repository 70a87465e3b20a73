"""An exploration file as plain data with places: parameters, cases, outcomes, and how a trial is made [T 4.4].

What trial functions there are, and what a task makes of its properties, is not known here; `kabo.trials` checks that.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from kabo.language.formulas import Place
from kabo.language.source import SourceFile
from kabo.language.task_description import Entries, Items, Word, Written

DEFAULT_JOBS = 400  # of one trial that plans a task
_REFERENCE = re.compile(r"<(PARAMETER|CASE):([a-z][a-z0-9_]*)>")


@dataclass(frozen=True)
class ParameterDescription:
    """A parameter and its bounds, `lower` below `upper`; `unit` is empty if the file gives none."""

    name: str
    lower: float
    upper: float
    unit: str
    place: Place


@dataclass(frozen=True)
class CaseDescription:
    """A case variable and its values; every combination of the values of all variables is a case."""

    name: str
    values: tuple[str, ...]
    place: Place


@dataclass(frozen=True)
class OutcomeDescription:
    """A number that a valid trial gives; `unit` is empty if the file gives none."""

    name: str
    unit: str
    place: Place


@dataclass(frozen=True)
class FunctionTrial:
    """A trial made by a function that was registered under a name."""

    name: str
    place: Place


@dataclass(frozen=True)
class TaskTrial:
    """A trial that plans the task of a file: valid if there is a solution within a number of jobs.

    Attributes:
        task: the task file; `scene`: the scene file, or None. Both paths can be opened as they are.
        jobs: how many jobs a trial may execute.
        max_solutions: how many solutions a trial looks for; the outcomes are those of the best.
        properties: values of the task's declared properties. In them, a word that is not quoted and reads
            `<PARAMETER:name>` or `<CASE:name>` stands for the value in a trial.
        keys: the places of the names of these properties.
        place: of the key `trial`; `task_place` and `scene_place`: of the paths.
    """

    task: Path
    scene: Path | None
    jobs: int
    max_solutions: int
    properties: Mapping[str, Written]
    keys: Mapping[str, Place]
    place: Place
    task_place: Place
    scene_place: Place | None = None


@dataclass(frozen=True)
class ExplorationDescription:
    """An exploration file.

    Attributes:
        trial: how a trial is made; None if trials are made elsewhere, and told.
        parameters, cases, outcomes: in the order of the file; without cases there is one case.
        scale, noise, alpha: of the model of validity; None: the default.
        invalid_budget: the share of invalid trials that is accepted; None: no budget.
        start: where to begin, a value for each parameter; None: not given.
        retry: by how much to change which parameters after an invalid trial with which reason.
        place: of the value of the key `exploration`.
    """

    name: str
    trial: FunctionTrial | TaskTrial | None
    parameters: tuple[ParameterDescription, ...]
    cases: tuple[CaseDescription, ...]
    outcomes: tuple[OutcomeDescription, ...]
    scale: float | None
    noise: float | None
    alpha: float | None
    invalid_budget: float | None
    start: Mapping[str, float] | None
    retry: Mapping[str, Mapping[str, float]]
    place: Place
    source: SourceFile = field(default_factory=lambda: SourceFile(Path(), "", ""))


@dataclass(frozen=True)
class TrialReference:
    """A reference to the value that a parameter or a case variable has in a trial."""

    source: Literal["PARAMETER", "CASE"]
    name: str


def reference_of(word: Word) -> TrialReference | None:
    """The reference that a word is; None if it is plain text."""
    found = None if word.quoted else _REFERENCE.fullmatch(word.text.strip())
    if found is None:
        return None
    return TrialReference("PARAMETER" if found[1] == "PARAMETER" else "CASE", found[2])


def words_of(written: Written) -> Iterator[Word]:
    """All words of a value."""
    if isinstance(written, Word):
        yield written
    elif isinstance(written, Items):
        for item in written.values:
            yield from words_of(item)
    elif isinstance(written, Entries):
        for value in written.values.values():
            yield from words_of(value)
