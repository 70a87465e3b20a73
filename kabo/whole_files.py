"""Files that are written whole or not at all, whatever happens while they are written; and the hash of a whole file."""

import hashlib
import os
import threading
import time
from pathlib import Path

LATELY = 3_000_000_000  # [ns]: within which two changes of a file may have the same time
MOST_HASHES = 10_000  # of files; then all are forgotten
_hashes: dict[str, tuple[tuple[int, ...], str]] = {}  # of what files were like, by their paths


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a temporary file beside the target and renames it, so that readers see the old file or the new one.

    What is there and is no regular file, such as a pipe, `/dev/null` or `/dev/stdout`, is written to, not replaced.

    Raises:
        OSError: the folder cannot be written; the old file is then unchanged.
    """
    if path.exists() and not path.is_file():
        _write_into(path, content)
        return
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.part")
    try:
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:  # a write says no name, and a temporary one says nothing to people
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        temporary.unlink(missing_ok=True)


def file_hash(path: Path) -> str:
    """`sha256:…` of what is in a file, as plans have it.

    A file is read again only if it may have changed: its size, and the times at which its content and its entry were
    changed, are compared. Clocks of file systems are coarse, so nothing is kept of a file that has changed lately.

    Raises:
        OSError: the file cannot be read.
    """
    began = time.time_ns()
    now = os.stat(path)
    seen = now.st_dev, now.st_ino, now.st_size, now.st_mtime_ns, now.st_ctime_ns
    known = _hashes.get(str(path))
    if known is not None and known[0] == seen:
        return known[1]
    found = "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest()
    if max(now.st_mtime_ns, now.st_ctime_ns) < began - LATELY:
        if len(_hashes) >= MOST_HASHES:
            _hashes.clear()
        _hashes[str(path)] = seen, found
    return found


def _write_into(path: Path, content: bytes) -> None:
    """Writes to a pipe or a device."""
    try:
        with path.open("wb", buffering=0) as file:
            rest = memoryview(content)
            while rest:
                rest = rest[file.write(rest) :]
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error
