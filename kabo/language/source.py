"""Text files with the place (line and column) of every character.

Line and column are computed from an offset only when a diagnostic needs them, so correct files cost no time.
"""

import hashlib
import logging
import os
import re
import stat
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from kabo.language.formulas import Place

_LOG = logging.getLogger("kabo.language")
MAX_BYTES = 1_000_000
_LONGEST_LINE = 400
OUTSIDE = "the file lies outside of the folder that may be read"
_LINE_BREAK = re.compile(r"\r\n|\n|\r")


class UnreadableError(Exception):
    """A file that cannot be read as text; carries the reason, a remedy and, if known, the offset."""

    def __init__(self, message: str, hint: str | None = None, offset: int | None = None, text: str = "") -> None:
        super().__init__(message)
        self.message, self.hint, self.offset, self.text = message, hint, offset, text

    def place(self, name: str) -> Place:
        """The place of the fault in the file called `name`; the beginning of the file if no offset is known."""
        before = self.text[: self.offset or 0]
        return Place(name, before.count("\n") + 1, len(before) - before.rfind("\n"))


@dataclass(frozen=True, eq=False)
class SourceFile:
    """A text file: `name` is its name in messages, `digest` the SHA-256 of its bytes."""

    path: Path
    name: str
    text: str = field(repr=False)
    digest: str = ""

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(found.end() for found in _LINE_BREAK.finditer(self.text))]

    def place(self, start: int, end: int | None = None) -> Place:
        """The place of the characters from `start` up to `end`; it ends with the first of several lines."""
        starts = self._starts
        line = bisect_right(starts, start)
        end = start + 1 if end is None else end
        if line == len(starts) or end > starts[line] - 2:  # else no line break is near
            end = min(end, self.bounds(line)[1])
        return Place(self.name, line, start - starts[line - 1] + 1, max(1, end - start))

    def bounds(self, number: int) -> tuple[int, int]:
        """The offsets at which the line `number` (from 1) begins and ends, without its line break."""
        begin = self._starts[number - 1]
        end = self._starts[number] if number < len(self._starts) else len(self.text)
        while end > begin and self.text[end - 1] in "\r\n":
            end -= 1
        return begin, end

    def shown_line(self, number: int) -> str | None:
        """The line `number` (from 1), or None if it is too long to be shown: a single line may have megabytes."""
        if not 1 <= number <= len(self._starts):
            return None
        begin, end = self.bounds(number)
        return self.text[begin:end] if end - begin <= _LONGEST_LINE else None

    def line(self, number: int) -> str:
        """The line `number` (from 1) without its line break; empty if the file has fewer lines."""
        if not 1 <= number <= len(self._starts):
            return ""
        begin, end = self.bounds(number)
        return self.text[begin:end]


def beside(folder: str, written: str) -> str:
    """The path `written`, taken relative to `folder`, with `..` removed without following links."""
    return os.path.normpath(os.path.join(folder, written))


def lies_within(path: Path, folder: Path | None) -> bool:
    """Whether `path`, with symbolic links followed, lies in `folder`; True if `folder` is None."""
    try:
        return folder is None or path.resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a null character, a circle of links
        return False


def read_source(path: Path, name: str, most: int = MAX_BYTES, *, within: Path | None = None) -> SourceFile:
    """The file `path` of at most `most` bytes as text, called `name` in messages; a byte order mark is dropped.

    Raises:
        UnreadableError: the file is missing, not an ordinary file, too large, not UTF-8, or outside of `within`.
    """
    if not lies_within(path, within):
        raise UnreadableError(OUTSIDE)
    data = _read_bytes(path, most)
    _LOG.debug("read %s", name, extra={"fields": {"file": str(path), "bytes": len(data)}})
    digest = "sha256:" + hashlib.sha256(data).hexdigest()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        readable = data.decode("utf-8-sig", errors="replace")
        offset = len(data[: error.start].decode("utf-8-sig", errors="replace"))
        raise UnreadableError("this is not UTF-8 text", "save the file as UTF-8", offset, readable) from None
    return SourceFile(path, name, text, digest)


def reason_of(error: OSError | ValueError) -> str:
    """The reason why a path cannot be opened, as text; the text does not depend on the version of Python."""
    return (error.strerror or str(error)) if isinstance(error, OSError) else "embedded null byte"


def _read_bytes(path: Path, most: int) -> bytes:
    try:
        mode = os.stat(path).st_mode
        if stat.S_ISDIR(mode):
            raise UnreadableError("this is a folder, not a file")
        if not stat.S_ISREG(mode):
            raise UnreadableError("this is not an ordinary file")
        with path.open("rb") as file:
            data = file.read(most + 1)
    except FileNotFoundError:
        raise UnreadableError("there is no such file") from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the path
        raise UnreadableError(f"the file cannot be read: {reason_of(error)}") from None
    if len(data) > most:
        raise UnreadableError(f"the file is larger than {most // 1_000_000} MB")
    return data


def missing_file_reason(path: Path) -> str | None:
    """The reason why `path` cannot be opened as a file, or None if it can; the file is not read."""
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:
        return f"the file cannot be read: {reason_of(error)}"
    if stat.S_ISDIR(mode):
        return "this is a folder, not a file"
    return None if os.access(path, os.R_OK) else "the file cannot be read: Permission denied"
