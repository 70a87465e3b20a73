"""Checks, before planning, of what a task says about a model: outcomes, case variables and their values, numbers.

References are not checked: their values are known only when a job runs.
"""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from kabo.errors import did_you_mean
from kabo.tasks.core import Misfit, Reference, TaskError

if TYPE_CHECKING:
    from kabo.tasks.learned.models import Model

LARGEST = 1e100  # as in `kabo.exploration`, which is not imported here, since it loads numpy


class MisfitError(TaskError):
    """Values do not fit the model; the message lists all `misfits`."""

    def __init__(self, misfits: Iterable[Misfit]) -> None:
        self.misfits = tuple(misfits)
        told = (each.message if each.hint is None else f"{each.message}, {each.hint}" for each in self.misfits)
        super().__init__("; ".join(told))


def case_text(value: Any) -> str:
    """The value of a case variable as text, as models have it, even if it is a number or a truth value in the task file."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def case_misfits(model: "Model", where: Any, keys: tuple[str, ...] = ("where",)) -> Iterator[Misfit]:
    """Case variables that the model does not have, and values that its variables do not take."""
    known = model.exploration.space.cases
    for name, value in where.items() if isinstance(where, Mapping) else ():
        if name not in known:
            yield unknown(model, "case variable", name, known, (*keys, name))
        elif not isinstance(value, Reference) and case_text(value) not in known[name]:
            yield unknown(model, name, case_text(value), known[name], (*keys, name))


def outcome_misfits(model: "Model", given: Any, keys: tuple[str, ...]) -> Iterator[Misfit]:
    """Outcomes that the model does not have; `given` is the name of one, or maps names to values."""
    known = model.exploration.outcomes
    for name in given if isinstance(given, Mapping) else () if isinstance(given, Reference) else (given,):
        if name not in known:
            where = (*keys, name) if isinstance(given, Mapping) else keys
            yield unknown(model, "outcome", name, known, where)


def unknown(model: "Model", kind: str, name: object, known: Iterable[str], keys: tuple[str, ...]) -> Misfit:
    """The misfit of a name that the model does not have; the hint is the nearest name that it has, or all."""
    names = list(known)
    hint = did_you_mean(str(name), names) or f"it has {', '.join(names) or 'none'}"
    return Misfit(keys, f'the model {model} has no {kind} "{name}"', hint)


def is_number(value: Any) -> bool:
    """Whether a value is a finite number that explorations take; a truth value is none."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def no_probability(value: Any) -> str | None:
    """Why a value is no probability between 0 and 1, both excluded; None if it is one."""
    return None if is_number(value) and 0 < value < 1 else f"is a probability above 0 and below 1, not {value!r}"
