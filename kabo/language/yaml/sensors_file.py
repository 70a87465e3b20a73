"""Sensor files: which measurement answers which formula or term of a plan, how often it is wrong; the camera; weights.

Source: docs/how-to/carry_out.md.
"""

import os
import re
from pathlib import Path

from kabo.displays import counted
from kabo.errors import InputError
from kabo.language.findings import Findings
from kabo.language.problem import Problem
from kabo.language.sensors_description import (
    DEFAULT_ERROR,
    DEFAULT_LOOKS,
    DEFAULT_RATE,
    DEFAULT_SECONDS,
    CameraDescription,
    Measurement,
    MeasurementKind,
    SensorBinding,
    SensorsDescription,
)
from kabo.language.source import UnreadableError, read_source
from kabo.language.yaml.documents import Mapping, Scalar, YamlNode, read_document
from kabo.language.yaml.sensor_calls import (
    Asked,
    Call,
    instances,
    read_asked,
    read_call,
    read_things,
    variables_of,
)
from kabo.language.yaml.values import Reader

SENSORS_KEYS = ("sensors", "answers", "camera", "weight")
ANSWER_KEYS = ("wrong", "error", "looks")
CAMERA_KEYS = ("sees", "position", "angle", "dropout", "rate")
WEIGHT_KEYS = ("noise", "seconds")
MEASUREMENTS = ("weight", "contact", "told")
_KEY = re.compile(
    r"(?P<asked>.*?)(?:\s+(?P<word>when|is)\s+(?P<no>not\s+)?(?P<measure>.*?)"
    r"\s*(?:(?P<sign><=|>=|<|>)\s*(?P<number>.*?))?)?\s*",
    re.DOTALL,
)
_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_EXAMPLE = "empty_bottle(o) when weight(o) < 0.25"


def load_sensors(path: str | Path, problem: Problem) -> SensorsDescription:
    """The sensors of a file, for the formulas, terms and bodies of a problem.

    Raises:
        InputError: with every diagnostic.
    """
    findings = Findings()
    root = open_document(path, findings)
    found = None if root is None else read_sensors(root, problem, findings)
    if found is None or findings.errors:
        raise InputError(findings.diagnostics)
    return found


def open_document(path: str | Path, findings: Findings) -> Mapping | None:
    """The document of a file; None if it cannot be read, which is reported."""
    name = os.fspath(path)
    try:
        return read_document(read_source(Path(path), name), findings)
    except UnreadableError as error:
        findings.add_unreadable(name, error)
        return None


def read_sensors(root: Mapping, problem: Problem | None, findings: Findings) -> SensorsDescription:
    """The sensors that a document describes; without a problem only the forms are checked."""
    return _Reading(root, problem, findings).sensors()


class _Reading:
    def __init__(self, root: Mapping, problem: Problem | None, findings: Findings) -> None:
        self.root, self.problem, self.findings, self.reader = root, problem, findings, Reader(findings)
        self.bindings: dict[str, SensorBinding] = {}

    def sensors(self) -> SensorsDescription:
        root, reader = self.root, self.reader
        reader.keys(root, SENSORS_KEYS, "a sensor file")
        name = reader.name(reader.require(root, "sensors", "a sensor file"), "the sensors") or "sensors"
        for _, key, value in reader.entries(root.get("answers"), "`answers`"):
            self.answer(key, value)
        weight = reader.mapping(root.get("weight"), "`weight`")
        noise, seconds = 0.0, DEFAULT_SECONDS
        if weight is not None:
            reader.keys(weight, WEIGHT_KEYS, "`weight`")
            noise = self.least(weight, "noise", 0.0)
            seconds = reader.between(weight.get("seconds"), "`seconds`", 1e-3, 60.0, "s") or DEFAULT_SECONDS
        return SensorsDescription(name, self.bindings, self.camera(), noise, seconds, root.source.name)

    # ------------------------------------------------------------------------------------------------- answers
    def answer(self, key: Scalar, node: YamlNode) -> None:
        """Reads one entry of `answers`, and binds all its instances."""
        found = _KEY.fullmatch(key.text)
        options = self.reader.mapping(node, "what is said of an answer")
        if options is not None:
            self.reader.keys(options, ANSWER_KEYS, "an answer")
        wrong = self.share(options, "wrong", 0.0)
        error = self.share(options, "error", DEFAULT_ERROR)
        looks = self.reader.whole(None if options is None else options.get("looks"), "`looks`", 1)
        if found is None:
            return
        call = read_call(key, found.start("asked"), found.end("asked"), self.findings)
        measured = self.measurement(key, found)
        if call is None or measured is None or self.problem is None:
            return
        asked = read_asked(call, self.problem, self.findings)
        if asked is None or not self.fits(asked, found, measured[0], key):
            return
        made = SensorBinding(
            call.name, asked.outcomes, Measurement(measured[0]), measured[2], measured[3], wrong, error,
            looks or DEFAULT_LOOKS, key.place,
        )  # fmt: skip
        if error == 0.0 or made.least_looks > made.looks:
            text = f"{counted(made.looks, 'look')} cannot bring the error below {error:g}, if one answer in "
            text += f"{1.0 / wrong:.3g} is wrong" if wrong else "none is wrong"
            self.findings.add(key.place, text, f"at least {made.least_looks} that agree are needed")
            return
        self.bind(asked, made, measured[1])

    def measurement(
        self, key: Scalar, found: "re.Match[str]"
    ) -> tuple[MeasurementKind, Call | None, str | None, float] | None:
        """The kind of a measurement, its call, the comparison and its threshold."""
        if found["word"] is None:
            return "told", None, None, 0.0
        call = read_call(key, found.start("measure"), found.end("measure"), self.findings)
        if call is None:
            return None
        if call.name not in MEASUREMENTS:
            text = f'there is no measurement "{call.name}"'
            self.findings.add(call.place, text, self.findings.near(call.name, MEASUREMENTS))
            return None
        number = 0.0
        if found["sign"] is not None:
            if not _NUMBER.fullmatch(found["number"]):
                text = f'"{found["number"]}" is no number; weights are in kilograms'
                self.findings.add(key.place, text, f"write {_EXAMPLE}")
                return None
            number = float(found["number"])
        things = {"weight": 1, "contact": 2, "told": 0}[call.name]
        if len(call.arguments) != things:
            self.findings.add(
                call.place, f"{call.name} is of {counted(things, 'thing')}, not {len(call.arguments)}"
            )
            return None
        kind: MeasurementKind = "weight" if call.name == "weight" else "contact" if things else "told"
        return kind, call, found["sign"] or ("not" if found["no"] else None), number

    def fits(self, asked: Asked, found: "re.Match[str]", kind: str, key: Scalar) -> bool:
        """Whether a measurement can answer what is asked; else this is reported."""
        name, word, sign = asked.call.name, found["word"], found["sign"]
        message = hint = None
        if word == "when" and not asked.is_predicate:
            message, hint = f"{name} has a value: it is no formula", f"write {name}(…) is …"
        elif word == "is" and asked.is_predicate:
            message, hint = f"{name} is a predicate: it is true or false", f"write {name}(…) when …"
        elif kind == "weight" and asked.is_predicate and sign is None:
            message, hint = "a weight is a number: a formula compares it", f"write {_EXAMPLE}"
        elif kind != "weight" and sign is not None:
            message, hint = f"{kind} is no number: it cannot be compared", "only a weight can"
        elif sign is not None and not asked.is_predicate:
            message, hint = f"{name} has a value: a comparison has none", None
        elif found["no"] and kind != "contact":
            message, hint = f"not {kind} means nothing", "turn the comparison round"
        elif kind == "weight" and not asked.is_predicate and asked.outcomes is not None:
            message, hint = f"{name} is one of {', '.join(asked.outcomes[:6])}, and a weight is a number", None
        elif kind == "contact" and not asked.is_predicate:
            message, hint = f"{name} has a value, and a contact is there or not", None
        if message is not None:
            self.findings.add(key.place, message, hint)
        return message is None

    def bind(self, asked: Asked, made: SensorBinding, measure: Call | None) -> None:
        """Binds all instances of what is asked."""
        assert self.problem is not None
        used = set() if measure is None else set(measure.arguments)
        variables = variables_of(asked, self.problem, self.findings, used)
        if variables is None:
            return
        for spelled, values in instances(asked, variables, self.problem):
            things = read_things(measure, values, self.problem, self.findings, made.measurement.kind)
            if things is None:
                return
            if spelled in self.bindings:
                text = f"{spelled} has an answer already"
                self.findings.add(asked.call.place, text, "a formula is answered by one sensor")
                return
            self.bindings[spelled] = SensorBinding(
                spelled, made.outcomes, Measurement(made.measurement.kind, things), made.comparison,
                made.threshold, made.wrong, made.error, made.looks, made.place,
            )  # fmt: skip

    # -------------------------------------------------------------------------------------------------- camera
    def camera(self) -> CameraDescription | None:
        node = self.reader.mapping(self.root.get("camera"), "`camera`")
        if node is None:
            return None
        self.reader.keys(node, CAMERA_KEYS, "`camera`")
        return CameraDescription(
            self.seen(node),
            self.reader.length(node.get("position"), "`position`") or 0.0,
            self.least(node, "angle", 0.0, angle=True),
            self.share(node, "dropout", 0.0, most=1.0),
            self.reader.between(node.get("rate"), "`rate`", 1e-3, 1e4, "Hz") or DEFAULT_RATE,
        )

    def seen(self, node: Mapping) -> tuple[str, ...]:
        """The bodies that a camera sees: all that move, or those in a list."""
        bodies = {} if self.problem is None or self.problem.scene is None else self.problem.scene.bodies
        moving = [name for name, body in bodies.items() if body.movable]
        items = self.reader.items(node.get("sees"), "`sees`")
        if not items:
            return tuple(moving)
        found = []
        for item in items:
            name = self.reader.text(item, "a body that the camera sees")
            if name is None:
                continue
            if self.problem is not None and name not in moving:
                text = f'the scene has no body "{name}" that moves'
                self.findings.add(item.place, text, self.findings.near(name, moving))
            else:
                found.append(name)
        return tuple(found)

    # ------------------------------------------------------------------------------------------------- numbers
    def least(self, node: Mapping, key: str, usual: float, *, angle: bool = False) -> float:
        """A number of at least zero."""
        value = self.reader.number(node.get(key), f"`{key}`", angle=angle)
        if value is not None and value < 0.0:
            self.findings.add(node.key(key).place, f"`{key}` must not be below 0")
        return usual if value is None else max(0.0, value)

    def share(self, node: Mapping | None, key: str, usual: float, most: float = 0.5) -> float:
        """A probability from zero up to, but without, a greatest one."""
        value = None if node is None else self.reader.number(node.get(key), f"`{key}`")
        if value is None or node is None:
            return usual
        if not 0.0 <= value < most:
            hint = "an answer that is wrong half of the time says nothing" if most == 0.5 else None
            text = f"`{key}` must be a probability from 0 to less than {most:g}, this is {value:g}"
            self.findings.add(node.key(key).place, text, hint)
            return usual
        return value
