"""XML files of others (URDF, SRDF) as elements with their places, and valid numbers in their attributes.

Errors are collected, so that all findings of a file are reported at once. Entities are not read, and neither depth nor
size of a file is unlimited.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NoReturn, TypeVar
from xml.etree import ElementTree  # noqa: S405  only files without entities are read
from xml.parsers import expat

from kabo.errors import Diagnostic, InputError
from kabo.language.formulas import Place
from kabo.language.source import reason_of

Element = ElementTree.Element
T = TypeVar("T")

MAX_FILE_BYTES = 16_000_000  # bytes
MAX_DEPTH = 40  # levels of nested elements
MAX_LENGTH = 1000.0  # [m] of an origin or a size
MAX_FINDINGS = 200  # of one file; further ones are counted
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_MAX_SHOWN_CHARACTERS = 40  # of a value that a message repeats
_MAX_SHOWN_LINE = 400  # characters of a line that a message quotes


def shortened(text: str) -> str:
    """The beginning of a text that a message repeats."""
    return text[:_MAX_SHOWN_CHARACTERS]


@dataclass
class Collected:
    """The findings of one file, collected while it is read."""

    found: list[Diagnostic] = field(default_factory=list)

    @contextmanager
    def kept(self) -> Iterator[None]:
        """Keeps the findings of an InputError that is raised within; what follows is read nevertheless."""
        try:
            yield
        except InputError as error:
            self.found.extend(error.diagnostics)

    def tried(self, make: Callable[[], T]) -> T | None:
        """The result of `make()`; None, and the findings are kept, if it raises an InputError."""
        with self.kept():
            return make()
        return None

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """All findings without duplicates; of very many the first ones, and how many there are."""
        found = list(dict.fromkeys(self.found))
        if len(found) <= MAX_FINDINGS:
            return found
        last = found[MAX_FINDINGS - 1]
        return [*found[: MAX_FINDINGS - 1], replace(last, message=f"{last.message} (of {len(found)} findings)")]

    def finish(self) -> None:
        """Raises an error if there are findings that are errors.

        Raises:
            InputError: carries all findings.
        """
        if any(each.severity == "error" for each in self.found):
            raise InputError(self.diagnostics)


@dataclass(frozen=True)
class XmlFile:
    """An XML file: its elements, and where each of them begins. `what`: how messages call the file."""

    path: Path
    root: Element
    places: dict[Element, tuple[int, int]] = field(repr=False)
    lines: tuple[str, ...] = field(repr=False)
    what: str = "robot file"

    def finding(
        self, element: Element, message: str, hint: str | None = None, *, warning: bool = False
    ) -> Diagnostic:
        """The finding about an element, at its place in the file."""
        line, column = self.places[element]
        severity = "warning" if warning else "error"
        length, source = len(element.tag) + 1, _shown_line(self.lines, line)
        return Diagnostic(str(self.path), line, column, message, hint, length, severity, source)  # type: ignore[arg-type]

    def wrong(self, element: Element, message: str, hint: str | None = None) -> InputError:
        """The error about an element, at its place in the file."""
        return InputError([self.finding(element, message, hint)])

    def place(self, element: Element) -> Place:
        """The place of an element."""
        return Place(str(self.path), *self.places[element], len(element.tag) + 1)

    def numbers(
        self,
        element: Element,
        key: str,
        count: int,
        default: str | None = None,
        largest: float = MAX_LENGTH,
    ) -> list[float]:
        """The numbers of an attribute; `default` where it is absent.

        Raises:
            InputError: the attribute is absent without a default, has more or fewer numbers, or a word that is no
            number.
        """
        text = element.get(key, default)
        if text is None:
            example = " ".join(["0.1"] * count)
            raise self.wrong(element, f"<{element.tag}> has no `{key}`", f'write {key}="{example}"')
        return self.numbers_in(element, f"`{key}` of <{element.tag}>", text, count, largest)

    def numbers_in(
        self, element: Element, named: str, text: str, count: int, largest: float = MAX_LENGTH
    ) -> list[float]:
        """The numbers of a text that stands in an element; `named`: how messages call it.

        Raises:
            InputError: there are more or fewer numbers than `count`, a word that is no number, or too large a number.
        """
        words = text.split()
        wanted = "a number" if count == 1 else f"{count} numbers"
        hint = (
            "write it with a point: 0.1" if count == 1 else f"write them with spaces: {' '.join(['0.1'] * count)}"
        )
        if "${" in text or "$(" in text:
            hint = "expand it with xacro, or name it .xacro"
        if len(words) != count:
            raise self.wrong(element, f'{named} must be {wanted}, this is "{shortened(text)}"', hint)
        for word in words:
            if not _NUMBER.fullmatch(word):
                raise self.wrong(element, f'{named} must be {wanted}, "{shortened(word)}" is none', hint)
            if not abs(float(word)) <= largest:
                said = f"{named} is too large: {shortened(word)}; {largest:g} is the most"
                raise self.wrong(element, said, "lengths are metres, angles radians")
        return [float(word) for word in words]

    def size(self, element: Element, key: str, count: int = 1) -> list[float]:
        """The numbers of an attribute that holds positive lengths."""
        values = self.numbers(element, key, count)
        if not min(values) >= 1e-6:
            said = f"`{key}` of <{element.tag}> must be above 0, at least a micrometre"
            raise self.wrong(element, said, "sizes are metres")
        return values


def _shown_line(lines: tuple[str, ...], line: int) -> str | None:
    shown = lines[line - 1] if 0 < line <= len(lines) else None
    return None if shown is None or len(shown) > _MAX_SHOWN_LINE else shown


def read_bytes(path: Path, place: Place | None, what: str = "robot file") -> bytes:
    """The bytes of a file.

    Args:
        path: the file.
        place: the place in another file that names it, for error messages.
        what: how messages call the file.

    Raises:
        InputError: the file cannot be read, or is too large.
    """
    at = place or Place(str(path), 1, 1)

    def unreadable(reason: str, hint: str | None = None) -> InputError:
        said = f'{what} "{path.name}" cannot be read: {reason}'
        return InputError([Diagnostic(at.file, at.line, at.column, said, hint, at.length)])

    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            hint = "meshes belong into files of their own: <mesh filename=…>"
            raise unreadable(f"it is larger than {MAX_FILE_BYTES // 10**6} MB", hint)
        return path.read_bytes()
    except (OSError, ValueError) as error:
        raise unreadable(reason_of(error)) from None


def parsed(path: Path, content: bytes, what: str = "robot file") -> XmlFile:
    """The elements of an XML text with their places.

    Raises:
        InputError: it is no XML, nests too deep, or defines entities.
    """
    lines = _lines(content)
    places: dict[Element, tuple[int, int]] = {}
    builder, depth = ElementTree.TreeBuilder(), 0
    parser = expat.ParserCreate()

    def refuse(message: str, line: int, column: int, hint: str | None = None) -> NoReturn:
        said, source = f'{what} "{path.name}" {message}', _shown_line(lines, line)
        raise InputError([Diagnostic(str(path), max(line, 1), column, said, hint, 1, "error", source)])

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        place = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1
        if depth > MAX_DEPTH:
            refuse(f"nests elements deeper than {MAX_DEPTH}", *place, "is it the file that you mean?")
        places[builder.start(tag, attributes)] = place

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def entity(*_: object) -> None:
        hint = "write the text itself in place of the entity"
        refuse("defines XML entities, which kabo does not read", parser.CurrentLineNumber, 1, hint)

    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        reason = expat.errors.messages.get(error.code, "broken")
        refuse(f"is no XML: {reason}", error.lineno, error.offset + 1, _XML_REMEDIES.get(reason))
    except (ValueError, LookupError) as error:  # an encoding that nobody knows
        refuse(f"is no XML: {error}", parser.CurrentLineNumber, 1, "save the file as UTF-8")
    return XmlFile(path, builder.close(), places, lines, what)


_XML_REMEDIES = {
    "no element found": "the file ends before its elements are closed: was it copied whole?",
    "unclosed token": "the file ends within an element: was it copied whole?",
    "mismatched tag": "each element is closed by its own name: <link> … </link>, or <link … />",
    "not well-formed (invalid token)": 'values stand in quotes, "<" and "&" are written &lt; and &amp;, the text is UTF-8',
    "undefined entity": "write the text itself in place of the entity",
    "unknown encoding": "save the file as UTF-8",
    "duplicate attribute": "write it once",
    "unbound prefix": "declare it in the first element: xmlns:…, or process the file with xacro",
    "junk after document element": "a file has one <robot>, with everything in it",
}


def _lines(content: bytes) -> tuple[str, ...]:
    """The lines for messages; expat counts those of the text, whatever its encoding."""
    encoding = "utf-16" if content[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig"
    return tuple(content.decode(encoding, "replace").replace("\r\n", "\n").replace("\r", "\n").split("\n"))
