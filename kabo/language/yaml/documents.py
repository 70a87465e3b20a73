"""YAML documents as trees of scalars, lists and mappings with places; scalars stay text.

The trees are built from parser events with an explicit stack: libyaml's composer would overflow the C stack on
deep nesting, and its trees would hide duplicate keys. YAML features beyond plain data (tags, anchors, aliases,
merge keys, a second document) are reported as errors, so nothing is ever expanded. Only task files may have
anchors and aliases [T 3.7]: an alias refers to the same node as its anchor, so this node occurs several times in
the tree. The limits on size apply to the expanded tree, which is never built.
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
class YamlNode:
    """A piece of a file, from offset `start` up to `end`."""

    source: SourceFile
    start: int
    end: int

    @property
    def place(self) -> Place:
        """The place of the piece in the file."""
        return self.source.place(self.start, self.end)


@dataclass(frozen=True, eq=False)
class Scalar(YamlNode):
    """A scalar: its text as YAML reads it; `style` is empty (plain), a quote, `|` or `>`."""

    text: str = ""
    style: str = ""
    refused: bool = False  # a tag or an alias stood here; that was reported

    @property
    def empty(self) -> bool:
        """Whether the scalar is empty, as in `key:` without a value."""
        return not self.text and not self.style and not self.refused


@dataclass(frozen=True, eq=False)
class Sequence(YamlNode):
    """A list; `flow` is true if it is written with brackets."""

    items: list[YamlNode] = field(default_factory=list)
    flow: bool = False


@dataclass(frozen=True, eq=False)
class Mapping(YamlNode):
    """A mapping of keys to values in the order of the file; `flow` is true if it is written with braces."""

    entries: dict[str, tuple[Scalar, YamlNode]] = field(default_factory=dict)
    flow: bool = False

    def get(self, key: str) -> YamlNode | None:
        """The value of `key`, or None if the key is absent."""
        entry = self.entries.get(key)
        return None if entry is None else entry[1]

    def key(self, key: str) -> Scalar:
        """The scalar that is the key itself, for its place in the file."""
        return self.entries[key][0]


def size_of(node: YamlNode) -> int:
    """The number of nodes of the tree below `node`, itself included."""
    waiting, count = [node], 0
    while waiting:
        here = waiting.pop()
        count += 1
        if isinstance(here, Sequence):
            waiting.extend(here.items)
        elif isinstance(here, Mapping):
            waiting.extend(value for _, value in here.entries.values())
    return count


def read_document(source: SourceFile, findings: Findings, *, aliases: bool = False) -> Mapping | None:
    """Parses a YAML file into its mapping; None if it is not a mapping or not valid YAML, which is reported.

    With `aliases`, anchors and aliases are allowed, and each alias is replaced by the node of its anchor.
    """
    findings.know(source)
    builder = _DocumentBuilder(source, findings, aliases)
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
    if "maximum nesting depth" in problem:  # newer libyaml gives up by itself, at a greater depth than ours
        findings.add(source.place(offset), f"nested deeper than {MAX_DEPTH} levels", None)
        return
    message = f"the YAML is broken here: {problem}" + (f" ({error.context})" if error.context else "")
    hints = (
        hint for part, signs, hint in _REMEDIES if part in problem and (not signs or set(signs) & set(before))
    )
    findings.add(source.place(offset), re.sub(r"'([^']*)'", r'"\1"', message), next(hints, None))


class _DocumentBuilder:
    """The tree under construction: one frame for every list or mapping that is open."""

    def __init__(self, source: SourceFile, findings: Findings, aliases: bool) -> None:
        self._source, self._findings = source, findings
        self._open: list[_Frame] = []
        self._root: YamlNode | None = None
        self._nodes = self._documents = 0
        self._anchors: dict[str, _Anchored] | None = {} if aliases else None

    def take(self, event: Any) -> bool:
        """Adds the node of a parser's event; returns False if reading must stop."""
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
        self._refuse_extras(event)
        start, end = event.start_mark.index, event.end_mark.index
        if isinstance(event, yaml.AliasEvent):
            return self._take_alias(event, start, end)
        if not self._count(event, 1):
            return False
        if isinstance(event, yaml.CollectionStartEvent):
            if not self._fits(event, 1):
                return False
            is_mapping = isinstance(event, yaml.MappingStartEvent)
            anchor = self._anchor(event)
            self._open.append(_Frame(is_mapping, start, bool(event.flow_style), anchor, self._nodes - 1))
        else:
            scalar = Scalar(self._source, start, end, event.value, event.style or "", event.tag is not None)
            if (name := self._anchor(event)) is not None and self._anchors is not None:
                self._anchors[name] = _Anchored(scalar, 1, 0)
            self._put(scalar)
        return True

    def _count(self, event: Any, more: int) -> bool:
        self._nodes += more
        if self._nodes > MAX_NODES:
            self._report(event, f"the file has more than {MAX_NODES} values")
        return self._nodes <= MAX_NODES

    def _fits(self, event: Any, levels: int) -> bool:
        """Whether so many more levels may stand here."""
        if len(self._open) + levels > MAX_DEPTH:
            self._report(event, f"nested deeper than {MAX_DEPTH} levels")
            return False
        if self._open:
            self._open[-1].levels = max(self._open[-1].levels, levels)
        return True

    # ---------------------------------------------------------------------------------------- anchors, aliases
    def _anchor(self, event: Any) -> str | None:
        """The anchor that an event brings, if anchors are allowed; reports one that is taken."""
        name = event.anchor
        if name is None or self._anchors is None:
            return None
        if name in self._anchors:
            self._report(event, f'the anchor "{name}" is defined twice', length=len(name) + 1)
        self._anchors[name] = _Anchored(None, 0, 0)  # open: what it stands for is not complete yet
        return str(name)

    def _take_alias(self, event: Any, start: int, end: int) -> bool:
        found = None if self._anchors is None else self._anchors.get(event.anchor)
        refused = Scalar(self._source, start, end, "", "", True)
        if found is None or found.node is None:
            if self._anchors is not None:
                self._report_alias(event, self._anchors)
            self._put(refused)
            return self._count(event, 1)
        if self._open and self._open[-1].is_mapping and self._open[-1].key is None:
            self._report(event, "an alias cannot be a key")
            self._put(refused)
            return self._count(event, 1)
        if not self._count(event, found.size) or not self._fits(event, found.levels):
            return False
        self._put(found.node)
        return True

    def _report_alias(self, event: Any, anchors: dict[str, "_Anchored"]) -> None:
        name = event.anchor
        if name in anchors:
            self._report(event, f'the alias "{name}" stands inside its own anchor', "nothing can contain itself")
        else:
            hint = (
                self._findings.near(name, list(anchors))
                if anchors
                else "an anchor &name stands before its aliases"
            )
            self._report(event, f'there is no anchor "{name}" before this alias', hint)

    def _refuse_extras(self, event: Any) -> None:
        if self._anchors is None and (isinstance(event, yaml.AliasEvent) or event.anchor is not None):
            kind = "alias" if isinstance(event, yaml.AliasEvent) else "anchor"
            hint = "`models` and `model:` say a thing once; in a formula write `and` instead of `&`"
            self._report(event, f'the {kind} "{event.anchor}" is not allowed in this file', hint, length=1)
        elif getattr(event, "tag", None) is not None:
            hint = "the place of a value decides its type; in a formula write `not` instead of `!`"
            self._report(event, f'the tag "{event.tag}" is not allowed', hint, length=1)

    def _put(self, node: YamlNode) -> None:
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

    def _put_entry(self, frame: "_Frame", key: YamlNode, value: YamlNode) -> None:
        if not isinstance(key, Scalar):
            self._findings.add(key.place, "a key must be a word")
        elif key.text == "<<" and not key.style:
            hint = "`model:` copies the keys of a model" if self._anchors is None else "write the keys out"
            self._findings.add(key.place, 'the merge key "<<" is not allowed', hint)
        elif key.text in frame.entries:
            first = frame.entries[key.text][0].place
            message = f'duplicate key "{key.text}"'
            self._findings.add(key.place, message, f"it stands already in line {first.line}")
        else:
            frame.entries[key.text] = (key, value)

    def _close(self, end: int) -> None:
        frame = self._open.pop()
        node: YamlNode
        if frame.is_mapping:
            node = Mapping(self._source, frame.start, end, frame.entries, frame.flow)
        else:
            node = Sequence(self._source, frame.start, end, frame.items, frame.flow)
        levels = frame.levels + 1
        if frame.anchor is not None and self._anchors is not None:
            self._anchors[frame.anchor] = _Anchored(node, self._nodes - frame.before, levels)
        if self._open:
            self._open[-1].levels = max(self._open[-1].levels, levels)
        self._put(node)

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


@dataclass(frozen=True)
class _Anchored:
    """What an anchor stands for (None as long as that is still open), with the size of the expanded tree."""

    node: YamlNode | None
    size: int
    levels: int


@dataclass
class _Frame:
    is_mapping: bool
    start: int
    flow: bool
    anchor: str | None = None
    before: int = 0  # how many nodes there were before
    levels: int = 0  # of lists and mappings, nested inside
    items: list[YamlNode] = field(default_factory=list)
    entries: dict[str, tuple[Scalar, YamlNode]] = field(default_factory=dict)
    key: YamlNode | None = None
