"""The journal of an exploration, which is the model file: a header, then each trial, a line of JSON each.

Each line is on disk before the next question, so a program that is stopped loses nothing but a torn last line.
"""

import errno
import json
import os
import stat
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from io import FileIO
from os import PathLike
from pathlib import Path
from typing import Any, NoReturn

from kabo.errors import Diagnostic, InputError
from kabo.exploration.errors import ExplorationError
from kabo.exploration.exploration import Exploration
from kabo.exploration.records import Case, Parameters, Trial, Validity
from kabo.exploration.space import Space, unknown
from kabo.exploration.text import FORMAT, line_of, trial_to_json
from kabo.exploration.values import shown

HEADER = ("format", "name", "space", "outcomes", "validity", "invalid_budget", "start", "retry", "seed")
A_HEADER = 'a model begins with {"format": …; kabo explore run makes one of an exploration file'
TRIAL = ("case", "parameters", "valid", "outcomes", "reason")


def load_exploration(path: str | PathLike[str], name: str | None = None) -> Exploration:
    """The exploration in a journal, which messages call `name`; a torn last line is dropped.

    Raises:
        InputError: the file cannot be read, or is no journal, or a line of it is damaged; with its place.
    """
    return _read(Path(path), name or str(path))[0]


class Journal:
    """A journal that is open for appending, and the exploration that it holds.

    Several programs may append to one file at a time: each reads what the others have appended before it appends.
    """

    def __init__(self, path: Path, exploration: Exploration, length: int) -> None:
        """The journal of an exploration in the first `length` bytes of a file; use `create` or `resume`."""
        self.path, self.exploration, self._length = path, exploration, length

    @classmethod
    def create(cls, path: str | PathLike[str], exploration: Exploration) -> "Journal":
        """Writes the exploration to a new file, and returns the journal in it.

        Raises:
            FileExistsError: there is such a file; it is not overwritten, lest trials are lost.
            OSError: the folder cannot be written.
        """
        path = Path(path)
        if path.exists():
            raise FileExistsError(errno.EEXIST, "there is such a file already", str(path))
        exploration.save(path)
        return cls(path, exploration, path.stat().st_size)

    @classmethod
    def resume(cls, path: str | PathLike[str]) -> "Journal":
        """The journal in a file, to go on with; a torn last line is cut off.

        Raises:
            InputError: as `load_exploration`.
            OSError: the file cannot be written.
        """
        path = Path(path)
        exploration, whole, length = _read(path, str(path))
        journal = cls(path, exploration, whole)
        if whole < length:
            with _locked(path) as file:
                journal._take_in(file)
        return journal

    def tell(
        self,
        case: Case | None,
        parameters: Parameters,
        valid: bool,
        outcomes: Mapping[str, float] | None = None,
        reason: str = "",
    ) -> Trial:
        """Appends a trial to the file, and then adds it to the exploration.

        Trials that other programs have appended since are added to the exploration first.

        Raises:
            ExplorationError: as `Exploration.tell`; nothing is written.
            InputError: another program has damaged the file; nothing is written.
            OSError: the file cannot be written.
        """
        trial = self.exploration.checked_trial(case, parameters, valid, outcomes, reason)
        line = line_of(trial_to_json(trial)).encode()
        with _locked(self.path) as file:
            self._take_in(file)
            _append(file, line)
            self._length += len(line)
        return self.exploration.tell(case, parameters, valid, outcomes, reason)

    def _take_in(self, file: FileIO) -> None:
        """Adds the trials that other programs have appended to the locked file, and cuts off a torn last line."""
        length, reading = file.seek(0, os.SEEK_END), _Reading(str(self.path))
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            return
        if length < self._length:
            reading.fail(1, "another program has shortened this file", "begin again with what is in it now")
        file.seek(self._length)
        content = file.read(length - self._length)
        *lines, torn = content.split(b"\n")
        for text in lines:
            reading.trial(self.exploration, 2 + len(self.exploration.trials), text)
            self._length += len(text) + 1
        if torn:
            file.truncate(self._length)


@contextmanager
def _locked(path: Path) -> Iterator[FileIO]:
    """A context with an existing file, open for reading and writing, locked against other journals; raises OSError."""
    with path.open("r+b", buffering=0) as file:
        with suppress(ImportError, OSError):  # not on POSIX, or a file system without locks
            from fcntl import LOCK_EX, flock

            flock(file, LOCK_EX)
        yield file


def _append(file: FileIO, line: bytes) -> None:
    """Adds a line at the end of a file, whole or not at all, and waits until the disk has it; raises OSError."""
    length = file.seek(0, os.SEEK_END)
    try:
        if file.write(line) < len(line):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(file.name))
        os.fsync(file.fileno())
    except OSError:
        file.truncate(length)
        raise


def _read(path: Path, name: str) -> tuple[Exploration, int, int]:
    """The exploration in a file, the length of its whole lines, and that of the file [bytes]."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError([Diagnostic(name, 1, 1, error.strerror or "it cannot be read")]) from error
    whole = content.rfind(b"\n") + 1
    lines = content[:whole].split(b"\n")[:-1]
    reading = _Reading(name)
    if not lines:
        reading.fail(1, "this is no model of an exploration: it has no header", A_HEADER)
    exploration = reading.header(lines[0])
    for number, text in enumerate(lines[1:], 2):
        reading.trial(exploration, number, text)
    return exploration, whole, len(content)


class _Reading:
    """Reads the lines of one file; every fault is an InputError with its place."""

    def __init__(self, name: str) -> None:
        self.name = name

    def fail(self, line: int, message: str, hint: str | None = None, column: int = 1) -> NoReturn:
        raise InputError([Diagnostic(self.name, line, column, message, hint)])

    def header(self, text: bytes) -> Exploration:
        given = self.object(1, text)
        if given.get("format") != FORMAT:
            told = f", its format is {shown(given['format'])}" if "format" in given else ""
            self.fail(1, f"this is no model of an exploration{told}", f'the format of a model is "{FORMAT}"')
        self.keys(1, given, HEADER, HEADER)
        found: Exploration = self.checked(1, lambda: _exploration(given))
        for key, value in found.header.items():
            if given[key] != value:
                self.fail(1, f'"{key}" is not what kabo writes', f"that would be {shown(value)}")
        return found

    def trial(self, exploration: Exploration, number: int, text: bytes) -> None:
        given = self.object(number, text)
        valid: Any = given.get("valid")
        self.keys(number, given, TRIAL, ("case", "parameters", "valid", "outcomes" if valid is True else "reason"))
        told = self.checked(
            number,
            lambda: exploration.tell(
                given["case"], given["parameters"], valid, given.get("outcomes"), given.get("reason", "")
            ),
        )
        if trial_to_json(told) != given:
            self.fail(number, "the trial is not what kabo writes")

    def object(self, number: int, text: bytes) -> dict[str, Any]:
        try:
            value = json.loads(
                text.decode(), object_pairs_hook=_once, parse_int=_whole, parse_constant=_no_constant
            )
        except UnicodeDecodeError as error:
            self.fail(number, "this is no text in UTF-8", column=error.start + 1)
        except json.JSONDecodeError as error:
            self.fail(number, f"this is no JSON: {error.msg}", A_HEADER if number == 1 else None, error.colno)
        except RecursionError:
            self.fail(number, "brackets are nested too deep")
        except ValueError as error:
            self.fail(number, str(error))
        if not isinstance(value, dict):
            self.fail(number, "a line must be an object in braces")
        return value

    def keys(self, number: int, given: Mapping[str, Any], known: tuple[str, ...], needed: tuple[str, ...]) -> None:
        for key in given:
            if key not in known:
                self.fail(number, unknown("key", key, known))
        for key in needed:
            if key not in given:
                self.fail(number, f'the key "{key}" is missing')

    def checked(self, number: int, make: Callable[[], Any]) -> Any:
        try:
            return make()
        except ExplorationError as error:
            self.fail(number, str(error))
        except (AttributeError, KeyError, TypeError, ValueError, OverflowError):
            self.fail(
                number,
                "the header is not what kabo writes" if number == 1 else "the trial is not what kabo writes",
            )


def _exploration(given: Mapping[str, Any]) -> Exploration:
    space, outcomes, validity = given["space"], given["outcomes"], given["validity"]
    parameters = space["parameters"]
    return Exploration(
        Space(
            {name: (each["from"], each["to"]) for name, each in parameters.items()},
            space["cases"],
            {name: each["unit"] for name, each in parameters.items() if "unit" in each},
        ),
        outcomes,
        seed=given["seed"],
        validity=Validity(validity["scale"], validity["noise"], validity["alpha"]),
        invalid_budget=given["invalid_budget"],
        start=given["start"],
        retry=given["retry"],
        units={name: each["unit"] for name, each in outcomes.items() if "unit" in each},
        name=given["name"],
    )


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise ValueError(f"the key {shown(key)} stands here twice")
        found[key] = value
    return found


def _no_constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number that a model may have")


def _whole(text: str) -> float:
    """The number; a very long one as a float, since Python reads such whole numbers slowly, and refuses the longest."""
    return int(text) if len(text) < 40 else float(text)  # noqa: PLR2004
