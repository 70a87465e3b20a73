"""Exploration files: parameters with bounds, cases, outcomes, and how a trial is made.

Source: T 4.4, docs/reference/explorations.md.

Trial functions and task files are not opened here; the package `kabo.trials` checks them.
"""

import math
import os
import re
from pathlib import Path

from kabo.exploration import LARGEST_NUMBER, MOST_CASES, MOST_PARAMETERS, OPTION_BOUNDS
from kabo.language.exploration_description import (
    DEFAULT_JOBS,
    CaseDescription,
    ExplorationDescription,
    FunctionTrial,
    OutcomeDescription,
    ParameterDescription,
    TaskTrial,
    reference_of,
    words_of,
)
from kabo.language.findings import Findings
from kabo.language.formulas import Place
from kabo.language.source import SourceFile, UnreadableError, beside, read_source
from kabo.language.task_description import Written
from kabo.language.yaml.documents import Mapping, Scalar, Sequence, YamlNode, read_document
from kabo.language.yaml.values import Reader
from kabo.language.yaml.written_values import read_written

EXPLORATION_KEYS = (
    "exploration", "trial", "parameters", "cases", "outcomes", "validity", "invalid_budget", "start", "retry",
)  # fmt: skip
TRIAL_KEYS = ("task", "scene", "jobs", "max_solutions", "properties")
PARAMETER_KEYS = ("from", "to", "unit")
OUTCOME_KEYS = ("unit",)
VALIDITY_KEYS = ("scale", "noise", "alpha")
_LONGEST_WORD = 80
_LIKE_REFERENCE = re.compile(r"<[^<>]*>")


def find_exploration(path: Path, name: str, findings: Findings) -> ExplorationDescription | None:
    """The exploration that a file describes; None if it cannot be read, which is reported."""
    try:
        source = read_source(path, name)
    except UnreadableError as error:
        findings.add_unreadable(name, error)
        return None
    return read_exploration_text(source, findings)


def read_exploration_text(source: SourceFile, findings: Findings) -> ExplorationDescription | None:
    """The exploration that `source` describes; None if it cannot be read, which is reported."""
    root = read_document(source, findings)
    return None if root is None else read_exploration(root, findings)


def read_exploration(root: Mapping, findings: Findings) -> ExplorationDescription:
    """The exploration that a document describes; what has errors, which are reported, is left out."""
    return _Reading(root, findings).exploration()


class _Reading:
    def __init__(self, root: Mapping, findings: Findings) -> None:
        self.root, self.findings, self.reader = root, findings, Reader(findings)
        self.known_parameters: list[str] = []  # also those whose bounds have errors
        self.known_cases: list[str] = []

    def exploration(self) -> ExplorationDescription:
        root, reader = self.root, self.reader
        reader.keys(root, EXPLORATION_KEYS, "an exploration")
        name_node = reader.require(root, "exploration", "an exploration")
        name = self.word(name_node, "the name of the exploration") or "?"
        parameters = self.parameters()
        cases = self.cases()
        outcomes = self.outcomes()
        trial = self.trial()
        validity = reader.mapping(root.get("validity"), "`validity`")
        if validity is not None:
            reader.keys(validity, VALIDITY_KEYS, "`validity`")
        bounds = {each.name: each for each in parameters}
        return ExplorationDescription(
            name,
            trial,
            parameters,
            cases,
            outcomes,
            self.share(validity, "scale"),
            self.share(validity, "noise"),
            self.alpha(validity),
            self.budget(root.get("invalid_budget")),
            self.start(bounds),
            self.retry(bounds),
            (name_node or root).place,
            root.source,
        )

    # ---------------------------------------------------------------------------------- parameters, cases, outcomes
    def parameters(self) -> tuple[ParameterDescription, ...]:
        node = self.reader.require(self.root, "parameters", "an exploration")
        found = []
        for name, key, value in self.reader.entries(node, "`parameters`"):
            if self.reader.check_name(key, "a parameter"):
                self.known_parameters.append(name)
                found.append(self.parameter(name, key, value))
        count = len(node.entries) if isinstance(node, Mapping) else None
        if node is not None and count == 0:
            self.findings.add(node.place, "an exploration needs at least one parameter")
        elif node is not None and count is not None and count > MOST_PARAMETERS:
            hint = "explore the others first, and fix them; or explore the parts of the motion one by one"
            message = f"an exploration has at most {MOST_PARAMETERS} parameters, these are {count}"
            self.findings.add(self.root.key("parameters").place, message, hint)
        return tuple(each for each in found if each is not None)

    def parameter(self, name: str, key: Scalar, node: YamlNode) -> ParameterDescription | None:
        what = f'the parameter "{name}"'
        if not isinstance(node, Mapping):
            self.findings.add(key.place, f"{what} needs its bounds: {{from: 0, to: 1, unit: m}}")
            return None
        self.reader.keys(node, PARAMETER_KEYS, what)
        ends = [self.reader.require(node, end, what, key) for end in ("from", "to")]
        lower, upper = (
            self.reader.number(each, f"`{end}` of {what}") for each, end in zip(ends, ("from", "to"), strict=True)
        )
        unit = self.unit(node, what)
        if lower is None or upper is None or ends[1] is None:
            return None
        message = _fault_of_bounds(lower, upper)
        if message is not None:
            self.findings.add(ends[1].place, f"{what}: {message}")
            return None
        return ParameterDescription(name, lower, upper, unit, key.place)

    def cases(self) -> tuple[CaseDescription, ...]:
        found: list[CaseDescription] = []
        for name, key, value in self.reader.entries(self.root.get("cases"), "`cases`"):
            if not self.reader.check_name(key, "a case variable"):
                continue
            self.known_cases.append(name)
            if name in self.known_parameters:
                self.findings.add(key.place, f'"{name}" is both a parameter and a case variable')
            values = self.values(name, key, value)
            if values:
                found.append(CaseDescription(name, values, key.place))
        count = math.prod(len(each.values) for each in found)
        if count > MOST_CASES:
            message = f"these are {count} cases, at most {MOST_CASES} can be explored: each has a model of its own"
            self.findings.add(self.root.key("cases").place, message)
        return tuple(found)

    def values(self, name: str, key: Scalar, node: YamlNode) -> tuple[str, ...]:
        what = f'the case variable "{name}"'
        items = self.reader.items(node, f"the values of {what}")
        if not items and (isinstance(node, Sequence) or (isinstance(node, Scalar) and node.empty)):
            self.findings.add(key.place, f"{what} has no values", f"write them as a list: {name}: [first, second]")
        found: dict[str, Place] = {}
        for item in items:
            text = self.word(item, f"a value of {what}")
            if text is not None and text in found:
                self.findings.add(item.place, f'{what} has the value "{text}" twice')
            elif text is not None:
                found[text] = item.place
        return tuple(found)

    def outcomes(self) -> tuple[OutcomeDescription, ...]:
        node = self.reader.require(self.root, "outcomes", "an exploration")
        found = []
        for name, key, value in self.reader.entries(node, "`outcomes`"):
            if not self.reader.check_name(key, "an outcome"):
                continue
            inside = self.reader.mapping(value, f'the outcome "{name}"')
            if inside is not None:
                self.reader.keys(inside, OUTCOME_KEYS, f'the outcome "{name}"')
            found.append(OutcomeDescription(name, self.unit(inside, f'the outcome "{name}"'), key.place))
        if isinstance(node, Mapping) and not node.entries:
            self.findings.add(node.place, "an exploration needs at least one outcome: {torque: {unit: Nm}}")
        return tuple(found)

    def unit(self, node: Mapping | None, what: str) -> str:
        return "" if node is None else self.word(node.get("unit"), f"the unit of {what}") or ""

    # -------------------------------------------------------------------------------------------------------- trial
    def trial(self) -> FunctionTrial | TaskTrial | None:
        node = self.root.get("trial")
        if isinstance(node, Mapping):
            return self.task_trial(node)
        if isinstance(node, Scalar) and node.empty:
            hint = "leave the key out if trials are made elsewhere, and told"
            self.findings.add(self.root.key("trial").place, "`trial` has no value", hint)
            return None
        if isinstance(node, Sequence):
            hint = "write the name of a registered function, or {task: task.yaml, scene: scene.yaml}"
            self.findings.add(node.place, "`trial` must be one trial, this is a list", hint)
            return None
        name = self.word(node, "`trial`")
        return None if name is None or node is None else FunctionTrial(name, node.place)

    def task_trial(self, node: Mapping) -> TaskTrial | None:
        reader, what = self.reader, "a trial that plans a task"
        reader.keys(node, TRIAL_KEYS, what)
        task_node = reader.require(node, "task", what)
        scene_node = node.get("scene")
        task = self.path(task_node, "the path of the task file")
        scene = self.path(scene_node, "the path of the scene file")
        jobs = reader.whole(node.get("jobs"), "`jobs`", 1)
        solutions = reader.whole(node.get("max_solutions"), "`max_solutions`", 1)
        values: dict[str, Written] = {}
        keys: dict[str, Place] = {}
        for name, key, value in reader.entries(node.get("properties"), "`properties` of the trial"):
            keys[name] = key.place
            written = read_written(value, f'the property "{name}"', self.findings, lambda each: None)
            if written is not None:
                values[name] = written
                self.check_references(written)
        if task is None or task_node is None:
            return None
        return TaskTrial(
            task, scene, jobs or DEFAULT_JOBS, solutions or 1, values, keys, self.root.key("trial").place,
            task_node.place, None if scene_node is None else scene_node.place,
        )  # fmt: skip

    def path(self, node: YamlNode | None, what: str) -> Path | None:
        """A path, which is relative to the folder of this file."""
        text = self.reader.text(node, what)
        if text is None or node is None:
            return None
        if "\0" in text:
            self.findings.add(node.place, f"{what} has a character that no path can have")
            return None
        return Path(beside(os.path.dirname(self.root.source.name), text))

    def check_references(self, written: Written) -> None:
        """Reports references to parameters and case variables that there are not, and what only looks like a reference."""
        for word in words_of(written):
            reference = reference_of(word)
            if reference is None:
                if not word.quoted and _LIKE_REFERENCE.fullmatch(word.text.strip()):
                    hint = "references are <PARAMETER:name> and <CASE:name>; other text stands in quotes"
                    self.findings.add(word.place, f'"{word.text[:60]}" is no reference', hint)
                continue
            known = self.known_parameters if reference.source == "PARAMETER" else self.known_cases
            if reference.name not in known:
                kind = "parameter" if reference.source == "PARAMETER" else "case variable"
                hint = self.findings.near(reference.name, known) or "there is none"
                self.findings.add(word.place, f'there is no {kind} "{reference.name}"', hint)

    # ----------------------------------------------------------------------------------------------------- options
    def share(self, validity: Mapping | None, key: str) -> float | None:
        node = None if validity is None else validity.get(key)
        value = self.reader.positive(node, f"`{key}` of `validity`")
        low, high = OPTION_BOUNDS
        if node is not None and value is not None and not low <= value <= high:
            message = f"`{key}` of `validity` must lie between {low:g} and {high:g}, this is {value:g}"
            self.findings.add(node.place, message)
            return None
        return value

    def alpha(self, validity: Mapping | None) -> float | None:
        node = None if validity is None else validity.get("alpha")
        value = self.reader.number(node, "`alpha` of `validity`")
        if node is not None and value is not None and not 0.5 <= value < 1.0:
            hint = "only parameters that are more probably valid than alpha are tried; the thesis has 0.7"
            self.findings.add(node.place, f"`alpha` must be at least 0.5 and less than 1, this is {value:g}", hint)
            return None
        return value

    def budget(self, node: YamlNode | None) -> float | None:
        value = self.reader.number(node, "`invalid_budget`")
        if node is not None and value is not None and not 0.0 < value < 1.0:
            hint = "it is the share of invalid trials, such as 0.1"
            self.findings.add(node.place, f"`invalid_budget` must lie between 0 and 1, this is {value:g}", hint)
            return None
        return value

    def start(self, bounds: dict[str, ParameterDescription]) -> dict[str, float] | None:
        node = self.root.get("start")
        if node is None:
            return None
        values = self.named_numbers(node, "`start`")
        if isinstance(node, Mapping):
            missing = [f'"{name}"' for name in self.known_parameters if name not in node.entries]
            if missing and node.entries:
                self.findings.add(
                    self.root.key("start").place, f"`start` lacks the parameter {', '.join(missing)}"
                )
        for name, (value, place) in values.items():
            known = bounds.get(name)
            if known is not None and not known.lower <= value <= known.upper:
                message = (
                    f'"{name}" of `start` is {value:g}, outside its bounds {known.lower:g} to {known.upper:g}'
                )
                self.findings.add(place, message)
        return {name: values[name][0] for name in self.known_parameters if name in values}

    def retry(self, bounds: dict[str, ParameterDescription]) -> dict[str, dict[str, float]]:
        found: dict[str, dict[str, float]] = {}
        for reason, key, node in self.reader.entries(self.root.get("retry"), "`retry`"):
            if self.word(key, "a reason in `retry`") is None:
                continue
            changes = self.named_numbers(node, f'`retry` after "{reason}"', key)
            for name, (value, place) in changes.items():
                known = bounds.get(name)
                if value == 0.0:
                    self.findings.add(
                        place, f'the change of "{name}" after "{reason}" is 0, which changes nothing'
                    )
                elif known is not None and abs(value) > known.upper - known.lower:
                    message = f'the change of "{name}" after "{reason}" is larger than its range'
                    hint = f"its bounds are {known.lower:g} to {known.upper:g}"
                    self.findings.add(place, message, hint)
            found[reason] = {name: changes[name][0] for name in self.known_parameters if name in changes}
        return found

    def named_numbers(
        self, node: YamlNode, what: str, key: Scalar | None = None
    ) -> dict[str, tuple[float, Place]]:
        """Numbers by the names of parameters, with their places."""
        if not isinstance(node, Mapping) or not node.entries:
            place = node.place if key is None else key.place
            self.findings.add(place, f"{what} must name parameters with numbers: {{along: 0.01}}")
            return {}
        found = {}
        for name, (scalar, value) in node.entries.items():
            if name not in self.known_parameters:
                hint = self.findings.near(name, self.known_parameters)
                self.findings.add(scalar.place, f'{what} names "{name[:60]}", which is no parameter', hint)
                continue
            number = self.reader.number(value, f'"{name}" of {what}')
            if number is not None:
                found[name] = (number, value.place)
        return found

    def word(self, node: YamlNode | None, what: str) -> str | None:
        """A short text in one line, as names outside of kabo are; None if it is absent or something else."""
        scalar = self.reader.scalar(node, what)
        if scalar is None:
            return None
        text = scalar.text
        if text != text.strip() or not text.isprintable() or len(text) > _LONGEST_WORD:
            hint = f"one line of at most {_LONGEST_WORD} characters, without blanks around it"
            self.findings.add(scalar.place, f"{what} is no word: {text[:60]!r}", hint)
            return None
        return text


def _fault_of_bounds(lower: float, upper: float) -> str | None:
    """What is wrong with the bounds of a parameter; None if nothing is."""
    if lower == upper:
        return f"its bounds are equal: {lower:g}; a parameter that does not vary is none"
    if lower > upper:
        return f"its bounds are the wrong way round: from {lower:g} to {upper:g}"
    if max(abs(lower), abs(upper)) > LARGEST_NUMBER:
        return f"its bounds reach beyond {LARGEST_NUMBER:g}"
    if upper - lower < 1e-9 * max(abs(lower), abs(upper)):
        return f"its bounds are equal but for rounding: {lower!r} and {upper!r}"
    return None
