"""Errors of explorations: what was asked of one, and that there is nothing to offer."""

from typing import Literal

from kabo.errors import KaboError
from kabo.exploration.records import Inferred

Reason = Literal["not_explored", "nothing_valid", "out_of_range"]


class ExplorationError(KaboError, ValueError):
    """An unknown name, a value outside its bounds, a result without outcome; the exploration is as before (exit code 2)."""

    exit_code = 2


class NoParametersError(ExplorationError):
    """There are no parameters to offer (exit code 4).

    Attributes:
        reason: `not_explored`, no trial has been told; `nothing_valid`, none of the parameters is believed valid enough;
            `out_of_range`, what is wanted is farther off than the tolerance permits.
        nearest: of `out_of_range`, the parameters whose outcome is nearest to what is wanted; else None.
    """

    exit_code = 4

    def __init__(self, reason: Reason, message: str, nearest: Inferred | None = None) -> None:
        self.reason: Reason = reason
        self.nearest = nearest
        super().__init__(message)
