"""Every error class of kabo, and the diagnostic that people read: place, what is wrong, the remedy.

"No plan", "budget exhausted" and "not verified" are results. Errors are what keeps kabo from answering.
"""

import difflib
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal


@dataclass(frozen=True)
class About:
    """What a finding about a scene is about, so that it can be shown there.

    `things` are bodies, regions and `robot.link`; a robot's name means all its links. `metres` is how deep two things
    overlap (then below 0), or how far they are apart. `values` are a robot and its configuration in which it is so;
    None: as at the start.
    """

    things: tuple[str, ...]
    metres: float | None = None
    values: tuple[str, tuple[float, ...]] | None = None


@dataclass(frozen=True, order=True)
class Diagnostic:
    """One error or warning about an input file. `line` and `column` count from 1; `length` counts carets."""

    file: str
    line: int
    column: int
    message: str
    hint: str | None = None
    length: int = 1
    severity: Literal["error", "warning"] = "error"
    source: str | None = None  # the line of the file, if it is text
    about: About | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        """The finding as compilers write it: `file:line:column: message`, the line, a caret, the remedy."""
        text = f"{self.file}:{self.line}:{self.column}: "
        text += ("warning: " if self.severity == "warning" else "") + self.message
        if self.source is not None:
            caret = " " * (self.column - 1) + "^" * max(1, min(self.length, len(self.source) - self.column + 1))
            text += f"\n{self.line:>5} | {self.source}\n      | {caret}"
        if self.hint is not None:
            text += f"\n      = {self.hint}"
        return text


def by_place(diagnostic: Diagnostic) -> tuple[str, int, int, str]:
    """The key by which findings are sorted: file, line, column, message."""
    return diagnostic.file, diagnostic.line, diagnostic.column, diagnostic.message


class KaboError(Exception):
    """A defect of kabo itself, when none of the classes below fits (exit code 1)."""

    exit_code = 1


class InputError(KaboError):
    """The error for unusable input: carries every diagnostic found, sorted by place (exit code 2)."""

    exit_code = 2

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(sorted(diagnostics, key=by_place))
        super().__init__("\n".join(map(str, self.diagnostics)))

    def __reduce__(self) -> tuple[type["InputError"], tuple[tuple[Diagnostic, ...]]]:
        """Another process gets the findings, not their text."""
        return type(self), (self.diagnostics,)


class ArgumentError(InputError, TypeError, ValueError):
    """The error for an argument of a function in Python that it cannot take (exit code 2).

    It is Python's `TypeError` and `ValueError` as well. `str` gives what is wrong, and the remedy if there is one; the
    argument's name is the `file` of its diagnostic.
    """

    def __init__(self, name: str, message: str, hint: str | None = None) -> None:
        super().__init__([Diagnostic(name, 1, 1, message, hint)])
        self.args = (message if hint is None else f"{message}; {hint}",)

    def __reduce__(self) -> tuple[type["ArgumentError"], tuple[str, str, str | None]]:  # type: ignore[override]
        """Another process gets the name, what is wrong, and the remedy."""
        (only,) = self.diagnostics
        return type(self), (only.file, only.message, only.hint)


class MeshError(InputError):
    """A mesh that cannot be used: counts and the remedy (exit code 2)."""


class CutOff(KaboError):
    """Work ended without an answer, because a budget was spent or the caller asked to stop (exit code 4).

    Raised wherever a stop flag is checked and found set. It means only that there is no answer: nothing is refused
    or proven by it. The stop flag names the budget that was spent.
    """

    exit_code = 4
    details: tuple[str, ...] = ()  # sentences about what is done and what is not

    def __init__(self, message: str = "it was cut off") -> None:
        super().__init__(message)


class ServiceError(KaboError):
    """The error of a failed request, with its id: no server, a busy one, cancelled, worker lost (exit code 6)."""

    exit_code = 6

    def __init__(
        self, code: str, message: str, *, request: str | None = None, retry_after_s: float | None = None
    ) -> None:
        self.code, self.request, self.retry_after_s = code, request, retry_after_s
        super().__init__(message)

    def __reduce__(self) -> tuple[partial["ServiceError"], tuple[str, str]]:
        """Another process gets the request's id and the time as well."""
        return partial(type(self), request=self.request, retry_after_s=self.retry_after_s), (self.code, str(self))


@contextmanager
def naming(**files: os.PathLike[str] | str | None) -> Iterator[None]:
    """Findings in the block about a `plan` or a `state` in memory name the file that it was read from."""
    try:
        yield
    except InputError as error:
        named = (replace(each, file=str(files.get(each.file) or each.file)) for each in error.diagnostics)
        raise InputError(named) from error.__cause__


def did_you_mean(word: object, known: Iterable[str]) -> str | None:
    """The remedy `did you mean "…"?` with the known word nearest to `word`, or None if none is near, or it is no word."""
    if not isinstance(word, str):
        return None
    ordered = sorted(known)
    near = [each for each in ordered if each.lower() == word.lower()] or difflib.get_close_matches(
        word, ordered, n=1
    )
    return f'did you mean "{near[0]}"?' if near else None


def missing_library(error: BaseException) -> str | None:
    """The remedy in one line if `error` is a shared library that the system lacks, else None."""
    text = str(error)
    if not isinstance(error, ImportError) or "cannot open shared object file" not in text:
        return None
    library = text.split(":", maxsplit=1)[0].strip()
    package = {"libgomp.so.1": "libgomp1"}.get(library, library)
    return f"the system library {library} is missing: install it, e.g. with `apt-get install {package}`"
