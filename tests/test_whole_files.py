"""Files are written whole or not at all, and what went wrong is told of the file that was to be written."""

import errno
import os
import resource
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from kabo.whole_files import write_atomically


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
