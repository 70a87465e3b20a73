"""The list of decisions, from the titles of their pages."""

import re
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent.parent / "docs" / "decisions"


def listed() -> str:
    """A line for each decision: its number, which is the link, and its title."""
    lines = []
    for page in sorted(FOLDER.glob("[0-9]*.md")):
        number, title = re.split(r":? ", page.read_text().split("\n", 1)[0].removeprefix("# "), maxsplit=1)
        lines.append(f"- [{number}]({page.name}) {title}")
    return "\n\n" + "\n".join(lines) + "\n\n"
