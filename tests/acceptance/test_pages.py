"""The pages as a whole: each is reached from the index, and every link and picture of each leads somewhere."""

import re
from pathlib import Path

import pytest

from tests.acceptance.test_references import sections

REPOSITORY = Path(__file__).parents[2]
DOCS = REPOSITORY / "docs"
FOLDERS = ("tutorial", "how-to", "reference", "explanation")
PAGES = sorted(
    path
    for pattern in ("*.md", "docs/**/*.md", "domains/*/*.md", "examples/**/*.md", "benchmarks/*.md")
    for path in REPOSITORY.glob(pattern)
)


def links(page: Path) -> set[str]:
    """What a page links to or shows, but for other sites; without what stands in code."""
    text = re.sub(r"^ *```.*?^ *```|`[^`\n]+`", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    named = re.findall(r"\]\(<?([^)\s>]+)>?(?: \"[^\"]*\")?\)", text) + re.findall(
        r"(?:src|href)=\"([^\"]+)\"", text
    )
    return {link for link in named if not re.match(r"[a-z]+:", link)}


def broken(page: Path) -> set[str]:
    """The links of a page that lead to no file, to a folder, or to no section of a page."""
    wrong = set()
    for link in links(page):
        target, _, section = link.partition("#")
        there = page.parent / target if target else page
        if not there.is_file() or (section and there.suffix == ".md" and section not in sections(there)):
            wrong.add(link)
    return wrong


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(REPOSITORY).as_posix())
def test_every_link_and_picture_of_a_page_leads_to_a_file_or_section(page):
    assert not broken(page)


def test_a_link_that_leads_nowhere_is_found(tmp_path):
    (tmp_path / "page.md").write_text(
        "# One\n[a](page.md#one) [b](page.md#two) [c](no.md) ![d](d.png) `[e](e.md)` [f](.)\n"
    )
    assert broken(tmp_path / "page.md") == {"page.md#two", "no.md", "d.png", "."}


def test_the_index_leads_to_every_page_by_need_and_the_list_of_decisions_to_every_decision():
    listed = {(DOCS / link.split("#")[0]).resolve() for link in links(DOCS / "index.md")}
    pages = {path for folder in FOLDERS for path in (DOCS / folder).rglob("*.md")}
    pages |= {*REPOSITORY.glob("domains/*/README.md"), *REPOSITORY.glob("examples/**/README.md")}
    assert not {path.relative_to(REPOSITORY).as_posix() for path in pages - listed}, "add them to docs/index.md"
    decisions = {path.name for path in (DOCS / "decisions").glob("[0-9]*.md")}
    assert links(DOCS / "decisions" / "README.md") == decisions
