"""Writes a task as a task file: YAML that loads to the same tree of stages [T 3.7]."""

import math
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from kabo.given import require_given, require_number, require_output
from kabo.tasks.core import MISSING, Container, Monitor, Propagator, Reference, Stage, Task, TaskError, Wrapper
from kabo.tasks.files.checking import ONLY, declared_by
from kabo.tasks.files.costs import written_as
from kabo.tasks.files.kinds import kind_of
from kabo.tasks.files.registry import name_of
from kabo.tasks.files.values import number_of
from kabo.tasks.learned import Model
from kabo.whole_files import write_atomically

_PLAIN = re.compile(r"[A-Za-z0-9_./-](?:[A-Za-z0-9_./ +-]*[A-Za-z0-9_./+-])?")
_MARKS = ("---", "...", "- ", "-")
_UNPRINTABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufeff\ufffe\uffff\u2028\u2029]")
_MAX_INTEGER = 10**18  # larger integers are not read back from a file


def task_to_yaml(task: Task, *, max_solutions: int | None = None, timeout: float | None = None) -> str:
    """The task as the text of a task file; arguments bound to declared properties become their defaults.

    Args:
        task: the task, loaded from a file or built in Python.
        max_solutions, timeout: limits to be written into the file.

    Raises:
        ArgumentError: an argument is of a wrong kind, or no limit.
        TaskError: lists all parts that files cannot represent: functions, Python objects, unregistered stages.
    """
    return _text_of(task, {"max_solutions": max_solutions, "timeout": timeout}, None)


def _text_of(task: Task, limits: Mapping[str, float | None], folder: Path | None) -> str:
    """The text of a task file that will lie in a folder; None: models are named as they were."""
    require_given("task", task, Task)
    if limits["max_solutions"] is not None:
        require_number("max_solutions", limits["max_solutions"], 1, whole=True)
    if limits["timeout"] is not None:
        require_number("timeout", limits["timeout"], above=0.0)
    writer = _Writer(folder)
    lines = list(writer.task(task, limits))
    if writer.problems:
        listed = "\n".join(f"  - {problem}" for problem in writer.problems)
        raise TaskError(f"the task {task.name!r} cannot be written as a file:\n{listed}")
    return "\n".join(lines) + "\n"


def dump_task(
    task: Task, path: str | Path, *, max_solutions: int | None = None, timeout: float | None = None
) -> None:
    """Writes the task to a task file; on errors the file is unchanged.

    Raises:
        TaskError: lists all parts that files cannot represent: functions, Python objects, unregistered stages.
        ArgumentError: an argument is of a wrong kind, no limit, or no file in a folder that exists.
        OSError: the file cannot be written.
    """
    path = require_output("path", path)
    text = _text_of(task, {"max_solutions": max_solutions, "timeout": timeout}, path.parent)
    write_atomically(path, text.encode())


class _Writer:
    def __init__(self, folder: Path | None) -> None:
        self.problems: list[str] = []
        self.folder = folder

    def task(self, task: Task, limits: Mapping[str, float | None]) -> Iterator[str]:
        yield f"name: {self.text(task.name)}"
        inputs = {name: each for name, each in task.properties.declared.items() if _is_input(task, name)}
        if inputs:
            yield "properties:"
        for name, declared in inputs.items():
            kind = kind_of(declared)
            value = task.properties.given.get(name, declared.default)
            default = (
                "" if value is MISSING else f", default: {'' if value is None else self.value(task, name, value)}"
            )
            yield f"  {name}: {{type: {kind}{default}}}"
        yield from (f"{key}: {self.value(task, key, value)}" for key, value in limits.items() if value is not None)
        for name, value in task.properties.given.items():
            if name not in inputs:
                yield f"{name}: {self.value(task, name, value)}"
        yield from self.cost(task)
        yield "stages:"
        for child in task.children:
            yield from self.stage(child, "  ")

    def stage(self, stage: Stage, indent: str) -> Iterator[str]:
        lines = self.keys(stage)
        yield f"{indent}- {next(lines)}"
        yield from (f"{indent}  {line}" for line in lines)
        if not isinstance(stage, Container):
            return
        if isinstance(stage, Wrapper):
            yield f"{indent}  wrapped:"
        else:
            yield f"{indent}  stages:"
        for child in stage.children:
            yield from self.stage(child, f"{indent}    ")

    def keys(self, stage: Stage) -> Iterator[str]:
        name = name_of(type(stage))
        if name is None:
            problem = f"{stage.path!r}: {type(stage).__name__} is not registered (kabo.tasks.register)"
            self.problems.append(problem)
        yield f"name: {self.text(stage.name)}"
        yield f"stage: {self.text(name or '?')}"
        if isinstance(stage, Monitor):
            yield f"monitors: {self.text(self.monitors(stage))}"
        if isinstance(stage, Propagator) and stage.only is not None:
            yield f"only: {next(word for word, flow in ONLY.items() if flow is stage.only)}"
        yield from self.cost(stage)
        for key, value in stage.properties.given.items():
            yield f"{key}: {self.value(stage, key, value)}"

    def cost(self, stage: Stage) -> Iterator[str]:
        if stage.cost is None:
            return
        written = written_as(stage.cost)
        if written is None:
            self.problems.append(f"{stage.path!r}: its cost term has no form in files (kabo.tasks.register_cost)")
        else:
            yield f"cost: {self.value(stage, 'cost', written)}"

    def monitors(self, stage: Monitor) -> str:
        """The path to the monitored stage from the container of the monitoring generator."""
        if isinstance(stage.monitors, str):
            return stage.monitors
        steps: list[str] = []
        holder: Stage | None = stage.parent
        while holder is not None:
            if (below := _names_below(holder, stage.monitors)) is not None:
                return "/".join([*steps, *below])
            steps.append("..")
            holder = holder.parent
        problem = f"{stage.path!r}: no path leads to the stage {stage.monitors.path!r} that it monitors"
        self.problems.append(problem)
        return "?"

    # ---------------------------------------------------------------------------------------------------- values
    def value(self, stage: Stage, name: str, value: Any) -> str:
        """The value on one line, in YAML's flow style."""
        value = value.tolist() if hasattr(value, "tolist") else value
        if isinstance(value, Reference):
            if value.through is None:
                return str(value)
            return self.refuse(stage, name, "a function of Python")
        if isinstance(value, bool):
            return "true" if value else "false"
        if isinstance(value, int | float):
            return self.number(stage, name, value)
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, Mapping):
            inner = (f"{self.text(str(key))}: {self.value(stage, name, each)}" for key, each in value.items())
            return "{" + ", ".join(inner) + "}"
        if isinstance(value, Sequence):
            return "[" + ", ".join(self.value(stage, name, each) for each in value) + "]"
        if isinstance(value, Model) and value.path:
            return self.text(value.written if self.folder is None else os.path.relpath(value.path, self.folder))
        return self.refuse(stage, name, f"a value of type {type(value).__name__}")

    def number(self, stage: Stage, name: str, value: float) -> str:
        if not math.isfinite(value) or (isinstance(value, int) and abs(value) >= _MAX_INTEGER):
            return self.refuse(stage, name, repr(value))
        return repr(value)

    def text(self, text: str) -> str:
        plain = _PLAIN.fullmatch(text) is not None and number_of(text) is None and text not in ("true", "false")
        if plain and not text.startswith(_MARKS):
            return text
        escaped = text.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + _UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", escaped) + '"'

    def refuse(self, stage: Stage, name: str, what: str) -> str:
        self.problems.append(f"{stage.path!r}, property {name!r}: {what} has no form in files")
        return "?"


def _is_input(task: Task, name: str) -> bool:
    """Whether a property was declared by the task, and not only set."""
    declared = task.properties.declared[name]
    if name in declared_by(type(task)):
        return False
    return declared.type is not Any or name not in task.properties.given


def _names_below(holder: Stage, wanted: Stage) -> list[str] | None:
    """The names from `holder` down to a stage, if looking them up leads to that stage alone; else None."""
    names: list[str] = []
    here: Stage | None = wanted
    while here is not None and here is not holder:
        names.append(here.name)
        here = here.parent
    if here is None or not names:
        return None
    for name in reversed(names):
        found = [child for child in here.children if child.name == name]
        if len(found) != 1:
            return None
        here = found[0]
    return list(reversed(names)) if here is wanted else None
