"""docs/how-to/deploy.md, done as it stands there: a server with TLS, a client that may ask, and three that may not."""

import socket
from pathlib import Path

import pytest

from tests.support.page_steps import follow, steps, unmarked

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "deploy.md"


def free_port() -> str:
    """A port of this machine that nothing listens on."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return str(found.getsockname()[1])


@pytest.mark.slow
def test_only_clients_with_a_certificate_that_a_rule_names_get_answers(tmp_path: Path) -> None:
    follow(steps(PAGE, other={"7447": free_port()}), tmp_path)


def test_every_block_of_the_page_is_a_step() -> None:
    assert not unmarked(PAGE)
