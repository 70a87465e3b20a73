"""`tests/` mirrors `kabo/`, as CONTRIBUTING says: a test that bears a module's name stands where the module stands."""

from pathlib import Path

import pytest

TESTS = Path(__file__).parent
KABO = TESTS.parent / "kabo"
#: Folders that are about several rooms, and what each is for: CONTRIBUTING names them.
EXTRA = {
    "acceptance",
    "benchmarks",
    "domains",
    "fuzz",
    "plan_mutants",
    "properties",
    "regressions",
    "scripts",
    "support",
    "tasks/applications",
    "viewer/browser",
}
FOLDERS = sorted({path.parent.relative_to(TESTS).as_posix() for path in TESTS.rglob("*.py")} - {"."})
FILES = sorted(TESTS.rglob("test_*.py"))


def is_extra(folder: str) -> bool:
    """Whether a folder of tests is about several rooms."""
    return any(folder == each or folder.startswith(f"{each}/") for each in EXTRA)


def places_of(name: str, room: Path) -> set[Path]:
    """The folders of a room that hold a module or a package of this name, and such packages themselves."""
    modules = {path.parent for path in room.rglob(f"{name}.py")}
    packages = {path.parent for path in room.rglob(f"{name}/__init__.py")}
    return modules | packages | {path.parent for path in packages}


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_of_tests_is_a_room_or_is_named_in_contributing(folder):
    contributing = (TESTS.parent / "CONTRIBUTING.md").read_text()
    assert f"`tests/{folder.split('/')[0]}/" in contributing if is_extra(folder) else (KABO / folder).is_dir()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(TESTS).as_posix())
def test_a_test_that_is_named_after_a_module_stands_where_the_module_stands(path):
    folder = path.parent.relative_to(TESTS)
    places = places_of(path.stem.removeprefix("test_"), KABO / (folder.parts or (".",))[0])
    assert is_extra(folder.as_posix()) or not places or KABO / folder in places, f"move it to one of {places}"


def test_helpers_of_the_top_level_are_in_support():
    assert {path.name for path in TESTS.glob("*.py") if not path.name.startswith("test_")} == {"conftest.py"}
