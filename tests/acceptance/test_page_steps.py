"""What pages tell a reader to do works: their commands, files and programs are run, or say why not."""

from pathlib import Path

import pytest

from tests.support.page_steps import REPOSITORY, follow, steps, unmarked

DOCS = REPOSITORY / "docs"
TESTS = Path(__file__).parent
#: Pages that need more than steps in an empty folder, and the test that does what they say.
OWN = {
    "how-to/deploy.md": "test_deploy_page.py",
    "how-to/execute.md": "test_execute_page.py",
    "how-to/explain.md": "test_explain_page.py",
    "how-to/exploration.md": "test_exploration_page.py",
    "reference/tasks.md": "test_tasks_page.py",
    "tutorial/two_cans.md": "test_tutorial.py",
}
#: Pages whose steps take more than ten seconds.
SLOW = {
    "explanation/architecture.md",
    "explanation/sampling.md",
    "how-to/choose_epsilon.md",
    "how-to/from_moveit.md",
    "how-to/speed.md",
    "how-to/write_a_task.md",
}
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
FOLLOWED = [page for page in PAGES if page not in OWN and {each.verb for each in steps(DOCS / page)} - {"not"}]


@pytest.mark.parametrize("page", [page for page in PAGES if page not in OWN])
def test_every_block_of_commands_files_or_code_is_a_step(page):
    assert unmarked(DOCS / page) == 0, "tests/support/page_steps.py says how a block is marked"


def test_pages_with_a_test_of_their_own_exist_and_the_test_names_them():
    for page, test in OWN.items():
        assert page in PAGES
        assert Path(page).name in (TESTS / test).read_text()


@pytest.mark.parametrize(
    "page", [pytest.param(page, marks=pytest.mark.slow) if page in SLOW else page for page in FOLLOWED]
)
def test_the_steps_of_a_page_work(page, tmp_path):
    for name in ("domains", "examples", "meshes", "tests"):
        (tmp_path / name).symlink_to(REPOSITORY / name)
    follow(steps(DOCS / page), tmp_path)
