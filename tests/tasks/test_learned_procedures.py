"""Procedures whose tasks have learned parameters: in plans, refusals and explanations, and for another model anew."""

import json
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

import kabo
from kabo.errors import InputError
from kabo.explain.explain import explanation_to_json
from kabo.geometry_server import GeometryServer, Refusal, Situation, Success
from kabo.language import load_problem
from kabo.language.formulas import GroundCall
from kabo.plan import describe, plan_from_json, plan_to_json, schema
from kabo.requests import check_files
from kabo.scene import load_scene
from kabo.tasks.procedures import GeometricProcedures
from kabo.verify import verify_plan
from tests.support.bars import AIM, BALANCE, explored, write_domain

STEEL, WOOD = GroundCall("aim", ("arm", "steel"), ()), GroundCall("aim", ("arm", "wood"), ())


def procedures(problem: Path) -> GeometricProcedures:
    """Procedures, with no memory, for a problem."""
    description = load_problem(problem).scene
    assert description is not None
    return GeometricProcedures(GeometryServer(load_scene(description)), problem.parent)


def changed(problem: Path, old: str, new: str) -> Path:
    """The problem, after some words of its task were replaced by others."""
    assert old in AIM
    (problem.parent / "tasks" / "aim.yaml").write_text(AIM.replace(old, new))
    return problem


def test_a_call_succeeds_with_the_record_of_what_was_learned(tmp_path: Path) -> None:
    asked = procedures(write_domain(tmp_path))
    answer = asked.call(STEEL, Situation.of(asked.scene.start))
    assert isinstance(answer, Success)
    (learned,) = answer.learned
    assert Path(learned.model).resolve() == (tmp_path / "model.jsonl").resolve()
    assert learned.case == {"bar": "steel"}
    assert answer.motion[-1].waypoints[-1] == (pytest.approx(learned.parameters["along"]),)
    assert learned.parameters["along"] == pytest.approx(BALANCE["steel"], abs=2e-3)


def test_each_further_attempt_takes_the_next_of_the_alternatives(tmp_path: Path) -> None:
    problem = write_domain(tmp_path)
    asked = procedures(changed(problem, "{torque: 0.0}", "{torque: 0.0}\n    count: 2"))
    start = Situation.of(asked.scene.start)
    answers = [asked.call(STEEL, start, attempt) for attempt in range(3)]
    first, second = (each.learned[0].parameters for each in answers[:2] if isinstance(each, Success))
    assert first != second and isinstance(answers[2], Refusal)


@pytest.mark.parametrize(
    ("call", "old", "new", "reason", "said"),
    [
        (WOOD, "0.0}", "0.0}", "not_explored", "by ../model.jsonl, bar wood: no trial has been made"),
        (STEEL, "0.0}", "5.0}", "out_of_range", "the nearest is torque 0."),
        (STEEL, "0.0}", "0.0}\n    alpha: 0.9999999999999999", "nothing_valid", "no parameters are valid"),
    ],
)
def test_without_parameters_the_refusal_is_a_proof_with_its_reason(
    tmp_path: Path, call: GroundCall, old: str, new: str, reason: str, said: str
) -> None:
    asked = procedures(changed(write_domain(tmp_path), old, new))
    answer = asked.call(call, Situation.of(asked.scene.start))
    assert isinstance(answer, Refusal)
    assert (answer.reason, answer.proof, answer.reads) == (reason, True, frozenset())
    assert said in answer.comment and answer.comment.startswith("arm cannot aim")
    refuted = procedures(tmp_path / "problem.yaml").refuted(call)
    assert refuted is not None and refuted.reason == reason, "it is known before any search"


def test_a_failure_inside_fallbacks_refutes_nothing(tmp_path: Path) -> None:
    stage = AIM[AIM.index("  - name: where") : AIM.index("  - name: move")]
    inner = "".join(f"    {line}\n" for line in stage.splitlines())
    heavy = inner.replace("0.0}", "5.0}").replace("name: where", "name: heavy")
    choice = f"  - name: choice\n    stage: Fallbacks\n    stages:\n{heavy}{inner}"
    asked = procedures(changed(write_domain(tmp_path), stage, choice))
    assert asked.refuted(STEEL) is None
    assert isinstance(asked.call(STEEL, Situation.of(asked.scene.start)), Success)


# ---------------------------------------------------------------------------------------------- plans
def test_a_plan_says_what_was_learned_and_from_which_of_its_files(tmp_path: Path) -> None:
    problem = load_problem(write_domain(tmp_path))
    plan = kabo.solve(problem).plan
    assert plan is not None
    (node,) = (node for node in plan.nodes.values() if node.kind == "action")
    (learned,) = node.learned
    assert learned.model == "model.jsonl" and plan.files["model.jsonl"] == problem.files["model.jsonl"]
    written = json.loads(plan_to_json(plan))
    jsonschema.validate(written, schema("kabo-plan-2"))
    assert written["nodes"][plan.root]["learned"]["case"] == {"bar": "steel"}
    assert plan_to_json(plan_from_json(plan_to_json(plan))) == plan_to_json(plan)
    assert "[learned along=0.0" in describe(plan) and "valid at over 0.999]" in describe(plan)
    assert verify_plan(problem, plan).ok, str(verify_plan(problem, plan))
    good = kabo.solve(problem, quality="good").plan
    assert good is not None and good.nodes[good.root].learned == node.learned
    assert plan_to_json(kabo.solve(problem, workers=2).plan) == plan_to_json(plan)


def test_another_model_in_the_same_file_gives_another_plan(tmp_path: Path) -> None:
    path = write_domain(tmp_path)
    plans = [kabo.solve(load_problem(path)).plan for _ in range(2)]
    explored(61).save(tmp_path / "model.jsonl")
    plans.append(kabo.solve(load_problem(path)).plan)
    assert all(plan is not None for plan in plans)
    first, same, other = map(plan_to_json, plans)
    assert first == same
    assert plans[2].nodes["n0"].motion != plans[0].nodes["n0"].motion
    report = verify_plan(load_problem(path), plans[0])
    assert [each.message for each in report.findings] == ["made for other files: model.jsonl has changed since"]
    assert verify_plan(load_problem(path), plans[2]).ok


def test_a_plan_that_hides_its_model_is_not_verified(tmp_path: Path) -> None:
    problem = load_problem(write_domain(tmp_path))
    content = json.loads(plan_to_json(kabo.solve(problem).plan))
    content["nodes"]["n0"]["learned"]["model"] = "elsewhere.jsonl"
    report = verify_plan(problem, plan_from_json(json.dumps(content)))
    assert "learned from elsewhere.jsonl, which is not recorded in the plan" in str(report)


def test_an_explanation_names_the_reason_and_what_can_be_had(tmp_path: Path) -> None:
    problem = load_problem(changed(write_domain(tmp_path), "0.0}", "5.0}"))
    result = kabo.solve(problem)
    assert result.status == "no_plan" and result.reason is not None and result.reason.proved == "refusals"
    explained = kabo.explain(problem)
    jsonschema.validate(explanation_to_json(explained), schema("kabo-explain-1"))
    assert "out of range" in str(explained)
    assert "torque 5 cannot be had: the nearest is torque 0." in str(explained)


# ---------------------------------------------------------------------------------------------- files
def test_a_model_outside_of_the_folder_that_may_be_read_is_not_opened(tmp_path: Path) -> None:
    path = write_domain(tmp_path / "inside")
    (tmp_path / "inside" / "model.jsonl").rename(tmp_path / "model.jsonl")
    changed(path, "../model.jsonl", "../../model.jsonl")
    assert kabo.solve(load_problem(path)).plan is not None
    with pytest.raises(InputError) as told:
        load_problem(path, within=tmp_path / "inside")
    (one,) = told.value.diagnostics
    assert "outside of the folder" in one.message and (one.line, one.column) == (9, 12)


def test_a_missing_model_is_told_once_and_with_its_place(tmp_path: Path) -> None:
    path = write_domain(tmp_path)
    (tmp_path / "model.jsonl").unlink()
    (one,) = check_files([path])
    assert (one.line, one.column, one.message) == (9, 12, '"../model.jsonl": there is no such file')


@pytest.mark.slow
def test_without_scikit_learn_one_line_says_how_to_install_it(tmp_path: Path) -> None:
    path = write_domain(tmp_path)
    call = f"sys.exit(main({['solve', str(path)]!r}))"
    program = f"import sys; sys.modules['sklearn'] = None; from kabo.cli import main; {call}"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "Traceback" not in done.stderr
    assert done.stderr.count("\n") == 1 and 'pip install "kabo[explore]"' in done.stderr
