"""Task files: declared properties, and the tree of stages, as plain data with places.

Source: T 3.7, docs/reference/tasks.md#task-files.

The types of stages and the meanings of their properties are not known here; the package `kabo.tasks` checks them.
"""

import re
from pathlib import Path

from kabo.content_cache import ContentCache
from kabo.errors import InputError
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.names import NAME, proper_name
from kabo.language.source import SourceFile, UnreadableError, read_source
from kabo.language.task_description import (
    KINDS,
    Input,
    PropertyReference,
    StageDescription,
    TaskDescription,
    Value,
    Word,
    Written,
)
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode, read_document
from kabo.language.yaml.values import Reader
from kabo.language.yaml.written_values import read_written

TASK_KEYS = ("name", "properties", "max_solutions", "timeout", "stages")
STAGE_KEYS = ("name", "stage", "stages", "wrapped", "monitors")
INPUT_KEYS = ("type", "default")
ROOT_TYPE = "SerialContainer"
_REFERENCE = re.compile(r"<(PARENT|INTERFACE)(?::([A-Za-z_][A-Za-z0-9_]*))?>")
_LIKE_REFERENCE = re.compile(r"<\s*([A-Za-z]*)\s*(?::\s*([^<>]*?))?\s*>")
_SOURCES = ("PARENT", "INTERFACE")
_BYTES_OF_CHARACTER = 100  # that a description takes for each character of its file
_DESCRIPTIONS: ContentCache[TaskDescription | None] = ContentCache(
    8 << 20, lambda read: 0 if read is None else _BYTES_OF_CHARACTER * len(read.source.text)
)
_WHOLE = re.compile(r"[+-]?[0-9]{1,18}")


def load_task_description(path: Path, name: str | None = None) -> TaskDescription:
    """The task that a file describes; the file is called `name` in messages.

    Raises:
        InputError: the file has errors; all of them are listed.
    """
    findings = Findings()
    task = find_task(path, name or str(path), findings)
    if task is None or findings.errors:
        raise InputError(findings.diagnostics)
    return task


def find_task(path: Path, name: str, findings: Findings) -> TaskDescription | None:
    """The task that a file describes; None if it cannot be read, which is reported."""
    try:
        source = read_source(path, name)
    except UnreadableError as error:
        findings.add_unreadable(name, error)
        return None
    return read_task_text(source, findings)


def read_task_text(source: SourceFile, findings: Findings) -> TaskDescription | None:
    """The task that `source` describes; None if it cannot be read, which is reported."""
    found = _DESCRIPTIONS.get_or_make((source.path, source.name, source.text), lambda: _faultless(source))
    if found is None:  # what is wrong is told each time
        return _read_text(source, findings)
    findings.know(source)
    return found


def _faultless(source: SourceFile) -> TaskDescription | None:
    """The task that `source` describes; None if there is anything to say about it."""
    own = Findings()
    found = _read_text(source, own)
    return None if own.diagnostics else found


def _read_text(source: SourceFile, findings: Findings) -> TaskDescription | None:
    root = read_document(source, findings, aliases=True)
    return None if root is None else read_task(root, findings)


def read_task(root: Mapping, findings: Findings) -> TaskDescription:
    """The task that a document describes; the document must have been read with `aliases`."""
    reading = _Reading(findings)
    return reading.task(root)


class _Reading:
    def __init__(self, findings: Findings) -> None:
        self.findings, self.reader = findings, Reader(findings)

    def task(self, root: Mapping) -> TaskDescription:
        reader = self.reader
        name_node = reader.require(root, "name", "a task")
        name = self.stage_name(name_node, "a task") or ""
        inputs = self.inputs(root.get("properties"))
        stages = reader.require(root, "stages", "a task")
        for key in ("stage", "wrapped", "monitors"):
            if key in root.entries:
                hint = "a task is a serial container: its stages stand in `stages`"
                self.findings.add(root.key(key).place, f'a task has no key "{key}"', hint)
        properties, keys = self.properties(root, (*TASK_KEYS, *STAGE_KEYS))
        self.check_once(inputs, keys)
        place = root.place if name_node is None else name_node.place
        tree = StageDescription(
            name, ROOT_TYPE, place, place, self.stages(stages, "a task"), None, None, properties, keys
        )
        return TaskDescription(
            name, inputs, tree, reader.whole(root.get("max_solutions"), "`max_solutions`", 1),
            reader.positive(root.get("timeout"), "`timeout`"), root.source,
        )  # fmt: skip

    def check_once(self, inputs: tuple[Input, ...], keys: dict[str, Place]) -> None:
        """Reports properties that are both declared as inputs and set to a value."""
        for each in inputs:
            if each.name in keys:
                hint = f"declared in line {each.place.line}; a value that it has if none is given is its `default`"
                message = f'"{each.name}" is declared in `properties` and set beside them'
                self.findings.add(keys[each.name], message, hint)

    # ------------------------------------------------------------------------------------- declared properties
    def inputs(self, node: YamlNode | None) -> tuple[Input, ...]:
        if isinstance(node, Sequence):  # as the thesis prints it: names without types
            return self.named_inputs(node)
        found = []
        for name, key, value in self.reader.entries(node, "the properties"):
            if self.reader.check_name(key, "a property"):
                found.append(self.input(name, key, value))
        return tuple(found)

    def named_inputs(self, node: Sequence) -> tuple[Input, ...]:
        found: dict[str, Input] = {}
        for item in node.items:
            name = self.reader.name(item, "a property")
            if name is not None and name in found:
                self.findings.add(item.place, f'the property "{name}" is declared twice')
            elif name is not None:
                found[name] = Input(name, "any", item.place)
        return tuple(found.values())

    def input(self, name: str, key: Scalar, node: YamlNode) -> Input:
        what = f'the property "{name}"'
        if not isinstance(node, Mapping):
            if isinstance(node, Scalar) and node.empty:
                self.findings.add(key.place, f"{what} has no type", f"the types are {', '.join(KINDS)}")
                return Input(name, None, key.place)
            return Input(name, self.reader.choice(node, KINDS, f"the type of {what}"), key.place)
        self.reader.keys(node, INPUT_KEYS, what)
        kind_node = self.reader.require(node, "type", what, key)
        kind = self.reader.choice(kind_node, KINDS, f"the type of {what}")
        if "default" not in node.entries:
            return Input(name, kind, key.place)
        default = node.get("default")
        if isinstance(default, Scalar) and default.empty:
            return Input(name, kind, key.place, required=False)
        return Input(name, kind, key.place, False, self.value_of(default, kind, f"the default of {what}"))

    def value_of(self, node: YamlNode | None, kind: str | None, what: str) -> Value | Written:
        if kind == "any":
            return None if node is None else read_written(node, what, self.findings, self.reference)
        if kind == "number":
            return self.number(node, what)
        if kind == "boolean":
            return self.reader.boolean(node, what)
        if isinstance(node, Scalar) and node.style and not node.refused:
            return node.text  # quoted, it may be empty
        return self.reader.text(node, what)

    def number(self, node: YamlNode | None, what: str) -> float | int | None:
        if isinstance(node, Scalar) and _WHOLE.fullmatch(node.text.strip()):
            return int(node.text)
        return self.reader.number(node, what, angle=True)

    # ---------------------------------------------------------------------------------------------------- stages
    def stages(self, node: YamlNode | None, of: str) -> tuple[StageDescription, ...]:
        if node is None:
            return ()
        if not isinstance(node, Sequence):
            if not getattr(node, "refused", False):
                self.findings.add(node.place, f'the stages of {of} must be a list: lines that begin with "- "')
            return ()
        if not node.items:
            self.findings.add(node.place, f"{of} needs at least one stage")
        found = (self.stage(item, f"stage {number} of {of}") for number, item in enumerate(node.items, 1))
        return tuple(each for each in found if each is not None)

    def stage(self, node: YamlNode, what: str) -> StageDescription | None:
        if not isinstance(node, Mapping):
            if not getattr(node, "refused", False):
                self.findings.add(node.place, f"{what} must be a mapping with the keys `name` and `stage`")
            return None
        reader = self.reader
        name_node = reader.require(node, "name", what)
        name = self.stage_name(name_node, what)
        called = what if name is None else f'the stage "{name}"'
        type_node = reader.require(node, "stage", called, name_node)
        type_name = reader.text(type_node, f"the type of {called}")
        properties, keys = self.properties(node, STAGE_KEYS)
        stages = self.stages(node.get("stages"), called) if "stages" in node.entries else None
        wrapped = self.wrapped(node, called)
        if stages is not None and "wrapped" in node.entries:
            hint = "a container has `stages`, a wrapper `wrapped`"
            self.findings.add(node.key("wrapped").place, f"{called} has both `stages` and `wrapped`", hint)
        monitors = self.reader.scalar(node.get("monitors"), f"`monitors` of {called}")
        place = (name_node or node).place
        return StageDescription(
            name or "?", type_name, place, (type_node or name_node or node).place, stages, wrapped,
            None if monitors is None else Word(monitors.text, bool(monitors.style), monitors.place), properties, keys,
        )  # fmt: skip

    def wrapped(self, node: Mapping, called: str) -> StageDescription | None:
        child = node.get("wrapped")
        if child is None:
            return None
        if isinstance(child, Sequence):
            if len(child.items) != 1:
                self.findings.add(
                    child.place, f"{called} wraps one stage, not {len(child.items)}",
                    "put several into a container and wrap that",
                )  # fmt: skip
                return None
            child = child.items[0]
        return self.stage(child, f"what {called} wraps")

    def stage_name(self, node: YamlNode | None, what: str) -> str | None:
        scalar = self.reader.scalar(node, f"the name of {what}")
        if scalar is None:
            return None
        if "/" in scalar.text or scalar.text in (".", "..") or scalar.text != scalar.text.strip():
            hint = "the path of a stage joins the names with /"
            self.findings.add(scalar.place, f'"{scalar.text[:60]}" cannot be the name of a stage', hint)
            return None
        return scalar.text

    def properties(self, node: Mapping, reserved: tuple[str, ...]) -> tuple[dict[str, Written], dict[str, Place]]:
        values: dict[str, Written] = {}
        places: dict[str, Place] = {}
        for key, (scalar, value) in node.entries.items():
            if key in reserved:
                continue
            if not NAME.fullmatch(key):
                hint = f'write "{proper_name(key)}": names match [a-z][a-z0-9_]*'
                self.findings.add(scalar.place, f'"{key[:60]}" cannot be the name of a property', hint)
                continue
            written = read_written(value, f'the property "{key}"', self.findings, self.reference)
            places[key] = scalar.place
            if written is not None:
                values[key] = written
        return values, places

    def reference(self, scalar: Scalar) -> PropertyReference | None:
        text = scalar.text.strip()
        if (found := _REFERENCE.fullmatch(text)) is not None:
            return PropertyReference("PARENT" if found[1] == "PARENT" else "INTERFACE", found[2], scalar.place)
        if (like := _LIKE_REFERENCE.fullmatch(text)) is not None and not scalar.style:
            word = like[1].upper()
            meant = (
                None
                if word == like[1] and word in _SOURCES
                else self.findings.near(word, _SOURCES, all_if_few=False)
            )
            hint = (
                meant or "references are <PARENT>, <PARENT:name> and <INTERFACE:name>; other text stands in quotes"
            )
            self.findings.add(scalar.place, f'"{text[:60]}" is no reference', hint)
        return None
