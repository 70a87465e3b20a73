"""The how-to pages, done in an empty folder as they stand there."""

import socket
from pathlib import Path

import pytest

from tests.support.page_steps import follow, steps, unmarked

REPOSITORY = Path(__file__).parents[2]
HOW_TO = REPOSITORY / "docs" / "how-to"
PAGES = sorted(path.stem for path in HOW_TO.glob("*.md") if "<!-- step: " in path.read_text())


def free_port() -> str:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return str(found.getsockname()[1])


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_says_can_be_done(page: str, tmp_path: Path) -> None:
    follow(steps(HOW_TO / f"{page}.md", other={"7447": free_port()}), tmp_path)


@pytest.mark.parametrize("page", PAGES)
def test_each_block_of_such_a_page_is_a_step_of_it(page: str) -> None:
    assert not unmarked(HOW_TO / f"{page}.md")
