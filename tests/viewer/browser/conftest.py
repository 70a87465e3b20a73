"""Pages in the browser of this machine, opened from disk: Debian's chromium, or whichever is found, without a display."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "chrome")
SOFTWARE = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
)
READY_MS = 60_000  # of a busy machine


@dataclass
class OpenPage:
    """A page that is open: playwright's page, what its console said, and which addresses it asked for."""

    page: Any
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def run(self, script: str, argument: Any = None) -> Any:
        """The value of an expression, or what a function returns, in the page."""
        return self.page.evaluate(script, argument)

    def require_accessible(self) -> None:
        """Checks that axe finds nothing serious, on light and on dark ground; skips where axe is not installed."""
        axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed")
        for scheme in ("light", "dark"):
            self.page.emulate_media(color_scheme=scheme)
            found = axe.Axe().run(self.page).response["violations"]
            serious = [each for each in found if each["impact"] in ("serious", "critical")]
            assert not serious, [scheme, *([each["id"], [n["html"] for n in each["nodes"]]] for each in serious)]

    def require_clean(self) -> None:
        """Checks that the console is clean, and that no request left the page."""
        assert not self.said, self.said
        assert not self.asked, self.asked


@pytest.fixture(scope="session")
def browser() -> Iterator[Any]:
    """A browser; tests that need it are skipped where there is none."""
    found = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if found is None:
        pytest.skip("this machine has no browser: apt-get install chromium")
    with playwright.sync_playwright() as started:
        made = started.chromium.launch(executable_path=found, args=list(SOFTWARE))
        yield made
        made.close()


@pytest.fixture
def open_page(browser: Any) -> Iterator[Callable[..., OpenPage]]:
    """A function that opens a page from disk, and waits until its first frame was drawn."""
    contexts = []

    def opened(path: Path, *, fragment: str = "", before: str = "", **options: Any) -> OpenPage:
        context = browser.new_context(viewport={"width": 1280, "height": 720}, **options)
        contexts.append(context)
        shown = OpenPage(context.new_page())
        if before:
            shown.page.add_init_script(before)
        shown.page.on("console", lambda message: _note(shown, message))
        shown.page.on("pageerror", lambda error: shown.said.append(f"error: {error}"))
        shown.page.on("request", lambda request: _ask(shown, request.url))
        shown.page.goto(path.resolve().as_uri() + fragment)
        shown.page.wait_for_selector("html[data-ready=yes], #waiting.failed", state="attached", timeout=READY_MS)
        return shown

    yield opened
    for context in contexts:
        context.close()


def _note(shown: OpenPage, message: Any) -> None:
    """Notes what the console says; that software draws slowly when pixels are read is no fault of the page."""
    if message.type in ("error", "warning") and "GPU stall due to ReadPixels" not in message.text:
        shown.said.append(f"{message.type}: {message.text}")


def _ask(shown: OpenPage, address: str) -> None:
    if not address.startswith(("file:", "blob:", "data:")):
        shown.asked.append(address)
