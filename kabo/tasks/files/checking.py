"""Checks a task file against the stages that exist: every name, type and reference; reports all errors at once [T 3.7].

The result is a tree of recipes, from which any number of tasks can be made.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from kabo.errors import InputError
from kabo.language import STAGE_KEYS, TASK_KEYS, included_task_path
from kabo.language.findings import Findings, spell_place
from kabo.language.formulas import Place
from kabo.language.source import UnreadableError, beside
from kabo.language.task_description import (
    RISK,
    Entries,
    Items,
    StageDescription,
    TaskDescription,
    Word,
    Written,
    model_of_risk,
)
from kabo.tasks.core import MISSING, Container, Flow, Monitor, Propagator, Property, Serial, Stage, Wrapper
from kabo.tasks.core.model.properties import references
from kabo.tasks.files import registry
from kabo.tasks.files.costs import NamedCost, NoCost, cost_of
from kabo.tasks.files.including import (
    IncludedTask,
    check_keys,
    continued,
    given_values,
    included_task,
    missing_inputs,
    near_names,
)
from kabo.tasks.files.values import NoValue, described, parent_references, value_of
from kabo.tasks.learned import MisfitError, open_model

_MAX_NAMES = 500  # similar names are searched for among at most so many
ONLY = {"forward": Flow.FORWARD, "backward": Flow.BACKWARD}


@dataclass(frozen=True)
class Recipe:
    """The recipe for creating a stage: its class, and the values of its properties."""

    kind: type[Stage]
    name: str
    place: Place
    values: Mapping[str, Any]
    children: tuple["Recipe", ...] = ()
    monitors: str | None = None
    only: Flow | None = None
    cost: NamedCost | None = None


@dataclass(frozen=True)
class _Holder:
    """An ancestor of a stage, as references see it: the properties that it declares or sets."""

    name: str
    names: frozenset[str]
    description: StageDescription
    used: set[str] = field(default_factory=set)  # names that stages inside refer to
    root: bool = False  # whether it is the task of a file, which no path leaves


def check_task(task: TaskDescription, findings: Findings) -> Recipe | None:
    """The recipe of a task; None if it has errors, which are added to `findings`, those of all stages at once."""
    checking = _Checking(task, findings, (task.source.path.resolve(),))
    recipe = checking.recipe(task.root, ())
    return None if findings.errors else recipe


class _Checking:
    def __init__(self, task: TaskDescription, findings: Findings, chain: tuple[Path, ...]) -> None:
        self.task, self.findings = task, findings
        self.chain = chain  # the files that lead to this one, by the tasks that they include
        self._children: dict[int, dict[str, list[StageDescription]]] = {}

    def recipe(self, stage: StageDescription, above: tuple[_Holder, ...]) -> Recipe:
        root = not above
        included = None if root else self.included(stage)
        if included is not None:
            return self.include(stage, included, above)
        kind = Serial if root else self.kind(stage)
        declared = declared_by(kind or Container)
        if kind is not None:
            self.structure(stage, kind)
        values = self.values(stage, kind or Container, declared)
        names = {*declared, *stage.properties, *((each.name for each in self.task.inputs) if root else ())}
        here = _Holder(stage.name, frozenset(names), stage, root=root)
        self.references(stage, above)
        if not root:
            self.inherited(stage, declared, above)
        children = tuple(self.recipe(child, (*above, here)) for child in stage.children)
        if stage.children:
            self.unused(here, declared)
        monitors = self.monitors(stage, kind, above)
        only = self.only(stage, kind, declared)
        cost = self.cost(stage, declared)
        return Recipe(kind or Stage, stage.name, stage.place, values, children, monitors, only, cost)

    def kind(self, stage: StageDescription) -> type[Stage] | None:
        if stage.type is None:
            return None
        found = registry.find(stage.type)
        if found is None and included_task_path(stage.type, self.task.source.path.parent) is None:
            hint = near_names(stage.type, self.task.source.path.parent, self.findings)
            self.findings.add(stage.type_place, f'unknown stage "{stage.type}"', hint)
        return found

    # ----------------------------------------------------------------------------------------------- other tasks
    def included(self, stage: StageDescription) -> IncludedTask | None:
        """The task of another file that a stage stands for, unless there is a stage of that name."""
        if stage.type is None or registry.find(stage.type) is not None:
            return None
        return included_task(stage, self.task.source.path.parent, self.chain, self.findings)

    def include(self, stage: StageDescription, task: IncludedTask, above: tuple[_Holder, ...]) -> Recipe:
        """The recipe of a serial container with the stages of another task, its properties set on it."""
        check_keys(stage, self.findings)
        self.references(stage, above)
        root = task.description.root
        checking = _Checking(task.description, self.findings, task.chain)
        values = given_values(stage, task.description, self.findings)
        for name in missing_inputs(task.description, {**values, **stage.properties}):
            holder = next((each for each in reversed(above) if name in each.names), None)
            if holder is None:
                message = f'"{stage.name}" needs the property "{name}" of the task "{stage.type}"'
                self.findings.add(stage.place, message, "no ancestor has one of that name, either")
            else:
                holder.used.add(name)
        values |= checking.values(root, Container, {})
        here = _Holder(stage.name, frozenset({*values, *stage.properties}), root, root=True)
        children = tuple(checking.recipe(child, (*above, here)) for child in root.children)
        if not (len(above) == 1 and stage is self.task.root.children[0]):
            children = continued(children)
        cost = self.cost(stage, {}) or checking.cost(root, {})
        return Recipe(Serial, stage.name, stage.place, values, children, cost=cost)

    def structure(self, stage: StageDescription, kind: type[Stage]) -> None:
        """Reports children of a stage that can have none, and missing children."""
        wraps, holds = issubclass(kind, Wrapper), issubclass(kind, Container)
        wanted = "wrapped" if wraps else "stages" if holds else None
        given = {"stages": stage.stages is not None, "wrapped": stage.wrapped is not None}
        for key, is_given in given.items():
            if is_given and key != wanted:
                what = (
                    "wraps one stage: the key is `wrapped`" if wraps else f"it has {wanted or 'no stages inside'}"
                )
                self.findings.add(stage.place, f"{_is_a(stage)} and has no `{key}`", what)
            elif not is_given and key == wanted and not any(given.values()):
                self.findings.add(stage.place, f'{_is_a(stage)} and needs the key "{key}"')

    # ------------------------------------------------------------------------------------------------ properties
    def values(
        self, stage: StageDescription, kind: type[Stage], declared: Mapping[str, Property]
    ) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, written in stage.properties.items():
            if name not in declared and (name == "cost" or (name == "only" and issubclass(kind, Propagator))):
                continue  # not properties: see `only` and `cost`
            if name not in declared and not kind.OPEN:
                self.unknown(stage, name, declared)
                continue
            wanted = declared.get(name, Property())
            if wanted.opens is not None:
                values |= self.opened(stage, name, written, wanted.opens)
                continue
            try:
                values[name] = value_of(written, wanted)
            except NoValue as error:
                found = f', this is "{written.text[:60]}"' if isinstance(written, Word) else ""
                self.findings.add(written.place, f'"{name}" of "{stage.name}" must be {error}{found}')
                continue
            fault = wanted.fault(values[name])
            if fault is not None:
                place = _element(written, values[name], wanted, fault) or written.place
                self.findings.add(place, f'"{name}" of "{stage.name}" {fault}')
        for name, wanted in declared.items():
            if wanted.default is MISSING and name not in stage.keys:
                hint = f"{stage.type} has {described(declared)}"
                self.findings.add(stage.place, f'"{stage.name}" needs the property "{name}"', hint)
        for misfit in kind.misfits(values):
            place = _place_of(stage.properties, misfit.keys) or stage.place
            self.findings.add(place, f'"{stage.name}": {misfit.message}', misfit.hint)
        return values

    def opened(
        self, stage: StageDescription, name: str, written: Written, opens: Callable[[str, str], Any]
    ) -> dict[str, Any]:
        """The value of a property that a file holds, by its name; empty if it cannot be opened, which is reported."""
        if not isinstance(written, Word):
            told = "a reference will not do: what a plan depends on is known before planning"
            self.findings.add(written.place, f'"{name}" of "{stage.name}" must be the path of a file', told)
            return {}
        folder = str(self.task.source.path.parent)
        try:
            return {name: opens(written.text, folder)}
        except UnreadableError as error:
            hint = error.hint or self.findings.near_file(Path(beside(folder, written.text)))
            self.findings.add(written.place, f'"{written.text}": {error.message}', hint)
        except InputError as error:
            named = f"named in {spell_place(written.place)}"
            for each in error.diagnostics:
                hint = named if each.hint is None else f"{each.hint}; {named}"
                self.findings.add(Place(each.file, each.line, each.column, each.length), each.message, hint)
        return {}

    def inherited(
        self, stage: StageDescription, declared: Mapping[str, Property], above: tuple[_Holder, ...]
    ) -> None:
        """Reports properties that a stage inherits by default and that no ancestor has."""
        for key, wanted in declared.items():
            if key in stage.keys:
                continue
            for reference in references(wanted.default, key):
                if reference.source != "parent":
                    continue
                holder = next((each for each in reversed(above) if reference.name in each.names), None)
                if holder is not None:
                    holder.used.add(str(reference.name))
                    continue
                searched = ", ".join(f'"{each.name}"' for each in reversed(above))
                message = f'"{stage.name}" needs the property "{key}", which no ancestor has'
                self.findings.add(stage.place, message, f"searched {searched}")

    def unknown(self, stage: StageDescription, name: str, declared: Mapping[str, Property]) -> None:
        hint = self.findings.near(name, [*declared, *STAGE_KEYS], all_if_few=False)
        hint = hint or f"{stage.type} has {described(declared)}"
        self.findings.add(stage.keys[name], f'"{stage.name}" has no property "{name}"', hint)

    def unused(self, holder: _Holder, declared: Mapping[str, Property]) -> None:
        """Warns of properties that a container sets and nothing reads: often they are misspelt."""
        stage = holder.description
        for name, place in stage.keys.items():
            if name in declared or name in holder.used or name == "cost":
                continue
            keys = TASK_KEYS if stage is self.task.root else STAGE_KEYS
            hint = self.findings.near(name, [*declared, *keys], all_if_few=False)
            message = f'no stage inside "{stage.name}" refers to its "{name}"'
            self.findings.add(place, message, hint, warning=True)

    def references(self, stage: StageDescription, above: tuple[_Holder, ...]) -> None:
        """Reports every reference to a property that no ancestor has, with the ancestors in the order of the search."""
        for key, written in stage.properties.items():
            for name, reference in parent_references(written, key):
                holder = next((each for each in reversed(above) if name in each.names), None)
                if holder is not None:
                    holder.used.add(name)
                    continue
                if not above:
                    message = f"{reference} of the task itself ({key}) refers to nothing: a task has no ancestor"
                    hint = f"stages inside may refer to <PARENT:{name}> themselves"
                    self.findings.add(reference.place, message, hint)
                    continue
                path = "/".join([*(each.name for each in above[1:]), stage.name])
                searched = ", ".join(f'"{each.name}"' for each in reversed(above)) or "it has none"
                message = f'{reference} of "{path}" ({key}) refers to nothing: no ancestor has "{name}"'
                few = self.findings.may_suggest and sum(len(each.names) for each in above) <= _MAX_NAMES
                known = sorted({n for each in above for n in each.names}) if few else []
                near = self.findings.near(name, known, all_if_few=False)
                hint = f"searched {searched}" + (f"; {near}" if near else "")
                self.findings.add(reference.place, message, hint)

    # ---------------------------------------------------------------------------------------- monitors, directions
    def monitors(
        self, stage: StageDescription, kind: type[Stage] | None, above: tuple[_Holder, ...]
    ) -> str | None:
        written = stage.monitors
        monitoring = kind is not None and issubclass(kind, Monitor)
        if written is None:
            if monitoring:
                hint = "the path of the stage whose successes trigger it, such as ../open"
                self.findings.add(stage.place, f'"{stage.name}" needs the key "monitors"', hint)
            return None
        if kind is not None and not monitoring:
            message = f"{_is_a(stage)}, which monitors no other stage"
            self.findings.add(written.place, message)
            return None
        return self.follow(written, stage, above)

    def follow(self, written: Word, stage: StageDescription, above: tuple[_Holder, ...]) -> str:
        """The path as relative to the container of the stage; reports a path that leads to no stage, and where it fails."""
        up, here, text = list(above), above[-1].description, written.text
        rises = 0
        if text.startswith("/"):  # from the task of this file
            rises = next(k for k, each in enumerate(reversed(above)) if each.root)
            text = "/".join([*[".."] * rises, text.lstrip("/")])
        for step in text.split("/"):
            if step in ("", "."):
                continue
            if step == "..":
                if up.pop().root:
                    hint = f'the path begins in "{above[-1].name}", which holds "{stage.name}"'
                    self.findings.add(written.place, f'"{written.text}" leads out of the task', hint)
                    return text
                here = up[-1].description
                continue
            inner = self.children(here).get(step, [])
            if len(inner) != 1:
                self.no_step(written, step, here, inner)
                return text
            here = inner[0]
            up.append(_Holder(here.name, frozenset(), here))
        if here is stage:
            self.findings.add(written.place, f'"{stage.name}" cannot monitor itself')
        return text

    def no_step(self, written: Word, step: str, here: StageDescription, found: list[StageDescription]) -> None:
        """Reports a step of a path for which there is no stage, or more than one."""
        if not found:
            near = self.findings.near(step, list(self.children(here)))
            self.findings.add(written.place, f'there is no stage "{step}" in "{here.name}"', near)
            return
        lines = list(dict.fromkeys(str(each.place.line) for each in found))
        where = f"the line{'s' if len(lines) > 1 else ''} {' and '.join(lines)}"
        message = f'"{here.name}" has {len(found)} stages "{step}", and the path does not say which'
        self.findings.add(written.place, message, f"give them names that differ: they are in {where}")

    def children(self, stage: StageDescription) -> dict[str, list[StageDescription]]:
        """The stages inside another one by name, in order of time; of an included task, those of its file."""
        if id(stage) not in self._children:
            known = self._children[id(stage)] = {}
            inner = self.included(stage) if stage is not self.task.root else None
            for child in stage.children if inner is None else inner.description.root.children:
                known.setdefault(child.name, []).append(child)
        return self._children[id(stage)]

    def only(
        self, stage: StageDescription, kind: type[Stage] | None, declared: Mapping[str, Property]
    ) -> Flow | None:
        """The direction to which the file restricts a propagator; None: no restriction."""
        written = stage.properties.get("only")
        if written is None or kind is None or "only" in declared or not issubclass(kind, Propagator):
            return None
        found = ONLY.get(written.text) if isinstance(written, Word) else None
        if found is None:
            self.findings.add(written.place, f'`only` of "{stage.name}" must be forward or backward')
        return found

    def cost(self, stage: StageDescription, declared: Mapping[str, Property]) -> NamedCost | None:
        """The cost term that replaces the stage's own costs; None: no such term."""
        written = stage.properties.get("cost")
        if written is None or "cost" in declared:
            return None
        value, model = value_of(written, Property()), model_of_risk(stage)
        if model is not None:
            opened = self.opened(stage, "model", model, open_model)
            if not opened:
                return None
            value = {RISK: {**value[RISK], **opened}}
        try:
            return cost_of(value)
        except MisfitError as error:
            for each in error.misfits:
                place = _place_of(stage.properties, ("cost", RISK, *each.keys)) or written.place
                self.findings.add(place, f'`cost` of "{stage.name}": {each.message}', each.hint)
            return None
        except NoCost as error:
            self.findings.add(written.place, f'`cost` of "{stage.name}": {error}', error.hint)
            return None


def _element(written: Written, value: Any, wanted: Property, fault: str) -> Place | None:
    """The place of the first element that alone is refused in the same words; None of what is no list, or a whole one."""
    for inner, one in zip(written.values, value, strict=True) if isinstance(written, Items) else ():
        if wanted.fault([one]) == fault:
            return inner.place
    return None


def _place_of(properties: Mapping[str, Written], keys: Sequence[str]) -> Place | None:
    """The place of the innermost value to which the keys lead; None if they lead to none."""
    place = None
    here: Written | None = Entries(properties, Place("", 1, 1)) if keys else None
    for key in keys:
        here = here.values.get(key) if isinstance(here, Entries) else None
        place = place if here is None else here.place
    return place


def declared_by(kind: type[Stage]) -> dict[str, Property]:
    """The properties that a stage class and its base classes declare."""
    declared: dict[str, Property] = {}
    for base in reversed(kind.__mro__):
        declared |= getattr(base, "PROPERTIES", {})
    return declared


def _is_a(stage: StageDescription) -> str:
    """The beginning of a sentence about a stage: its name, and of which type it is."""
    article = "an" if str(stage.type)[:1] in tuple("AEIOU") else "a"
    return f'"{stage.name}" is {article} {stage.type}'
