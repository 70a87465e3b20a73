"""Builds `kabo/viewer/static/three.js` and its licence notice: `python -m scripts.viewer_bundle`.

Needs Node and npm. What is bundled is pinned in `scripts/viewer/package-lock.json`, so that the same bytes come out
each time. The page's own modules (`kabo/viewer/page/modules/`) are not bundled: pages carry them as they are written.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

REPOSITORY = Path(__file__).parents[1]
SOURCE = REPOSITORY / "scripts" / "viewer"
TARGET = REPOSITORY / "kabo" / "viewer" / "static"
BUILD = ("--bundle", "--format=esm", "--minify", "--charset=utf8", "--legal-comments=none", "--target=es2022")


def main() -> None:
    """Installs the pinned packages in a temporary folder, bundles them, and writes bundle and notice."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        for name in ("package.json", "package-lock.json", ".npmrc", "three.js"):
            shutil.copy(SOURCE / name, work / name)
        subprocess.run(["npm", "ci", "--silent", "--no-audit", "--no-fund"], cwd=work, check=True)
        made = work / "made.js"
        esbuild = work / "node_modules" / ".bin" / "esbuild"
        subprocess.run([esbuild, "three.js", *BUILD, f"--outfile={made}"], cwd=work, check=True)
        licence = (work / "node_modules" / "three" / "LICENSE").read_text()
        TARGET.mkdir(exist_ok=True)
        head = "// three.js 0.187.0, MIT licence: see three.LICENSE.txt. Built by scripts/viewer_bundle.py.\n"
        (TARGET / "three.js").write_text(head + made.read_text())
        (TARGET / "three.LICENSE.txt").write_text("three.js 0.187.0, https://threejs.org\n\n" + licence)
    print(f"{TARGET / 'three.js'}: {(TARGET / 'three.js').stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
