"""The stage LearnedParameters: parameters for a wanted outcome, as interface properties of a task [T e5]."""

import math
from collections.abc import Collection, Iterator, Mapping
from types import NoneType
from typing import Any

from kabo.exploration import INFERRED_ALPHA
from kabo.tasks.core import (
    Agreed,
    Alternatives,
    Failure,
    Fallbacks,
    Misfit,
    Propagator,
    Property,
    Reference,
    Result,
    UndefinedProperty,
)
from kabo.tasks.core.model.stages import Values
from kabo.tasks.learned.models import Model, model_of, open_model
from kabo.tasks.learned.naming import case_misfits, case_text, is_number, no_probability, outcome_misfits
from kabo.tasks.learned.records import comment_of, record_of

WANTED = ("target", "least", "most")  # of these exactly one is given


def _no_count(value: Any) -> str | None:
    return None if value >= 1 else f"is at least 1, not {value}"


class LearnedParameters(Propagator):
    """Infers parameters from a model: those believed valid whose expected outcome is nearest to the wanted one.

    Writes each parameter as an interface property of its name. The cost is the negative logarithm of the validity. Fails
    with `not_explored`, `nothing_valid` or `out_of_range`; the last names the nearest outcome that can be had.
    """

    PROPERTIES = {
        "model": Property(Model, doc="the file of the model, relative to the task file", opens=open_model),
        "where": Property(
            dict, {}, "variables of the case with their values; those left out are chosen; empty: all are"
        ),
        "target": Property((dict, NoneType), None, "the wanted outcome: {name: value}"),
        "least": Property((str, NoneType), None, "the outcome to be as small as possible, instead of a target"),
        "most": Property((str, NoneType), None, "the outcome to be as great as possible, instead of a target"),
        "tolerance": Property(
            (float, dict, NoneType),
            None,
            "how far from the target an outcome may be, or {name: how far}; none: twice the deviation there",
        ),
        "alpha": Property(
            float, INFERRED_ALPHA, "the parameters are valid with a greater probability", no_probability
        ),
        "count": Property(int, 1, "how many parameters, at least the scale of validity apart", _no_count),
    }

    def __init__(self, name: str, /, **properties: Any) -> None:
        """A stage; in Python `model` is a path, an exploration or a `Model`."""
        if "model" in properties:
            properties["model"] = model_of(properties["model"])
        super().__init__(name, **properties)

    @classmethod
    def writes(cls, values: Values) -> Collection[str]:
        """The parameters of the model."""
        model = values.get("model")
        return model.exploration.space.names if isinstance(model, Model) else ()

    @classmethod
    def misfits(cls, values: Values) -> Iterator[Misfit]:
        """Names that the model does not have, unusable numbers, and not exactly one of target, least and most."""
        model = values.get("model")
        given = [key for key in WANTED if values.get(key) is not None]
        if len(given) != 1:
            text = " and ".join(given) + " are given: one of them is wanted" if given else "no outcome is wanted"
            yield Misfit(tuple(given[1:2]), text, "target: {outcome: value}, least: outcome, or most: outcome")
        if isinstance(values.get("target"), Mapping):
            yield from _target_misfits(values["target"])
        if values.get("tolerance") is not None:
            yield from _tolerance_misfits(values)
        if not isinstance(model, Model):
            return
        yield from case_misfits(model, values.get("where"))
        for key in (*given, *(("tolerance",) if isinstance(values.get("tolerance"), Mapping) else ())):
            yield from outcome_misfits(model, values[key], (key,))

    def forward(self, scene: Any, properties: Values, seed: int) -> list[Result | Failure]:
        """One result for each alternative, the nearest first, with the unchanged scene; or a failure that says why."""
        from kabo.exploration import ExplorationError, NoParametersError

        model: Model = properties["model"]
        where = {name: case_text(value) for name, value in properties["where"].items()}
        try:
            model.exploration.space.part_of_case(where)
        except ExplorationError as error:  # other values were checked before: this one comes from a reference
            return [Failure("not_explored", f"by {model}: {error}", proof=self.is_fixed)]
        target, tolerance = _wanted(properties), properties["tolerance"]
        try:
            found = model.alternatives(
                target,
                where,
                properties["alpha"],
                "deviation" if tolerance is None else tolerance,
                properties["count"],
            )
        except NoParametersError as error:
            told = "".join(f", {name} {value}" for name, value in where.items())
            return [Failure(error.reason, f"by {model}{told}: {error}", proof=self.is_fixed)]
        return [
            Result(
                cost=-math.log(each.validity) + 0.0,
                comment=comment_of(model, each),
                properties={**each.parameters, f"other parameters by {self.path}": Agreed(each.parameters)},
                details=record_of(model, each),
            )
            for each in found
        ]

    backward = forward

    def refute(self) -> Failure | None:
        """The failure that makes the task unsolvable in any scene; None if there is none.

        Below `Alternatives` or `Fallbacks` there may be another way, so None.
        """
        from kabo.exploration import ExplorationError

        above = self.parent
        while above is not None:
            if isinstance(above, Alternatives | Fallbacks):
                return None
            above = above.parent
        try:
            values = {name: self.properties.value(name) for name in self.properties.declared}
            answers = self.forward(None, values, 0)
        except UndefinedProperty:  # the stage reads what other stages write
            return None
        except ExplorationError:  # planning reports it, with its place
            return None
        return next((each for each in answers if isinstance(each, Failure)), None)

    @property
    def is_fixed(self) -> bool:
        """Whether the results depend on nothing that other stages write."""
        return not any(self.properties.reads_interface(name) for name in self.properties.declared)


def _wanted(properties: Values) -> Mapping[str, Any]:
    """The target in the form of `Exploration.infer`."""
    if properties["target"] is not None:
        return dict(properties["target"])
    key = "least" if properties["least"] is not None else "most"
    return {properties[key]: key}


def _target_misfits(target: Mapping[str, Any]) -> Iterator[Misfit]:
    if not target:
        yield Misfit(("target",), "the target names no outcome", "target: {outcome: value}")
    for name, value in target.items():
        if not isinstance(value, Reference) and not is_number(value):
            yield Misfit(("target", name), f'the target of "{name}" must be a finite number, this is "{value}"')


def _tolerance_misfits(values: Values) -> Iterator[Misfit]:
    tolerance, target = values["tolerance"], values.get("target")
    if target is None:
        yield Misfit(("tolerance",), "there is no target that the tolerance could be about")
    given = tolerance if isinstance(tolerance, Mapping) else {"tolerance": tolerance}
    for name, value in given.items():
        keys = ("tolerance", name) if isinstance(tolerance, Mapping) else ("tolerance",)
        if not isinstance(value, Reference) and not (is_number(value) and value >= 0):
            yield Misfit(keys, f'a tolerance is a number from 0 on, this is "{value}"')
        if isinstance(tolerance, Mapping) and isinstance(target, Mapping) and name not in target:
            yield Misfit(keys, f'the target does not name "{name}", for which there is a tolerance')
