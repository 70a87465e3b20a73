"""Task files as stages of other tasks: properties, references, directions, monitors, and files that include themselves."""

from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import ProcedureSignatures
from kabo.tasks.core import Flow, InitialisationError, Monitor, Task, directions
from kabo.tasks.files import load_task, load_task_file, task_to_yaml
from kabo.tasks.robots import NoOp

BOTH = """\
name: both
properties:
  robot: {type: robot}
  object: {type: body, default: can}
stages:
  - {name: start, stage: CurrentState}
  - {name: take, stage: pick, object: <PARENT>, grasp: side}
  - {name: put, stage: place, object: <PARENT>, region: bin}
"""
OWN = """\
name: own
properties:
  height: {type: number, default: 0.1}
  robot: {type: robot}
stages:
  - {name: open, stage: MoveTo, goal: open}
  - {name: poses, stage: MonitoredPoses, monitors: /open, poses: [{position: [0, 0, <PARENT:height>]}]}
"""


def write(folder: Path, text: str, name: str = "task.yaml") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def errors(folder: Path, text: str) -> str:
    with pytest.raises(InputError) as refused:
        load_task_file(write(folder, text))
    return str(refused.value)


def both(folder: Path) -> Task:
    return load_task(write(folder, BOTH), {"robot": "arm"})


def test_a_task_of_the_library_is_a_stage_with_its_own_stages_inside(tmp_path: Path) -> None:
    task = both(tmp_path)
    taken = task.find("take")
    assert taken is not None and [child.name for child in taken.children] == ["start", "open", "reach", "grasp"]
    flows, wrong = directions(task)
    assert wrong == [] and flows[taken] is Flow.FORWARD


def test_a_fault_inside_is_told_at_the_stage_of_the_file_and_where_it_is(tmp_path: Path) -> None:
    file = load_task_file(write(tmp_path, BOTH))
    inside = next(path for path in file.places if path.startswith("put/") and "pose" in path)
    (told,) = file.located(InitialisationError([f"{inside!r}: it is wrong"], "")).diagnostics
    assert (Path(told.file).name, told.line) == ("task.yaml", 8)
    assert told.message == f"{inside!r}: it is wrong"
    assert told.hint is not None and f"place.yaml:{file.places[inside].line}" in told.hint
    (own,) = file.located(InitialisationError(["'take': it is wrong"], "")).diagnostics
    assert (own.line, own.hint) == (7, None)


def test_it_begins_in_the_scene_before_it(tmp_path: Path) -> None:
    task = both(tmp_path)
    for path in ("take/start", "put/start/now"):
        assert isinstance(task.find(path), NoOp)


def test_a_task_that_comes_first_begins_as_it_does_alone(tmp_path: Path) -> None:
    text = BOTH.replace("  - {name: start, stage: CurrentState}\n", "")
    task = load_task(write(tmp_path, text), {"robot": "arm"})
    assert type(task.find("take/start")).__name__ == "CurrentState"
    assert directions(task)[1] == []


def test_its_properties_are_given_inherited_or_have_their_defaults(tmp_path: Path) -> None:
    task = both(tmp_path)
    taken, put = task.find("take"), task.find("put")
    assert taken is not None and put is not None
    assert taken.properties.given["grasp"] == "side"
    assert put.properties.given["placement"] == "any"
    assert "robot" not in taken.properties.given, "inherited from the task"
    opened = task.find("take/open")
    assert opened is not None and opened.properties.value("robot") == "arm"
    sampled = task.find("take/grasp/grasp pose IK/grasp pose")
    assert sampled is not None
    assert (sampled.properties.value("family"), sampled.properties.value("object")) == ("side", "can")


def test_unknown_missing_and_wrong_properties_are_told_where_they_stand(tmp_path: Path) -> None:
    text = BOTH.replace("grasp: side", "grapse: side").replace(", region: bin", "")
    text = text.replace("  robot: {type: robot}\n", "")
    told = errors(tmp_path, text)
    assert "task.yaml:6:" in told and 'the task "pick" has no property "grapse"' in told
    assert 'did you mean "grasp"?' in told
    assert '"put" needs the property "region" of the task "place"' in told
    assert '"take" needs the property "robot" of the task "pick"' in told
    wrong = errors(tmp_path, BOTH.replace("grasp: side", "grasp: [1, 2]"))
    assert '"grasp" of "take" must be' in wrong


def test_keys_that_only_stages_have_are_refused(tmp_path: Path) -> None:
    told = errors(tmp_path, BOTH.replace("grasp: side", "monitors: start"))
    assert '"take" is the task "pick" and has no `monitors`' in told


def test_an_unknown_stage_is_told_the_tasks_too(tmp_path: Path) -> None:
    assert 'did you mean "hand_over"?' in errors(tmp_path, BOTH.replace("stage: place", "stage: hand_ovr"))


def test_tasks_beside_a_file_come_before_the_library(tmp_path: Path) -> None:
    write(tmp_path, OWN.replace("name: own", "name: pick"), "pick.yaml")
    task = load_task(
        write(tmp_path, "name: t\nproperties: {robot: robot}\nstages: [{name: a, stage: pick, height: 20e-2}]\n"),
        {"robot": "arm"},
    )
    inner = task.find("a")
    assert inner is not None and [each.name for each in inner.children] == ["open", "poses"]
    assert inner.properties.given["height"] == 0.2  # noqa: PLR2004


def test_absolute_paths_begin_at_the_task_of_their_file(tmp_path: Path) -> None:
    write(tmp_path, OWN, "own.yaml")
    outer = (
        "name: t\nproperties: {robot: robot}\nstages:\n  - {name: open, stage: Wait}\n  - {name: a, stage: own}\n"
    )
    task = load_task(write(tmp_path, outer), {"robot": "arm"})
    poses = task.find("a/poses")
    assert isinstance(poses, Monitor) and poses.monitored is task.find("a/open")
    own = load_task(tmp_path / "own.yaml", {"robot": "arm"})
    alone = own.find("poses")
    assert isinstance(alone, Monitor) and alone.monitored is own.find("open")


def test_a_path_may_lead_into_an_included_task(tmp_path: Path) -> None:
    more = "  - {name: then, stage: MonitoredPoses, monitors: /take/grasp/lift, poses: [{position: [0, 0, 1]}]}\n"
    task = load_task(write(tmp_path, BOTH + more), {"robot": "arm"})
    then = task.find("then")
    assert isinstance(then, Monitor) and then.monitored is task.find("take/grasp/lift")
    assert 'there is no stage "lft" in "grasp"' in errors(tmp_path, BOTH + more.replace("/lift", "/lft"))


def test_an_included_task_does_not_look_at_the_stages_around_it(tmp_path: Path) -> None:
    write(tmp_path, OWN.replace("monitors: /open", "monitors: ../start"), "own.yaml")
    assert "leads out of the task" in errors(
        tmp_path, "name: t\nproperties: {robot: robot}\nstages:\n  - {name: a, stage: own}\n"
    )


def test_files_that_include_each_other_are_refused(tmp_path: Path) -> None:
    write(tmp_path, "name: first\nstages: [{name: a, stage: second}]\n", "first.yaml")
    write(tmp_path, "name: second\nstages: [{name: b, stage: first}]\n", "second.yaml")
    with pytest.raises(InputError, match="would contain itself: first → second → first"):
        load_task_file(tmp_path / "first.yaml")


def test_a_file_that_is_called_as_the_task_of_the_library_which_it_means_is_told_to_take_another_name(
    tmp_path: Path,
) -> None:
    own = write(
        tmp_path,
        "name: pick\nproperties: {robot: robot, object: body}\nstages: [{name: a, stage: pick}]\n",
        "pick.yaml",
    )
    with pytest.raises(InputError, match="would contain itself: pick → pick") as told:
        load_task_file(own)
    assert told.value.diagnostics[0].hint == 'it hides the task "pick" of the library: give this file another name'


def test_faults_inside_an_included_file_are_told_at_their_place(tmp_path: Path) -> None:
    write(tmp_path, OWN.replace("goal: open", "gaol: open"), "own.yaml")
    told = errors(tmp_path, "name: t\nproperties: {robot: robot}\nstages: [{name: a, stage: own}]\n")
    assert "own.yaml:6:" in told and '"open" has no property "gaol"' in told


def test_a_dumped_task_has_the_stages_written_out_and_is_the_same(tmp_path: Path) -> None:
    task = both(tmp_path)
    again = load_task(write(tmp_path, task_to_yaml(task), "dumped.yaml"))
    assert again.tree() == task.tree()


def test_included_files_beside_a_domains_tasks_are_among_the_files_of_its_plans(tmp_path: Path) -> None:
    (tmp_path / "tasks").mkdir()
    write(tmp_path / "tasks", OWN, "own.yaml")
    outer = (
        "name: outer\nproperties: {robot: robot}\nstages:\n  - {name: a, stage: own}\n  - {name: b, stage: pick}\n"
    )
    write(tmp_path / "tasks", outer, "outer.yaml")
    signatures = ProcedureSignatures(str(tmp_path))
    assert signatures["outer"] is not None
    assert {Path(path).name for path in signatures.digests} == {"outer.yaml", "own.yaml"}
