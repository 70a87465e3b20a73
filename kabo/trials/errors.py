"""The error of a trial that failed to give a usable result: it names the trial, and the place of its function."""

from collections.abc import Iterable

from kabo.errors import Diagnostic, InputError
from kabo.exploration import Case, Parameters


class TrialError(InputError):
    """A trial raised an error, or returned something that is no result; all trials before it are kept (exit code 2).

    Attributes:
        number: of the trial, from 1, counted over all cases.
        case: the values of the case variables.
        parameters: what was tried.
    """

    def __init__(self, diagnostics: Iterable[Diagnostic], number: int, case: Case, parameters: Parameters) -> None:
        self.number, self.case, self.parameters = number, dict(case), dict(parameters)
        super().__init__(diagnostics)

    def __reduce__(self) -> tuple[type["TrialError"], tuple[object, ...]]:  # type: ignore[override]
        """Pickles the arguments: by default only the message would be passed to `__init__` in another process."""
        return type(self), (self.diagnostics, self.number, self.case, self.parameters)
