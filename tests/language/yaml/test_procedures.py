"""What a domain may call: tasks beside it, then the library's; calls are checked against their declared properties."""
# ruff: noqa: E501 (messages stand on one line, as they are printed)

import os
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import check_files, load_problem, spell
from kabo.language.task_description import ProcedureProperty
from kabo.language.yaml.procedures import ProcedureSignatures, library_names, library_signature
from tests.language.conftest import DOMAIN, SCENE, Kitchen

POUR = """\
name: pour
properties:
  robot: {type: robot}
  into: {type: body}
  tilt: {type: number, default: 1.0}
  grasp: {type: grasp, default: any}
  how: {type: name, default: fast}
  check: {type: boolean, default: false}
stages:
  - {name: start, stage: CurrentState}
"""
ACTION = "    geometry: pick(r, o, grasp = side)"


def write(kitchen: Kitchen, call: str, **tasks: str) -> Path:
    """The kitchen with task files beside its domain, and a call of one."""
    (kitchen.folder / "tasks").mkdir(exist_ok=True)
    for name, text in tasks.items():
        (kitchen.folder / "tasks" / f"{name}.yaml").write_text(text)
    assert ACTION in DOMAIN
    return kitchen.write(domain=DOMAIN.replace(ACTION, f"    geometry: {call}"), scene=SCENE)


def test_the_library_has_the_procedures_of_manipulation() -> None:
    expected = {"move", "pick", "place", "transfer", "release", "restack", "sense", "sense_weight"}
    assert expected <= set(library_names())
    assert library_signature("pick") == (
        ProcedureProperty("robot", "robot"), ProcedureProperty("object", "body"), ProcedureProperty("grasp", "grasp", required=False),
    )  # fmt: skip


def test_a_task_beside_the_domain_is_a_procedure_and_belongs_to_the_problems_files(kitchen: Kitchen) -> None:
    problem = load_problem(
        write(kitchen, "pour(r, o, tilt = 2, grasp = side, how = slowly, check = true)", pour=POUR)
    )
    assert "tasks/pour.yaml" in problem.files
    assert problem.files["tasks/pour.yaml"].startswith("sha256:")
    call = problem.domain.actions["pick_up"].geometry
    assert call is not None and spell(call) == "pour(r, o, tilt = 2, grasp = side, how = slowly, check = true)"


def test_a_task_beside_the_domain_comes_before_the_librarys(kitchen: Kitchen) -> None:
    own = POUR.replace("name: pour", "name: pick")
    assert check_files([write(kitchen, "pick(r, o, tilt = 2)", pick=own)]) == []
    procedures = ProcedureSignatures(str(kitchen.folder))
    assert [each.name for each in procedures["pick"] or ()] == ["robot", "into", "tilt", "grasp", "how", "check"]
    assert set(procedures) == set(library_names())


def test_task_files_that_nobody_calls_are_not_opened(kitchen: Kitchen) -> None:
    problem = load_problem(write(kitchen, "pick(r, o, grasp = side)", pour="broken: ["))
    assert not any(name.startswith("tasks/") for name in problem.files)


@pytest.mark.parametrize(
    ("call", "message", "hint"),
    [
        ("pout(r, o)", 'unknown procedure "pout" in `geometry` of action "pick_up"', 'did you mean "pour"?'),
        ("pour(r)", 'pour lacks "into"', "it is pour(robot, into, tilt = …, grasp = …, how = …, check = …)"),
        ("pour(r, o, tillt = 1)", 'pour has no property "tillt"', 'did you mean "tilt"?'),
        ("pour(r, o, tilt = side)", 'the property "tilt" takes a number, not a name', None),
        ("pour(r, o, 1, 2)", 'the property "grasp" takes a name, not a number', None),
        ("pour(r, o, check = 1)", 'the property "check" takes true or false, not a number', None),
        ("pour(r, o, check = yes)", 'the property "check" takes true or false, not a name', None),
        ("pour(r, o, how = true)", 'the property "how" takes a name, not true or false', None),
        ("pour(r, o, grasp = sied)", 'the scene has no grasp family "sied"', 'did you mean "side"?'),
        ("pour(r, trey)", '"trey" is no body of the scene; pour(r, trey) at domain.yaml:23:15 needs a body', 'did you mean "tray"?'),
    ],
)  # fmt: skip
def test_a_call_is_checked_against_the_declared_properties(
    kitchen: Kitchen, call: str, message: str, hint: str | None
) -> None:
    found = check_files([write(kitchen, call, pour=POUR)])
    assert [each.message for each in found] == [message]
    assert found[0].hint == hint


def test_a_broken_task_file_is_told_once_at_its_own_place(kitchen: Kitchen) -> None:
    broken = POUR.replace("type: number", "type: nubmer").replace("stage: CurrentState", "stagee: CurrentState")
    found = check_files([write(kitchen, "pour(r, o)", pour=broken)])
    assert [os.path.basename(each.file) for each in found] == ["pour.yaml", "pour.yaml"]
    assert [each.line for each in found] == [5, 10]


def test_the_name_of_the_file_is_the_name_of_the_task(kitchen: Kitchen) -> None:
    (found,) = check_files([write(kitchen, "pour(r, o)", pour=POUR.replace("name: pour", "name: spill"))])
    assert found.message == 'the file pour.yaml holds the task "pour", not "spill"'


def test_a_task_file_outside_of_the_folder_that_may_be_read_is_not_opened(
    kitchen: Kitchen, tmp_path: Path
) -> None:
    outside = tmp_path.parent / f"{tmp_path.name}_outside.yaml"
    outside.write_text(POUR)
    problem = write(kitchen, "pour(r, o)")
    (kitchen.folder / "tasks" / "pour.yaml").symlink_to(outside)
    with pytest.raises(InputError, match="lies outside of the folder"):
        load_problem(problem, within=kitchen.folder)
    outside.unlink()


def test_an_external_procedure_cannot_take_the_name_of_a_task(kitchen: Kitchen) -> None:
    declared = "procedures:\n  pour: {}\nactions:"
    path = write(kitchen, "pick(r, o)", pour=POUR)
    domain = kitchen.folder / "domain.yaml"
    domain.write_text(domain.read_text().replace("actions:", declared))
    assert [each.message for each in check_files([path])] == ['"pour" is the name of a procedure of geometry']


def test_a_task_file_is_checked_by_itself_and_may_have_anchors(tmp_path: Path) -> None:
    path = tmp_path / "t.yaml"
    path.write_text("name: t\nstages:\n  - &a {name: x, stage: CurrentState}\n  - *a\n")
    assert check_files([path]) == []
    path.write_text("name: t\nstages:\n  - {name: x, stages: []}\n")
    assert len(check_files([path])) == 2
