"""The objects that `kabo explore` prints with `--json`, format `kabo-explore/1`: their keys, and their JSON Schema."""

from pathlib import Path
from typing import Any, Literal, TypedDict

import msgspec

from kabo.exploration import Exploration, Inferred, NoParametersError, Question, Trial
from kabo.trials.summaries import CaseSummary, summaries_of, summary_to_json

FORMAT: Literal["kabo-explore/1"] = "kabo-explore/1"
Stopped = Literal["time", "memory", "interrupted", "not_explored", "nothing_valid"]


class Range(TypedDict):
    """Bounds of a parameter [its unit]."""

    lower: float
    upper: float
    unit: str


class OutcomeFigures(TypedDict):
    """An outcome over the valid trials of a case; `error`: its mean by leaving one out, null below three of them."""

    lowest: float
    highest: float
    error: float | None
    unit: str


class CaseFigures(TypedDict):
    """What is known of one case; the next trial is looked for where the validity is above `alpha`."""

    case: dict[str, str]
    trials: int
    valid: int
    reasons: dict[str, int]
    alpha: float
    outcomes: dict[str, OutcomeFigures]


class Shown(TypedDict):
    """The answer of `show`; `digest` is the SHA-256 sum of the model."""

    format: Literal["kabo-explore/1"]
    command: Literal["show"]
    model: str
    digest: str
    exploration: str
    parameters: dict[str, Range]
    seed: int
    invalid_budget: float | None
    trials: int
    valid: int
    cases: list[CaseFigures]


class Ran(TypedDict):
    """The answer of `run`: `made` trials were added (null: not counted); `stopped` says why not all, else null."""

    format: Literal["kabo-explore/1"]
    command: Literal["run"]
    model: str
    exploration: str
    made: int | None
    trials: int
    valid: int
    stopped: Stopped | None
    message: str | None
    cases: list[CaseFigures]


class Asked(TypedDict):
    """The answer of `ask`: parameters to try next, the probability that they are valid, and the case's trials so far."""

    format: Literal["kabo-explore/1"]
    command: Literal["ask"]
    case: dict[str, str]
    parameters: dict[str, float]
    validity: float
    trials: int
    valid: int


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


Answer = Ran | Asked | Told | InferredAnswer | Nothing | Shown
ANSWERS: tuple[type, ...] = (Ran, Asked, Told, InferredAnswer, Nothing, Shown)


def schema() -> dict[str, Any]:
    """The JSON Schema of all answers: `command` says which one it is, and `reason` that there is nothing to offer."""
    _, found = msgspec.json.schema_components(ANSWERS, ref_template="#/$defs/{name}")
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": FORMAT,
        "anyOf": [{"$ref": f"#/$defs/{each.__name__}"} for each in ANSWERS],
        "$defs": dict(sorted(found.items())),
    }


# ----------------------------------------------------------------------------------------- from explorations to data
def show_answer(exploration: Exploration, model: Path | str) -> Shown:
    """The answer of `show` about an exploration that was read from the file `model`."""
    space = exploration.space
    return {
        "format": FORMAT,
        "command": "show",
        "model": str(model),
        "digest": exploration.digest,
        "exploration": exploration.name,
        "parameters": {
            name: {"lower": lower, "upper": upper, "unit": space.units.get(name, "")}
            for name, (lower, upper) in space.parameters.items()
        },
        "seed": exploration.seed,
        "invalid_budget": exploration.invalid_budget,
        "trials": len(exploration.trials),
        "valid": _valid(exploration),
        "cases": [_figures(each) for each in summaries_of(exploration)],
    }


def run_answer(
    exploration: Exploration, model: Path | str, made: int | None, stopped: Stopped | None, message: str | None
) -> Ran:
    """The answer of `run`: it made some trials, and stopped for a reason, which `message` tells in words; None: done."""
    return {
        "format": FORMAT,
        "command": "run",
        "model": str(model),
        "exploration": exploration.name,
        "made": made,
        "trials": len(exploration.trials),
        "valid": _valid(exploration),
        "stopped": stopped,
        "message": message,
        "cases": [_figures(each) for each in summaries_of(exploration)],
    }


def ask_answer(exploration: Exploration, question: Question) -> Asked:
    """The answer of `ask`."""
    trials = exploration.trials_of(question.case)
    return {
        "format": FORMAT,
        "command": "ask",
        "case": dict(question.case),
        "parameters": dict(question.parameters),
        "validity": question.validity,
        "trials": len(trials),
        "valid": sum(trial.valid for trial in trials),
    }


def tell_answer(exploration: Exploration, trial: Trial) -> Told:
    """The answer of `tell`."""
    return {
        "format": FORMAT,
        "command": "tell",
        "case": dict(trial.case),
        "parameters": dict(trial.parameters),
        "valid": trial.valid,
        "outcomes": dict(trial.outcomes),
        "reason": trial.reason,
        "trials": len(exploration.trials),
    }


def infer_answer(found: Inferred) -> InferredAnswer:
    """The answer of `infer`."""
    return {"format": FORMAT, "command": "infer", **_found(found)}


def nothing_answer(command: Literal["ask", "infer"], error: NoParametersError) -> Nothing:
    """The answer of `ask` or `infer` where there is nothing to offer."""
    return {
        "format": FORMAT,
        "command": command,
        "reason": error.reason,
        "message": str(error),
        "nearest": None if error.nearest is None else _found(error.nearest),
    }


def _found(found: Inferred) -> Found:
    return {
        "case": dict(found.case),
        "parameters": dict(found.parameters),
        "validity": found.validity,
        "expected": dict(found.expected),
        "deviation": dict(found.deviation),
    }


def _figures(summary: CaseSummary) -> CaseFigures:
    made: CaseFigures = summary_to_json(summary)  # type: ignore[assignment] # validated against the schema by tests
    return made


def _valid(exploration: Exploration) -> int:
    return sum(trial.valid for trial in exploration.trials)
