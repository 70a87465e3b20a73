"""The lines of a journal, as JSON."""

import json
from collections.abc import Mapping
from typing import Any

from kabo.exploration.records import Trial

FORMAT = "kabo-exploration/1"


def trial_to_json(trial: Trial) -> dict[str, Any]:
    """The JSON object of a trial in the journal."""
    told: dict[str, Any] = {"case": dict(trial.case), "parameters": dict(trial.parameters), "valid": trial.valid}
    return told | ({"outcomes": dict(trial.outcomes)} if trial.valid else {"reason": trial.reason})


def line_of(value: Mapping[str, Any]) -> str:
    """A line of a journal."""
    return json.dumps(value, ensure_ascii=False, allow_nan=False) + "\n"
