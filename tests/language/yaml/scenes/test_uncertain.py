"""`uncertain` of a scene: lengths by the names of robots and bodies."""

import pytest

from kabo.language import check_files, load_problem
from tests.language.conftest import SCENE, Kitchen

KEY = "allowed_contacts:\n"
WRONG = [
    ("uncertain: «5mm»", "`uncertain` is said of each body or robot by its name", "write uncertain: {name: 5mm}"),
    ("uncertain: {table: «0»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «0mm»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «-3mm»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «5 inches»}", 'the error of "table" must be a number, this is "5 inches"', None),
    ("uncertain: {table: «5000 m»}", 'the error of "table" reaches farther than 1000 m: 5000',
     "lengths are metres; move the scene to its origin"),
    ("uncertain: {table: «[1]»}", 'the error of "table" must be text, this is a list', None),
]  # fmt: skip
NOBODY = [
    ("tabel", 'no robot or body is called "tabel", so `uncertain` says nothing of it here', 'did you mean "table"?'),
    ("shelf", '"shelf" is a region, and regions are exact', "write uncertain: {name: 5mm}"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message", "hint"), WRONG, ids=[row[0] for row in WRONG])
def test_a_wrong_error_is_reported_at_its_place(
    kitchen: Kitchen, given: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", KEY, f"{given}\n{KEY}", message, hint)


@pytest.mark.parametrize(("name", "message", "hint"), NOBODY)
def test_an_error_of_nobody_is_a_warning(kitchen: Kitchen, name: str, message: str, hint: str) -> None:
    path = kitchen.write(scene=SCENE.replace(KEY, f"uncertain: {{left: 1mm, {name}: 5mm}}\n{KEY}"))
    found = [each for each in check_files([path]) if each.severity == "warning" and name in each.message]
    assert [(each.message, each.hint, each.column) for each in found] == [(message, hint, 24)]
    scene = load_problem(path).scene
    assert scene is not None and scene.uncertain == {"left": 0.001}


def test_errors_are_metres_or_have_their_unit_and_are_of_bodies_of_problems_too(kitchen: Kitchen) -> None:
    given = f"uncertain: {{table: 0.004, left: 0.5 cm, bottle_1: 5mm, tray: 1e-3}}\n{KEY}"
    scene = load_problem(kitchen.write(scene=SCENE.replace(KEY, given))).scene
    assert scene is not None
    assert scene.uncertain == pytest.approx({"table": 0.004, "left": 0.005, "bottle_1": 0.005, "tray": 0.001})
