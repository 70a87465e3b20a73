"""Cost terms in files: named, with arguments, summed; written again; those of Python have no form unless registered."""
# ruff: noqa: E501 (lines of files stand on one line)

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.tasks.core import Solution, Task, TaskError, constant, offset, total, uniform_random, weighted
from kabo.tasks.files import load_task, register_cost, task_to_yaml
from tests.tasks.files.conftest import Start, Step, write

TEXT = "name: t\ncost: {offset: {value: 10}}\nstages:\n  - {name: a, stage: line/Start}\n  - {name: s, stage: line/Step, by: 3, cost: COST}\n"


def planned(folder: Path, cost: str) -> Solution:
    task = load_task(write(folder, TEXT.replace("COST", cost)))
    (solution,) = task.plan(0.0)
    return solution


def test_a_term_replaces_the_cost_of_its_stage_and_one_of_a_container_the_sum(tmp_path: Path) -> None:
    solution = planned(tmp_path, "{constant: {value: 5}}")
    assert solution["s"].cost == 5.0 and solution.cost == 15.0
    assert planned(tmp_path, "{offset: {value: 1}}")["s"].cost == 4.0


def test_the_same_solution_has_the_same_random_cost(tmp_path: Path) -> None:
    first, second = (planned(tmp_path, "{uniform_random: {low: 2, high: 3, seed: 4}}")["s"].cost for _ in range(2))
    assert 2.0 <= first == second <= 3.0
    assert planned(tmp_path, "{uniform_random: {low: 2, high: 3, seed: 5}}")["s"].cost != first


def own_cost(solution: Solution) -> tuple[float, str]:
    """A cost of one's own."""
    return 2.5, "cheap"


def scaled(factor: float, *, more: float = 0.0) -> object:
    """Makes one."""
    return lambda solution: factor + more


def test_terms_of_ones_own_are_named_summed_and_written_again(tmp_path: Path) -> None:
    register_cost(own_cost, "mine/own")
    register_cost(scaled, "mine/scaled", makes=True)
    solution = planned(tmp_path, "{sum: {mine/own: 2}}")
    assert (solution["s"].cost, solution["s"].comment) == (5.0, "by 3, cheap")
    for cost, value in (
        ("mine/own", 2.5),
        ("{mine/scaled: {factor: 2, more: 1}}", 3.0),
        ("{sum: {mine/own: 2}}", 5.0),
    ):
        task = load_task(write(tmp_path, TEXT.replace("COST", cost)))
        assert task.plan(0.0)[0]["s"].cost == value
        assert f"cost: {cost}\n" in task_to_yaml(task) and "cost: {offset: {value: 10}}\n" in task_to_yaml(task)
        assert task_to_yaml(load_task(write(tmp_path, task_to_yaml(task)))) == task_to_yaml(task)
    task = Task("t", Start("a"), Step("s", cost=own_cost))
    assert "cost: mine/own" in task_to_yaml(task)
    with pytest.raises(TaskError, match="the name 'mine/own' of a cost term is taken"):
        register_cost(scaled, "mine/own")
    with pytest.raises(TaskError, match="'sum'"):
        register_cost(own_cost, "sum")


@pytest.mark.parametrize(
    ("cost", "message", "hint"),
    [
        ("path_lenght", 'unknown cost term "path_lenght"', 'did you mean "path_length"?'),
        ("{path_length: 3}", "the arguments of the cost term path_length stand in braces", None),
        ("{path_length: {by: 3}}", "the cost term path_length takes no arguments", None),
        ("{constant: {valeu: 3}}", 'the cost term constant has no "valeu"', 'did you mean "value"?'),
        ("{constant: {amount: 3}}", 'the cost term constant has no "amount"', "it has value"),
        ("{constant: {}}", "the cost term constant: ", "it is constant(value: float)"),
        ("[a]", "a cost term is a name, or a name with its arguments", None),
        ("{sum: {duration: fast}}", "the weight of duration in a sum must be a number", None),
        ("{sum: 3}", "a sum of cost terms has weights", None),
    ],
)
def test_what_is_no_term_is_told_at_its_place(tmp_path: Path, cost: str, message: str, hint: str | None) -> None:
    with pytest.raises(InputError) as told:
        load_task(write(tmp_path, TEXT.replace("COST", cost)))
    (one,) = told.value.diagnostics
    assert one.message.startswith(f'`cost` of "s": {message}') and one.line == 5
    assert hint is None or (one.hint or "").startswith(hint)


def test_sums_add_terms_and_comments() -> None:
    task = Task("t", Start("a"), Step("s", by=2.0, cost=total(own_cost, constant(1.0), offset(0.5))))
    solution = task.plan(0.0)[0]["s"]
    assert (solution.cost, solution.comment) == (2.5 + 1.0 + 2.5, "by 2.0, cheap")
    task = Task("t", Start("a"), Step("s", cost=weighted((own_cost, 2.0), (uniform_random(1.0, 1.0), 3.0))))
    assert task.plan(0.0)[0]["s"].cost == 8.0


def test_an_infinite_cost_is_a_failure(tmp_path: Path) -> None:
    task = Task("t", Start("a"), Step("s", cost=constant(float("inf"))))
    assert task.plan(0.0) == [] and task.explain().failures == {"cost": 1}
