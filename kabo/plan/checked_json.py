"""JSON values with their paths: every wrong value becomes a diagnostic with its JSON path, and reading goes on.

`JsonValue` wraps a value, its path (`$.nodes.n3.motion[0].times`) and the list of findings that all values share.
"""

import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

from kabo.errors import Diagnostic, InputError, did_you_mean

_T = TypeVar("_T")
_TEXT, _BRACKET = re.compile(r'"(?:[^"\\]|\\.)*"'), re.compile(r"[\[\]{}]")

MAX_DEPTH = 40  # nested brackets; a plan never has as many, and deeper files are refused before they are parsed
MAX_FINDINGS = 100  # reported for one file: one missing bracket should not print a megabyte


class JsonValue:
    """A JSON value at a path; `file` and `findings` are shared by all values of one file."""

    def __init__(self, value: Any, path: str, file: str, findings: list[Diagnostic]) -> None:
        self.value, self.path, self.file, self.findings = value, path, file, findings

    def add_finding(self, message: str, hint: str | None = None) -> None:
        """Adds a finding about this value."""
        if len(self.findings) < MAX_FINDINGS:
            self.findings.append(Diagnostic(self.file, 1, 1, f"{self.path}: {message}", hint))

    def at(self, step: str | int, value: Any) -> "JsonValue":
        """An entry of this JSON value, wrapped with its own path: `step` is the key or index of the entry."""
        path = f"{self.path}[{step}]" if isinstance(step, int) else f"{self.path}.{step}"
        return JsonValue(value, path, self.file, self.findings)

    def expected(self, what: str) -> None:
        """Adds the finding that `what` was expected instead of this value."""
        self.add_finding(f"expected {what}, found {_shown(self.value)}")

    def refuse_other_files(self, needed: str, others: Mapping[str, tuple[str, str]]) -> None:
        """Refuses a file of kabo that says itself what it is, and is not what is needed: its keys are no findings then.

        Raises:
            InputError: `others` has its format, with what such a file is, and a remedy.
        """
        name = self.value.get("format") if isinstance(self.value, dict) else None
        kind = name.partition("/")[0] if isinstance(name, str) else ""
        if kind in others:
            what, remedy = others[kind]
            raise InputError([Diagnostic(self.file, 1, 1, f"{needed} is needed here, this is {what}", remedy)])

    # ---------------------------------------------------------------------------------------------- leaves
    def text(self) -> str:
        """This value as text; anything else is a finding."""
        if isinstance(self.value, str):
            return self.value
        self.expected("a text")
        return ""

    def text_or_null(self) -> str | None:
        """This value as text, or None for null; anything else is a finding."""
        return None if self.value is None else self.text()

    def number(self) -> float:
        """This value as a finite number; anything else is a finding."""
        if isinstance(self.value, int | float) and not isinstance(self.value, bool):
            try:
                number = float(self.value)
            except OverflowError:
                number = math.inf
            if math.isfinite(number):
                return number + 0.0
        self.expected("a finite number")
        return 0.0

    def index(self) -> int:
        """This value as a non-negative whole number; anything else is a finding."""
        if isinstance(self.value, int) and not isinstance(self.value, bool) and self.value >= 0:
            return self.value
        self.expected("a number 0, 1, 2, …")
        return 0

    def one_of(self, *allowed: str) -> str:
        """This value as one of the allowed words; anything else is a finding."""
        word = self.text()
        if isinstance(self.value, str) and word not in allowed:
            self.add_finding(f'"{word}" is none of {", ".join(allowed)}', did_you_mean(word, allowed))
        return word

    # -------------------------------------------------------------------------------------------- containers
    def items(self, least: int = 0, exactly: int | None = None) -> list["JsonValue"]:
        """The items of this list; it is a finding if there are fewer than `least`, or not `exactly` as many."""
        if not isinstance(self.value, list):
            self.expected("a list")
            return []
        if exactly is not None and len(self.value) != exactly:
            self.add_finding(f"expected {exactly} entries, found {len(self.value)}")
        elif len(self.value) < least:
            self.add_finding(f"expected at least {least}, found {len(self.value)}")
        return [self.at(i, value) for i, value in enumerate(self.value)]

    def mapping(self) -> dict[str, "JsonValue"]:
        """The entries of this object; anything else is a finding."""
        if not isinstance(self.value, dict):
            self.expected("an object")
            return {}
        return {key: self.at(key, value) for key, value in self.value.items()}

    def fields(self, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> Mapping[str, "JsonValue"]:
        """The entries of this object; unknown keys, and required ones that are missing, are findings."""
        found = self.mapping()
        for key in found:
            if key not in required and key not in optional:
                self.add_finding(f'unknown key "{key}"', did_you_mean(key, [*required, *optional]))
        if isinstance(self.value, dict):
            for key in required:
                if key not in found:
                    self.add_finding(f'"{key}" is missing')
        return _Fields(self, found)


class _Fields(Mapping[str, JsonValue]):
    """The entries of an object; a missing one reads as null, without a second finding."""

    def __init__(self, owner: JsonValue, found: dict[str, JsonValue]) -> None:
        self.owner, self.found = owner, found

    def __getitem__(self, key: str) -> JsonValue:
        return self.found[key] if key in self.found else JsonValue(None, f"{self.owner.path}.{key}", "", [])

    def __contains__(self, key: object) -> bool:
        return key in self.found

    def __iter__(self) -> Iterator[str]:
        return iter(self.found)

    def __len__(self) -> int:
        return len(self.found)


def read_checked(content: bytes, file: str, read: Callable[[JsonValue], _T]) -> _T:
    """The result of `read` for the contents of a JSON file.

    Raises:
        InputError: the file is not valid JSON, is nested deeper than `MAX_DEPTH`, has a duplicate key, or `read`
            added findings.
    """
    findings: list[Diagnostic] = []
    value = _parse(content, file, findings)
    if findings:
        raise InputError(findings)
    result = read(JsonValue(value, "$", file, findings))
    if findings:
        raise InputError(findings)
    return result


def _parse(content: bytes, file: str, findings: list[Diagnostic]) -> Any:
    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key, value in pairs:
            if key in result:
                findings.append(Diagnostic(file, 1, 1, f'the key "{key}" stands twice in one object'))
            result[key] = value
        return result

    def refuse(message: str, line: int = 1, column: int = 1, hint: str | None = None) -> InputError:
        return InputError([Diagnostic(file, line, column, message, hint)])

    try:
        text = content.decode("utf-8")
        if _depth(text) > MAX_DEPTH:
            raise refuse(f"nested deeper than {MAX_DEPTH}")
        value = json.loads(text, object_pairs_hook=unique, parse_constant=_Constant)
    except UnicodeDecodeError as error:
        raise refuse(f"not UTF-8: byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise refuse(f"not JSON: {error.msg}", error.lineno, error.colno) from None
    except (RecursionError, ValueError) as error:  # ValueError: an integer of thousands of digits
        raise refuse(f"not usable as JSON: {error}") from None
    if "NaN" in text or "Infinity" in text:
        _add_constants(JsonValue(value, "$", file, findings))
    return value


class _Constant(str):
    """`NaN` or `Infinity`, which is no number of JSON though Python reads it."""


def _add_constants(place: JsonValue) -> None:
    """Adds a finding for each value that is no number of JSON."""
    if isinstance(place.value, _Constant):
        place.add_finding(f"{place.value} is no number of JSON", "every number must be finite")
    for key, value in _entries(place.value):
        _add_constants(place.at(key, value))


def _entries(value: Any) -> Iterable[tuple[str | int, Any]]:
    if isinstance(value, dict):
        return value.items()
    return enumerate(value) if isinstance(value, list) else ()


def _depth(text: str) -> int:
    """The deepest nesting of brackets outside texts, counted before the recursive parser is called."""
    deepest = depth = 0
    for bracket in _BRACKET.findall(_TEXT.sub("", text)):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    return deepest


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "an object"
    if isinstance(value, list):
        return "a list"
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 40 else text[:37] + "…"
