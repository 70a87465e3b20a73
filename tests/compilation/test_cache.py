"""The folder of what may be computed again: what lies there is executed, so it must be this user's alone."""

import os
import stat
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import pytest

from kabo.compilation import cache as cache_module
from kabo.compilation import cache_folder


@pytest.fixture(autouse=True)
def _fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Every test warns anew and makes private folders of its own."""
    monkeypatch.setenv("KABO_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    for remembered in (cache_module._private_folder, cache_module._takes_files, cache_module._warn_of):
        remembered.cache_clear()


def test_a_new_folder_is_private(tmp_path: Path) -> None:
    folder = cache_folder()
    assert folder == tmp_path / "cache"
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702, 0o1777])
def test_a_folder_to_which_others_can_write_is_not_used(tmp_path: Path, mode: int) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(mode)
    with pytest.warns(UserWarning, match="to which others can write; empty it, then chmod go-w"):
        folder = cache_folder()
    assert folder.parent == tmp_path
    assert folder.name.startswith("kabo-cache-")
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert cache_folder() == folder, "one folder for the process, one warning"


def test_whether_a_folder_takes_files_is_tried_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []
    once = tempfile.NamedTemporaryFile
    monkeypatch.setattr(tempfile, "NamedTemporaryFile", lambda **given: made.append(given) or once(**given))
    assert cache_folder() == cache_folder() == tmp_path / "cache"
    assert len(made) == 1
    (tmp_path / "cache").rmdir()
    assert cache_folder().is_dir(), "a folder that was removed is made anew"
    (tmp_path / "cache").chmod(0o777)
    with pytest.warns(UserWarning, match="to which others can write"):
        assert cache_folder() != tmp_path / "cache", "who can write there is looked at each time"


def test_a_folder_that_others_can_only_read_is_used(tmp_path: Path) -> None:
    (tmp_path / "cache").mkdir(mode=0o755)
    assert cache_folder() == tmp_path / "cache"


def test_a_folder_of_somebody_else_is_not_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own = os.getuid()
    cache_folder()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    with pytest.warns(UserWarning, match="belongs to another user"):
        assert cache_folder() != tmp_path / "cache"


@pytest.mark.parametrize("name", ["file", "file/below", "nul\0"])
def test_a_folder_that_cannot_be_made_is_replaced_by_a_private_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setattr(os, "environ", {**os.environ, "KABO_CACHE": str(tmp_path / name)})
    folder = cache_folder()
    assert folder.name.startswith("kabo-cache-")
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_processes_share_the_private_folder_and_it_goes_with_the_one_that_made_it(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("no folder")
    script = (
        "import subprocess, sys; from kabo.compilation import cache_folder; folder = cache_folder(); print(folder)\n"
        "ask = 'from kabo.compilation import cache_folder; print(cache_folder())'\n"
        "print(subprocess.run([sys.executable, '-c', ask], capture_output=True, text=True, check=True).stdout)"
    )
    environment = {**os.environ, "KABO_CACHE": str(tmp_path / "file"), "TMPDIR": str(tmp_path)}
    run = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment
    )
    first, second = run.stdout.split()
    assert first == second
    assert not Path(first).exists()
