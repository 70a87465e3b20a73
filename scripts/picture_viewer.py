"""Draws the viewer's page of a plan, as a browser without a display shows it: `python -m scripts.picture_viewer`.

The page of BARTENDER at a moment of one of its branches, light, 1280 by 720 pixels. Needs playwright and chromium.
"""

import argparse
import shutil
import tempfile
from io import BytesIO
from pathlib import Path
from typing import Any

from kabo.whole_files import write_atomically
from scripts.gallery import page
from scripts.pictures import ROOT, plan_of

PICTURE = ROOT / "docs" / "pictures" / "viewer.png"
FOLDER, MOMENT = "domains/bartender", "n16@0.6s"
SIZE = {"width": 1280, "height": 720}
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
SOFTWARE = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
)
COLOURS = 256  # of the picture file: a fifth of the bytes


def main() -> None:
    """Writes the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plans", type=Path, metavar="FOLDER", help="where plans are kept")
    parser.add_argument(
        "--moment", default=MOMENT, metavar="NODE@TIMEs", help=f"what is shown (default: {MOMENT})"
    )
    parser.add_argument("--output", type=Path, default=PICTURE, metavar="FILE")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plans = (options.plans or Path(folder)).resolve()
        shown = Path(folder) / "page.html"
        shown.write_bytes(page(FOLDER, plan_of(f"{FOLDER}/four_bottles.yaml", plans)))
        write_atomically(options.output, _smaller(_screenshot(f"{shown.as_uri()}#{options.moment}")))
    print(options.output)


def _screenshot(address: str) -> bytes:
    """The page as PNG, once its first frame was drawn and nothing loads any more."""
    from playwright.sync_api import sync_playwright

    browser_path = next(path for name in BROWSERS if (path := shutil.which(name)))
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=browser_path, args=list(SOFTWARE))
        opened: Any = browser.new_page(viewport=SIZE, color_scheme="light")
        opened.goto(address)
        opened.wait_for_selector('html[data-ready="yes"]', timeout=120_000, state="attached")
        opened.wait_for_timeout(2000)
        picture: bytes = opened.screenshot()
        browser.close()
    return picture


def _smaller(picture: bytes) -> bytes:
    from PIL import Image

    file = BytesIO()
    Image.open(BytesIO(picture)).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(
        file, "PNG", optimize=True
    )
    return file.getvalue()


if __name__ == "__main__":
    main()
