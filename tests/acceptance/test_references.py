"""What code and pages refer to is in the repository: pages, their sections, decisions, keys of what kabo writes."""

import json
import re
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
FOLDERS = ("kabo", "tests", "scripts", "benchmarks", "examples", "domains", "docs", ".ci", ".github")
TEXTS = sorted(
    path
    for folder in FOLDERS
    for path in [*(REPOSITORY / folder).rglob("*"), *REPOSITORY.glob("*.md"), REPOSITORY / "pyproject.toml"]
    if path.suffix in (".py", ".md", ".toml", ".yml", ".lark") and path != Path(__file__)
)
#: Words in capitals before a number that are no documents of this project.
KNOWN = {"AIPS", "ASSEMBLY", "BARTENDER", "ICAPS", "IEEE", "RGBA", "REARRANGE", "SENSING", "STACKED"}


def found(pattern: str) -> set[tuple[str, str]]:
    """Where a pattern's group occurs: the file, and what was written."""
    return {
        (path.relative_to(REPOSITORY).as_posix(), match[1])
        for path in TEXTS
        for match in re.finditer(pattern, path.read_text())
    }


def sections(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", page.read_text(), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    anchors = [re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings]
    repeated = [anchors[:number].count(anchor) for number, anchor in enumerate(anchors)]
    return {f"{anchor}-{count}" if count else anchor for anchor, count in zip(anchors, repeated, strict=True)}


def resolves(page: Path, section: str) -> bool:
    """Whether a page exists and has a section of that anchor ("": any)."""
    return page.is_file() and (not section or section in sections(page))


def test_pages_and_sections_that_code_refers_to_exist():
    named = found(r"(?<![\w/.-])(docs/[\w/-]+\.md(?:#[\w-]+)?)")
    assert len(named) > 30
    assert not {
        each for each in named if not resolves(REPOSITORY / each[1].split("#")[0], each[1].partition("#")[2])
    }


def test_decisions_that_are_cited_exist():
    numbers = {path.name[:3] for path in (REPOSITORY / "docs" / "decisions").glob("*.md")}
    cited = found(r"[Dd]ecisions? (\d{3})\b")
    assert len(cited) > 5
    assert not {each for each in cited if each[1] not in numbers}


def test_no_document_is_cited_that_is_not_here():
    """Such as `[LANGUAGE 6]`, `[DESIGN section 3]`, `[contract 4]`, or a page beside the repository."""
    cited = found(r"\b([A-Z]{4,}) (?:section |chapter |§ ?)?\d")
    cited |= found(r"\[(contract) \d") | found(r"(\.\./shared\b)")
    assert not {each for each in cited if each[1] not in KNOWN}
    pages = found(r"(?<![\w/.#:-])([A-Z]+\.md)\b")
    assert not {page for page in pages if page[1] != "README.md" and not (REPOSITORY / page[1]).exists()}


@pytest.mark.parametrize("name", ["kabo-plan-2", "kabo-result-1"])
def test_every_key_of_plans_and_results_is_described(name):
    schema = json.loads((REPOSITORY / "kabo" / "plan" / "schemas" / f"{name}.schema.json").read_text())
    pages = "".join(
        (REPOSITORY / "docs" / page).read_text()
        for page in ("reference/plans.md", "reference/contacts.md", "explanation/certificates.md")
    )

    def keys(value: object) -> set[str]:
        if isinstance(value, list):
            return {key for each in value for key in keys(each)}
        if not isinstance(value, dict):
            return set()
        return set(value.get("properties", {})) | {key for each in value.values() for key in keys(each)}

    assert not {key for key in keys(schema) if f"`{key}`" not in pages and f'"{key}"' not in pages}
