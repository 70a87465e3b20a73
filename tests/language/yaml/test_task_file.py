"""Task files as plain data: every key and value with its place, every mistake named, aliases counted before use."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kabo.errors import Diagnostic, InputError
from kabo.language.findings import Findings
from kabo.language.source import SourceFile
from kabo.language.task_description import Entries, Items, PropertyReference, TaskDescription, Word
from kabo.language.yaml.documents import MAX_NODES, read_document
from kabo.language.yaml.task_file import load_task_description, read_task_text

APPENDIX_B = Path(__file__).with_name("appendix_b.yaml")

TASK = """\
name: pick
properties:
  robot: {type: robot}
  object: {type: body}
  grasp: {type: grasp, default: any}
  hold: {type: number, default: 90 deg}
  keep: {type: motion_constraint, default: }
  note: {type: name, default: ""}
max_solutions: 3
timeout: 2.5
speed: 0.5
stages:
  - name: start
    stage: CurrentState
  - name: lift it
    stage: Wrapper
    robot: <PARENT>
    note: "<PARENT:speed>"
    along: {frame: world, vector: [0, 0, <INTERFACE:up>]}
    wrapped:
      - name: inner
        stage: my/Grasp
        on: "off"
        monitors: ../start
"""


def read(text: str) -> tuple[TaskDescription | None, list[Diagnostic]]:
    findings = Findings()
    task = read_task_text(SourceFile(Path("t.yaml"), "t.yaml", text), findings)
    return task, findings.diagnostics


def test_a_task_is_read_with_its_inputs_in_order_and_its_stages_as_written() -> None:
    task, found = read(TASK)
    assert task is not None and not found
    assert (task.name, task.max_solutions, task.timeout) == ("pick", 3, 2.5)
    assert [(each.name, each.kind, each.required, each.default) for each in task.inputs] == [
        ("robot", "robot", True, None),
        ("object", "body", True, None),
        ("grasp", "grasp", False, "any"),
        ("hold", "number", False, pytest.approx(1.5707963)),
        ("keep", "motion_constraint", False, None),
        ("note", "name", False, ""),
    ]
    start, lift = task.root.children
    assert (start.name, start.type, start.stages, start.children) == ("start", "CurrentState", None, ())
    assert isinstance(lift.properties["robot"], PropertyReference) and lift.properties["robot"].name is None
    assert str(lift.properties["note"]) == "<PARENT:speed>"
    along = lift.properties["along"]
    assert isinstance(along, Entries) and isinstance(along.values["vector"], Items)
    assert str(along.values["vector"].values[2]) == "<INTERFACE:up>"
    (inner,) = lift.children
    assert inner is lift.wrapped and inner.monitors is not None and inner.monitors.text == "../start"
    word = inner.properties["on"]
    assert isinstance(word, Word) and (word.text, word.quoted, word.place.line, word.place.column) == (
        "off", True, 23, 13,
    )  # fmt: skip
    speed = task.root.properties["speed"]
    assert isinstance(speed, Word) and (speed.text, speed.quoted) == ("0.5", False)


def test_the_example_of_the_thesis_is_read_and_every_alias_is_an_instance_of_its_own() -> None:
    task = load_task_description(APPENDIX_B)
    assert [(each.name, each.kind) for each in task.inputs] == [
        ("target_face", "any"), ("target_cube", "any"), ("table_surface_geometry", "any"),
    ]  # fmt: skip
    once, twice = task.root.children[1].children[1:]
    first, second = twice.children
    assert once.stages == first.stages == second.stages
    assert once.stages is not None and first.stages is not None and once.stages[0] is not first.stages[0]
    assert sum(1 for _ in task.root.walk()) == 1 + 2 + 2 + 4 + 3 * 21
    assert once.stages[3].wrapped is not None and once.stages[3].wrapped.monitors is not None
    assert once.stages[3].wrapped.monitors.text == "../open gripper"


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"),
    [
        ("name: pick\n", "«»", 'a task needs the key "name"', None),
        ("stages:\n", "«stagse»:\n", 'a task needs the key "stages"', None),
        ("name: start", "name: «a/b»", '"a/b" cannot be the name of a stage', "the path of a stage joins the names with /"),
        ("    stage: CurrentState\n", "", 'the stage "start" needs the key "stage"', None),
        ("{type: robot}", "{type: «robto»}", 'the type of the property "robot" must be one of robot, body, region, grasp, placement, motion_constraint, name, number, boolean, any, not "robto"', 'did you mean "robot"?'),
        ("{type: robot}", "{type: robot, «defualt»: a}", 'unknown key "defualt" of the property "robot"', 'did you mean "default"?'),
        ("90 deg", "«soon»", 'the default of the property "hold" must be a number, this is "soon"', None),
        ("speed: 0.5", "«hold»: 0.5", '"hold" is declared in `properties` and set beside them', "declared in line 6"),
        ("speed: 0.5", "«isFast»: 0.5", '"isFast" cannot be the name of a property', 'write "is_fast"'),
        ("speed: 0.5", "«wrapped»: 0.5", 'a task has no key "wrapped"', "a task is a serial container"),
        ("    robot: <PARENT>", "    robot: «<PARNET:x>»", '"<PARNET:x>" is no reference', 'did you mean "PARENT"?'),
        ("    robot: <PARENT>", "    robot: «<PARENT:a b>»", '"<PARENT:a b>" is no reference', "references are <PARENT>"),
        ("max_solutions: 3", "max_solutions: «0»", '`max_solutions` must be a whole number from 1 on, not "0"', None),
        ("timeout: 2.5", "timeout: «-1»", "`timeout` must be greater than 0", None),
        ("    wrapped:\n      - name", "    wrapped:\n      - {name: a, stage: B}\n      - name", 'the stage "lift it" wraps one stage, not 2', "put several into a container and wrap that"),
        ("    wrapped:\n", "    stages: [{name: a, stage: B}]\n    «wrapped»:\n", 'the stage "lift it" has both `stages` and `wrapped`', "a container has `stages`"),
        ('on: "off"', "«on»:", 'the property "on" has no value', None),
        ('on: "off"', "«on»: *nothing", 'there is no anchor "nothing" before this alias', "an anchor &name"),
        ('on: "off"', "«on»: &this [*this]", 'the alias "this" stands inside its own anchor', "nothing can contain itself"),
        ('on: "off"', "a: &x 1\n        b: &x 2", 'the anchor "x" is defined twice', None),
        ('on: "off"', "<<: {a: 1}", 'the merge key "<<" is not allowed', "write the keys out"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_at_its_place_with_the_remedy(
    old: str, new: str, message: str, hint: str | None
) -> None:
    assert TASK.count(old) == 1
    text = TASK.replace(old, new)
    start = text.find("«")
    marked = start >= 0 and "«»" not in text
    text = text.replace("«", "").replace("»", "")
    _, found = read(text)
    assert [each.message for each in found] == [message]
    assert (found[0].hint or "").startswith(hint or "") and (found[0].hint is None) == (hint is None)
    if marked and "«" in new and not new.lstrip().startswith(("«on»", "«stagse»")):
        line = text.count("\n", 0, start) + 1
        assert (found[0].line, found[0].column) == (line, start - text.rfind("\n", 0, start))


def test_all_mistakes_are_told_at_once() -> None:
    text = TASK.replace("{type: body}", "{type: boddy}").replace("timeout: 2.5", "timeout: soon")
    _, found = read(text.replace("name: start", "name: .."))
    assert len(found) == 3


def test_an_alias_bomb_is_refused_before_it_is_made() -> None:
    lines = ["name: bomb", "a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
    task, found = read("\n".join(lines))
    assert task is None
    assert [each.message for each in found] == [f"the file has more than {MAX_NODES} values"]


def test_aliases_cannot_nest_deeper_than_what_is_written_out() -> None:
    lines = ["a0: &a0 [x]"] + [f"a{i}: &a{i} [[[[[[[[[*a{i - 1}]]]]]]]]]" for i in range(1, 8)]
    findings = Findings()
    source = SourceFile(Path("t.yaml"), "t.yaml", "\n".join(lines))
    assert read_document(source, findings, aliases=True) is None
    assert [each.message for each in findings.diagnostics] == ["nested deeper than 40 levels"]


def test_a_file_that_is_not_there_or_no_text_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        load_task_description(tmp_path / "none.yaml")
    path = tmp_path / "t.yaml"
    path.write_bytes(b"name: a\nstages: \xff")
    with pytest.raises(InputError, match="t.yaml:2:9: this is not UTF-8 text"):
        load_task_description(path, "t.yaml")


PIECES = st.sampled_from(
    ["", "*turn_once", "&a ", "*a", "<PARENT:", "<INTERFACE>", "- ", "  ", "\n", ": ", "[", "]", "{", "}", "'", '"']
    + ["name", "stages", "wrapped", "stage", "monitors", "properties", "!x", "\t", "#", "|", ">", "\0", "é", "<<: ", "null"]
)  # fmt: skip


@given(
    start=st.integers(0, 5500),
    length=st.integers(0, 300),
    pieces=st.lists(PIECES, max_size=4),
    cut=st.booleans(),
)
@settings(max_examples=150)
def test_whatever_is_done_to_a_task_file_it_is_read_or_told(
    start: int, length: int, pieces: list[str], cut: bool
) -> None:
    """Truncated and mutated files give a task or findings with places, never another error."""
    text = APPENDIX_B.read_text()
    changed = text[:start] + "".join(pieces) + ("" if cut else text[start + length :])
    task, found = read(changed)
    assert task is not None or found
    assert all(each.line >= 1 and each.column >= 1 for each in found)


def test_a_description_is_read_once_for_each_text_and_its_faults_are_told_each_time(tmp_path: Path) -> None:
    path, text = tmp_path / "t.yaml", "name: t\nstages: [{name: start, stage: CurrentState}]\n"
    path.write_text(text)
    first, again = load_task_description(path), load_task_description(path)
    assert first is again
    path.write_text(text.replace("name: t", "name: u"))
    assert load_task_description(path).name == "u"
    path.write_text(text.replace("stages", "stagez"))
    for _ in range(2):
        with pytest.raises(InputError, match="stages"):
            load_task_description(path)
