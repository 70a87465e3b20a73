"""Builds the documentation as a site of plain files, which opens from disk: build/site/index.html.

    python -m scripts.site [FOLDER]

It needs the extra `docs`. Every warning is an error: a link or a picture that leads nowhere ends it.
"""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SITE = ROOT / "build" / "site"


def build(site: Path) -> int:
    """Writes the site into a folder and returns the exit code of Sphinx."""
    options = ["--fail-on-warning", "--fresh-env", "--keep-going", "--quiet", "--jobs", "auto"]
    folders = ["-d", str(site.parent / "site-state"), "-c", str(ROOT / "docs"), str(ROOT), str(site)]
    return subprocess.run([sys.executable, "-m", "sphinx", *options, *folders], check=False).returncode


def main() -> None:
    """Builds the site and prints where it is."""
    site = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else SITE
    code = build(site)
    if code == 0:
        print(site / "index.html")
    sys.exit(code)


if __name__ == "__main__":
    main()
