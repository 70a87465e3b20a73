"""Makes the exploration that a file describes, and checks that a model to be resumed was made from the same file."""

from collections.abc import Iterator, Mapping
from typing import Any

from kabo.errors import Diagnostic, InputError
from kabo.exploration import Exploration, Space, Validity
from kabo.language.exploration_description import ExplorationDescription
from kabo.language.findings import Findings

MOST_DIFFERENCES = 8  # listed in a message


def exploration_of(
    description: ExplorationDescription, *, seed: int = 0, invalid_budget: float | None = None
) -> Exploration:
    """A new exploration, without trials, as a file describes it.

    If the file says how a trial is made, but gives no `start`, it begins in the middle of the bounds. If trials are made
    elsewhere, as by a robot, no start is chosen for it: without one, the first trial must be told.

    Args:
        description: the file.
        seed: of all random candidates and trials.
        invalid_budget: the share of trials that may be invalid; None: as the file says.
    """
    default = Validity()
    start = description.start if description.trial is None else first_parameters(description)
    return Exploration(
        Space(
            {each.name: (each.lower, each.upper) for each in description.parameters},
            {each.name: each.values for each in description.cases},
            {each.name: each.unit for each in description.parameters if each.unit},
        ),
        [each.name for each in description.outcomes],
        seed=seed,
        validity=Validity(
            default.scale if description.scale is None else description.scale,
            default.noise if description.noise is None else description.noise,
            default.alpha if description.alpha is None else description.alpha,
        ),
        invalid_budget=description.invalid_budget if invalid_budget is None else invalid_budget,
        start=start,
        retry=description.retry,
        units={each.name: each.unit for each in description.outcomes if each.unit},
        name=description.name,
    )


def first_parameters(description: ExplorationDescription) -> Mapping[str, float]:
    """The start that a file gives, else the middle of its bounds."""
    if description.start is not None:
        return description.start
    return {each.name: each.lower + (each.upper - each.lower) / 2 for each in description.parameters}


def require_same(
    description: ExplorationDescription,
    exploration: Exploration,
    *,
    seed: int | None = None,
    invalid_budget: float | None = None,
) -> None:
    """Checks that a model to be resumed was made from the same file with the same options.

    Args:
        description: the file.
        exploration: the exploration in the model.
        seed, invalid_budget: the options of this run; None: as in the model.

    Raises:
        InputError: names everything that differs.
    """
    mine = exploration_of(
        description,
        seed=exploration.seed if seed is None else seed,
        invalid_budget=exploration.invalid_budget if invalid_budget is None else invalid_budget,
    ).header
    theirs = exploration.header
    if invalid_budget is None:
        mine["invalid_budget"] = theirs["invalid_budget"]
    different = [key for key in theirs if mine.get(key) != theirs[key]]
    if different:
        raise InputError([_of_another(description, ", ".join(different), list(_differences(mine, theirs, "")))])


def _differences(mine: Any, theirs: Any, name: str) -> Iterator[str]:
    """The differences between two headers, such as `seed is 1, in the model 0`."""
    if isinstance(mine, Mapping) and isinstance(theirs, Mapping):
        for key in dict.fromkeys([*mine, *theirs]):
            inner = f"{name} {key}".strip()
            if key not in mine:
                yield f"{inner} is only in the model"
            elif key not in theirs:
                yield f"{inner} is not in the model"
            else:
                yield from _differences(mine[key], theirs[key], inner)
    elif mine != theirs:
        yield f"{name} is {_said(mine)}, in the model {_said(theirs)}"


def _said(value: Any) -> str:
    """A value of a header in words."""
    if value is None:
        return "not given"
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_said(each)}" for name, each in value.items()) or "empty"
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def _of_another(description: ExplorationDescription, what: str, differences: list[str]) -> Diagnostic:
    findings = Findings()
    findings.know(description.source)
    left = len(differences) - MOST_DIFFERENCES
    told = [*differences[:MOST_DIFFERENCES], *([f"and {left} more"] if left > 0 else [])]
    hint = f"{'; '.join(told)}: write a new model"
    findings.add(description.place, f"the model was made with another {what}", hint)
    return findings.diagnostics[0]
