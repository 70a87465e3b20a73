"""Pieces of Markdown: tables, text of help messages, docstrings."""

import re
import textwrap
from collections.abc import Iterable, Sequence

_SECTIONS = ("Args", "Returns", "Raises", "Yields", "Attributes", "Example", "Examples", "Note")


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table, without the columns in which nothing stands."""
    filled = [[cell(each) for each in row] for row in rows]
    kept = [number for number in range(len(heads)) if any(row[number] for row in filled)]
    lines = [[heads[number] for number in kept], *([row[number] for number in kept] for row in filled)]
    first, *others = [f"| {' | '.join(line)} |" for line in lines]
    return "\n".join([first, f"|{'---|' * len(kept)}", *others])


def cell(text: str) -> str:
    """Text for a cell of a table: on one line, bars escaped."""
    return re.sub(r"(?<!\\)\|", r"\\|", " ".join(text.split()))


def code(text: object) -> str:
    """Text as code, or nothing for an empty one."""
    return f"`{text}`" if str(text) else ""


def plain(text: str) -> str:
    """Text that is no Markdown, such as a help message: signs that would be read as such are escaped outside of code."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if number % 2 else re.sub(r"([<*])", r"\\\1", part) for number, part in enumerate(parts))


def docstring(text: str, *, after_first: bool = False) -> str:
    """A docstring in Google form as Markdown: its sections become lists.

    Args:
        text: the docstring, without its indentation.
        after_first: leaves the first line out, which stands elsewhere.
    """
    head, *rest = _split(text)
    if after_first:
        head = head.partition("\n")[2].strip()
    return "\n\n".join(each for each in [plain(head.strip()), *map(_section, rest)] if each)


def _split(text: str) -> list[str]:
    return re.split(rf"^(?=(?:{'|'.join(_SECTIONS)}):$)", text, flags=re.MULTILINE)


def _section(text: str) -> str:
    """One section of a docstring, each entry an item; an example is a block of code."""
    title, _, body = text.partition("\n")
    if body.lstrip().startswith(">>>"):
        return f"*{title.removesuffix(':')}*\n\n```pycon\n{textwrap.dedent(body).strip()}\n```"
    entries: list[str] = []
    for line in body.splitlines():
        if re.match(r" {1,4}\S", line):
            entries.append(line.strip())
        elif line.strip() and entries:
            entries[-1] += " " + line.strip()
    return f"*{title.removesuffix(':')}*\n\n" + "\n".join(f"- {_entry(each)}" for each in entries)


def _entry(text: str) -> str:
    name, colon, meaning = text.partition(": ")
    words = re.fullmatch(r"\*{0,2}[\w.]+(, \*{0,2}[\w.]+)*", name)
    if not (colon and words):
        return plain(text)
    return f"{', '.join(code(each) for each in name.split(', '))}: {plain(meaning)}"
