"""Trials that plan a task: valid within a number of jobs, with costs as outcomes, or the stage to blame as reason."""

from pathlib import Path

import pytest

from kabo.errors import CutOff
from kabo.exploration import Journal
from kabo.trials import (
    Invalid,
    Valid,
    exploration_of,
    load_exploration_file,
    run_exploration,
    trial_findings,
    trial_of,
)
from tests.trials import conftest
from tests.trials.conftest import JUMPS, Jump

GRASS = {"ground": "grass"}


def test_a_trial_is_valid_if_there_is_a_solution_and_its_outcome_is_the_cost(jumps: Path) -> None:
    trial = trial_of(load_exploration_file(jumps))
    assert trial(GRASS, {"far": 0.5, "side": 0.0}, 0) == Valid({"cost": 0.5})
    assert trial(GRASS, {"far": 1.0, "side": -0.25}, 0) == Valid({"cost": pytest.approx(1.05)})


def test_the_case_and_every_parameter_reach_the_task(jumps: Path) -> None:
    trial = trial_of(load_exploration_file(jumps))
    assert trial({"ground": "ice"}, {"far": 1.0, "side": 0.0}, 0) == Valid({"cost": pytest.approx(1.08)})
    result = trial(GRASS, {"far": 1.0, "side": 0.75}, 0)
    assert isinstance(result, Invalid) and result.reason == "jump: beside"


def test_what_takes_more_jobs_than_there_are_is_invalid_and_the_stage_is_named(jumps: Path) -> None:
    parameters = {"far": 1.5, "side": 0.0}  # the eleventh try is good enough
    few = trial_of(load_exploration_file(jumps))(GRASS, parameters, 0)
    jumps.write_text(JUMPS.replace("jobs: 30", "jobs: 3"))
    assert isinstance(few, Valid)
    result = trial_of(load_exploration_file(jumps))(GRASS, parameters, 0)
    assert isinstance(result, Invalid) and result.reason == "jump: too_short"
    assert "3 jobs are spent" in result.comment and "'jump' found nothing" in result.comment
    jumps.write_text(JUMPS.replace("jobs: 30", "jobs: 1"))
    result = trial_of(load_exploration_file(jumps))(GRASS, parameters, 0)
    assert isinstance(result, Invalid) and result.reason == "jobs spent"


def test_of_several_solutions_the_best_counts(jumps: Path) -> None:
    jumps.write_text(JUMPS.replace("  jobs: 30\n", "  jobs: 300\n  max_solutions: 4\n"))
    result = trial_of(load_exploration_file(jumps))(GRASS, {"far": 1.0, "side": 0.0}, 0)
    assert result == Valid({"cost": pytest.approx(1.05)}, "4 solutions")


def test_an_outcome_may_be_a_cost_term(jumps: Path) -> None:
    jumps.write_text(JUMPS.replace("outcomes: {cost: {unit: J}}", "outcomes: {cost: , uniform_random: }"))
    result = trial_of(load_exploration_file(jumps))(GRASS, {"far": 1.0, "side": 0.0}, 0)
    assert isinstance(result, Valid) and list(result.outcomes) == ["cost", "uniform_random"]


def test_a_trial_that_is_stopped_has_no_result(jumps: Path) -> None:
    with pytest.raises(CutOff):
        trial_of(load_exploration_file(jumps), stop=lambda: True)(GRASS, {"far": 1.0, "side": 0.0}, 0)


def test_an_exploration_of_a_task_finds_where_it_can_be_solved(jumps: Path, tmp_path: Path) -> None:
    file = load_exploration_file(jumps)
    journal = Journal.create(tmp_path / "m.jsonl", exploration_of(file))
    assert run_exploration(journal, trial_of(file), 80).ended == "done"
    near, far = ({"far": 1.0, "side": 0.0}, {"far": 3.0, "side": 0.0})
    assert list(journal.exploration.validity(GRASS, [near, far]) > 0.5) == [True, False]
    assert {each.reason for each in journal.exploration.trials} == {"", "jump: beside", "jump: too_short"}


def test_an_error_of_a_stage_of_ones_own_is_told_at_its_line_and_names_the_trial(jumps: Path) -> None:
    jumps.write_text(JUMPS.replace("landing: {at:", "landing: {on:"))
    (one,) = trial_findings(load_exploration_file(jumps))
    assert one.message == "trial 1 (ground grass; far 0.5, side 0) raised KeyError: 'at'"
    assert (one.file, one.line) == (conftest.__file__, Jump.forward.__code__.co_firstlineno + 1)


@pytest.mark.parametrize("jobs", [5, 17, 30])
def test_the_result_does_not_depend_on_the_number_of_workers(jumps: Path, jobs: int) -> None:
    jumps.write_text(JUMPS.replace("jobs: 30", f"jobs: {jobs}"))
    file = load_exploration_file(jumps)
    for far in (0.8, 1.2, 1.9):
        parameters = {"far": far, "side": 0.0}
        results = [trial_of(file, workers=workers)(GRASS, parameters, 3) for workers in (None, 1, 2)]
        assert results[0] == results[1] == results[2]
