"""The geometric procedures that a domain may call: each is a task file, whose declared properties are its arguments.

Task files in the domain's folder take precedence over those of kabo's library [docs/reference/tasks.md]. Only the declared
properties are used here; `kabo.tasks` interprets the stages. A task file is opened when its procedure is called.
"""

import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path

from kabo.language.findings import Findings
from kabo.language.names import NAME
from kabo.language.source import UnreadableError, beside, read_source
from kabo.language.task_description import ProcedureProperty, Signature, TaskDescription, Word, models_named
from kabo.language.yaml.task_file import read_task_text

TASK_FOLDER = "tasks"
MOST_MODEL_BYTES = 100_000_000
TASK_LIBRARY = Path(__file__).parents[2] / "tasks" / "library"


class ProcedureSignatures(Mapping[str, Signature | None]):
    """The signatures of all procedures by name; None for a procedure whose task file is faulty, which is reported.

    Args:
        folder: the domain's folder, as written in messages; None if only the library is used.
        findings: the collection that receives errors in the task files of called procedures.
        within: if given, no file outside of this folder is opened.
    """

    def __init__(
        self, folder: str | None = None, findings: Findings | None = None, within: Path | None = None
    ) -> None:
        self._folder = None if folder is None else os.path.join(folder, TASK_FOLDER)
        self._findings, self._within = findings or Findings(), within
        self._read: dict[str, Signature | None] = {}
        self.digests: dict[str, str] = {}  # of the task files beside the domain that were read, by their paths
        self.models: dict[str, str] = {}  # the same of the models that these name

    def __getitem__(self, name: str) -> Signature | None:
        if name not in self._read:
            self._read[name] = self._signature(name)
        return self._read[name]

    def __iter__(self) -> Iterator[str]:
        return iter(sorted({*_names(self._folder), *library_names()}))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and (self._own(name) is not None or name in library_names())

    def _own(self, name: str) -> str | None:
        """The file of a procedure beside the domain."""
        if self._folder is None or NAME.fullmatch(name) is None:
            return None
        path = os.path.join(self._folder, f"{name}.yaml")
        return path if os.path.lexists(path) else None

    def _signature(self, name: str) -> Signature | None:
        path = self._own(name)
        if path is None:
            return library_signature(name)
        task = self._task(path)
        if task is None or any(each.file == path for each in self._findings.errors):
            return None
        if task.name != name:
            place = task.root.place
            self._findings.add(place, f'the file {name}.yaml holds the task "{name}", not "{task.name}"')
            return None
        return signature_of(task)

    def _task(self, path: str) -> TaskDescription | None:
        try:
            source = read_source(Path(path), path, within=self._within)
        except UnreadableError as error:
            self._findings.add(error.place(path), error.message, error.hint)
            return None
        self.digests[path] = source.digest
        task = read_task_text(source, self._findings)
        if task is not None:
            self._note_files(task, path)
        return task

    def _note_files(self, task: TaskDescription, path: str) -> None:
        """Records the files that a task names: models, and tasks beside it that it includes."""
        folder = os.path.dirname(path)
        for word in models_named(task):
            self._note_model(word, beside(folder, word.text))
        for stage in task.root.walk():
            included = None if stage.type is None else included_task_path(stage.type, folder)
            if included is not None and included.parent != TASK_LIBRARY and str(included) not in self.digests:
                self._task(str(included))

    def _note_model(self, word: Word, path: str) -> None:
        """Records a model that a task names, as a file that solving reads."""
        try:
            self.models[path] = read_source(Path(path), path, MOST_MODEL_BYTES, within=self._within).digest
        except UnreadableError as error:
            hint = error.hint or self._findings.near_file(Path(path), self._within)
            self._findings.add(word.place, f'"{word.text}": {error.message}', hint)


def included_task_path(name: str, folder: str | Path) -> Path | None:
    """The file of the task that may stand for a stage in a task file of a folder; None if there is none of that name.

    It lies beside that file, in the folder `tasks` there, or in the library.
    """
    if NAME.fullmatch(name) is None:
        return None
    places = (Path(folder), Path(folder) / TASK_FOLDER, TASK_LIBRARY)
    found = (place / f"{name}.yaml" for place in places)
    return next((each for each in found if os.path.isfile(each)), None)  # noqa: PTH113 - False for a name too long


def included_task_names(folder: str | Path) -> list[str]:
    """The names of tasks that may stand for a stage in a task file of a folder: those of the library, and beside it."""
    return sorted({*_names(Path(folder) / TASK_FOLDER), *_names(folder), *library_names()})


def _names(folder: str | Path | None) -> list[str]:
    """The tasks of a folder."""
    try:
        listed = [] if folder is None else os.listdir(folder)
    except OSError:
        return []
    stems = (name.removesuffix(".yaml") for name in sorted(listed) if name.endswith(".yaml"))
    return [stem for stem in stems if NAME.fullmatch(stem)]


@lru_cache(maxsize=1)
def library_names() -> tuple[str, ...]:
    """The names of the tasks in the library, sorted."""
    return tuple(sorted(_names(TASK_LIBRARY)))


@lru_cache
def library_signature(name: str) -> Signature:
    """The signature of a task of the library.

    Raises:
        KeyError: the library has no task of this name.
    """
    if name not in library_names():
        raise KeyError(name)
    findings = Findings()
    task = read_task_text(read_source(TASK_LIBRARY / f"{name}.yaml", f"kabo/tasks/library/{name}.yaml"), findings)
    assert task is not None and not findings.errors, findings.diagnostics
    return signature_of(task)


def signature_of(task: TaskDescription) -> Signature:
    """The declared properties of a task, in their order."""
    return tuple(ProcedureProperty(each.name, each.kind or "any", each.required) for each in task.inputs)
