"""The cost term `risk`: how likely parameters that come from elsewhere are to be invalid, by a model [T e9]."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from kabo.exploration import INFERRED_ALPHA
from kabo.tasks.core import Interface, Misfit, Reference, Solution, TaskError
from kabo.tasks.core.model.stages import Told
from kabo.tasks.learned.models import Model, model_of
from kabo.tasks.learned.naming import MisfitError, case_misfits, case_text, is_number, no_probability, unknown
from kabo.tasks.learned.records import comment_of, record_of

if TYPE_CHECKING:
    from kabo.exploration import Inferred

INFINITE = math.inf  # the cost of parameters that are not believed valid enough


class Risk:
    """The negative logarithm of the validity of parameters; infinite where they are not believed valid enough.

    Args:
        model: the model.
        where: every variable of the case with its value.
        alpha: the validity must be greater than this.
        parameters: values by name; a parameter that is left out is the interface property of its name.
    """

    def __init__(
        self, model: Model, where: Mapping[str, Any], alpha: float, parameters: Mapping[str, Any]
    ) -> None:
        self.model, self.where, self.alpha = model, dict(where), alpha
        names = model.exploration.space.names
        self.implied = tuple(name for name in names if name not in parameters)
        self.parameters = {name: parameters.get(name, Interface(name)) for name in names}

    def __call__(self, solution: Solution) -> Told:
        """The cost of a solution, a comment, and the record of its parameters."""
        from kabo.exploration import ExplorationError

        start = {} if solution.start is None else solution.start.properties
        # Costs are computed in the process that plans, where a solution has its stage, not only the stage's name.
        resolved = solution.stage.properties.resolved  # type: ignore[attr-defined]
        try:
            case, parameters = (
                resolved(each, "cost", {**start, **solution.properties}) for each in (self.where, self.parameters)
            )
            found = self.found(case, parameters)
        except (TaskError, ExplorationError) as error:
            return INFINITE, f"{self.model}: {error}"
        comment = comment_of(self.model, found)
        if not found.validity > self.alpha:
            return INFINITE, f"{comment}: not above {self.alpha:g}"
        return -math.log(found.validity) + 0.0, comment, record_of(self.model, found)

    def found(self, case: Mapping[str, Any], parameters: Mapping[str, Any]) -> "Inferred":
        """The parameters with their validity and expected outcomes by the model.

        Raises:
            ExplorationError: parameters or case are not usable, or no trial of the case is valid.
        """
        from kabo.exploration import Inferred

        known = self.model.exploration
        case = known.space.case({name: case_text(value) for name, value in case.items()})
        parameters = known.space.checked(parameters)
        validity = float(known.validity(case, [parameters])[0])
        told = known.predict(case, [parameters])
        expected = {name: float(mean[0]) for name, (mean, _) in told.items()}
        deviation = {name: float(spread[0]) for name, (_, spread) in told.items()}
        return Inferred(case, parameters, validity, expected, deviation)


def risk(
    model: Any,
    where: Mapping[str, Any] | None = None,
    alpha: float = INFERRED_ALPHA,
    parameters: Mapping[str, Any] | None = None,
) -> Risk:
    """The cost term for a model, given by its path, or in Python as an exploration.

    Raises:
        InputError: the file cannot be read.
        MisfitError: a name is unknown to the model, a variable of the case is missing, or a value is not usable; lists all.
        TaskError: `where` or `parameters` does not map names to values.
    """
    model = model_of(model)
    where, parameters = {} if where is None else where, {} if parameters is None else parameters
    if not (isinstance(model, Model) and isinstance(where, Mapping) and isinstance(parameters, Mapping)):
        raise TaskError("it has a model, and `where` and `parameters` map names to values")
    faults = [*case_misfits(model, where), *_misfits(model, where, alpha, parameters)]
    if faults:
        raise MisfitError(faults)
    return Risk(model, where, alpha, parameters)


def _misfits(model: Model, where: Mapping[str, Any], alpha: float, parameters: Mapping[str, Any]) -> list[Misfit]:
    space, found = model.exploration.space, []
    for name in space.cases:
        if name not in where:
            found.append(Misfit(("where",), f"the case must say {name}: {' or '.join(space.cases[name])}"))
    fault = no_probability(alpha)
    if fault is not None:
        found.append(Misfit(("alpha",), f"alpha {fault}"))
    for name, value in parameters.items():
        if name not in space.parameters:
            found.append(unknown(model, "parameter", name, space.names, ("parameters", name)))
        elif isinstance(value, Reference):
            continue
        elif not is_number(value):
            found.append(Misfit(("parameters", name), f'{name} must be a finite number, this is "{value}"'))
        elif not space.parameters[name][0] <= value <= space.parameters[name][1]:
            low, high = space.parameters[name]
            found.append(
                Misfit(("parameters", name), f"{name} is {value:g}, outside its bounds {low:g} to {high:g}")
            )
    return found
