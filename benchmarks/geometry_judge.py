"""The judge: an environment and a process of its own, which share no code with kabo; it also builds the meshes."""

import hashlib
import json
import subprocess
import sys
import venv
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from kabo.arrays import Array
from kabo.compilation import cache_folder

HERE = Path(__file__).resolve().parent / "judge"
Faces = npt.NDArray[np.int64]


def environment(chosen: Path | None) -> Path:
    """The judge's interpreter: the chosen one, or that of an environment made once from its requirements."""
    if chosen is not None:
        return chosen
    wanted = (HERE / "requirements.txt").read_bytes()
    folder = cache_folder() / f"judge-{hashlib.sha256(wanted).hexdigest()[:12]}"
    python = folder / "bin" / "python"
    if not (folder / "complete").exists():
        print(f"making the judge's environment in {folder}", file=sys.stderr)
        venv.create(folder, clear=True, with_pip=True)
        subprocess.run(
            [python, "-m", "pip", "install", "--quiet", "-r", HERE / "requirements.txt"],
            check=True,
            stdout=sys.stderr,
        )
        (folder / "complete").touch()
    return python


def mesh_set(python: Path, chosen: Path | None) -> Path:
    """The folder of the mesh set; made once by the judge's script."""
    folder = chosen or cache_folder() / "judge-meshes"
    if not (folder / "meshes.json").exists():
        folder.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            [python, HERE / "make_meshes.py", folder, "--extra", HERE / "robot.json"],
            check=True,
            stdout=sys.stderr,
        )
    return folder


def read_off(path: Path) -> tuple[Array, Faces]:
    """Vertices (V, 3) and triangles (F, 3) of a plain OFF file."""
    words = path.read_text().split()
    count, faces = int(words[1]), int(words[2])
    vertices = np.array(words[4 : 4 + 3 * count], float).reshape(count, 3)
    triangles = np.array(words[4 + 3 * count : 4 + 3 * count + 4 * faces], np.int64).reshape(faces, 4)[:, 1:]
    return vertices, np.ascontiguousarray(triangles)


def write_off(path: Path, vertices: Array, faces: Faces) -> None:
    """Writes what `read_off` reads, to the last bit."""
    corners = "".join("{:.17g} {:.17g} {:.17g}\n".format(*point) for point in vertices)
    triangles = "".join("3 {} {} {}\n".format(*face) for face in faces)
    path.write_text(f"OFF\n{len(vertices)} {len(faces)} 0\n{corners}{triangles}")


def verdicts(python: Path, jobs: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The judge's verdict of every job, in order; `judge/batch.py` says what a job is."""
    lines = "".join(json.dumps(job, default=str) + "\n" for job in jobs)
    asked = subprocess.run([python, HERE / "batch.py"], input=lines, capture_output=True, text=True, check=False)
    if asked.returncode:
        raise RuntimeError(f"the judge failed: {asked.stderr.strip().splitlines()[-1:]}")
    return map(json.loads, asked.stdout.splitlines())
