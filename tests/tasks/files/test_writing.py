"""Load–dump–load is the identity, for tasks of files and tasks built in Python; what has no form in files is told."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kabo.tasks.core import (
    INTERFACE,
    PARENT,
    Alternatives,
    Fallbacks,
    Flow,
    Interface,
    Parent,
    Serial,
    Stage,
    Task,
    TaskError,
)
from kabo.tasks.files import dump_task, load_task, load_task_file, task_to_yaml
from tests.tasks.files.conftest import TASK, Below, Near, Points, Start, Step, Way, double, write


def again(folder: Path, text: str) -> Task:
    """The task of a text, without its required arguments."""
    return load_task_file(write(folder, text, "again.yaml")).task(partly=True)


def by_hand() -> Task:
    task = Task("line", target=[3, 4], deep={"a": [1.0, "x y"], "b": -0.5})
    start = Start("start")
    task.add(start)
    task.add(Way("go", reach=50.0))
    points = Points("points, all", points=Parent("target"), label="1.0")
    task.add(
        Alternatives(
            "choose",
            Serial("one", Step("back", by=PARENT, only=Flow.BACKWARD), Below("low", points, limit=40), by=0.25),
            Near("near", start, by=2),
        )
    )
    task.add(double("twice", by=INTERFACE))
    task.add(
        Fallbacks("or", Step("note", note=[Interface("goal"), {"k": Parent("target")}, "true", "é: \t#'\"\\"]))
    )
    task.add(Step("last", mode="3", pair=(1, 2), flag=True, count=2, table={"a b": {"c": [1e-7, 1e22, True]}}))
    return task


def test_a_file_that_was_loaded_and_written_loads_to_the_same_tree(tmp_path: Path) -> None:
    file = load_task_file(write(tmp_path))
    for arguments in (None, {"target": [3], "by": 2}):
        task = file.task(arguments, partly=True)
        text = task_to_yaml(task, max_solutions=file.max_solutions, timeout=file.timeout)
        loaded = again(tmp_path, text)
        assert loaded.tree() == task.tree()
        assert task_to_yaml(loaded, max_solutions=3, timeout=20.0) == text
    once = load_task_file(tmp_path / "again.yaml")
    assert (once.max_solutions, once.timeout) == (3, 20.0)
    assert [(each.name, each.kind, each.required) for each in once.inputs] == [
        ("by", "number", False), ("target", "any", False), ("mode", "name", False),
    ]  # fmt: skip


def test_required_properties_stay_required(tmp_path: Path) -> None:
    task = load_task_file(write(tmp_path)).task(partly=True)
    assert "  target: {type: any}\n" in task_to_yaml(task)
    assert "  by: {type: number, default: 1.5}\n" in task_to_yaml(task)


def test_a_task_built_in_python_is_written_and_loads_to_the_same_tree(tmp_path: Path) -> None:
    task = by_hand()
    dump_task(task, tmp_path / "task.yaml")
    loaded = load_task(tmp_path / "task.yaml")
    assert loaded.tree() == task.tree()
    assert task_to_yaml(loaded) == (tmp_path / "task.yaml").read_text()
    assert "monitors: ../start" in task_to_yaml(task)


def test_the_same_task_from_a_file_and_from_python_has_the_same_tree(tmp_path: Path) -> None:
    task = Task("line", by=1.5, target=[3], mode="slow")
    pose = Points("pose", points=Parent("target"), label="place")
    task.add(Start("start"))
    task.add(Way("go", reach=50))
    note = [Interface("goal"), {"deep": Parent("by")}, "1.0", "off"]
    task.add(
        Serial(
            "grasp",
            Step("approach", by=PARENT, mode=PARENT),
            Below("low enough", pose, limit=40),
            Step("lift", by=Parent("depth"), note=note),
            depth=0.25,
        )
    )
    assert load_task(write(tmp_path, TASK), {"target": [3]}).tree() == task.tree()


def test_all_that_has_no_form_in_files_is_told_at_once() -> None:
    class Unknown(Start):
        """Not registered."""

    task = Task("t", Unknown("u"), Step("s", by=Parent("x", through=abs), note=object()), x=float("nan"))
    task.children[1].cost = lambda solution: 1.0
    with pytest.raises(TaskError) as told:
        task_to_yaml(task)
    assert str(told.value).splitlines() == [
        "the task 't' cannot be written as a file:",
        "  - 't', property 'x': nan has no form in files",
        "  - 'u': Unknown is not registered (kabo.tasks.register)",
        "  - 's': its cost term has no form in files (kabo.tasks.register_cost)",
        "  - 's', property 'by': a function of Python has no form in files",
        "  - 's', property 'note': a value of type object has no form in files",
    ]


def test_a_monitor_that_a_path_cannot_reach_is_told() -> None:
    first, second = Start("start"), Start("start")
    task = Task("t", Alternatives("a", first, second, Near("near", second)))
    with pytest.raises(TaskError, match="no path leads to the stage 'a/start' that it monitors"):
        task_to_yaml(task)


def test_a_monitored_stage_whose_name_another_one_has_too_cannot_be_written() -> None:
    """The file would not say which of them is meant."""
    first, second = Start("start"), Start("start")
    task = Task("t", Alternatives("a", first, second, Near("near", first)))
    with pytest.raises(TaskError, match="no path leads to the stage 'a/start' that it monitors"):
        task_to_yaml(task)


TEXTS = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
NUMBERS = st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**17), 10**17)
VALUES = st.recursive(
    st.booleans()
    | NUMBERS
    | TEXTS
    | st.sampled_from(["on", "-1", "1e3", "true", "~", "<A>", "- x", "90 deg", "*a"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(TEXTS.filter(bool), inner, max_size=3),
    max_leaves=8,
)
NAMES = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="/"), min_size=1, max_size=8).filter(
    lambda name: name == name.strip() and name not in (".", "..")
)


@st.composite
def stages(draw: st.DrawFn, depth: int = 3) -> Stage:
    kinds = ["step", "way", "points"] + (["serial", "below", "fallbacks"] if depth else [])
    kind = draw(st.sampled_from(kinds))
    name = draw(NAMES)
    if kind == "step":
        return Step(name, by=draw(NUMBERS), note=draw(VALUES), mode=draw(TEXTS | NUMBERS))
    if kind == "way":
        return Way(name, reach=draw(NUMBERS))
    if kind == "points":
        return Points(name, points=draw(st.lists(VALUES, max_size=3)), label=draw(TEXTS))
    if kind == "below":
        return Below(name, draw(stages(depth - 1)), limit=draw(NUMBERS))
    inner = draw(st.lists(stages(depth - 1), min_size=1, max_size=3))
    extra: dict[str, Any] = {"extra": draw(VALUES)} if draw(st.booleans()) else {}
    return (Serial if kind == "serial" else Fallbacks)(name, *inner, **extra)


@given(name=NAMES, children=st.lists(stages(), min_size=1, max_size=3), own=VALUES)
@settings(max_examples=60)
def test_whatever_values_stages_have_they_survive_writing_and_loading(
    name: str, children: list[Stage], own: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    task = Task(name, *children, own=own)
    text = task_to_yaml(task)
    loaded = again(tmp_path_factory.getbasetemp(), text)
    for before, after in zip(task.walk(), loaded.walk(), strict=True):
        assert (type(before), before.name) == (type(after), after.name)
        assert before.properties.given == after.properties.given
    assert task_to_yaml(loaded) == text
