"""Files are written whole or not at all, and what went wrong is told of the file that was to be written."""

import errno
import hashlib
import os
import resource
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from kabo import whole_files
from kabo.whole_files import file_hash, write_atomically


@contextmanager
def files_of_at_most(size: int) -> Iterator[None]:
    """A context in which no file grows beyond `size` bytes, as on a full disk."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_full_disk_leaves_the_old_file_and_is_told_of_the_new_one(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"old")
    with files_of_at_most(1000), pytest.raises(OSError) as caught:  # noqa: PT011 - its fields are looked at
        write_atomically(tmp_path / "a", b"new" * 1000)
    assert (caught.value.errno, caught.value.filename) == (errno.EFBIG, str(tmp_path / "a"))
    assert (tmp_path / "a").read_bytes() == b"old" and len(list(tmp_path.iterdir())) == 1


def test_a_folder_that_is_not_there_is_told_of_the_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught:
        write_atomically(tmp_path / "no" / "a", b"new")
    assert caught.value.filename == str(tmp_path / "no" / "a")


def test_a_pipe_is_written_to_and_not_replaced_by_a_file(tmp_path: Path) -> None:
    pipe, read = tmp_path / "pipe", []
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_atomically(pipe, b"new" * 100_000)
    reader.join(10.0)
    assert read == [b"new" * 100_000]
    assert pipe.is_fifo()


def test_a_device_that_takes_nothing_stays_a_device(tmp_path: Path) -> None:
    device = tmp_path / "full"
    device.symlink_to("/dev/full")
    with pytest.raises(OSError) as caught:  # noqa: PT011 - its fields are looked at
        write_atomically(device, b"new")
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(device))
    assert device.is_symlink()


def hash_of(content: bytes) -> str:
    return "sha256:" + hashlib.sha256(content).hexdigest()


def test_a_file_that_changes_again_and_again_has_the_hash_of_what_is_in_it(tmp_path: Path) -> None:
    """Of the same size, in quick succession, and with the time of the first content put back."""
    path = tmp_path / "a"
    path.write_bytes(b"0000")
    times = path.stat().st_atime_ns, path.stat().st_mtime_ns
    for number in range(300):
        content = f"{number:04}".encode()
        if number % 2:
            path.write_bytes(content)
        else:
            write_atomically(path, content)
        os.utime(path, ns=times)
        assert file_hash(path) == hash_of(content)
        assert file_hash(path) == hash_of(content)


def test_a_file_that_has_not_changed_for_long_is_read_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(whole_files, "LATELY", -(10**15))  # every change was long ago
    path, read = tmp_path / "a", list[Path]()
    path.write_bytes(b"old")

    def counted(own: Path) -> bytes:
        read.append(own)
        with own.open("rb") as file:
            return file.read()

    monkeypatch.setattr(Path, "read_bytes", counted)
    assert {file_hash(path) for _ in range(5)} == {hash_of(b"old")} and read == [path]
    path.write_bytes(b"newer")
    assert {file_hash(path) for _ in range(5)} == {hash_of(b"newer")} and read == [path, path]
    path.unlink()
    with pytest.raises(FileNotFoundError):
        file_hash(path)
