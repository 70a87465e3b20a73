"""The cache folder for files that can be computed again, and the checks that only its owner can write there."""

import atexit
import os
import shutil
import stat
import tempfile
import warnings
from contextlib import suppress
from functools import cache, lru_cache
from pathlib import Path


def cache_folder() -> Path:
    """The folder for everything that can be computed again: $KABO_CACHE, $XDG_CACHE_HOME/kabo, or ~/.cache/kabo.

    Files in it can execute code (compiled kernels, and indices that are pickles), so a folder is used only if it
    belongs to this user and nobody else can write to it. If the folder is not safe in this sense, this process and
    its children use a private folder in the system's temporary directory.
    """
    chosen = os.environ.get("KABO_CACHE")
    home = os.environ.get("XDG_CACHE_HOME")
    candidate = Path(chosen) if chosen else Path(home) / "kabo" if home else _home() / ".cache" / "kabo"
    return candidate if _usable(candidate) else _private_folder()


def _home() -> Path:
    try:
        return Path.home()
    except RuntimeError:  # a user without a name or a home
        return Path("/nonexistent")


def _usable(folder: Path) -> bool:
    """Whether a folder exists or was made, belongs to this user, and can be written by this user alone."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.stat()
    except (OSError, ValueError):  # ValueError: a null byte in the name
        return False
    if not _takes_files(folder, status.st_dev, status.st_ino, status.st_mode):
        return False
    if not hasattr(os, "getuid"):
        return True
    if status.st_uid == os.getuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return True
    _warn_of(folder, status.st_uid == os.getuid())
    return False


@lru_cache(maxsize=8)
def _takes_files(folder: Path, _device: int, _number: int, _mode: int) -> bool:
    """Whether a file can be made in a folder; tried once for each folder with its mode, as it takes long."""
    try:
        with tempfile.NamedTemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def keep_below(folder: Path, max_bytes: int) -> None:
    """Removes the files of a folder that were used least recently, if all together have more than `max_bytes`.

    A quarter of the room is free then, so that this is not needed for each new file. Other processes may read and remove
    files meanwhile: who misses one makes it anew.
    """
    files = []
    with suppress(OSError):
        for entry in os.scandir(folder):
            with suppress(OSError):
                status = entry.stat()
                files.append((status.st_mtime_ns, entry.path, status.st_size))
    total = sum(size for _, _, size in files)
    if total <= max_bytes:
        return
    for _, path, size in sorted(files):
        if 4 * total <= 3 * max_bytes:
            return
        with suppress(OSError):
            Path(path).unlink()
            total -= size


@cache
def _warn_of(folder: Path, own: bool) -> None:
    remedy = (
        "empty it, then chmod go-w" if own else "it belongs to another user: set KABO_CACHE to a folder of yours"
    )
    said = f"kabo does not use the cache folder {folder}, to which others can write; {remedy}"
    warnings.warn(said, stacklevel=3)


@cache
def _private_folder() -> Path:
    """A new folder that only this user can read or write; it is removed when the process ends."""
    folder, owner = Path(tempfile.mkdtemp(prefix="kabo-cache-")), os.getpid()

    def remove() -> None:
        if os.getpid() == owner:  # forks leave it to the process that made it
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    os.environ["KABO_CACHE"] = str(folder)  # processes that this one starts share it
    return folder
