"""Task files that name models: every fault is told at its place, before planning; reports say what was learned."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import json
from pathlib import Path

import jsonschema
import pytest

from kabo.errors import InputError
from kabo.plan import schema as schema_of
from kabo.requests import check_files
from kabo.tasks import dump_task, load_task, load_task_file, task_to_yaml
from kabo.tasks.files.describing import describe_report
from kabo.tasks.files.report_form import Report, read_report, report_bytes
from kabo.tasks.files.reports import report
from kabo.tasks.files.running import PlanningOptions, plan_file
from kabo.tasks.learned import Risk
from tests.support.bars import write_model
from tests.tasks.files.conftest import write

TASK = """name: hold
properties: {which: {type: name, default: steel}}
stages:
  - {name: start, stage: CurrentState}
  - name: where
    stage: LearnedParameters
    model: model.jsonl
    where: {bar: <PARENT:which>}
    target: {torque: 0.0}
  - name: move
    stage: MoveRelative
    robot: arm
    direction: {joints: {x: <INTERFACE:along>}}
    cost: {risk: {model: model.jsonl, where: {bar: steel}, parameters: {force: 15}}}
"""


@pytest.fixture(autouse=True)
def model(tmp_path: Path) -> Path:
    """A model beside the task file."""
    return write_model(tmp_path, trials=30)


def told(folder: Path, text: str) -> list[tuple[str, int, int, str, str | None]]:
    """What loading a task file says: file, line, column, message, hint; the command line says the same."""
    path = write(folder, text)
    with pytest.raises(InputError) as error:
        load_task_file(path)
    assert set(error.value.diagnostics) <= set(check_files([path]))
    return [(Path(d.file).name, d.line, d.column, d.message, d.hint) for d in error.value.diagnostics]


@pytest.mark.parametrize(
    ("old", "new", "line", "message", "hint"),
    [
        ("model: model.jsonl\n", "model: modle.jsonl\n", 7, '"modle.jsonl": there is no such file', 'did you mean "model.jsonl"?'),
        ("model: model.jsonl\n", "model: .\n", 7, '".": this is a folder, not a file', None),
        ("model: model.jsonl\n", "model: <PARENT:which>\n", 7, '"model" of "where" must be the path of a file', "a reference will not do"),
        ("model: model.jsonl\n", "model: [a]\n", 7, '"model" of "where" must be the path of a file', None),
        ("    model: model.jsonl\n", "", 5, '"where" needs the property "model"', None),
        ("<PARENT:which>", "stele", 8, 'the model model.jsonl has no bar "stele"', 'did you mean "steel"?'),
        ("{bar: <PARENT:which>}", "{br: steel}", 8, 'the model model.jsonl has no case variable "br"', 'did you mean "bar"?'),
        ("{torque: 0.0}", "{torqe: 0.0}", 9, 'the model model.jsonl has no outcome "torqe"', 'did you mean "torque"?'),
        ("target: {torque: 0.0}", "least: loudness", 9, 'the model model.jsonl has no outcome "loudness"', "it has torque"),
        ("{torque: 0.0}", "{torque: nan}", 9, 'the target of "torque" must be a finite number', None),
        ("{torque: 0.0}", "{torque: 1e999}", 9, 'the target of "torque" must be a finite number', None),
        ("{torque: 0.0}", "{torque: 1e200}", 9, 'the target of "torque" must be a finite number', None),
        ("{torque: 0.0}", "{torque: level}", 9, 'the target of "torque" must be a finite number', None),
        ("{torque: 0.0}", "{}", 9, "the target names no outcome", "target: {outcome: value}"),
        ("    target: {torque: 0.0}\n", "", 5, "no outcome is wanted", "target: {outcome: value}"),
        ("{torque: 0.0}", "{torque: 0.0}\n    least: torque", 10, "target and least are given: one of them is wanted", None),
        ("{torque: 0.0}", "{torque: 0.0}\n    alpha: 1", 10, '"alpha" of "where" is a probability above 0 and below 1, not 1', None),
        ("{torque: 0.0}", "{torque: 0.0}\n    alpha: 0", 10, '"alpha" of "where" is a probability above 0 and below 1, not 0', None),
        ("{torque: 0.0}", "{torque: 0.0}\n    count: 0", 10, '"count" of "where" is at least 1, not 0', None),
        ("{torque: 0.0}", "{torque: 0.0}\n    count: 1.5", 10, '"count" of "where" must be a whole number', None),
        ("{torque: 0.0}", "{torque: 0.0}\n    tolerance: -1", 10, 'a tolerance is a number from 0 on, this is "-1"', None),
        ("{torque: 0.0}", "{torque: 0.0}\n    tolerance: {torqe: 1}", 10, 'the target does not name "torqe"', None),
        ("target: {torque: 0.0}", "most: torque\n    tolerance: 1", 10, "there is no target that the tolerance could be about", None),
        ("<INTERFACE:along>", "<INTERFACE:alog>", 13, '"direction" of "move" reads the interface property "alog", which no stage writes', 'did you mean "along"?'),
        ("{risk: {model: model.jsonl, ", "{risk: {", 14, "`cost` of \"move\": the cost term risk: missing a required argument: 'model'", None),
        ("{risk: {model: model.jsonl", "{risk: {model: mode.jsonl", 14, '"mode.jsonl": there is no such file', 'did you mean "model.jsonl"?'),
        ("{bar: steel}, par", "{bar: stele}, par", 14, '`cost` of "move": the model model.jsonl has no bar "stele"', 'did you mean "steel"?'),
        ("where: {bar: steel}, par", "par", 14, '`cost` of "move": the case must say bar: steel or wood', None),
        ("{force: 15}", "{force: 150}", 14, '`cost` of "move": force is 150, outside its bounds 1 to 40', None),
        ("{force: 15}", "{forc: 15}", 14, '`cost` of "move": the model model.jsonl has no parameter "forc"', 'did you mean "force"?'),
        ("{force: 15}", "{force: hard}", 14, '`cost` of "move": force must be a finite number, this is "hard"', None),
        ("{force: 15}", "3", 14, '`cost` of "move": the cost term risk: it has a model', None),
        ("{force: 15}}", "{force: 15}, alpha: 2}", 14, '`cost` of "move": alpha is a probability', None),
        ("{force: 15}", "{force: <INTERFACE:forc>}", 14, '"cost" of "move" reads the interface property "forc"', 'did you mean "force"?'),
    ],
)  # fmt: skip
def test_a_fault_is_told_at_its_place(
    tmp_path: Path, old: str, new: str, line: int, message: str, hint: str | None
) -> None:
    assert TASK.count(old) == 1
    found = told(tmp_path, TASK.replace(old, new))
    fitting = [each for each in found if message in each[3]]
    assert fitting, found
    assert fitting[0][:2] == ("task.yaml", line)
    assert hint is None or hint in (fitting[0][4] or "")


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        ('{"format": "kabo-plan/1"}\n', 1, "this is no model of an exploration"),
        ("name: hold\n", 1, "this is no JSON"),
        ("", 1, "it has no header"),
        ("DAMAGED", 3, "JSON"),
    ],
)
def test_a_foreign_or_damaged_model_is_told_at_its_own_place(
    tmp_path: Path, model: Path, content: str, line: int, message: str
) -> None:
    lines = model.read_text().splitlines(keepends=True)
    model.write_text("".join([*lines[:2], "{torn\n", *lines[2:]]) if content == "DAMAGED" else content)
    found = told(tmp_path, TASK)
    assert found[0][:2] == ("model.jsonl", line) and message in found[0][3]
    assert "named in task.yaml:" in (found[0][4] or "")


def test_parameters_that_no_stage_reads_and_cases_left_open_are_fine(tmp_path: Path) -> None:
    text = TASK.replace("    where: {bar: <PARENT:which>}\n", "").replace("<INTERFACE:along>", "0.1")
    path = write(tmp_path, text.replace("properties: {which: {type: name, default: steel}}\n", ""))
    assert not load_task_file(path).warnings and not check_files([path])


def test_a_term_without_parameters_reads_what_the_stage_writes(tmp_path: Path) -> None:
    bare = TASK.replace(", parameters: {force: 15}", "")
    term = load_task_file(write(tmp_path, bare)).recipe.children[2].cost
    assert term is not None and isinstance(term.term, Risk) and term.term.implied == ("along", "force")
    start, end = bare.index("  - name: where"), bare.index("  - name: move")
    without = bare[:start] + bare[end:].replace("<INTERFACE:along>", "0.1")
    found = told(tmp_path, without)
    assert [each[3] for each in found] == [
        f'`cost` of "move" reads the interface property "{name}", which no stage writes'
        for name in ("along", "force")
    ]


def test_a_value_that_a_caller_gives_and_that_is_no_target_is_told_at_the_stage(tmp_path: Path) -> None:
    text = HOLD.replace("name: hold\n", "name: hold\nproperties: {wanted: {type: any}}\n")
    file = load_task_file(write(tmp_path, text.replace("{torque: 0.0}", "{torque: <PARENT:wanted>}")))
    with pytest.raises(InputError) as error:
        plan_file(file, {"wanted": "much"}, None, PlanningOptions())
    (one,) = error.value.diagnostics
    assert one.line == 5 and "torque must be a finite number" in one.message


def test_what_stages_of_others_write_is_not_known(tmp_path: Path) -> None:
    text = TASK.replace("  - {name: start, stage: CurrentState}", "  - {name: start, stage: line/Start}")
    assert load_task_file(write(tmp_path, text.replace("<INTERFACE:along>", "<INTERFACE:other>")))


def test_a_task_is_written_with_paths_from_where_it_is_written(tmp_path: Path) -> None:
    task = load_task(write(tmp_path, TASK))
    assert task_to_yaml(task).count("model: model.jsonl") == 2
    (tmp_path / "deep").mkdir()
    dump_task(task, tmp_path / "deep" / "task.yaml")
    text = (tmp_path / "deep" / "task.yaml").read_text()
    assert text.count("model: ../model.jsonl") == 2
    again = load_task(tmp_path / "deep" / "task.yaml")
    assert task_to_yaml(again) == text


# ---------------------------------------------------------------------------------------------------- reports
HOLD = """name: hold
stages:
  - {name: start, stage: line/Points, points: [0.0]}
  - name: where
    stage: LearnedParameters
    model: model.jsonl
    where: {bar: steel}
    target: {torque: 0.0}
    count: 2
  - name: again
    stage: line/Below
    limit: 1.0
    wrapped: {name: step, stage: line/Step, by: <INTERFACE:along>, cost: {risk: {model: model.jsonl, where: {bar: steel}}}}
"""


def reported(folder: Path, text: str = HOLD) -> Report:
    """The report of planning a task of a file."""
    return report(plan_file(load_task_file(write(folder, text)), {}, None, PlanningOptions()), file="task.yaml")


def test_parts_of_a_report_say_what_was_learned(tmp_path: Path) -> None:
    made = reported(tmp_path)
    assert read_report(report_bytes(made), "r.json") == made
    jsonschema.validate(json.loads(report_bytes(made)), schema_of("kabo-task-2"))
    parts = made["runs"][0]["solutions"][0]["parts"]
    assert [part["stage"] for part in parts if "learned" in part] == ["where", "again"]
    learned = parts[1]["learned"]
    assert isinstance(learned, dict)
    assert (learned["model"], learned["case"]) == ("model.jsonl", {"bar": "steel"})
    assert 0.95 < learned["validity"] <= 1.0 and set(learned["expected"]) == {"torque"}
    assert parts[2]["learned"] == learned
    assert made["runs"][0]["stages"]["again"]["solutions"][0].get("learned") is None
    assert "along 0.0" in describe_report(made)
    assert b'"learned"' not in report_bytes(reported(tmp_path, HOLD[: HOLD.index("  - name: where")]))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("validity", 0.0, "has a validity that is no probability above 0"),
        ("validity", 1.5, "has a validity that is no probability above 0"),
        ("validity", "high", "Expected `float`, got `str`"),
        ("model", 3, "Expected `str`, got `int`"),
        ("parameters", {"along": None}, "Expected `float`, got `null`"),
    ],
)
def test_a_report_with_impossible_records_is_refused(
    tmp_path: Path, key: str, value: object, message: str
) -> None:
    made = json.loads(report_bytes(reported(tmp_path)))
    made["runs"][0]["solutions"][0]["parts"][1]["learned"][key] = value
    with pytest.raises(InputError) as error:
        read_report(json.dumps(made).encode(), "r.json")
    assert message in str(error.value)


def test_a_report_of_failures_says_why(tmp_path: Path) -> None:
    text = describe_report(reported(tmp_path, HOLD.replace("0.0}", "5.0}")))
    assert "1 × no valid parameters give the wanted outcome" in text and "the nearest is torque 0." in text
