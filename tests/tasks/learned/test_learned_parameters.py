"""The stage LearnedParameters: parameters for a wanted outcome, forward and backward, or the reason why there are none."""

import math
from collections.abc import Callable
from itertools import combinations

import pytest

from kabo.exploration import Exploration, ExplorationError
from kabo.tasks.core import Failure, Fallbacks, Flow, InitialisationError, Interface, Parent, Solution, Task
from kabo.tasks.learned import LearnedParameters, learned_by
from tests.support.bars import BALANCE, torque
from tests.tasks.files.conftest import Near, Points, Start, Step, Way

Hold = Callable[..., Task]
TARGETS = [{"target": {"torque": 0.0}}, {"target": {"torque": -0.2}}, {"least": "torque"}, {"most": "torque"}]


def found_by(known: Exploration, **properties: object) -> list[Solution]:
    """The solutions of the stage alone, after a generator."""
    stage = LearnedParameters("where", model=known, where={"bar": "steel"}, **properties)
    return Task("t", Start("start"), stage).plan(0.0)


def test_a_bar_is_held_where_it_hangs_level(hold: Hold) -> None:
    (solution,) = hold().plan(0.0)
    assert solution.end is not None
    assert solution.end.scene == solution["where"].properties["along"] == pytest.approx(BALANCE["steel"], abs=2e-3)
    assert {"along", "force"} < set(solution["where"].properties)
    assert solution["where"].comment.startswith("along 0.0") and "Nm" in solution["where"].comment


def test_backward_the_stages_before_it_read_the_parameters(known: Exploration) -> None:
    where = LearnedParameters("where", model=known, where={"bar": "steel"}, target={"torque": 0.0})
    task = Task("t", Step("step", by=Interface("along")), where, Points("goal", points=[0.5]))
    (solution,) = task.plan(0.0)
    assert task.directions[where] is Flow.BACKWARD
    assert solution.start is not None
    along = solution.start.properties["along"]
    assert along == pytest.approx(BALANCE["steel"], abs=2e-3)
    assert solution.start.scene == pytest.approx(0.5 - along)


@pytest.mark.parametrize("alpha", [0.6, 0.95, 0.999])
@pytest.mark.parametrize("wanted", TARGETS, ids=str)
def test_alternatives_are_valid_enough_apart_and_as_dear_as_they_are_risky(
    known: Exploration, wanted: dict[str, object], alpha: float
) -> None:
    solutions = found_by(known, alpha=alpha, count=4, tolerance=None, **wanted)
    assert len(solutions) > 1
    points = []
    for each in solutions:
        part = each["where"]
        parameters = {name: part.properties[name] for name in ("along", "force")}
        (validity,) = known.validity({"bar": "steel"}, [parameters])
        assert validity > alpha
        assert part.cost == pytest.approx(-math.log(validity), abs=1e-9) and part.cost >= 0.0
        points.append(known.space.scaled([parameters])[0])
        record = learned_by(part)
        assert record is not None and record.case == {"bar": "steel"} and record.parameters == parameters
        assert record.expected["torque"] == pytest.approx(torque("steel", parameters["along"]), abs=0.05)
    for one, other in combinations(points, 2):
        assert math.dist(one, other) >= known.validity_options.scale - 1e-9


def test_the_same_model_gives_the_same_parameters(hold: Hold) -> None:
    first, second = (hold(("0.0}", "-0.1}\n    count: 3")).plan(0.0) for _ in range(2))
    assert [each["where"].properties for each in first] == [each["where"].properties for each in second]


@pytest.mark.parametrize(
    ("change", "reason", "comment"),
    [
        (("steel", "wood"), "not_explored", "by model.jsonl, bar wood: no trial has been made"),
        (("0.0}", "3.0}"), "out_of_range", "the nearest is torque 0."),
        (("0.0}", "0.0}\n    alpha: 0.9999999999999999"), "nothing_valid", "no parameters are valid"),
        (("0.0}", "0.1}\n    tolerance: 1e-9"), "out_of_range", "torque 0.1 cannot be had"),
    ],
)
def test_without_parameters_it_says_why(hold: Hold, change: tuple[str, str], reason: str, comment: str) -> None:
    task = hold(change)
    assert task.plan(0.0) == []
    why = task.explain()
    assert why.failures == {reason: 1} and comment in why.examples[0].comment and "where" in why.text


def test_a_bar_that_only_a_caller_names_may_be_unknown_to_the_model(known: Exploration) -> None:
    stage = LearnedParameters("where", model=known, where={"bar": Parent("which")}, target={"torque": 0.0})
    task = Task("t", Start("start"), stage, which="glas")
    assert task.plan(0.0) == []
    assert task.explain().failures == {"not_explored": 1}
    assert "glas" in task.explain().examples[0].comment


def test_without_a_case_the_best_of_all_cases_is_taken(hold: Hold) -> None:
    (solution,) = hold(("    where: {bar: steel}\n", "")).plan(0.0)
    record = learned_by(solution["where"])
    assert record is not None and record.case == {"bar": "steel"}


def test_only_a_failure_that_every_solution_must_meet_refutes_the_task(known: Exploration) -> None:
    def stage(**properties: object) -> LearnedParameters:
        return LearnedParameters("where", model=known, where={"bar": "steel"}, **properties)

    alone, fine = stage(target={"torque": 9.0}), stage(target={"torque": 0.0})
    chosen, earlier = stage(target={"torque": 9.0}), stage(target={"torque": Interface("goal")})
    Task("t", Start("start"), alone, fine, Fallbacks("or", chosen, Step("step")), earlier)
    refuted = alone.refute()
    assert refuted is not None and refuted.reason == "out_of_range" and refuted.proof
    assert fine.refute() is None and chosen.refute() is None and earlier.refute() is None
    values = {name: alone.properties.value(name) for name in alone.properties.declared}
    (failure,) = earlier.forward(None, values, 0)
    assert isinstance(failure, Failure) and failure.reason == "out_of_range" and not failure.proof


def test_in_python_wrong_names_are_told_before_planning(known: Exploration) -> None:
    stage = LearnedParameters("where", model=known, where={"bar": "stele"}, most="torqe")
    with pytest.raises(InitialisationError) as told:
        Task("t", Start("start"), stage).plan(0.0)
    text = str(told.value)
    assert 'has no bar "stele"' in text and 'has no outcome "torqe"' in text


def test_a_target_that_is_no_number_when_the_job_runs_is_an_error_of_the_caller(known: Exploration) -> None:
    target = {"torque": Parent("wanted")}
    stage = LearnedParameters("where", model=known, where={"bar": "steel"}, target=target)
    with pytest.raises(ExplorationError, match="torque must be a finite number"):
        Task("t", Start("start"), stage, wanted="much").plan(0.0)


def test_what_stands_on_both_sides_of_a_connector_relies_on_the_same_alternative(known: Exploration) -> None:
    where = LearnedParameters("where", model=known, where={"bar": "steel"}, target={"torque": 0.0}, count=3)
    goal = Near("goal", monitors="where", by=Interface("along"))
    task = Task("t", Start("start"), where, Way("way"), goal)
    solutions = task.plan(0.0)
    assert len(solutions) == 3
    for each in solutions:
        assert each.end is not None and each.end.scene == each["where"].properties["along"]
    assert task.figures(task.children[2]).mismatches == {"other parameters by where": 6}
