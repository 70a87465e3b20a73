"""Task files become tasks: values of the declared types, arguments bound, every mistake told at its place."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import math
from pathlib import Path
from typing import Any

import pytest

from kabo.errors import InputError
from kabo.tasks.core import Flow, InitialisationError, Propagator, Property, Serial, Task
from kabo.tasks.files import load_task, load_task_file, register
from kabo.tasks.files.building import argument_of
from tests.tasks.files.conftest import TASK, Below, Near, Step, Way, write

APPENDIX_B = Path(__file__).parents[2] / "language" / "yaml" / "appendix_b.yaml"


def test_a_task_is_made_of_its_stages_with_the_arguments_bound(tmp_path: Path) -> None:
    task = load_task(write(tmp_path), {"target": [3, -1, 60], "by": 2}, seed=7)
    assert (task.name, task.seed) == ("line", 7)
    assert [type(stage).__name__ for stage in task.walk()] == [
        "Task", "Start", "Way", "Serial", "Step", "Below", "Points", "Step",
    ]  # fmt: skip
    (solution,) = task.plan(0.0)
    assert [part.end.scene for part in solution.leaves if part.end is not None] == [0.0, 1, 3, 3, 3.25]
    below = task.find("grasp/low enough")
    assert below is not None and [failure.comment for failure in task.found(below)[1]] == ["60 is above 40"]


def test_the_file_says_how_much_is_wanted(tmp_path: Path) -> None:
    file = load_task_file(write(tmp_path))
    assert (file.name, file.max_solutions, file.timeout) == ("line", 3, 20.0)
    assert [each.name for each in file.inputs] == ["by", "target", "mode"]


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("by: 3", 3), ("by: 1e-3", 0.001), ("by: 90 deg", math.pi / 2), ('by: "2"', 2), ("by: -.5", -0.5),
        ("flag: true", True), ("mode: 3", 3), ('mode: "3"', "3"), ("mode: on", "on"), ("mode: true", "true"),
        ("note: true", True), ('note: "true"', "true"), ("note: no", "no"), ("note: 010", 10), ("note: 1:30", "1:30"),
        ("note: [1, a, [b]]", [1, "a", ["b"]]), ("note: {a: {b: 0.5}}", {"a": {"b": 0.5}}),
        ("pair: [1, 2.5]", (1, 2.5)), ("table: {a: 1}", {"a": 1}), ("count: 4", 4),
    ],
)  # fmt: skip
def test_the_declared_type_decides_what_a_text_means(tmp_path: Path, line: str, value: Any) -> None:
    text = f"name: t\nstages:\n  - name: s\n    stage: line/Step\n    {line}\n"
    task = load_task(write(tmp_path, text))
    step = task.find("s")
    assert step is not None
    found = step.properties.value(line.split(":", maxsplit=1)[0])
    assert found == value and type(found) is type(value)


def test_every_alias_is_a_stage_of_its_own(tmp_path: Path) -> None:
    text = (
        "name: t\nstages:\n  - {name: s, stage: line/Start}\n"
        "  - &step {name: a, stage: line/Step, table: &table {x: 1}}\n  - *step\n  - {name: b, stage: line/Step, table: *table}\n"
    )
    task = load_task(write(tmp_path, text))
    first, second = task.children[1], task.children[2]
    assert first is not second and first.name == second.name == "a"
    assert first.properties is not second.properties
    assert first.properties.value("table") is not second.properties.value("table")
    assert task.plan(0.0)[0].end.scene == 3.0  # type: ignore[union-attr]


SPOILED = [
    ("line/Way", "«line/Wya»", 'unknown stage "line/Wya"', 'did you mean "line/Way"?'),
    ("reach: 50", "«raech»: 50", '"go" has no property "raech"', 'did you mean "reach"?'),
    ("reach: 50", "«monitor»: a", '"go" has no property "monitor"', 'did you mean "monitors"?'),
    ("reach: 50", "reach: «far»", '"reach" of "go" must be a number, this is "far"', None),
    ("reach: 50", "reach: «[1]»", '"reach" of "go" must be a number', None),
    ("        limit: 40\n", "", '"low enough" needs the property "limit"', "line/Below has limit"),
    ("reach: 50", "monitors: «../start»", '"go" is a line/Way, which monitors no other stage', None),
    ("    depth: 0.25\n", "    depth: 0.25\n    «stagess»: 2\n", 'no stage inside "grasp" refers to its "stagess"', 'did you mean "stages"?'),
    ("<PARENT:depth>", "«<PARENT:dept>»", '<PARENT:dept> of "grasp/lift" (by) refers to nothing: no ancestor has "dept"', 'searched "grasp", "line"; did you mean "depth"?'),
    ("{deep: <PARENT:by>}", "{deep: «<PARENT>»}", '<PARENT> of "grasp/lift" (note) refers to nothing: no ancestor has "deep"', 'searched "grasp", "line"; did you mean "depth"?'),
    ("        wrapped:\n          name: pose", "        stages: []\n        wrapped:\n          name: pose", 'the stage "low enough" has both `stages` and `wrapped`', None),
    ("reach: 50", "wrapped: {name: x, stage: line/Start}", '"go" is a line/Way and has no `wrapped`', "it has no stages inside"),
    ("stage: line/Way\n    reach: 50", "stage: Fallbacks", '"go" is a Fallbacks and needs the key "stages"', None),
    ("stage: line/Way\n    reach: 50", "stage: Alternatives", '"go" is an Alternatives and needs the key "stages"', None),
    ("stage: line/Way\n    reach: 50", "stage: line/Near", '"go" needs the key "monitors"', "the path of the stage whose successes trigger it, such as ../open"),
    ("stage: line/Way\n    reach: 50", "stage: line/Near\n    monitors: «strat»", 'there is no stage "strat" in "line"', 'did you mean "start"?'),
    ("stage: line/Way\n    reach: 50", "stage: line/Near\n    monitors: «../start»", '"../start" leads out of the task', 'the path begins in "line", which holds "go"'),
    ("stage: line/Way\n    reach: 50", "stage: line/Near\n    monitors: «go»", '"go" cannot monitor itself', None),
    ("by: <PARENT:depth>", "only: «up»\n        by: <PARENT:depth>", '`only` of "lift" must be forward or backward', None),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message", "hint"), SPOILED)
def test_a_mistake_is_told_at_its_place_with_the_remedy(
    tmp_path: Path, old: str, new: str, message: str, hint: str | None
) -> None:
    assert TASK.count(old) == 1
    text = TASK.replace(old, new)
    start = text.find("«")
    text = text.replace("«", "").replace("»", "")
    path = write(tmp_path, text)
    if "refers to its" in message:
        found = load_task_file(path).warnings
    else:
        with pytest.raises(InputError) as told:
            load_task_file(path)
        found = told.value.diagnostics
    assert message in [each.message for each in found]
    one = next(each for each in found if each.message == message)
    assert hint is None or one.hint == hint
    if start >= 0:
        assert (one.line, one.column) == (text.count("\n", 0, start) + 1, start - text.rfind("\n", 0, start))


AMBIGUOUS = """name: t
stages:
  - {name: start, stage: line/Start}
  - {name: start, stage: line/Step}
  - {name: go, stage: line/Way, reach: 9}
"""
BESIDE = "  - {name: near, stage: line/Near, monitors: PATH}\n"
INSIDE = "  - {name: low, stage: line/Below, limit: 9, wrapped: {name: near, stage: line/Near, monitors: PATH}}\n"


@pytest.mark.parametrize(("stage", "path"), [(BESIDE, "/start"), (BESIDE, "start"), (INSIDE, "../start")])
def test_a_path_that_fits_two_stages_is_refused_with_the_lines_of_both(
    tmp_path: Path, stage: str, path: str
) -> None:
    with pytest.raises(InputError) as told:
        load_task_file(write(tmp_path, AMBIGUOUS + stage.replace("PATH", path)))
    (one,) = told.value.diagnostics
    assert one.message == '"t" has 2 stages "start", and the path does not say which'
    assert one.hint == "give them names that differ: they are in the lines 3 and 4"
    assert (one.line, one.column) == (6, stage.index("PATH") + 1)


@pytest.mark.parametrize(
    ("stage", "words"),
    [
        ("{name: go, stage: Connect, robot: r, planner: [straight, «rrt_conect»]}", "not 'rrt_conect': did you mean"),
        ("{name: go, stage: Connect, robot: r, planner: «rrt_conect»}", "not 'rrt_conect': did you mean"),
        ("{name: a, stage: AllowContact, pairs: [[a, b], «[c]», [d]]}", "is a list of pairs of names, not of ['c']"),
        ("{name: a, stage: RemoveGeometry, bodies: [a, «[b]»]}", "is a list of names, not ['b']"),
        ("{name: f, stage: PredicateFilter, attached: «[a, b, c]», wrapped: {name: s, stage: CurrentState}}", "a list of 2 names"),
    ],
)  # fmt: skip
def test_of_a_list_the_element_that_is_wrong_is_marked(tmp_path: Path, stage: str, words: str) -> None:
    text = f"name: t\nstages:\n  - {stage}\n"
    start, end = text.index("«"), text.index("»") - 1
    with pytest.raises(InputError) as told:
        load_task_file(write(tmp_path, text.replace("«", "").replace("»", "")))
    (one,) = [each for each in told.value.diagnostics if words in each.message]
    line_start = text.rfind("\n", 0, start) + 1
    assert one.column == start - line_start + 1
    assert one.length == end - start


def test_the_six_references_that_the_thesis_left_unresolved_are_told_in_one_error() -> None:
    with pytest.raises(InputError) as told:
        load_task_file(APPENDIX_B)
    found = [each for each in told.value.diagnostics if "refers to nothing" in each.message]
    assert [(each.message.split(" of ")[0], each.message.split('"')[1]) for each in found] == [
        ("<PARENT:grasp_face_to_turn>", "fallbacks/turn twice/turn first time/grasp pose IK/grasp pose"),
        ("<PARENT:grasp_cube_to_turn>", "fallbacks/turn once/grasp pose IK/grasp pose"),
        ("<PARENT:grasp_cube_to_turn>", "fallbacks/turn twice/turn second time/grasp pose IK/grasp pose"),
        ("<PARENT:place_face>", "fallbacks/turn twice/turn first time/place pose IK/cube place pose"),
        ("<PARENT:place_cube>", "fallbacks/turn once/place pose IK/cube place pose"),
        ("<PARENT:place_cube>", "fallbacks/turn twice/turn second time/place pose IK/cube place pose"),
    ]
    assert (found[0].hint or "").startswith(
        'searched "grasp pose IK", "turn first time", "turn twice", "fallbacks", "pr2_turn_cube"'
    )


@pytest.mark.parametrize(
    ("arguments", "messages"),
    [
        ({}, ['the property "target" must be given']),
        ({"target": [1], "bye": 1}, ['the task "line" has no property "bye"']),
        ({"target": [1], "by": "fast"}, ["\"by\" must be a number, not 'fast'"]),
        ({"by": True, "mode": 3}, ['"by" must be a number, not True', 'the property "target" must be given', '"mode" must be a text, not 3']),
    ],
)  # fmt: skip
def test_arguments_are_checked_all_at_once(tmp_path: Path, arguments: dict[str, Any], messages: list[str]) -> None:
    file = load_task_file(write(tmp_path))
    with pytest.raises(InputError) as told:
        file.task(arguments)
    assert [each.message for each in told.value.diagnostics] == messages
    assert all(each.source for each in told.value.diagnostics)


def test_what_does_not_fit_together_is_told_where_it_stands(tmp_path: Path) -> None:
    file = load_task_file(write(tmp_path, TASK.replace("line/Start", "line/Step")))
    task = file.task({"target": [1]})
    with pytest.raises(InitialisationError) as told:
        task.initialise()
    (one,) = file.located(told.value).diagnostics
    assert (one.line, one.column) == (9, 11) and "'start'" in one.message


def test_the_text_of_a_person_becomes_the_declared_kind(tmp_path: Path) -> None:
    by, target, mode = load_task_file(write(tmp_path)).inputs
    assert argument_of(by, "3 deg") == pytest.approx(math.radians(3))
    assert (argument_of(target, "4"), argument_of(target, "x"), argument_of(mode, "4")) == (4, "x", "4")
    with pytest.raises(Exception, match="number"):
        argument_of(by, "fast")


def test_a_stage_can_be_restricted_to_one_direction(tmp_path: Path) -> None:
    text = TASK.replace("        by: <PARENT>\n", "        by: <PARENT>\n        only: backward\n")
    approach = load_task(write(tmp_path, text), {"target": [1]}).find("grasp/approach")
    assert isinstance(approach, Propagator) and approach.only is Flow.BACKWARD


def test_a_name_of_a_stage_is_given_once(tmp_path: Path) -> None:
    class Other(Step):
        """Another stage of the same name."""

    with pytest.raises(ValueError, match="the name 'line/Step' of a stage is taken by"):
        register(Other, "line/Step")
    assert register(Step, "line/Step") is Step
    text = "name: t\nstages:\n  - {name: s, stage: Other}\n"
    with pytest.raises(InputError, match='unknown stage "Other"'):
        load_task(write(tmp_path, text))
    register(Other)
    assert isinstance(load_task(write(tmp_path, text)).children[0], Other)


def test_the_place_of_a_stage_is_known_by_its_path(tmp_path: Path) -> None:
    places = load_task_file(write(tmp_path)).places
    assert places["grasp/low enough/pose"].line == 26
    assert places["line"].line == 1
    assert Near.PROPERTIES and Below.PROPERTIES and Way.PROPERTIES and Property and Serial and Task


@pytest.mark.parametrize("cut", range(0, len(TASK), 37))
def test_a_cut_file_is_told_or_read_never_worse(tmp_path: Path, cut: int) -> None:
    path = write(tmp_path, TASK[:cut])
    try:
        load_task_file(path)
    except InputError as error:
        assert all(each.line >= 1 and each.file == str(path) for each in error.diagnostics)


def test_a_reference_of_the_task_itself_is_told_as_such(tmp_path: Path) -> None:
    text = "name: t\nby: <PARENT:giver>\nstages:\n  - {name: start, stage: CurrentState}\n"
    with pytest.raises(InputError) as told:
        load_task_file(write(tmp_path, text))
    assert "<PARENT:giver> of the task itself (by) refers to nothing: a task has no ancestor" in str(told.value)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("brng.yaml", 'there is no such file\n      = did you mean "bring.yaml"?'),
        ("pikc", 'there is no such file, nor such a task of the library\n      = did you mean "pick"?'),
    ],
)
def test_a_task_that_is_not_there_is_told_with_the_nearest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bring.yaml").write_text("name: bring\nstages: []\n")
    with pytest.raises(InputError) as refused:
        load_task_file(name)
    assert told in str(refused.value)
