"""Errors of explorations: wrong arguments, and no parameters to offer."""

from typing import Literal

from kabo.errors import KaboError
from kabo.exploration.records import Inferred

Reason = Literal["not_explored", "nothing_valid", "out_of_range"]


class ExplorationError(KaboError, ValueError):
    """A wrong argument, such as an unknown name or a value outside its bounds; nothing has changed (exit code 2)."""

    exit_code = 2


class NoParametersError(ExplorationError):
    """There are no parameters to offer (exit code 4).

    Attributes:
        reason: `not_explored`, there are no trials; `nothing_valid`, no parameters are believed valid enough;
            `out_of_range`, what is wanted is farther off than the tolerance permits.
        nearest: of `out_of_range`, the parameters whose outcome is nearest to what is wanted; else None.
    """

    exit_code = 4

    def __init__(self, reason: Reason, message: str, nearest: Inferred | None = None) -> None:
        self.reason: Reason = reason
        self.nearest = nearest
        super().__init__(message)
