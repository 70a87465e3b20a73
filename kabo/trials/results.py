"""The result of a trial: valid with outcomes, or invalid with a reason."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Valid:
    """A valid trial: its outcomes by name, and a comment that is shown during the run."""

    outcomes: Mapping[str, float]
    comment: str = ""


@dataclass(frozen=True)
class Invalid:
    """An invalid trial: a short reason, always the same for the same fault, and a comment shown during the run."""

    reason: str
    comment: str = ""


TrialResult = Valid | Invalid
TrialFunction = Callable[[Mapping[str, str], Mapping[str, float], int], TrialResult]
"""A function of the case, the parameters and a seed: everything that is random in the trial follows from the seed."""
