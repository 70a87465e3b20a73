"""Truth files: what a simulator owns and neither plan nor controller knows: masses, places, answers.

Source: docs/how-to/carry_out.md.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from kabo.errors import InputError
from kabo.language.findings import Findings
from kabo.language.problem import Problem
from kabo.language.sensors_description import TruthDescription
from kabo.language.source import SourceFile
from kabo.language.yaml.documents import Mapping, Scalar, YamlNode
from kabo.language.yaml.sensor_calls import read_asked, read_call, spelt, variables_of
from kabo.language.yaml.sensors_file import open_document
from kabo.language.yaml.values import Reader

TRUTH_KEYS = ("truth", "masses", "answers", "offsets", "displaced")
OFFSETS_KEYS = ("position", "turn")
DISPLACED_KEYS = ("by", "turn")
MASSES = 1e-3, 1e4  # kg
_Value = TypeVar("_Value")


def load_truth(path: str | Path, problem: Problem) -> TruthDescription:
    """The truth of a file, about the bodies, formulas and terms of a problem.

    Raises:
        InputError: with every diagnostic.
    """
    findings = Findings()
    root = open_document(path, findings)
    found = None if root is None else read_truth(root, problem, findings)
    if found is None or findings.errors:
        raise InputError(findings.diagnostics)
    return found


def question_of(text: str, problem: Problem, name: str) -> str:
    """The ground formula or term of a problem that a text names, as plans spell it.

    Args:
        text: the formula, such as `empty(bottle_1)`.
        problem: whose domain declares it.
        name: what messages call the place of the text.

    Raises:
        InputError: it is no formula or term of the problem; says what was meant.
    """
    findings = Findings()
    source = SourceFile(Path(name), name, text, "")
    findings.know(source)
    call = read_call(Scalar(source, 0, len(text), text), 0, len(text), findings)
    asked = None if call is None else read_asked(call, problem, findings)
    if call is not None and asked is not None:
        variables_of(asked, problem, findings, set(problem.objects))
    if call is None or findings.errors:
        raise InputError(findings.diagnostics)
    return spelt(call.name, list(call.arguments))


def read_truth(root: Mapping, problem: Problem | None, findings: Findings) -> TruthDescription:
    """The truth that a document describes; without a problem only the forms are checked."""
    return _Reading(root, problem, findings).truth()


class _Reading:
    def __init__(self, root: Mapping, problem: Problem | None, findings: Findings) -> None:
        self.root, self.problem, self.findings, self.reader = root, problem, findings, Reader(findings)

    def truth(self) -> TruthDescription:
        root, reader = self.root, self.reader
        reader.keys(root, TRUTH_KEYS, "a truth file")
        name = reader.name(reader.require(root, "truth", "a truth file"), "the truth") or "truth"
        offsets = reader.mapping(root.get("offsets"), "`offsets`")
        position = turn = 0.0
        if offsets is not None:
            reader.keys(offsets, OFFSETS_KEYS, "`offsets`")
            position = reader.length(offsets.get("position"), "`position`") or 0.0
            turn = abs(reader.number(offsets.get("turn"), "`turn`", angle=True) or 0.0)
        masses = self.of_bodies("masses", self.mass)
        return TruthDescription(
            name, masses, self.answers(), position, turn, self.of_bodies("displaced", self.offset)
        )

    def of_bodies(self, key: str, read: Callable[[YamlNode, str], _Value | None]) -> dict[str, _Value]:
        """Values of bodies that move."""
        bodies = {} if self.problem is None or self.problem.scene is None else self.problem.scene.bodies
        moving = [name for name, body in bodies.items() if body.movable]
        found = {}
        for name, place, node in self.reader.entries(self.root.get(key), f"`{key}`"):
            if self.problem is not None and name not in moving:
                text = f'the scene has no body "{name}" that moves'
                self.findings.add(place.place, text, self.findings.near(name, moving))
                continue
            value = read(node, name)
            if value is not None:
                found[name] = value
        return found

    def mass(self, node: YamlNode, name: str) -> float | None:
        return self.reader.between(node, f"the mass of {name}", *MASSES, "kg")

    def offset(self, node: YamlNode, name: str) -> tuple[tuple[float, float, float], float] | None:
        """By how much a body is off: `{by: [0.01, 0, 0], turn: 5 deg}`."""
        inside = self.reader.mapping(node, f"the offset of {name}")
        if inside is None:
            return None
        self.reader.keys(inside, DISPLACED_KEYS, f"the offset of {name}")
        by = self.reader.position(inside.get("by"), f"the offset of {name}")
        turn = self.reader.number(inside.get("turn"), f"the turn of {name}", angle=True)
        return by or (0.0, 0.0, 0.0), turn or 0.0

    def answers(self) -> dict[str, str]:
        """Answers of ground formulas and terms."""
        found = {}
        for _, key, node in self.reader.entries(self.root.get("answers"), "`answers`"):
            value = self.reader.text(node, "an answer")
            call = read_call(key, 0, len(key.text), self.findings)
            if value is None or call is None or self.problem is None or not isinstance(node, Scalar):
                continue
            asked = read_asked(call, self.problem, self.findings)
            objects = set(self.problem.objects)
            if asked is None or variables_of(asked, self.problem, self.findings, objects) is None:
                continue
            if asked.outcomes is not None and value not in asked.outcomes:
                text = f'"{value}" is no answer of {call.name}'
                self.findings.add(node.place, text, self.findings.near(value, asked.outcomes))
                continue
            if asked.outcomes is None and self.reader.number(node, f"the value of {call.name}") is None:
                continue
            found[spelt(call.name, list(call.arguments))] = value
        return found
