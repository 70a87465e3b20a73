"""The errors of tasks: of properties, and of structures that do not fit; each says what to do."""

from collections.abc import Iterable
from difflib import get_close_matches


class TaskError(ValueError):
    """A task that cannot be planned as it is written."""


class UndeclaredProperty(TaskError):
    """A property that nobody declared was set, read or inherited."""


class UndefinedProperty(TaskError):
    """A declared property has no value."""


class InitialisationError(TaskError):
    """Stages that do not fit together; `errors` has one sentence for each, `tree` the task with its arrows."""

    def __init__(self, errors: Iterable[str], tree: str) -> None:
        self.errors = tuple(errors)
        self.tree = tree
        lines = "\n".join(f"  - {error}" for error in self.errors)
        super().__init__(f"the task does not fit together:\n{lines}\n{tree}")

    def __reduce__(self) -> tuple[type, tuple[tuple[str, ...], str]]:
        return type(self), (self.errors, self.tree)


def note(error: BaseException, text: str) -> None:
    """Adds a line to what is shown of an error, from Python 3.11 on."""
    if hasattr(error, "add_note"):
        error.add_note(text)


def meant(name: str, names: Iterable[str]) -> str:
    """`, did you mean 'x'?`, or nothing."""
    found = get_close_matches(name, list(names), 1)
    return f", did you mean {found[0]!r}?" if found else ""
