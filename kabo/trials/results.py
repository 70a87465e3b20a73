"""The result of a trial: valid with outcomes, or invalid with a reason."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Valid:
    """A trial that went well: its outcomes by name, and a comment for whoever watches the run."""

    outcomes: Mapping[str, float]
    comment: str = ""


@dataclass(frozen=True)
class Invalid:
    """A trial that went wrong: a short reason, always the same word for the same fault, and a comment."""

    reason: str
    comment: str = ""


TrialResult = Valid | Invalid
TrialFunction = Callable[[Mapping[str, str], Mapping[str, float], int], TrialResult]
"""A function of the case, the parameters and a seed: everything that is random in the trial follows from the seed."""
