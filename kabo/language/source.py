"""Text files as they lie on disk: decoded once, with the place of every character.

A place is computed from an offset and only when a finding needs it, so reading costs nothing for correct files.
"""

import hashlib
import os
import re
import stat
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from kabo.language.formulas import Place

MAX_BYTES = 1_000_000
_LONGEST_LINE = 400
_LINE_BREAK = re.compile(r"\r\n|\n|\r")


class UnreadableError(Exception):
    """A file that cannot be read as text: says why, the remedy, and where if the place is known."""

    def __init__(self, message: str, hint: str | None = None, offset: int | None = None, text: str = "") -> None:
        super().__init__(message)
        self.message, self.hint, self.offset, self.text = message, hint, offset, text


@dataclass(frozen=True, eq=False)
class SourceFile:
    """A text file: `name` as people see it in messages, `digest` the SHA-256 of its bytes."""

    path: Path
    name: str
    text: str = field(repr=False)
    digest: str = ""

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(found.end() for found in _LINE_BREAK.finditer(self.text))]

    def place(self, start: int, end: int | None = None) -> Place:
        """The place of the characters from `start` up to `end` (of their first line, if there are several)."""
        starts = self._starts
        line = bisect_right(starts, start)
        end = start + 1 if end is None else end
        if line == len(starts) or end > starts[line] - 2:  # else no line break is near
            end = min(end, self.bounds(line)[1])
        return Place(self.name, line, start - starts[line - 1] + 1, max(1, end - start))

    def bounds(self, number: int) -> tuple[int, int]:
        """Where the line `number` (from 1) begins and ends, without its line break."""
        begin = self._starts[number - 1]
        end = self._starts[number] if number < len(self._starts) else len(self.text)
        while end > begin and self.text[end - 1] in "\r\n":
            end -= 1
        return begin, end

    def shown_line(self, number: int) -> str | None:
        """The line if it is short enough to be shown: a file may be a single line of megabytes."""
        if not 1 <= number <= len(self._starts):
            return None
        begin, end = self.bounds(number)
        return self.text[begin:end] if end - begin <= _LONGEST_LINE else None

    def line(self, number: int) -> str:
        """The line `number` (from 1) without its line break; empty behind the end."""
        if not 1 <= number <= len(self._starts):
            return ""
        begin, end = self.bounds(number)
        return self.text[begin:end]


def read_source(path: Path, name: str, most: int = MAX_BYTES) -> SourceFile:
    """The file `path` of at most `most` bytes as text, called `name` in messages; a byte order mark is dropped.

    Raises:
        UnreadableError: it is missing, a folder, no ordinary file, too large, or not UTF-8.
    """
    data = _read_bytes(path, most)
    digest = "sha256:" + hashlib.sha256(data).hexdigest()
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        readable = data.decode("utf-8-sig", errors="replace")
        offset = len(data[: error.start].decode("utf-8-sig", errors="replace"))
        raise UnreadableError("this is not UTF-8 text", "save the file as UTF-8", offset, readable) from None
    return SourceFile(path, name, text, digest)


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
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise UnreadableError(f"the file cannot be read: {reason}") from None
    if len(data) > most:
        raise UnreadableError(f"the file is larger than {most // 1_000_000} MB")
    return data


def missing_file_reason(path: Path) -> str | None:
    """Why `path` cannot be opened as a file, or None if it seems that it can; reads nothing."""
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        return "there is no such file"
    except (OSError, ValueError) as error:
        return f"the file cannot be read: {getattr(error, 'strerror', None) or error}"
    if stat.S_ISDIR(mode):
        return "this is a folder, not a file"
    return None if os.access(path, os.R_OK) else "the file cannot be read: Permission denied"
