"""Command lines in code on any page, run or not: kabo understands them, and files of the repository in them exist."""

import re
import shlex
from pathlib import Path

import pytest

from kabo.cli.main import parser
from tests.acceptance.test_pages import PAGES, REPOSITORY

_CODE = re.compile(r"^```\w*\n(.*?)^```|((?:^(?: {4}|\t).*\n)+)", re.MULTILINE | re.DOTALL)
#: Letters that stand for something that a reader chooses.
PLACEHOLDER = re.compile(r"…|\b[A-Z]{2,}\b|\[|^kabo explain says ")  # the last is what a command prints


def command_lines(page: Path) -> list[str]:
    """The lines in code of a page that call kabo, continued lines joined, but for those with placeholders."""
    code = "\n".join("".join(found) for found in _CODE.findall(page.read_text())).replace("\\\n", " ")
    lines = [re.sub(r"^(\.venv/bin/|\$ )?", "", line.strip()) for line in code.splitlines()]
    lines = [part.strip() for line in lines for part in line.split("&&")]
    return [line for line in lines if re.match(r"kabo (-|\w+ )", line) and not PLACEHOLDER.search(line)]


def words(line: str) -> list[str]:
    """The words of a command line behind `kabo`, up to a pipe, a redirection or a comment."""
    found = shlex.split(line, comments=True)[1:]
    ends = [number for number, word in enumerate(found) if word in ("|", ">", "2>", "&", "<")]
    return found[: min(ends, default=len(found))]


CALLING = [page for page in PAGES if command_lines(page)]


@pytest.mark.parametrize("page", CALLING, ids=lambda page: page.relative_to(REPOSITORY).as_posix())
def test_kabo_understands_the_command_lines_of_a_page(page, monkeypatch):
    monkeypatch.chdir(REPOSITORY)
    for line in command_lines(page):
        given = words(line)
        parser().parse_args(given)
        named = [word for word in given if re.match(r"(domains|examples|meshes)/.*\.\w+$", word)]
        outputs = {given[number + 1] for number, word in enumerate(given[:-1]) if word == "-o"}
        assert not [name for name in named if name not in outputs and not Path(name).exists()], line


def test_a_command_line_with_a_wrong_option_is_found(tmp_path):
    (tmp_path / "page.md").write_text(
        "    kabo solve a.yaml --sead 1\n\n```sh\nkabo check b.yaml && kabo solve FILE\n```\n"
    )
    wrong, right = command_lines(tmp_path / "page.md")
    parser().parse_args(words(right))
    with pytest.raises(BaseException, match="sead"):
        parser().parse_args(words(wrong))
