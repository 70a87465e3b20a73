"""The errors of tasks: wrong properties, and stages that do not fit together; each message says what to do."""

from collections.abc import Iterable
from difflib import get_close_matches


class TaskError(ValueError):
    """A task that cannot be planned because of an error in its definition."""


class UndeclaredProperty(TaskError):
    """An error: a property was set, read or inherited that no stage declares."""


class UndefinedProperty(TaskError):
    """An error: the value of a declared property is needed, but none was given and there is no default."""


class InitialisationError(TaskError):
    """An error: the stages of a task do not fit together.

    `errors` has a sentence for each fault; `tree` shows the stages with their flows.
    """

    def __init__(self, errors: Iterable[str], tree: str) -> None:
        self.errors = tuple(errors)
        self.tree = tree
        lines = "\n".join(f"  - {error}" for error in self.errors)
        super().__init__(f"the task does not fit together:\n{lines}\n{tree}")

    def __reduce__(self) -> tuple[type, tuple[tuple[str, ...], str]]:
        return type(self), (self.errors, self.tree)


def note(error: BaseException, text: str) -> None:
    """Adds a line of text to the error's traceback; does nothing before Python 3.11."""
    if hasattr(error, "add_note"):
        error.add_note(text)


def meant(name: str, names: Iterable[str]) -> str:
    """A hint for a misspelt name: `, did you mean 'x'?`, or an empty text if no name is close."""
    found = get_close_matches(name, list(names), 1)
    return f", did you mean {found[0]!r}?" if found else ""
