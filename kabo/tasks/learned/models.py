"""Models in tasks: the journal of an exploration, read with the task file, and a cache of its answers.

Answers are cached by the content of the model, so a changed file is never mistaken for the old one.
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Union

from kabo.content_cache import ContentCache
from kabo.errors import Diagnostic, InputError
from kabo.language.source import UnreadableError, beside, missing_file_reason

if TYPE_CHECKING:  # imports numpy, which only tasks with a model need
    from kabo.exploration import Exploration, Inferred, NoParametersError

CACHE_BYTES, ANSWER_BYTES = 10_000_000, 2_000
_Answer = Union["tuple[Inferred, ...]", "NoParametersError"]
_ANSWERS: ContentCache[_Answer] = ContentCache(CACHE_BYTES, lambda _: ANSWER_BYTES)


@dataclass(frozen=True)
class Model:
    """A model: its path as the task writes it, the path at which it was opened, and its exploration."""

    written: str
    path: str
    exploration: "Exploration"

    def __str__(self) -> str:
        return self.written

    def __fspath__(self) -> str:
        return self.path

    def alternatives(
        self, target: Mapping[str, Any], where: Mapping[str, str], alpha: float, tolerance: Any, count: int
    ) -> "tuple[Inferred, ...]":
        """What `Exploration.alternatives` gives for these arguments, from the cache if the content is the same.

        Raises:
            NoParametersError: there are none.
            ExplorationError: an argument is wrong.
        """
        from kabo.exploration import NoParametersError

        key = self.exploration.digest, repr((dict(target), dict(where), alpha, tolerance, count))

        def ask() -> _Answer:
            try:
                return self.exploration.alternatives(target, where, alpha, tolerance, count)
            except NoParametersError as error:
                return error.with_traceback(None)

        answer = _ANSWERS.get_or_make(key, ask)
        if isinstance(answer, NoParametersError):
            raise NoParametersError(answer.reason, str(answer), answer.nearest)
        return answer


def open_model(written: str, folder: str = "") -> Model:
    """The model in the file `written`, a path relative to `folder`.

    Raises:
        UnreadableError: there is no such file.
        InputError: the file is no model, or damaged; with the place in it.
    """
    from kabo.exploration import load_exploration

    path = beside(folder, written)
    reason = missing_file_reason(Path(path))
    if reason is not None:
        raise UnreadableError(reason)
    return Model(written, path, load_exploration(path))


def model_of(given: Any) -> Any:
    """The model of a path or of an exploration that is given in Python; anything else as it is.

    Raises:
        InputError: there is no such file, it is no model, or it is damaged.
    """
    from kabo.exploration import Exploration

    if isinstance(given, Exploration):
        return Model(given.name or "exploration", "", given)
    if not isinstance(given, (str, os.PathLike)) or isinstance(given, Model):
        return given
    try:
        return open_model(os.fspath(given))
    except UnreadableError as error:
        raise InputError([Diagnostic(os.fspath(given), 1, 1, error.message, error.hint)]) from None
