"""`kabo serve`, `kabo request` and `kabo view --follow` as three processes, and a browser that watches."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from tests.service.conftest import free_endpoint

ROOT = Path(__file__).parents[3]
READY_MS = 180_000  # of a busy machine, with kernels still to compile


def started(*arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "kabo.cli", *arguments]
    return subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=ROOT)


def line_with(process: subprocess.Popen[str], text: str) -> str:
    assert process.stderr is not None
    return next(line for line in process.stderr if text in line)


@pytest.fixture
def endpoint() -> Iterator[str]:
    where = free_endpoint()
    server = started("serve", "--listen", where, "--workers", "1")
    line_with(server, "is ready")
    yield where
    server.send_signal(signal.SIGTERM)
    server.wait(20)


def test_a_server_that_is_not_there_is_told_with_the_remedy() -> None:
    where = free_endpoint()
    process = started("view", "--follow", where, "--no-open")
    _, said = process.communicate(timeout=60)
    assert process.returncode == 6 and f"no server answers at {where}" in said and "kabo serve --listen" in said  # noqa: PLR2004


def wait_until_done(page: Any) -> None:
    """Asks again and again: playwright's own waiting may end with a page that is loaded anew meanwhile."""
    from playwright.sync_api import Error  # where there is no browser, there may be no playwright

    until = time.monotonic() + READY_MS / 1000
    while time.monotonic() < until:
        with suppress(Error):  # between two pages
            if page.query_selector(".live[data-state=done]") is not None:
                return
        page.wait_for_timeout(200)
    raise AssertionError(page.text_content("#panel-live"))


@pytest.mark.slow
def test_a_request_is_followed_to_its_plan(endpoint: str, browser: Any, tmp_path: Path) -> None:
    following = started("view", "--follow", endpoint, "--no-open")
    address = line_with(following, "shows the requests").split()[0]
    said: list[str] = []
    page = browser.new_context().new_page()
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(address)
    page.wait_for_selector("html[data-ready=yes]", state="attached", timeout=READY_MS)
    assert "waiting for a request" in page.inner_text("#panel-live")
    plan = tmp_path / "plan.json"
    asking = started("request", "domains/stacked/n2.yaml", "--connect", endpoint, "-o", str(plan))
    wait_until_done(page)
    page.wait_for_function("window.kabo?.document.plan !== null", timeout=READY_MS)
    assert asking.wait(30) == 0 and "solved" in page.text_content("#panel-live")
    assert page.evaluate("kabo.document.scene.name") == "stacked" and not said
    following.send_signal(signal.SIGINT)
    assert following.wait(20) == 0
    assert "Traceback" not in following.communicate()[1]
