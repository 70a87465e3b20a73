"""The cost term risk: parameters that come from elsewhere cost what a model holds them to risk."""

import math
from collections.abc import Callable

import pytest

from kabo.exploration import Exploration
from kabo.tasks.core import INTERFACE, Interface, Parent, Task
from kabo.tasks.learned import LearnedParameters, MisfitError, learned_by, risk
from tests.tasks.files.conftest import Start, Step

STEEL = {"bar": "steel"}


def cost_of(known: Exploration, parameters: dict[str, object], alpha: float = 0.95) -> tuple[float | None, Task]:
    """The cost of a step with such parameters, None if it fails; and the task."""
    task = Task("t", Start("start"), Step("step", cost=risk(known, STEEL, alpha, parameters)), push=20.0)
    solutions = task.plan(0.0)
    return (solutions[0]["step"].cost if solutions else None), task


def test_the_cost_is_the_negative_logarithm_of_the_validity(known: Exploration) -> None:
    for along, force in ((0.02, 15.0), (0.0, 20.0), (0.05, 24.0)):
        (validity,) = known.validity(STEEL, [{"along": along, "force": force}])
        assert validity > 0.9
        cost, task = cost_of(known, {"along": along, "force": force}, 0.9)
        assert cost == pytest.approx(-math.log(validity), abs=1e-12)
        record = learned_by(task.solutions[0]["step"])
        assert record is not None and record.parameters == {"along": along, "force": force}
        assert record.validity == validity and set(record.expected) == {"torque"}


def test_what_is_not_valid_enough_is_refused_and_says_how_valid_it_is(known: Exploration) -> None:
    cost, task = cost_of(known, {"along": 0.02, "force": 2.0})
    assert cost is None and task.explain().failures == {"cost": 1}
    assert "force 2 N" in task.explain().examples[0].comment
    assert task.explain().examples[0].comment.endswith("not above 0.95")


def test_values_come_from_ancestors_and_from_earlier_stages(known: Exploration) -> None:
    where = LearnedParameters("where", model=known, where=STEEL, target={"torque": 0.0})
    pushed = risk(known, STEEL, parameters={"along": INTERFACE, "force": Parent("push")})
    task = Task("t", Start("start"), where, Step("a", cost=risk(known, STEEL)), Step("b", cost=pushed), push=20.0)
    (solution,) = task.plan(0.0)
    assert solution["a"].cost == pytest.approx(solution["where"].cost, abs=1e-12)
    record = learned_by(solution["b"])
    assert record is not None
    assert record.parameters == {"along": solution["where"].properties["along"], "force": 20.0}


@pytest.mark.parametrize(
    ("parameters", "comment"),
    [
        ({"along": Interface("offset"), "force": 9.0}, "the interface state has no 'offset'"),
        ({"along": 0.0, "force": Parent("much")}, "force must be a finite number"),
        ({"along": Parent("push"), "force": 9.0}, "along is 20, outside its bounds"),
    ],
)
def test_values_that_are_none_when_a_solution_is_found_are_refused(
    known: Exploration, parameters: dict[str, object], comment: str
) -> None:
    step = Step("step", cost=risk(known, STEEL, parameters=parameters))
    task = Task("t", Start("start"), step, push=20.0, much="much")
    assert task.plan(0.0) == [] and comment in task.explain().examples[0].comment


def test_nothing_is_known_of_a_case_without_trials(known: Exploration) -> None:
    step = Step("step", cost=risk(known, {"bar": "wood"}, parameters={"along": 0.0, "force": 9.0}))
    task = Task("t", Start("start"), step)
    assert task.plan(0.0) == [] and "no trial has been made" in task.explain().examples[0].comment


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"where": {}}, "the case must say bar: steel or wood"),
        ({"where": {"bar": "woods"}}, 'has no bar "woods", did you mean "wood"?'),
        ({"where": STEEL, "alpha": 1.0}, "alpha is a probability above 0 and below 1, not 1.0"),
        ({"where": STEEL, "alpha": math.nan}, "alpha is a probability"),
        ({"where": STEEL, "parameters": {"forces": 3.0}}, 'has no parameter "forces", did you mean "force"?'),
        ({"where": STEEL, "parameters": {"force": "hard"}}, "force must be a finite number"),
        ({"where": STEEL, "parameters": {"force": 41.0}}, "force is 41, outside its bounds 1 to 40"),
    ],
)
def test_wrong_arguments_are_told(known: Exploration, arguments: dict[str, object], message: str) -> None:
    with pytest.raises(MisfitError) as told:
        risk(known, **arguments)  # type: ignore[arg-type]
    assert message in str(told.value)


def test_sums_of_terms_may_contain_a_risk(known: Exploration) -> None:
    from kabo.tasks.core import constant, total

    term: Callable[..., object] = total(
        constant(2.0), risk(known, STEEL, parameters={"along": 0.02, "force": 15.0})
    )
    task = Task("t", Start("start"), Step("step", cost=term))
    step = task.plan(0.0)[0]["step"]
    assert step.cost == pytest.approx(2.0, abs=1e-3) and learned_by(step) is not None
