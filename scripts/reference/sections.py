"""The generated sections by name, and the pages that hold them."""

import re
from collections.abc import Callable
from pathlib import Path

from scripts.reference import (
    commands,
    constraints,
    decisions,
    exceptions,
    file_keys,
    messages,
    procedures,
    python_api,
    schemas,
    solve_options,
    stages,
)

ROOT = Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"
_SECTION = re.compile(r"(<!-- python -m scripts\.reference: ([\w -]+) -->)(.*?)(<!-- to here -->)", re.DOTALL)

#: Of each section its text. One that begins with a line feed stands on lines of its own.
SECTIONS: dict[str, Callable[[], str]] = {
    "options of a request": solve_options.fields,
    "commands": commands.sections,
    "procedures": procedures.sections,
    "stages": stages.sections,
    "constraints": constraints.section,
    "decisions": decisions.listed,
    "errors": exceptions.sections,
    "exit codes": exceptions.exit_codes,
    "messages": messages.sections,
    "schemas": schemas.sections,
    "python kabo": lambda: python_api.sections("kabo"),
    "python tasks": lambda: python_api.sections("kabo.tasks"),
    "python trials": lambda: python_api.sections("kabo.trials"),
    "python exploration": lambda: python_api.sections("kabo.exploration"),
    **{f"keys of {page}": lambda page=page: file_keys.sections(page) for page in file_keys.PAGES},
}


def named(text: str) -> list[str]:
    """The names of the generated sections of a page."""
    return [found[2] for found in _SECTION.finditer(text)]


def pages() -> list[Path]:
    """The pages that hold a generated section."""
    return [page for page in sorted(DOCS.rglob("*.md")) if named(page.read_text())]


def renewed(text: str) -> str:
    """The text of a page with its sections as the code says them now."""
    return _SECTION.sub(lambda found: found[1] + SECTIONS[found[2]]() + found[4], text)
