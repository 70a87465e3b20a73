"""`uncertain` of a scene: lengths by the names of robots and bodies."""

import pytest

from kabo.errors import InputError
from kabo.language import check_files, load_problem, load_scene_description
from tests.language.conftest import SCENE, Kitchen

KEY = "allowed_contacts:\n"
WRONG = [
    ("uncertain: «5mm»", "`uncertain` is said of each body or robot by its name", "write uncertain: {name: 5mm}"),
    ("uncertain: «[table]»", "`uncertain` is said of each body or robot by its name", "write uncertain: {name: 5mm}"),
    ("uncertain: {table: «0»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «0mm»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «-3mm»}", 'the error of "table" must be greater than 0', None),
    ("uncertain: {table: «5 inches»}", 'the error of "table" must be a number, this is "5 inches"', None),
    ("uncertain: {table: «5000 m»}", 'the error of "table" reaches farther than 1000 m: 5000',
     "lengths are metres; move the scene to its origin"),
    ("uncertain: {table: «[1]»}", 'the error of "table" must be a length', "write 5mm, or a number of metres"),
]  # fmt: skip


@pytest.mark.parametrize(("given", "message", "hint"), WRONG, ids=[row[0] for row in WRONG])
def test_a_wrong_error_is_reported_at_its_place(
    kitchen: Kitchen, given: str, message: str, hint: str | None
) -> None:
    kitchen.expect("scene", KEY, f"{given}\n{KEY}", message, hint)


NOBODY = 'no robot or body is called "{}"{}: `uncertain` takes names of robots and bodies'


def test_an_error_of_nobody_is_refused_where_all_bodies_are_known(kitchen: Kitchen) -> None:
    """Else nothing would be kept from the body that is meant."""
    hint = 'did you mean "table"?'
    given = f"uncertain: {{left: 1mm, «tabel»: 5mm}}\n{KEY}"
    kitchen.expect("scene", KEY, given, NOBODY.format("tabel", ""), hint)
    with pytest.raises(InputError, match="tabel"):
        load_problem(kitchen.folder / "problem.yaml")


def test_an_error_of_nobody_is_a_warning_of_a_scene_alone_to_which_problems_add_bodies(kitchen: Kitchen) -> None:
    kitchen.write(scene=SCENE.replace(KEY, f"uncertain: {{tabel: 5mm}}\n{KEY}"))
    path = kitchen.folder / "scene.yaml"
    (found,) = [each for each in check_files([path]) if "uncertain" in each.message]
    assert (found.severity, found.message) == ("warning", NOBODY.format("tabel", " in the scene alone"))
    assert found.hint == 'did you mean "table"?'
    assert load_scene_description(path, whole=False).uncertain == {}
    with pytest.raises(InputError, match="tabel"):
        load_scene_description(path)


def test_regions_are_exact(kitchen: Kitchen) -> None:
    given, text = f"uncertain: {{«shelf»: 5mm}}\n{KEY}", '"shelf" is a region, and regions are exact'
    kitchen.expect("scene", KEY, given, text, "write uncertain: {name: 5mm}")


def test_errors_are_metres_or_have_their_unit_and_are_of_bodies_of_problems_too(kitchen: Kitchen) -> None:
    given = f"uncertain: {{table: 0.004, left: 0.5 cm, bottle_1: 5mm, tray: 1e-3}}\n{KEY}"
    scene = load_problem(kitchen.write(scene=SCENE.replace(KEY, given))).scene
    assert scene is not None
    assert scene.uncertain == pytest.approx({"table": 0.004, "left": 0.005, "bottle_1": 0.005, "tray": 0.001})
