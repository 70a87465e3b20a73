"""Preparation as a user meets it: a limit or Ctrl-C ends it in time, names what is missing, and keeps what is done."""

import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kabo.compilation import cache_folder

ROOT = Path(__file__).resolve().parents[2]
LINKS = 36
FIRST = 5  # links that are prepared before the time runs out
LINE = re.compile(r"^r\.part\d+: 20 triangles, \d+ parts, \d+ vertices \([\d.]+ s\)$", re.MULTILINE)

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A scene with a robot of many links of two plates each, no two alike."""
    links, joints = '<link name="base"/>', ""
    for i in range(LINKS):
        corners = np.array([[0, 0], [1, 0], [1, 0.2], [0.2, 0.2], [0.2, 1], [0, 1]]) * (0.2 + 0.004 * i)
        corners[2:4, 1] *= 1.0 + 0.004 * i
        faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]])
        trimesh.creation.extrude_triangulation(corners, faces, height=0.1).export(tmp_path / f"part{i}.stl")
        mesh = f'<mesh filename="part{i}.stl"/>'
        links += f'<link name="part{i}"><collision><geometry>{mesh}</geometry></collision></link>'
        joints += f'<joint name="j{i}" type="fixed"><parent link="base"/><child link="part{i}"/></joint>'
    (tmp_path / "many.urdf").write_text(f'<robot name="many">{links}{joints}</robot>')
    (tmp_path / "scene.yaml").write_text("scene: many\nepsilon: 0.01\nrobots:\n  r: {urdf: many.urdf}\n")
    cache = tmp_path / "cache"
    cache.mkdir(mode=0o700)
    (cache_folder() / "compiled").mkdir(exist_ok=True)
    (cache / "compiled").symlink_to((cache_folder() / "compiled").resolve())
    return tmp_path


def started(folder: Path, *options: str) -> "subprocess.Popen[str]":
    """`kabo check` of the scene, with a folder of parts that is new."""
    return subprocess.Popen(
        [sys.executable, "-m", "kabo", "check", "scene.yaml", *options],
        cwd=folder,
        env={**os.environ, "KABO_CACHE": str(folder / "cache")},
        stderr=subprocess.PIPE,
        text=True,
    )


def test_a_limit_names_what_is_missing_and_the_next_run_makes_only_that(folder: Path) -> None:
    for limit in (6, 12, 24, 48, 96):  # on a busy machine the first may be over too soon, or the signal too late
        forget(folder)
        code, told = stopped_until_its_limit(folder, limit)
        found = re.search(
            rf"cut off while preparing geometry: (\d+) of {LINKS} done, not yet r\.part\d+, .* and \d+ more", told
        )
        if found is not None:
            break
    assert found is not None, told
    assert code == 4
    first = len(LINE.findall(told))
    assert int(found[1]) == first
    code, told = started_and_done(folder)
    assert code == 0 and len(LINE.findall(told)) <= LINKS - first
    assert LINE.findall(started_and_done(folder)[1]) == []


def stopped_until_its_limit(folder: Path, limit: float) -> tuple[int, str]:
    """The exit code of `kabo check`, and what it says, where its time runs out once some parts are made [s].

    The processes that work for it are stopped by a signal after its first lines: so most parts are missing at its limit,
    however fast the machine is.
    """
    process = started(folder, "--timeout", str(limit))
    assert process.stderr is not None
    told, lines = "", 0
    while lines < FIRST and (line := process.stderr.readline()):
        told, lines = told + line, lines + bool(LINE.match(line))
    stop_workers(process)
    told += process.stderr.read()
    return process.wait(timeout=60), told


def stop_workers(process: "subprocess.Popen[str]") -> None:
    """Stops the processes that work for one, so that nothing more gets done, however slow the caller is."""
    with suppress(OSError):  # it has ended meanwhile
        for child in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split():
            os.killpg(int(child), signal.SIGSTOP)


def forget(folder: Path) -> None:
    """Deletes all parts that are kept."""
    for kept in ("parts", "proven"):
        subprocess.run(["rm", "-r", "-f", str(folder / "cache" / kept)], check=True)


def test_ctrl_c_keeps_what_is_done(folder: Path) -> None:
    process = started(folder)
    assert process.stderr is not None
    while not LINE.match(line := process.stderr.readline()):
        assert line, "it ended without a line"
    stop_workers(process)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == 130
    told = started_and_done(folder)[1]
    assert len(LINE.findall(told)) < LINKS


def started_and_done(folder: Path, *options: str) -> tuple[int, str]:
    """The exit code of `kabo check`, and what it says."""
    process = started(folder, *options)
    told = process.communicate()[1]
    return process.returncode, told
