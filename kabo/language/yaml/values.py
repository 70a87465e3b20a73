"""Readers of scalars and mappings: the key of a scalar decides its type, never the form of its text.

Every method returns the value that it reads, or None after it has reported an error.
"""

import math
import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from kabo.language.findings import Findings
from kabo.language.names import NAME, RESERVED, proper_name
from kabo.language.scene_description import FARTHEST
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode
from kabo.options import LARGEST_EPSILON, SMALLEST_EPSILON

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
_NUMBER = re.compile(r"([+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)[ \t]*(deg)?")
# Limits of velocity, acceleration and jerk [rad or m, and s]: beyond them times are no whole microseconds, or centuries.
RATES = 1e-6, 1e5
_LENGTH = re.compile(r"([+-]?\d+(?:\.\d+)?)\s*(mm|cm|m)")
_RATE = re.compile(r"([+-]?\d+(?:\.\d+)?)\s*(rad|deg|m|mm|cm)/s(?:\^?[23]|[²³])?")
_LARGEST_WHOLE = 10**18
SMALLEST_SIZE = 1e-6  # m
_Word = TypeVar("_Word", bound=str)


@dataclass(frozen=True)
class Reader:
    """Reads values from nodes of a YAML file; errors are reported to `findings`.

    `within`: if given, no file outside of this folder is accessed.
    """

    findings: Findings
    within: Path | None = None

    # --------------------------------------------------------------------------------------------- structure
    def mapping(self, node: YamlNode | None, what: str) -> Mapping | None:
        """The node if it is a mapping; None if it is absent, empty, or something else, which is reported."""
        if isinstance(node, Mapping) or node is None:
            return node
        if not (isinstance(node, Scalar) and node.empty):
            self.findings.add(node.place, f"{what} must be a mapping: `name: value`, one a line")
        return None

    def entries(self, node: YamlNode | None, what: str) -> Iterator[tuple[str, Scalar, YamlNode]]:
        """The key, the key's scalar and the value of every entry of a mapping; nothing if the node is absent."""
        mapping = self.mapping(node, what)
        for key, (scalar, value) in {} if mapping is None else mapping.entries.items():
            yield key, scalar, value

    def keys(self, mapping: Mapping, allowed: Collection[str], what: str) -> None:
        """Reports the keys of `mapping` that are not allowed in `what`."""
        for key, (scalar, _) in mapping.entries.items():
            if key in allowed:
                continue
            if mapping.flow and key.count("(") != key.count(")"):
                self._report_cut(scalar, "{ }")
                return
            hint = self.findings.near(key, allowed) or f"it has {', '.join(allowed)}"
            self.findings.add(scalar.place, f'unknown key "{key}" of {what}', hint)

    def require(self, mapping: Mapping, key: str, what: str, at: YamlNode | None = None) -> YamlNode | None:
        """The value of a required key, which must not be empty; None if it is, which is reported."""
        node = mapping.get(key)
        if node is None:
            place = (at or mapping).place
            self.findings.add(place, f'{what} needs the key "{key}"')
        elif isinstance(node, Scalar) and node.empty:
            self.findings.add(mapping.key(key).place, f'the key "{key}" of {what} has no value')
            return None
        return node

    def items(self, node: YamlNode | None, what: str) -> list[YamlNode]:
        """The items of a list; a single item may be written without brackets, an absent node is an empty list."""
        if node is None or (isinstance(node, Scalar) and node.empty):
            return []
        if isinstance(node, Sequence):
            return node.items
        if isinstance(node, Mapping):
            self.findings.add(node.place, f"{what} must be a list")
            return []
        return [node]

    def formulas(self, node: YamlNode | None, what: str) -> list[Scalar]:
        """The formulas in a list; formulas that the commas of a YAML flow list have split are reported as such."""
        found: list[Scalar] = []
        open_parentheses = 0
        flow = isinstance(node, Sequence) and node.flow
        for item in self.items(node, what):
            if not isinstance(item, Scalar):
                self._report_no_text(item, what)
                continue
            surplus = 0 if item.style else item.text.count("(") - item.text.count(")")
            if flow and (open_parentheses or surplus > 0):
                if not open_parentheses:
                    self._report_cut(item, "[ ]")
                open_parentheses = max(0, open_parentheses + surplus)
            elif item.refused:
                continue
            elif item.empty:
                self.findings.add(item.place, f"{what} is missing after the dash")
            else:
                found.append(item)
        return found

    def _report_cut(self, scalar: Scalar, brackets: str) -> None:
        message = f"this formula is cut in two: inside {brackets} YAML separates at every comma"
        self.findings.add(scalar.place, message, 'write one formula a line after "- ", or put it in double quotes')

    def _report_no_text(self, node: YamlNode, what: str) -> None:
        hint = None
        if isinstance(node, Mapping) and not node.flow:
            hint = 'a formula that contains ": " must stand in double quotes'
        self.findings.add(node.place, f"{what} must be text, this is {_kind(node)}", hint)

    # ----------------------------------------------------------------------------------------------- scalars
    def scalar(self, node: YamlNode | None, what: str) -> Scalar | None:
        """The node if it is a scalar that is not empty; otherwise None."""
        if node is None:
            return None
        if not isinstance(node, Scalar):
            self._report_no_text(node, what)
            return None
        if node.refused:
            return None
        if not node.text.strip():
            self.findings.add(node.place, f"{what} is empty")
            return None
        return node

    def text(self, node: YamlNode | None, what: str) -> str | None:
        """The text of a scalar unchanged: a path, or a name that another program defines."""
        scalar = self.scalar(node, what)
        return None if scalar is None else scalar.text

    def name(self, node: YamlNode | None, what: str) -> str | None:
        """A valid name in kabo; for an invalid name the report suggests a valid spelling."""
        scalar = self.scalar(node, what)
        return scalar.text if scalar is not None and self.check_name(scalar, what) else None

    def check_name(self, scalar: Scalar, what: str) -> bool:
        """Whether the scalar is a name that may be declared; if not, this is reported."""
        word = scalar.text
        if word in RESERVED:
            self.findings.add(scalar.place, f'"{word}" is a word of the language and cannot be the name of {what}')
            return False
        if NAME.fullmatch(word):
            return True
        message = f'"{_short(word)}" cannot be the name of {what}'
        self.findings.add(scalar.place, message, f'write "{proper_name(word)}": names match [a-z][a-z0-9_]*')
        return False

    def number(self, node: YamlNode | None, what: str, *, angle: bool = False) -> float | None:
        """A finite number; with `angle`, radians or degrees with the suffix `deg`."""
        if node is not None and not isinstance(node, Scalar):
            self.findings.add(node.place, f"{what} must be a number, this is {_kind(node)}")
            return None
        scalar = self.scalar(node, what)
        if scalar is None:
            return None
        found = _NUMBER.fullmatch(scalar.text.strip())
        if found is None:
            hint = (
                "write 0.5, not 0,5"
                if re.fullmatch(r"-?\d+,\d+", scalar.text)
                else _without_unit(scalar.text, angle)
            )
            self.findings.add(scalar.place, f'{what} must be a number, this is "{_short(scalar.text)}"', hint)
            return None
        if found[2] and not angle:
            self.findings.add(scalar.place, f"{what} is no angle: only angles have the suffix deg")
            return None
        value = float(found[1])
        if not math.isfinite(value):
            self.findings.add(scalar.place, f"{what} is too large to be a number")
            return None
        return math.radians(value) if found[2] else value + 0.0

    def epsilon(self, node: YamlNode | None, what: str) -> float | None:
        """A tolerance within the range that bounded geometric predicates support [m]."""
        return self.between(node, what, SMALLEST_EPSILON, LARGEST_EPSILON, "m")

    def between(self, node: YamlNode | None, what: str, least: float, most: float, unit: str) -> float | None:
        """A number above zero that is at least `least` and at most `most`, in `unit`."""
        value = self.positive(node, what)
        if value is not None and node is not None and not least <= value <= most:
            span = f"between {least:g} and {most:g} {unit}"
            self.findings.add(node.place, f"{what} must lie {span}, this is {value:g} {unit}")
            return None
        return value

    def size(self, node: YamlNode | None, what: str) -> float | None:
        """A length above zero that is a possible size of a thing [m]."""
        value = self.positive(node, what)
        return value if node is None or self.sensible(node, what, value, SMALLEST_SIZE) else None

    def position(self, node: YamlNode | None, what: str) -> tuple[float, float, float] | None:
        """A position that is possible in a scene: three lengths [m]."""
        values = self.vector(node, what)
        if values is None or not isinstance(node, Sequence):
            return values
        near = [self.sensible(*each) for each in zip(node.items, [what] * 3, values, strict=True)]
        return values if all(near) else None

    def sensible(self, node: YamlNode, what: str, value: float | None, least: float = 0.0) -> bool:
        """Whether the size of a length is at least `least` and possible in a scene [m]; else this is reported."""
        if value is not None and abs(value) > FARTHEST:
            hint = "lengths are metres; move the scene to its origin"
            self.findings.add(node.place, f"{what} reaches farther than {FARTHEST:g} m: {value:g}", hint)
            return False
        if value is not None and abs(value) < least:
            self.findings.add(node.place, f"{what} is less than a micrometre: {value:g}", "lengths are metres")
            return False
        return True

    def positive(self, node: YamlNode | None, what: str) -> float | None:
        """A number greater than zero."""
        value = self.number(node, what)
        if value is not None and value <= 0 and node is not None:
            self.findings.add(node.place, f"{what} must be greater than 0")
            return None
        return value

    def rate(self, node: YamlNode | None, what: str) -> float | None:
        """A limit of velocity, acceleration or jerk, which may be of an angle: in rad, or with the suffix `deg`."""
        value = self.number(node, what, angle=True)
        if value is None or node is None or RATES[0] <= value <= RATES[1]:
            return value
        if value <= 0.0:
            self.findings.add(node.place, f"{what} is not above 0")
        else:
            self.findings.add(node.place, f"{what} is not from {RATES[0]:g} to {RATES[1]:g}: {value:g}")
        return None

    def length(self, node: YamlNode | None, what: str) -> float | None:
        """A length above zero [m]: a number of metres, or one with its unit, such as `5mm`."""
        if node is not None and not isinstance(node, Scalar):
            self.findings.add(node.place, f"{what} must be a length", "write 5mm, or a number of metres")
            return None
        scalar = self.scalar(node, what)
        found = None if scalar is None else _LENGTH.fullmatch(scalar.text.strip())
        if scalar is None or found is None:
            return self.size(scalar, what)
        value = float(found[1]) * METRES[found[2]]
        if value <= 0.0:
            self.findings.add(scalar.place, f"{what} must be greater than 0")
            return None
        return value if self.sensible(scalar, what, value, SMALLEST_SIZE) else None

    def whole(self, node: YamlNode | None, what: str, minimum: int = 0) -> int | None:
        """A whole number of at least `minimum`."""
        scalar = self.scalar(node, what)
        if scalar is None:
            return None
        word = scalar.text.strip()
        if not re.fullmatch(r"[0-9]{1,19}", word) or not minimum <= int(word) <= _LARGEST_WHOLE:
            self.findings.add(
                scalar.place, f'{what} must be a whole number from {minimum} on, not "{_short(word)}"'
            )
            return None
        return int(word)

    def boolean(self, node: YamlNode | None, what: str) -> bool | None:
        """A truth value, written `true` or `false`."""
        scalar = self.scalar(node, what)
        if scalar is None:
            return None
        if scalar.text not in ("true", "false"):
            self.findings.add(scalar.place, f'{what} must be true or false, not "{_short(scalar.text)}"')
            return None
        return scalar.text == "true"

    def choice(self, node: YamlNode | None, options: Collection[_Word], what: str) -> _Word | None:
        """The text of a scalar that must be one of the given words."""
        scalar = self.scalar(node, what)
        if scalar is None:
            return None
        for option in options:
            if scalar.text == option:
                return option
        hint = self.findings.near(scalar.text, options)
        message = f'{what} must be one of {", ".join(options)}, not "{_short(scalar.text)}"'
        self.findings.add(scalar.place, message, hint)
        return None

    def numbers(
        self,
        node: YamlNode | None,
        what: str,
        count: int | None = None,
        *,
        angle: bool = False,
        hint: str | None = None,
    ) -> tuple[float, ...] | None:
        """A list of numbers, of the length `count` if it is given; `hint` is the remedy for another length."""
        if node is None:
            return None
        if not isinstance(node, Sequence):
            example = ", ".join(["0"] * (3 if count is None else count))
            self.findings.add(node.place, f"{what} must be a list of {count or 'some'} numbers: [{example}]")
            return None
        if count is not None and len(node.items) != count:
            self.findings.add(node.place, f"{what} must have {count} numbers, not {len(node.items)}", hint)
            return None
        values = [self.number(item, f"every number of {what}", angle=angle) for item in node.items]
        return None if None in values else tuple(value for value in values if value is not None)

    def vector(self, node: YamlNode | None, what: str) -> tuple[float, float, float] | None:
        """Three numbers."""
        values = self.numbers(node, what, 3)
        return None if values is None else (values[0], values[1], values[2])


def _short(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "…"


def _kind(node: YamlNode) -> str:
    return "a list" if isinstance(node, Sequence) else "a mapping"


def _without_unit(text: str, angle: bool) -> str | None:
    """The remedy for a length or a rate with a unit, such as `5 mm` or `90 deg/s`; `angle`: an angle may be meant."""
    found = _LENGTH.fullmatch(text.strip())
    if found is not None:
        metres = f"{float(found[1]) * METRES[found[2]]:g}"
        return (
            f"angles are rad, or 45deg; lengths are metres: {metres}"
            if angle
            else f"lengths are metres: write {metres}"
        )
    found = _RATE.fullmatch(text.strip())
    if found is None:
        return None
    if found[2] in ("rad", "deg"):
        return f"units are rad, m and s: write {found[1]}{' deg' if found[2] == 'deg' else ''}"
    return f"units are rad, m and s: write {float(found[1]) * METRES[found[2]]:g}"
