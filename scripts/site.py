"""Builds the documentation as a site of plain files, which opens from disk: build/site/index.html.

    python -m scripts.site [FOLDER] [--pages PAGES]

It needs the extra `docs`. Every warning is an error: a link or a picture that leads nowhere ends it. PAGES holds pages
of the viewer, as `python -m scripts.gallery --pages PAGES` writes them: `domains-bartender.html` and so on. They go
along, and the page of each domain leads to its own.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "build" / "site"


def build(site: Path, pages: Path | None = None) -> int:
    """Writes the site into a folder, with the pages of the viewer in another, and returns the exit code of Sphinx."""
    options = ["--fail-on-warning", "--fresh-env", "--keep-going", "--quiet", "--jobs", "auto"]
    if pages is not None:
        options += ["-D", f"viewer_pages={pages.resolve()}"]
    folders = ["-d", str(site.parent / "site-state"), "-c", str(ROOT / "docs"), str(ROOT), str(site)]
    code = subprocess.run([sys.executable, "-m", "sphinx", *options, *folders], check=False).returncode
    if pages is not None:
        shutil.copytree(pages, site / "pages", dirs_exist_ok=True)
    return code


def main() -> None:
    """Builds the site and prints where it is."""
    parser = argparse.ArgumentParser(description="Build the documentation as a site.")
    parser.add_argument("site", nargs="?", type=Path, default=SITE, metavar="FOLDER")
    parser.add_argument("--pages", type=Path, help="pages of the viewer, which go along")
    options = parser.parse_args()
    code = build(options.site.resolve(), options.pages)
    if code == 0:
        print(options.site.resolve() / "index.html")
    sys.exit(code)


if __name__ == "__main__":
    main()
