"""The tutorial, done from an empty folder as it stands there, with each of its two robots."""

from pathlib import Path

import pytest

from kabo.language.recorded_paths import installed_folder
from tests.conftest import PROPERTY_SCALE
from tests.support.page_steps import follow, steps, unmarked

PAGE = Path(__file__).parents[2] / "docs" / "tutorial" / "two_cans.md"
FINISHED = Path(__file__).parents[2] / "examples" / "two_cans"
ROBOTS = ("panda", "tiago")
LED = ROBOTS if PROPERTY_SCALE >= 1.0 else ROBOTS[:1]  # a minute each


@pytest.mark.slow
@pytest.mark.skipif(installed_folder("example-robot-data") is None, reason="example-robot-data is not installed")
@pytest.mark.parametrize("robot", LED)
def test_the_tutorial_leads_from_an_empty_folder_to_a_verified_plan(robot: str, tmp_path: Path) -> None:
    found = steps(PAGE, variants=ROBOTS, variant=robot)
    assert [step.text.split()[1] for step in found if step.verb == "run"][-1] == "explain"
    follow(found, tmp_path)
    if robot == "panda":
        written = {file.name: file.read_text() for file in FINISHED.iterdir()}
        assert {name: (tmp_path / name).read_text() for name in written} == written


def test_of_the_tutorials_blocks_all_but_one_that_shows_what_a_file_holds_are_steps() -> None:
    assert unmarked(PAGE) == 1
