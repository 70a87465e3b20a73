"""The objects that `kabo explore` prints with `--json`, format `kabo-explore/1`: their keys, and their JSON Schema."""

from collections.abc import Mapping
from typing import Any, Literal, TypedDict

import msgspec

FORMAT = "kabo-explore/1"


class Range(TypedDict):
    """Bounds of a parameter [its unit]."""

    lower: float
    upper: float
    unit: str


class OutcomeSummary(TypedDict):
    """An outcome over the valid trials of a case (null without); the mean error by leaving one out, from three on."""

    lowest: float | None
    highest: float | None
    error: float | None
    unit: str


class CaseSummary(TypedDict):
    """What is known of one case; the next trial is looked for where the validity is above `alpha`."""

    case: dict[str, str]
    trials: int
    valid: int
    reasons: dict[str, int]
    alpha: float
    outcomes: dict[str, OutcomeSummary]


class Shown(TypedDict):
    """The answer of `show`."""

    format: Literal["kabo-explore/1"]
    command: Literal["show"]
    model: str
    exploration: str
    parameters: dict[str, Range]
    seed: int
    trials: int
    valid: int
    cases: list[CaseSummary]


class Ran(TypedDict):
    """The answer of `run`: `made` trials were added; `stopped` says why they are fewer than asked for, else null."""

    format: Literal["kabo-explore/1"]
    command: Literal["run"]
    model: str
    exploration: str
    made: int
    trials: int
    valid: int
    stopped: Literal["time", "memory", "interrupted", "not_explored", "nothing_valid"] | None
    message: str | None
    cases: list[CaseSummary]


class Asked(TypedDict):
    """The answer of `ask`: parameters to try next, the probability that they are valid, and what is known of the case."""

    format: Literal["kabo-explore/1"]
    command: Literal["ask"]
    case: dict[str, str]
    parameters: dict[str, float]
    validity: float
    so_far: CaseSummary


class Told(TypedDict):
    """The answer of `tell`: the trial as the model has it now, and how many there are."""

    format: Literal["kabo-explore/1"]
    command: Literal["tell"]
    case: dict[str, str]
    parameters: dict[str, float]
    valid: bool
    outcomes: dict[str, float]
    reason: str
    trials: int


class Found(TypedDict):
    """Parameters that were inferred, with the outcomes expected there and their standard deviations."""

    case: dict[str, str]
    parameters: dict[str, float]
    validity: float
    expected: dict[str, float]
    deviation: dict[str, float]


class InferredAnswer(Found):
    """The answer of `infer`."""

    format: Literal["kabo-explore/1"]
    command: Literal["infer"]


class Nothing(TypedDict):
    """The answer of `ask` and `infer` where there is nothing to offer; `nearest` is the best that can be had."""

    format: Literal["kabo-explore/1"]
    command: Literal["ask", "infer"]
    reason: Literal["not_explored", "nothing_valid", "out_of_range"]
    message: str
    nearest: Found | None


ANSWERS: Mapping[str, type] = {each.__name__: each for each in (Ran, Asked, Told, InferredAnswer, Nothing, Shown)}


def schema() -> dict[str, Any]:
    """The JSON Schema of all answers; `command`, and `reason` of `infer` and `ask`, say which one it is."""
    _, found = msgspec.json.schema_components(ANSWERS.values(), ref_template="#/$defs/{name}")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FORMAT,
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in ANSWERS],
        "$defs": dict(sorted(found.items())),
    }
