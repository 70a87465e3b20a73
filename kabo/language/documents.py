"""YAML as marked text: a tree of scalars, lists and mappings that know their place and decide no types.

Read from parser events with an explicit stack: libyaml's composer would overflow the C stack on deep nesting, and
its trees would hide duplicate keys. What YAML could do beyond plain data (tags, anchors, aliases, merge keys, a
second document) is refused where it stands, so nothing is ever expanded.
"""

import re
from dataclasses import dataclass, field
from typing import Any

import yaml

from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.source import SourceFile

MAX_DEPTH = 40
MAX_NODES = 200_000

_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, eq=False)
class Node:
    """A piece of a file, from offset `start` up to `end`."""

    source: SourceFile
    start: int
    end: int

    @property
    def place(self) -> Place:
        """Where the piece stands."""
        return self.source.place(self.start, self.end)


@dataclass(frozen=True, eq=False)
class Scalar(Node):
    """A scalar: its text as YAML reads it; `style` is empty (plain), a quote, `|` or `>`."""

    text: str = ""
    style: str = ""
    refused: bool = False  # a tag or an alias stood here; that was reported

    @property
    def empty(self) -> bool:
        """Whether nothing is written here: `key:` and no more."""
        return not self.text and not self.style and not self.refused


@dataclass(frozen=True, eq=False)
class Sequence(Node):
    """A list; `flow` if it is written with brackets."""

    items: list[Node] = field(default_factory=list)
    flow: bool = False


@dataclass(frozen=True, eq=False)
class Mapping(Node):
    """A mapping of keys to values in the order of the file; `flow` if it is written with braces."""

    entries: dict[str, tuple[Scalar, Node]] = field(default_factory=dict)
    flow: bool = False

    def get(self, key: str) -> Node | None:
        """The value of `key`, or None if the key is absent."""
        entry = self.entries.get(key)
        return None if entry is None else entry[1]

    def key(self, key: str) -> Scalar:
        """The key itself, for its place."""
        return self.entries[key][0]


def size_of(node: Node) -> int:
    """How many nodes the tree below `node` has, itself included."""
    waiting, count = [node], 0
    while waiting:
        here = waiting.pop()
        count += 1
        if isinstance(here, Sequence):
            waiting.extend(here.items)
        elif isinstance(here, Mapping):
            waiting.extend(value for _, value in here.entries.values())
    return count


def read_document(source: SourceFile, findings: Findings) -> Mapping | None:
    """The mapping that `source` consists of; None if there is none or the YAML is broken. Findings say why."""
    findings.know(source)
    builder = _Builder(source, findings)
    try:
        for event in yaml.parse(source.text, Loader=_LOADER):
            if not builder.take(event):
                return None
    except yaml.MarkedYAMLError as error:
        _report_broken(source, findings, error)
        return None
    except yaml.reader.ReaderError as error:
        position = max(0, min(int(error.position), len(source.text)))
        findings.add(
            source.place(position), f"the character U+{_code(error.character):04X} is not allowed in YAML"
        )
        return None
    return builder.document()


def _code(character: object) -> int:
    return character if isinstance(character, int) else ord(str(character)[:1] or "\0")


_REMEDIES = (
    ("cannot start any token", "\t", "this is a tab: indent with blanks"),
    ("cannot start any token", "`@%", "put the value in double quotes"),
    ("mapping values are not allowed", ":", 'a value that contains ": " must stand in double quotes'),
    ("expected alphabetic or numeric character", "&", "write `and`, and not before the first formula"),
    ("expected alphabetic or numeric character", "*", "a value that begins with * must stand in double quotes"),
    ("tab character", "", "this is a tab: indent with blanks"),
)


def _report_broken(source: SourceFile, findings: Findings, error: Any) -> None:
    sign = error.context in ("while scanning an alias", "while scanning an anchor")
    mark = error.context_mark if sign else error.problem_mark or error.context_mark
    offset = 0 if mark is None else min(mark.index, len(source.text))
    before = source.text[max(0, offset - 1) : offset + 1]
    problem = error.problem or error.context or "broken"
    message = f"the YAML is broken here: {problem}" + (f" ({error.context})" if error.context else "")
    hints = (
        hint for part, signs, hint in _REMEDIES if part in problem and (not signs or set(signs) & set(before))
    )
    findings.add(source.place(offset), re.sub(r"'([^']*)'", r'"\1"', message), next(hints, None))


class _Builder:
    """The tree under construction: one frame for every list or mapping that is open."""

    def __init__(self, source: SourceFile, findings: Findings) -> None:
        self._source, self._findings = source, findings
        self._open: list[_Frame] = []
        self._root: Node | None = None
        self._nodes = self._documents = 0

    def take(self, event: Any) -> bool:
        """Adds what the event says; False if reading must stop."""
        if isinstance(event, yaml.DocumentStartEvent):
            self._documents += 1
            if self._documents > 1:
                self._report(event, "a second document begins here; a file holds one")
                return False
        elif isinstance(event, yaml.CollectionEndEvent):
            self._close(event.end_mark.index)
        elif isinstance(event, yaml.NodeEvent):
            return self._take_node(event)
        return True

    def _take_node(self, event: Any) -> bool:
        self._nodes += 1
        if self._nodes > MAX_NODES:
            self._report(event, f"the file has more than {MAX_NODES} values")
            return False
        self._refuse_extras(event)
        start, end = event.start_mark.index, event.end_mark.index
        if isinstance(event, yaml.CollectionStartEvent):
            if len(self._open) >= MAX_DEPTH:
                self._report(event, f"nested deeper than {MAX_DEPTH} levels")
                return False
            self._open.append(_Frame(isinstance(event, yaml.MappingStartEvent), start, bool(event.flow_style)))
        elif isinstance(event, yaml.AliasEvent):
            self._put(Scalar(self._source, start, end, "", "", True))
        else:
            self._put(Scalar(self._source, start, end, event.value, event.style or "", event.tag is not None))
        return True

    def _refuse_extras(self, event: Any) -> None:
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            kind = "alias" if isinstance(event, yaml.AliasEvent) else "anchor"
            hint = "`models` and `model:` say a thing once; in a formula write `and` instead of `&`"
            self._report(event, f'the {kind} "{event.anchor}" is not allowed in this file', hint, length=1)
        elif getattr(event, "tag", None) is not None:
            hint = "the place of a value decides its type; in a formula write `not` instead of `!`"
            self._report(event, f'the tag "{event.tag}" is not allowed', hint, length=1)

    def _put(self, node: Node) -> None:
        if not self._open:
            self._root = node
            return
        frame = self._open[-1]
        if not frame.is_mapping:
            frame.items.append(node)
        elif frame.key is None:
            frame.key = node
        else:
            self._put_entry(frame, frame.key, node)
            frame.key = None

    def _put_entry(self, frame: "_Frame", key: Node, value: Node) -> None:
        if not isinstance(key, Scalar):
            self._findings.add(key.place, "a key must be a word")
        elif key.text == "<<" and not key.style:
            self._findings.add(
                key.place, 'the merge key "<<" is not allowed', "`model:` copies the keys of a model"
            )
        elif key.text in frame.entries:
            first = frame.entries[key.text][0].place
            message = f'duplicate key "{key.text}"'
            self._findings.add(key.place, message, f"it stands already in line {first.line}")
        else:
            frame.entries[key.text] = (key, value)

    def _close(self, end: int) -> None:
        frame = self._open.pop()
        if frame.is_mapping:
            self._put(Mapping(self._source, frame.start, end, frame.entries, frame.flow))
        else:
            self._put(Sequence(self._source, frame.start, end, frame.items, frame.flow))

    def _report(self, event: Any, message: str, hint: str | None = None, *, length: int | None = None) -> None:
        start = event.start_mark.index
        place = self._source.place(start, event.end_mark.index if length is None else start + length)
        self._findings.add(place, message, hint)

    def document(self) -> Mapping | None:
        """The finished tree, if it is a mapping."""
        if isinstance(self._root, Mapping):
            return self._root
        if self._root is None or (isinstance(self._root, Scalar) and self._root.empty):
            self._findings.add(self._source.place(0), "the file is empty")
        else:
            self._findings.add(self._root.place, "the file must be a mapping: lines of the form `key: value`")
        return None


@dataclass
class _Frame:
    is_mapping: bool
    start: int
    flow: bool
    items: list[Node] = field(default_factory=list)
    entries: dict[str, tuple[Scalar, Node]] = field(default_factory=dict)
    key: Node | None = None
