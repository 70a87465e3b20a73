"""The records of learned parameters that solutions, task reports and plans carry."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from kabo.plan import Learned, described_validity
from kabo.tasks.core import Solution

if TYPE_CHECKING:
    from kabo.exploration import Inferred
    from kabo.tasks.learned.models import Model


def record_of(model: "Model", found: "Inferred") -> Learned:
    """The record of parameters that were inferred from a model, or judged by it."""
    return Learned(str(model), dict(found.case), dict(found.parameters), found.validity, dict(found.expected))


def learned_by(solution: Solution) -> Learned | None:
    """The record of a solution's own stage; None if the stage uses no learned parameters."""
    return solution.details if isinstance(solution.details, Learned) else None


def learned_in(solution: Solution) -> tuple[Learned, ...]:
    """The records of a solution and of all that it consists of, in order of time, each once."""
    found = (learned_by(each) for each in solution.walk())
    kept: list[Learned] = []
    for each in found:
        if each is not None and each not in kept:
            kept.append(each)
    return tuple(kept)


def comment_of(model: "Model", found: "Inferred", *, spread: bool = True) -> str:
    """Parameters, validity and expected outcomes as text: `along 0.01 m, valid at 0.97, torque 0.1 ± 0.2 Nm`."""
    known = model.exploration
    told = [_measured(name, value, known.space.units) for name, value in found.parameters.items()]
    told += [f"{name} {value}" for name, value in found.case.items()]
    told.append(f"valid at {described_validity(found.validity)}")
    for name, value in found.expected.items():
        unit = f" {known.units[name]}" if name in known.units else ""
        told.append(
            f"{name} {value:.3g} ± {found.deviation[name]:.2g}{unit}" if spread else f"{name} {value:.3g}{unit}"
        )
    return ", ".join(told)


def _measured(name: str, value: float, units: Mapping[str, str]) -> str:
    return f"{name} {value:.4g} {units[name]}" if name in units else f"{name} {value:.4g}"
