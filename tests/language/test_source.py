"""Files that cannot be read as text: one clear finding each."""

import os
from pathlib import Path

import pytest

from kabo.errors import InputError
from kabo.language import check_files, load_problem
from kabo.language.source import MAX_BYTES, SourceFile


def the_finding(path: Path) -> tuple[int, int, str]:
    (one,) = check_files([path])
    assert one.file == str(path)
    with pytest.raises(InputError):
        load_problem(path)
    return one.line, one.column, one.message


def test_a_missing_file_is_reported_at_its_name(tmp_path: Path) -> None:
    assert the_finding(tmp_path / "no.yaml") == (1, 1, "there is no such file")


def test_a_near_name_beside_a_missing_file_is_proposed(tmp_path: Path) -> None:
    (tmp_path / "bottles.yaml").write_text("problem: x")
    (one,) = check_files([tmp_path / "botles.yaml"])
    assert one.hint == 'did you mean "bottles.yaml"?'


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    assert the_finding(tmp_path) == (1, 1, "this is a folder, not a file")


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert the_finding(tmp_path / "pipe") == (1, 1, "this is not an ordinary file")


def test_a_null_character_in_a_path_is_reported(tmp_path: Path) -> None:
    assert the_finding(tmp_path / "a\0b") == (1, 1, "the file cannot be read: embedded null byte")


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "huge.yaml"
    path.write_bytes(b"#" * (MAX_BYTES + 1))
    assert the_finding(path)[2] == "the file is larger than 1 MB"


def test_the_first_byte_that_is_no_utf_8_is_found(tmp_path: Path) -> None:
    path = tmp_path / "latin.yaml"
    path.write_bytes("problem: x\n# für\n".encode("latin-1"))
    assert the_finding(path) == (2, 4, "this is not UTF-8 text")


@pytest.mark.skipif(os.geteuid() == 0, reason="root reads everything")
def test_an_unreadable_file_says_why(tmp_path: Path) -> None:
    path = tmp_path / "locked.yaml"
    path.write_text("problem: x")
    path.chmod(0)
    assert the_finding(path) == (1, 1, "the file cannot be read: Permission denied")


def test_a_place_never_reaches_behind_its_line(tmp_path: Path) -> None:
    source = SourceFile(tmp_path, "f", "ab\r\ncd\r\n")
    place = source.place(1, 7)
    assert (place.line, place.column, place.length) == (1, 2, 1)
    assert [source.line(number) for number in (0, 1, 2, 3, 4)] == ["", "ab", "cd", "", ""]
